#include "isolux/io/dicom_parse.h"

#include <gdcmImageReader.h>
#include <gdcmReader.h>
#include <gdcmSequenceOfFragments.h>
#include <gdcmSequenceOfItems.h>
#include <gdcmUIDs.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <fstream>
#include <memory>
#include <optional>
#include <set>
#include <sstream>

#include "isolux/base/error.h"
#include "isolux/base/number_text.h"
#include "isolux/base/vec3.h"

namespace isolux {
namespace {

const gdcm::Tag kPixelData(0x7fe0, 0x0010);
constexpr const char* kNoImage = "is DICOM, but holds no image";
const gdcm::Tag kFloatPixels(0x7fe0, 0x0008);
const gdcm::Tag kDoublePixels(0x7fe0, 0x0009);

std::unique_ptr<std::istream> open(const std::string& path, std::size_t start) {
  auto file = std::make_unique<std::ifstream>(path, std::ios::binary);
  if (!*file) throw std::runtime_error(std::string("cannot be opened: ") + std::strerror(errno));
  if (start == 0) return file;
  file->seekg(static_cast<std::streamoff>(start));
  auto rest = std::make_unique<std::stringstream>();
  *rest << file->rdbuf();
  return rest;
}

// --- Values of elements; empty where there are none ---

bool has(const gdcm::DataSet& set, gdcm::Tag tag) { return set.FindDataElement(tag); }

const gdcm::ByteValue* bytes_of(const gdcm::DataSet& set, gdcm::Tag tag) {
  return has(set, tag) ? set.GetDataElement(tag).GetByteValue() : nullptr;
}

std::string trimmed(const std::string& text) {
  const auto is_blank = [](char c) { return c == ' ' || c == '\0' || c == '\n' || c == '\r'; };
  std::size_t begin = 0, end = text.size();
  while (begin < end && is_blank(text[begin])) ++begin;
  while (end > begin && is_blank(text[end - 1])) --end;
  return text.substr(begin, end - begin);
}

std::string text(const gdcm::DataSet& set, gdcm::Tag tag) {
  constexpr std::size_t kLongest = 1 << 20;
  const gdcm::ByteValue* value = bytes_of(set, tag);
  if (!value || value->GetLength() > kLongest) return {};
  return trimmed({value->GetPointer(), value->GetLength()});
}

// Decimal and whole-number strings. Empty where one of them is not a number.
std::vector<double> decimals(const gdcm::DataSet& set, gdcm::Tag tag) {
  std::vector<double> numbers;
  std::istringstream list(text(set, tag));
  for (std::string item; std::getline(list, item, '\\');) {
    const auto number = parse_number(trimmed(item));
    if (!number) return {};
    numbers.push_back(*number);
  }
  return numbers;
}

std::vector<double> decimals(const gdcm::DataSet& set, gdcm::Tag tag, std::size_t count) {
  std::vector<double> numbers = decimals(set, tag);
  return numbers.size() < count ? std::vector<double>{}
                                : std::vector<double>(numbers.begin(), numbers.begin() + count);
}

double decimal(const gdcm::DataSet& set, gdcm::Tag tag, double otherwise) {
  const std::vector<double> numbers = decimals(set, tag);
  return numbers.empty() ? otherwise : numbers[0];
}

int whole(const gdcm::DataSet& set, gdcm::Tag tag, int otherwise) {
  const double number = decimal(set, tag, otherwise);
  return std::fabs(number) < 2e9 ? static_cast<int>(number) : otherwise;
}

template <typename Number>
std::vector<double> binary(const gdcm::DataSet& set, gdcm::Tag tag) {
  const gdcm::ByteValue* value = bytes_of(set, tag);
  if (!value || value->GetLength() < sizeof(Number)) return {};
  Number number;
  std::memcpy(&number, value->GetPointer(), sizeof number);
  return {static_cast<double>(number)};
}

int unsigned_short(const gdcm::DataSet& set, gdcm::Tag tag, int otherwise) {
  const std::vector<double> number = binary<std::uint16_t>(set, tag);
  return number.empty() ? otherwise : static_cast<int>(number[0]);
}

// The data sets of a sequence's items.
std::vector<const gdcm::DataSet*> items(
    const gdcm::DataSet& set, gdcm::Tag tag,
    std::vector<gdcm::SmartPointer<gdcm::SequenceOfItems>>& alive) {
  if (!has(set, tag)) return {};
  const gdcm::SmartPointer<gdcm::SequenceOfItems> sequence = set.GetDataElement(tag).GetValueAsSQ();
  if (!sequence) return {};
  alive.push_back(sequence);
  std::vector<const gdcm::DataSet*> sets;
  for (gdcm::SequenceOfItems::SizeType n = 1; n <= sequence->GetNumberOfItems(); ++n) {
    sets.push_back(&sequence->GetItem(n).GetNestedDataSet());
  }
  return sets;
}

// --- Frames ---

class FrameParser {
 public:
  explicit FrameParser(const gdcm::DataSet& root) : root_(root) { take_all(root, shared_); }

