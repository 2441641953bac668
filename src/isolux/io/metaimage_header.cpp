#include "isolux/io/metaimage_header.h"

#include <algorithm>
#include <map>
#include <optional>
#include <set>
#include <sstream>

#include "isolux/base/error.h"
#include "isolux/base/number_text.h"
#include "isolux/io/data_file.h"
#include "isolux/io/header_text.h"
#include "isolux/io/stored_bytes.h"

namespace isolux {
namespace {

WorkError damaged(const std::string& path, const std::string& why) {
  return {path, "damaged MetaImage header: " + why, "compare it with the file that wrote it"};
}

// The fields of a header, up to ElementDataFile, which ends it.
struct Fields {
  std::string path;
  std::map<std::string, std::string> values;
  std::vector<std::string> listed_files;  // the lines behind ElementDataFile = LIST
  std::size_t bytes = 0;                  // up to the end of the line of ElementDataFile

  /// The field's value; where several names stand for one thing, the last that is there.
  /// Nothing where none of them is.
  const std::pair<const std::string, std::string>* find(
      std::initializer_list<const char*> names) const {
    const std::pair<const std::string, std::string>* found = nullptr;
    for (const char* name : names) {
      const auto at = values.find(name);
      if (at != values.end()) found = &*at;
    }
    return found;
  }

  std::string text(std::initializer_list<const char*> names) const {
    const auto* field = find(names);
    return field ? field->second : "";
  }

  bool is_true(std::initializer_list<const char*> names) const {
    const std::string value = text(names);
    return !value.empty() && (value[0] == 'T' || value[0] == 't' || value[0] == '1');
  }

  /// The field's numbers, or `count` times `otherwise` where it is absent.
  std::vector<double> numbers(std::initializer_list<const char*> names, std::size_t count,
                              double otherwise) const {
    const auto* field = find(names);
    if (!field) return std::vector<double>(count, otherwise);
    std::vector<double> list;
    for (const std::string& word : words(field->second)) {
      const auto number = parse_number(word);
      if (!number) throw damaged(path, field->first + " holds '" + word + "'");
      list.push_back(*number);
    }
    if (list.size() != count) {
      throw damaged(path, field->first + " holds " + std::to_string(list.size()) +
                              " numbers, not " + std::to_string(count));
    }
    return list;
  }

  double number(const char* name, double otherwise) const {
    return numbers({name}, 1, otherwise)[0];
  }
};

// "Name = value" or "Name : value", as MetaIO takes them.
std::optional<std::pair<std::string, std::string>> field_of(const std::string& line) {
  const std::size_t sign = line.find_first_of("=:");
  if (sign == std::string::npos) return std::nullopt;
  return std::pair(trimmed(line.substr(0, sign)), trimmed(line.substr(sign + 1)));
}

Fields read_fields(const std::string& path) {
  constexpr double kLongestHeader = 4 << 20;
  const double length = std::min(kLongestHeader, stored_size({path}));
  std::istringstream stream(first_bytes({path}, static_cast<std::size_t>(length)));
  Fields fields{path, {}, {}, 0};
  for (std::string line; std::getline(stream, line);) {
    fields.bytes += line.size() + 1;
    if (trimmed(line).empty()) continue;
    const auto field = field_of(line);
    if (!field) throw damaged(path, "a line has no field: '" + trimmed(line).substr(0, 40) + "'");
    fields.values[field->first] = field->second;
    if (field->first != "ElementDataFile") continue;
    if (field->second.starts_with("LIST")) {
      while (std::getline(stream, line)) {
        if (!trimmed(line).empty()) fields.listed_files.push_back(trimmed(line));
      }
    }
    return fields;
  }
  throw damaged(path, "it has no ElementDataFile");
}

StoredType stored_type(const Fields& fields) {
  // MET_LONG has four bytes, whatever a long has on the machine that wrote it.
  static const std::map<std::string, StoredType> kTypes = {
      {"MET_CHAR", StoredType::kI8},        {"MET_ASCII_CHAR", StoredType::kI8},
      {"MET_UCHAR", StoredType::kU8},       {"MET_SHORT", StoredType::kI16},
      {"MET_USHORT", StoredType::kU16},     {"MET_INT", StoredType::kI32},
      {"MET_UINT", StoredType::kU32},       {"MET_LONG", StoredType::kI32},
      {"MET_ULONG", StoredType::kU32},      {"MET_LONG_LONG", StoredType::kI64},
      {"MET_ULONG_LONG", StoredType::kU64}, {"MET_FLOAT", StoredType::kF32},
      {"MET_DOUBLE", StoredType::kF64}};
  const std::string name = fields.text({"ElementType"});
  const auto found = kTypes.find(name);
  if (found == kTypes.end()) {
    throw damaged(fields.path, "ElementType '" + name + "' is not a number type");
  }
  return found->second;
}

void refuse_other_kinds(const Fields& fields) {
  const std::string object = fields.text({"ObjectType"});
  if (!object.empty() && object != "Image") {
    throw WorkError(fields.path, "holds the MetaIO object '" + object + "'",
                    "isolux reads those of ObjectType Image");
  }
  if (fields.find({"BinaryData"}) && !fields.is_true({"BinaryData"})) {
    throw WorkError(fields.path, "has its voxels as text (BinaryData = False)",
                    "write it again with binary data");
  }
}

void set_channels(MetaImageHeader& header, const Fields& fields) {
  const double channels = fields.number("ElementNumberOfChannels", 1);
  constexpr double kMost = 1 << 20;
  if (!(channels >= 1 && channels <= kMost) || channels != static_cast<int>(channels)) {
    throw damaged(fields.path, "ElementNumberOfChannels is " + to_text(channels));
  }
  header.channels = static_cast<int>(channels);
}

void set_dims(MetaImageHeader& header, const Fields& fields) {
  const double axes = fields.number("NDims", 0);
  constexpr double kMostAxes = 4;
  if (!(axes >= 1 && axes <= kMostAxes) || axes != static_cast<int>(axes)) {
    throw damaged(fields.path, "NDims is " + to_text(axes) + ", not 1 to 4");
  }
  header.axes = static_cast<std::size_t>(axes);
  header.dims = {1, 1, 1, 1};
  const std::vector<double> sizes = fields.numbers({"DimSize"}, header.axes, 0);
  double numbers = header.channels;
  for (std::size_t axis = 0; axis < header.axes; ++axis) {
    constexpr double kLongest = 1 << 30;
    if (!(sizes[axis] >= 1 && sizes[axis] <= kLongest) ||
        sizes[axis] != static_cast<int>(sizes[axis])) {
      throw damaged(fields.path, "DimSize holds " + to_text(sizes[axis]));
    }
    header.dims[axis] = static_cast<int>(sizes[axis]);
    numbers *= sizes[axis];
  }
  constexpr double kMostNumbers = 1e18;  // so that no product of dims and bytes overflows
  if (numbers > kMostNumbers)
    throw damaged(fields.path, "it promises " + to_text(numbers) + " numbers");
}

// The names that MetaIO has for one thing stand in the order in which it reads them, so that the
// same one wins.
void set_place(MetaImageHeader& header, const Fields& fields, std::vector<std::string>& notes) {
  header.spacing = fields.numbers({"ElementSize", "ElementSpacing"}, header.axes, 1);
  for (const double spacing : header.spacing) {
    if (!(spacing > 0)) throw damaged(fields.path, "its spacing is " + to_text(spacing));
  }
  header.origin = fields.numbers({"Position", "Offset", "Origin"}, header.axes, 0);
  if (fields.find({"Orientation", "Rotation", "TransformMatrix"})) {
    header.matrix = fields.numbers({"Orientation", "Rotation", "TransformMatrix"},
                                   header.axes * header.axes, 0);
  } else {
    notes.push_back("it does not say how its axes lie in the patient: taken as LPS");
    header.matrix.assign(header.axes * header.axes, 0);
    for (std::size_t axis = 0; axis < header.axes; ++axis) {
      header.matrix[axis * (header.axes + 1)] = 1;
    }
  }
  const std::string orientation = fields.text({"AnatomicalOrientation"});
  if (!orientation.empty() && orientation.find('?') == std::string::npos) {
    notes.push_back("AnatomicalOrientation (" + orientation +
                    ") is for information alone: its matrix places it, in LPS");
  }
  const std::string unit = fields.text({"DistanceUnits"});
  if (!unit.empty() && unit != "mm" && unit != "?") {
    notes.push_back("its lengths are in '" + unit + "' and taken as mm, number for number");
  }
}

// The files that ElementDataFile names, each for an equal share of the voxels.
std::vector<std::string> data_files(const MetaImageHeader& header, const Fields& fields) {
  const std::string value = fields.text({"ElementDataFile"});
  if (value == "LOCAL" || value == "Local" || value == "local") return {fields.path};
  const std::vector<std::string> w = words(value);
  std::vector<std::string> files;
  std::size_t axes_in_a_file = header.axes - 1;
  if (!w.empty() && w[0] == "LIST") {
    // "LIST 2D": each file has two axes.
    if (w.size() > 1 && w[1][0] >= '1' && w[1][0] <= '4') {
      axes_in_a_file = std::min<std::size_t>(static_cast<std::size_t>(w[1][0] - '0'), header.axes);
    }
    files = fields.listed_files;
  } else if (w.size() > 1 && w[0].find('%') != std::string::npos) {
    const auto first = parse_whole_number(w[1]);
    const auto step = parse_whole_number(w.size() > 3 ? w[3] : "1");
    std::optional<long long> last = first;
    if (w.size() > 2) last = parse_whole_number(w[2]);
    if (w.size() == 2 && first) last = *first + header.dims[header.axes - 1] - 1;
    if (first && last && step) files = numbered_files(w[0], *first, *last, *step);
    if (files.empty())
      throw damaged(fields.path, "data file pattern '" + value + "' is not understood");
  } else {
    return {data_file_beside(fields.path, value)};
  }
  double expected = 1;
  for (std::size_t axis = axes_in_a_file; axis < header.axes; ++axis) expected *= header.dims[axis];
  if (static_cast<double>(files.size()) != expected) {
    throw damaged(fields.path, "it names " + std::to_string(files.size()) +
                                   " data files, not the " + to_text(expected) + " of its DimSize");
  }
  for (std::string& file : files) file = data_file_beside(fields.path, file);
  return files;
}

void set_data(MetaImageHeader& header, const Fields& fields) {
  header.deflated = fields.is_true({"CompressedData"});
  header.big_endian = fields.is_true({"ElementByteOrderMSB", "BinaryDataByteOrderMSB"});
  header.data_files = data_files(header, fields);
  const double skip = fields.number("HeaderSize", 0);
  constexpr double kLargest = 1e15;
  if (!(skip >= -1 && skip <= kLargest) ||
      skip != static_cast<double>(static_cast<long long>(skip))) {
    throw damaged(fields.path, "HeaderSize is " + to_text(skip));
  }
  if (skip == -1 && header.deflated) {
    throw damaged(fields.path, "HeaderSize is -1, but how long compressed data are is not known");
  }
  header.data_at_end = skip == -1;
  // As in MetaIO, a HeaderSize counts from the beginning of a LOCAL file too.
  const bool is_local = header.data_files == std::vector<std::string>{fields.path};
  if (skip > 0) {
    header.data_offset = static_cast<std::uint64_t>(skip);
  } else if (is_local) {
    header.data_offset = fields.bytes;
  }
}

}  // namespace

bool looks_like_metaimage(std::string_view first_bytes) {
  static const std::set<std::string> kFirstFields = {
      "ObjectType", "ObjectSubType",  "NDims",
      "Comment",    "Name",           "ID",
      "ParentID",   "DimSize",        "ElementType",
      "BinaryData", "CompressedData", "ElementSpacing",
      "Modality",   "AcquisitionDate"};
  const std::string text = trimmed(first_bytes);
  const auto field = field_of(text.substr(0, text.find('\n')));
  if (!field || !kFirstFields.contains(field->first)) return false;
  return text.find("NDims") != std::string::npos || field->first == "ObjectType";
}

MetaImageHeader read_metaimage_header(const std::string& path, std::vector<std::string>& notes) {
  const Fields fields = read_fields(path);
  refuse_other_kinds(fields);
  MetaImageHeader header;
  set_channels(header, fields);
  set_dims(header, fields);
  header.type = stored_type(fields);
  set_place(header, fields, notes);
  set_data(header, fields);
  header.rescale = {fields.number("ElementToIntensityFunctionSlope", 1),
                    fields.number("ElementToIntensityFunctionOffset", 0)};
  if (header.rescale.slope == 0) throw damaged(path, "ElementToIntensityFunctionSlope is 0");
  if (header.rescale != Rescale{}) {
    notes.push_back("its values are rescaled by ElementToIntensityFunction");
  }
  const std::string modality = fields.text({"Modality"});
  for (const std::string known : {"CT", "MR", "US"}) {
    if (modality == "MET_MOD_" + known) header.modality = known;
  }
  return header;
}

}  // namespace isolux