  std::vector<DicomFrame> frames(DicomFile& file) {
    // Enhanced files: first what all frames share, then each frame's own.
    for (const gdcm::DataSet* group : items(root_, {0x5200, 0x9229}, alive_)) {
      take_groups(*group, shared_);
    }
    std::vector<DicomFrame> frames;
    for (const gdcm::DataSet* group : items(root_, {0x5200, 0x9230}, alive_)) {
      frames.push_back(shared_);
      take_groups(*group, frames.back());
    }
    if (!rescale_type_.empty()) file.units = rescale_type_;
    if (frames.empty()) frames = dose(file);
    if (frames.empty()) frames = after_the_first(file);
    if (frames.empty()) frames.push_back(shared_);
    if (frames.size() == 1 && file.frame_count > 1) {
      frames[0].position.clear();
      frames[0].orientation.clear();
    }
    for (DicomFrame& frame : frames) {
      if (std::isfinite(frame.slope) && frame.slope != 0) continue;
      frame.slope = 1;
      file.remarks = {"its rescale slope is zero: 1 was taken"};
    }
    return frames;
  }

 private:
  static void take(std::vector<double>& to, std::vector<double> from) {
    if (!from.empty()) to = std::move(from);
  }

  void take_all(const gdcm::DataSet& set, DicomFrame& frame) {
    take(frame.position, decimals(set, {0x0020, 0x0032}, 3));
    take(frame.orientation, decimals(set, {0x0020, 0x0037}, 6));
    take(frame.spacing, decimals(set, {0x0018, 0x1164}, 2));  // at the detector
    take(frame.spacing, decimals(set, {0x0028, 0x0030}, 2));
    take(frame.distance, decimals(set, {0x0018, 0x0050}, 1));  // thickness
    if (decimal(set, {0x0018, 0x0088}, 0) != 0) {
      take(frame.distance, decimals(set, {0x0018, 0x0088}, 1));
    }
    frame.intercept = decimal(set, {0x0028, 0x1052}, frame.intercept);
    frame.slope = decimal(set, {0x0028, 0x1053}, frame.slope);
    if (has(set, {0x0028, 0x1054})) rescale_type_ = text(set, {0x0028, 0x1054});
    frame.time = whole(set, {0x0020, 0x0100}, frame.time);
    for (const double time : binary<std::uint32_t>(set, {0x0020, 0x9128})) {
      frame.time = static_cast<int>(std::fmin(time, 1e9));
    }
    frame.segment = unsigned_short(set, {0x0062, 0x000b}, frame.segment);
  }

  // Plane position and orientation, pixel measures, value transformation, content, segment.
  void take_groups(const gdcm::DataSet& set, DicomFrame& frame) {
    for (const gdcm::Tag& tag :
         {gdcm::Tag(0x0020, 0x9113), gdcm::Tag(0x0020, 0x9116), gdcm::Tag(0x0028, 0x9110),
          gdcm::Tag(0x0028, 0x9145), gdcm::Tag(0x0020, 0x9111), gdcm::Tag(0x0062, 0x000a)}) {
      for (const gdcm::DataSet* item : items(set, tag, alive_)) take_all(*item, frame);
    }
  }

  // `offsets_mm` along the normal of the first frame.
  std::vector<DicomFrame> along_normal(const std::vector<double>& offsets_mm) const {
    const std::vector<double>&o = shared_.orientation, &p = shared_.position;
    if (o.empty() || p.empty()) return {};
    const Vec3 normal = cross({o[0], o[1], o[2]}, {o[3], o[4], o[5]});
    std::vector<DicomFrame> frames;
    for (const double offset : offsets_mm) {
      frames.push_back(shared_);
      const Vec3 at = Vec3{p[0], p[1], p[2]} + offset * normal;
      frames.back().position = {at.x, at.y, at.z};
    }
    return frames;
  }

  // Files that tell only where their first frame lies.
  std::vector<DicomFrame> after_the_first(const DicomFile& file) {
    constexpr long long kMost = 1 << 20;
    const bool is_film = file.modality == "US" || file.modality == "XA" || file.modality == "RF";
    if (is_film || file.frame_count < 2 || file.frame_count > kMost) return {};
    if (file.modality == "NM") {
      const std::string type = text(root_, {0x0008, 0x0008});
      if (type.find("RECON TOMO") == std::string::npos) return {};
      for (const gdcm::DataSet* detector : items(root_, {0x0054, 0x0022}, alive_)) {
        take_all(*detector, shared_);
        break;
      }
    }
    if (shared_.distance.empty()) return {};
    std::vector<double> offsets;
    for (int n = 0; n < file.frame_count; ++n) offsets.push_back(n * shared_.distance[0]);
    return along_normal(offsets);
  }

  // Doses tell each frame's distance from the first along the normal, or, where the first number is
  // not 0, each frame's z (DICOM PS3.3, C.8.8.3.2).
  std::vector<DicomFrame> dose(DicomFile& file) {
    if (file.modality != "RTDOSE") return {};
    shared_.slope = decimal(root_, {0x3004, 0x000e}, 1);
    file.units = text(root_, {0x3004, 0x0002});
    std::vector<double> offsets = decimals(root_, {0x3004, 0x000c});
    if (offsets.empty() || offsets[0] == 0 || shared_.orientation.empty()) {
      return along_normal(offsets);
    }
    const std::vector<double>& o = shared_.orientation;
    const double upward = cross({o[0], o[1], o[2]}, {o[3], o[4], o[5]}).z < 0 ? -1 : 1;
    const double first = offsets[0];
    for (double& offset : offsets) offset = upward * (offset - first);
    return along_normal(offsets);
  }

  const gdcm::DataSet& root_;
  DicomFrame shared_;
  std::string rescale_type_;
  std::vector<gdcm::SmartPointer<gdcm::SequenceOfItems>> alive_;
};

// --- Pixels ---

std::string transfer_syntax_text(const std::string& uid) {
  gdcm::UIDs known;
  const char* name = known.SetFromUID(uid.c_str()) ? known.GetName() : nullptr;
  return name ? std::string(name) + ", " + uid : uid;
}

// Finds uncompressed pixels, whose element's head ends where the reader stopped, or the fault.
void find_pixels(const gdcm::Reader& reader, std::istream& stream, DicomFile& file) {
  const gdcm::TransferSyntax& syntax = reader.GetFile().GetHeader().GetDataSetTransferSyntax();
  if (syntax == gdcm::TransferSyntax::DeflatedExplicitVRLittleEndian) return;
  const auto value = static_cast<std::streamoff>(reader.GetStreamCurrentPosition());
  char head[12] = {};
  stream.clear();
  stream.seekg(value - 12);
  stream.read(head, sizeof head);
  const auto has_tag = [&](std::size_t at, bool big) {
    const char element = file.packing.is_float ? (file.packing.bits_allocated == 64 ? 9 : 8) : 0x10;
    const char little_tag[] = {'\xe0', '\x7f', element, 0},
               big_tag[] = {'\x7f', '\xe0', 0, element};
    return std::memcmp(head + at, big ? big_tag : little_tag, 4) == 0;
  };
  const bool is_big = has_tag(0, true);
  const bool is_explicit = is_big || has_tag(0, false);
  const bool is_implicit = !is_explicit && has_tag(4, false);
  if (!stream || !(is_explicit || is_implicit)) {
    file.fault = kNoImage;
    return;
  }
  file.is_in_pieces = syntax.IsEncapsulated();
  if (file.is_in_pieces) return;
  std::uint32_t length = 0;
  for (int n = 0; n < 4; ++n) {
    const auto byte = static_cast<unsigned char>(head[is_big ? 8 + n : 11 - n]);
    length = length << 8 | byte;
  }
  if (length == 0xffffffff) return;  // called uncompressed, but in fragments
  const double promised = std::ceil(file.voxel_count() * file.packing.bits_allocated / 8);
  if (file.fault.empty() && file.samples == 1 && promised > length) {
    file.fault = "its header promises " + to_text(promised) + " bytes of pixels, but gives only " +
                 std::to_string(length);
  }
  file.pixel_offset = static_cast<long long>(file.start) + value;
  const bool is_swapped = is_big || syntax == gdcm::TransferSyntax::ImplicitVRBigEndianPrivateGE;
  const bool is_words = !is_explicit || std::memcmp(head + 4, "OW", 2) == 0;
  if (is_swapped && file.packing.bits_allocated >= 8) {
    file.swapped_bytes = std::max(file.packing.bits_allocated / 8, is_words ? 2 : 1);
  }
}

void parse_packing(const gdcm::DataSet& set, DicomFile& file) {
  PixelPacking& packing = file.packing;
  packing.bits_allocated = unsigned_short(set, {0x0028, 0x0100}, 0);
  packing.bits_stored = unsigned_short(set, {0x0028, 0x0101}, packing.bits_allocated);
  packing.high_bit = unsigned_short(set, {0x0028, 0x0102}, packing.bits_stored - 1);
  packing.is_signed = unsigned_short(set, {0x0028, 0x0103}, 0) == 1;
  file.padding = packing.is_signed ? binary<std::int16_t>(set, {0x0028, 0x0120})
                                   : binary<std::uint16_t>(set, {0x0028, 0x0120});
}

std::string segment_names(const gdcm::DataSet& set) {
  std::vector<gdcm::SmartPointer<gdcm::SequenceOfItems>> alive;
  std::string names;
  for (const gdcm::DataSet* segment : items(set, {0x0062, 0x0002}, alive)) {
    names += (names.empty() ? "" : ", ") +
             std::to_string(unsigned_short(*segment, {0x0062, 0x0004}, 0)) + " " +
             text(*segment, {0x0062, 0x0005});
  }
  return names;
}

std::string date_text(const gdcm::DataSet& set) {
  for (const gdcm::Tag& tag : {gdcm::Tag(0x0008, 0x0021), gdcm::Tag(0x0008, 0x0020)}) {
    const std::string date = text(set, tag);
    if (date.size() != 8) continue;
    return date.substr(0, 4) + "-" + date.substr(4, 2) + "-" + date.substr(6, 2);
  }
  return {};
}

// Reads up to the pixels that stand under `tag`.
DicomFile parse_up_to(const std::string& path, std::size_t start, const gdcm::Tag& tag) {
  DicomFile file;
  file.path = path;
  file.start = start;
  const std::unique_ptr<std::istream> stream = open(path, start);
  gdcm::Reader reader;
  reader.SetStream(*stream);
  const bool is_read = reader.ReadUpToTag(tag, {kPixelData, kFloatPixels, kDoublePixels});
  const gdcm::FileMetaInformation& header = reader.GetFile().GetHeader();
  const std::string syntax = text(header, {0x0002, 0x0010});
  file.transfer_syntax =
      transfer_syntax_text(syntax.empty() ? header.GetDataSetTransferSyntax().GetString() : syntax);
  if (!is_read) {
    const bool is_known =
        gdcm::TransferSyntax::GetTSType(syntax.c_str()) < gdcm::TransferSyntax::TS_END;
    file.fault = syntax.empty() ? "is DICOM, but its header names no transfer syntax"
                 : is_known     ? "is DICOM, but its header is damaged"
                                : "is in a transfer syntax that isolux cannot decode (" +
                                  file.transfer_syntax + ")";
    return file;
  }
  const gdcm::DataSet& set = reader.GetFile().GetDataSet();
  file.instance_uid = text(set, {0x0008, 0x0018});
  file.series_uid = text(set, {0x0020, 0x000e});
  file.description = text(set, {0x0008, 0x103e});
  file.modality = text(set, {0x0008, 0x0060});
  file.date = date_text(set);
  file.series_number = whole(set, {0x0020, 0x0011}, 0);
  file.instance_number = whole(set, {0x0020, 0x0013}, 0);
  file.segments = segment_names(set);
  file.photometric = text(set, {0x0028, 0x0004});
  file.rows = unsigned_short(set, {0x0028, 0x0010}, 0);
  file.columns = unsigned_short(set, {0x0028, 0x0011}, 0);
  file.samples = unsigned_short(set, {0x0028, 0x0002}, 1);
  if (const std::string frames = text(set, {0x0028, 0x0008}); !frames.empty()) {
    file.frame_count = parse_whole_number(frames).value_or(0);
  }
  parse_packing(set, file);
  file.frames = FrameParser(set).frames(file);
  if (file.modality == "PT") file.units = text(set, {0x0054, 0x1001});
  if (tag != kPixelData) {
    file.packing = {.bits_allocated = tag == kDoublePixels ? 64 : 32, .is_float = true};
  }
  if (has(set, {0x0028, 0x3000})) {
    file.fault = "has a lookup table for its values (Modality LUT), which isolux does not apply";
    return file;
  }
  find_pixels(reader, *stream, file);
  return file;
}

}  // namespace

DicomFile parse_dicom_header(const std::string& path, std::size_t start) {
  DicomFile file = parse_up_to(path, start, kPixelData);
  for (const gdcm::Tag& tag : {kFloatPixels, kDoublePixels}) {
    if (file.fault != kNoImage) break;
    file = parse_up_to(path, start, tag);
  }
  return file;
}

namespace {

// --- Decoding ---

// Sends the voxels of the frames that an image holds; the packing goes before the first of all.
class FrameSender {
 public:
  FrameSender(const DicomFile& file, FenceOutput& output) : file_(file), output_(output) {}

  // Why it cannot be done; empty: it was.
  std::string send(const gdcm::Image& image, long long frames) {
    std::vector<char> voxels(image.GetBufferLength());
    if (!image.GetBuffer(voxels.data())) return "cannot be decoded";
    const gdcm::PixelFormat& format = image.GetPixelFormat();
    const PixelPacking packing{format.GetBitsAllocated(), format.GetBitsStored(),
                               format.GetHighBit(), format.GetPixelRepresentation() == 1};
    const double expected = std::ceil(1.0 * file_.columns * file_.rows *
                                      static_cast<double>(frames) * packing.bits_allocated / 8);
    if (format.GetSamplesPerPixel() != 1 || static_cast<double>(voxels.size()) < expected ||
        (packing_ && !(packing == *packing_))) {
      return "decode to another size than its header says";
    }
    if (!packing_) {
      output_.send_text("");
      output_.send(&packing, sizeof packing);
    }
    packing_ = packing;
    output_.send(voxels.data(), static_cast<std::size_t>(expected));
    return {};
  }

  // As WorkError, once frames are on their way.
  void fail(const std::string& why) {
    if (packing_) {
      throw WorkError(file_.path,
                      "its pixels " + why + " (transfer syntax " + file_.transfer_syntax + ")",
                      "is the file complete?");
    }
    output_.send_text(why);
  }

 private:
  const DicomFile& file_;
  FenceOutput& output_;
  std::optional<PixelPacking> packing_;
};

// Where the encoded pieces of the pixels lie in a stream.
struct Fragment {
  std::streamoff begin = 0;
  std::uint32_t length = 0;
};

// The items of encoded pixels from where the element's head ends: first the table of offsets, which
// may be empty, then the pieces. Empty where that is not what stands there.
std::vector<Fragment> fragments_at(std::istream& stream, std::streamoff at) {
  std::vector<Fragment> fragments;
  while (true) {
    unsigned char head[8] = {};
    stream.clear();
    stream.seekg(at);
    stream.read(reinterpret_cast<char*>(head), sizeof head);
    if (!stream) return {};
    const std::uint32_t length =
        head[4] | head[5] << 8 | head[6] << 16 | static_cast<std::uint32_t>(head[7]) << 24;
    if (std::memcmp(head, "\xfe\xff\xdd\xe0", 4) == 0) return fragments;
    if (std::memcmp(head, "\xfe\xff\x00\xe0", 4) != 0 || length == 0xffffffff) return {};
    fragments.push_back({at + 8, length});
    at += 8 + static_cast<std::streamoff>(length);
  }
}

// Takes a file made in memory for one that was read.
class OneFrame : public gdcm::ImageReader {
 public:
  bool read(gdcm::File& file) {
    SetFile(file);
    GetImage().SetTransferSyntax(file.GetHeader().GetDataSetTransferSyntax());
    return ReadImage(gdcm::MediaStorage::SecondaryCaptureImageStorage);
  }
};

// The number in a table of offsets.
std::uint32_t offset_at(const std::string& table, std::size_t n) {
  std::uint32_t offset = 0;
  for (std::size_t byte = 4; byte-- > 0;) {
    offset = offset << 8 | static_cast<unsigned char>(table[4 * n + byte]);
  }
  return offset;
}

std::string bytes_at(std::istream& stream, const Fragment& fragment, std::size_t most) {
  std::string bytes(std::min<std::size_t>(fragment.length, most), '\0');
  stream.clear();
  stream.seekg(fragment.begin);
  stream.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  bytes.resize(static_cast<std::size_t>(std::max<std::streamsize>(stream.gcount(), 0)));
  return bytes;
}

// Whether a picture in JPEG, JPEG-LS or JPEG 2000 begins here.
bool begins_a_picture(const std::string& bytes) {
  return bytes.starts_with("\xff\xd8\xff") || bytes.starts_with("\xff\x4f\xff\x51");
}

// The numbers of the pieces that frames begin with, and behind them that of the end: a piece a
// frame, else as the table of offsets says, else where pictures begin. Empty where none of these
// makes `count` frames.
std::vector<std::size_t> frame_starts(std::istream& stream, const std::vector<Fragment>& items,
                                      std::size_t count) {
  if (items.size() < count + 1) return {};
  std::vector<std::size_t> starts;
  if (items.size() == count + 1) {
    for (std::size_t n = 1; n <= items.size(); ++n) starts.push_back(n);
    return starts;
  }
  const std::string table = bytes_at(stream, items[0], 4 * count);
  for (std::size_t n = 1; n < items.size() && table.size() == 4 * count; ++n) {
    const std::streamoff offset = items[n].begin - items[1].begin;
    if (starts.size() < count && offset == offset_at(table, starts.size())) starts.push_back(n);
  }
  if (starts.size() != count) {
    starts.clear();
    for (std::size_t n = 1; n < items.size(); ++n) {
      if (begins_a_picture(bytes_at(stream, items[n], 4))) starts.push_back(n);
    }
  }
  if (starts.size() != count || starts[0] != 1) return {};
  starts.push_back(items.size());
  return starts;
}

// Sends frames [begin, end) one at a time, so that neither the encoded nor the decoded pixels are
// ever whole in memory. GDCM is given files of one frame, made in memory.
void send_one_by_one(const DicomFile& file, std::size_t begin, std::size_t end,
                     FrameSender& sender) {
  const std::unique_ptr<std::istream> stream = open(file.path, file.start);
  gdcm::Reader header;
  header.SetStream(*stream);
  if (!header.ReadUpToTag(kPixelData, {kPixelData})) return sender.fail("cannot be found");
  const gdcm::TransferSyntax& syntax = header.GetFile().GetHeader().GetDataSetTransferSyntax();
  const std::vector<Fragment> items =
      fragments_at(*stream, static_cast<std::streamoff>(header.GetStreamCurrentPosition()));
  const std::vector<std::size_t> starts =
      frame_starts(*stream, items, static_cast<std::size_t>(file.frame_count));
  if (starts.empty()) return sender.fail("are in pieces that do not make its frames");
  const gdcm::SmartPointer<gdcm::File> frame_file = new gdcm::File;
  frame_file->GetHeader().SetDataSetTransferSyntax(syntax);
  for (const gdcm::DataElement& element : header.GetFile().GetDataSet().GetDES()) {
    const bool is_of_image = element.GetTag().GetGroup() == 0x0028;
    if (is_of_image && element.GetTag() != gdcm::Tag(0x0028, 0x0008)) {
      frame_file->GetDataSet().Insert(element);
    }
  }
  for (std::size_t frame = begin; frame < end; ++frame) {
    std::string encoded;
    std::size_t length = 0;
    for (std::size_t n = starts[frame]; n < starts[frame + 1]; ++n) {
      encoded += bytes_at(*stream, items[n], items[n].length);
      length += items[n].length;
    }
    if (encoded.size() != length) return sender.fail("are cut short");
    gdcm::Fragment piece;
    piece.SetByteValue(encoded.data(), gdcm::VL(static_cast<std::uint32_t>(length)));
    const gdcm::SmartPointer<gdcm::SequenceOfFragments> pieces = new gdcm::SequenceOfFragments;
    pieces->AddFragment(piece);
    gdcm::DataElement pixels(kPixelData, 0xffffffff, gdcm::VR::OB);
    pixels.SetValue(*pieces);
    frame_file->GetDataSet().Replace(pixels);
    OneFrame one;
    const std::string why =
        one.read(*frame_file) ? sender.send(one.GetImage(), 1) : "cannot be decoded";
    if (!why.empty()) return sender.fail(why);
  }
}

}  // namespace

void decode_dicom_pixels(const DicomFile& file, std::size_t begin, std::size_t end,
                         FenceOutput& output) {
  FrameSender sender(file, output);
  if (file.is_in_pieces && file.frame_count > 1) return send_one_by_one(file, begin, end, sender);
  const std::unique_ptr<std::istream> stream = open(file.path, file.start);
  gdcm::ImageReader reader;
  reader.SetStream(*stream);
  const std::string why =
      reader.Read() ? sender.send(reader.GetImage(), file.frame_count) : "cannot be decoded";
  if (!why.empty()) sender.fail(why);
}

}  // namespace isolux
