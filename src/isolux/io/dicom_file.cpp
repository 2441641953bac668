#include "isolux/io/dicom_file.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "isolux/base/error.h"
#include "isolux/base/fence.h"
#include "isolux/base/memory.h"
#include "isolux/base/number_text.h"
#include "isolux/base/parallel.h"
#include "isolux/io/dicom_parse.h"
#include "isolux/io/dicom_signature.h"

namespace isolux {

// For the way home from the fence.
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(PixelPacking, bits_allocated, bits_stored, high_bit, is_signed,
                                   is_float)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(DicomFrame, position, orientation, spacing, distance, slope,
                                   intercept, time, segment)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(DicomFile, path, fault, instance_uid, series_uid, description,
                                   modality, date, units, segments, transfer_syntax, photometric,
                                   series_number, instance_number, columns, rows, samples,
                                   frame_count, packing, padding, remarks, frames, start,
                                   pixel_offset, swapped_bytes, is_in_pieces)

namespace {

std::string first_bytes_of(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::string bytes(512, '\0');
  file.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  bytes.resize(static_cast<std::size_t>(std::max<std::streamsize>(file.gcount(), 0)));
  return bytes;
}

double size_of(const std::string& path) {
  std::error_code error;
  const auto size = std::filesystem::file_size(path, error);
  return error ? 0 : static_cast<double>(size);
}

// How many bytes of voxels a byte of a file can stand for at the very most. An empty slice in
// JPEG 2000 is a few hundred bytes.
double best_ratio(const DicomFile& file) { return file.is_plain() ? 1 : 1e4; }

bool is_sound(const PixelPacking& packing) {
  const int bits = packing.bits_allocated;
  if (packing.is_float) return bits == 32 || bits == 64;
  return (bits == 1 || bits == 8 || bits == 16 || bits == 32) && packing.bits_stored >= 1 &&
         packing.bits_stored <= bits && packing.high_bit >= packing.bits_stored - 1 &&
         packing.high_bit < bits;
}

std::string size_fault(const DicomFile& file) {
  const PixelPacking& packing = file.packing;
  if (file.rows < 1 || file.columns < 1) {
    return "is " + std::to_string(file.columns) + " x " + std::to_string(file.rows) + " pixels";
  }
  if (file.frame_count < 1) return "its number of frames is not a positive number";
  if (file.samples == 1 && !is_sound(packing)) {
    return "stores " + std::to_string(packing.bits_stored) + " of " +
           std::to_string(packing.bits_allocated) + " bits a voxel, which isolux does not read";
  }
  if (file.frames.empty() ||
      (file.frames.size() > 1 && static_cast<long long>(file.frames.size()) < file.frame_count)) {
    return "describes " + std::to_string(file.frames.size()) + " of its " +
           std::to_string(file.frame_count) + " frames";
  }
  if (file.samples != 1) return {};
  const double promised = file.voxel_count() * packing.bits_allocated / 8;
  const double there = size_of(file.path) - static_cast<double>(std::max(0LL, file.pixel_offset));
  if (!(promised <= there * best_ratio(file))) {
    return "its header promises " + to_text(promised) + " bytes of pixels, but only " +
           to_text(std::max(0.0, there)) + " bytes are there";
  }
  return {};
}

// Has the headers of `paths` parsed in one child, as far as that gets; the file that it dies of
// gets a fault. At least one is described.
void describe_some(const std::string* paths, std::size_t count, std::vector<DicomFile>& files) {
  double largest = 0;
  for (std::size_t n = 0; n < count; ++n) largest = std::max(largest, size_of(paths[n]));
  const auto parse = [&](FenceOutput& output) {
    for (std::size_t n = 0; n < count; ++n) {
      nlohmann::json described;
      try {
        const auto start = dicom_start(first_bytes_of(paths[n]));
        described = parse_dicom_header(paths[n], start.value_or(0));
      } catch (...) {  // stays empty, which says enough
      }
      output.send_text(described.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace));
    }
  };
  const auto take = [&](Fence& fence) {
    for (std::size_t n = 0; n < count; ++n) {
      DicomFile file;
      const std::string described = fence.receive_text();
      try {
        file = nlohmann::json::parse(described).get<DicomFile>();
        if (file.fault.empty()) file.fault = size_fault(file);
      } catch (const nlohmann::json::exception&) {
        file.fault = "is DICOM, but its header is damaged";
      }
      file.path = paths[n];
      files.push_back(file);
    }
  };
  const std::size_t before = files.size();
  try {
    Fence fence({.seconds = 10, .memory = 512e6 + 2 * largest}, parse);
    take(fence);
  } catch (const FenceBroken& broken) {
    DicomFile file;
    file.path = paths[files.size() - before];
    file.fault = std::string("is DICOM, but damaged: its header ") + broken.what();
    files.push_back(file);
  }
}

void read_plain(const DicomFile& file, std::size_t begin, std::size_t end, const UseFrame& use) {
  std::ifstream stream(file.path, std::ios::binary);
  const std::size_t voxels = static_cast<std::size_t>(file.columns) * file.rows;
  const auto bits = static_cast<std::size_t>(file.packing.bits_allocated);
  std::vector<char> packed;
  for (std::size_t frame = begin; frame < end; ++frame) {
    const std::size_t first_bit = frame * voxels * bits;
    // Swapped groups must not be torn: a frame of an odd number of swapped bytes begins inside one.
    const std::size_t unit = static_cast<std::size_t>(file.swapped_bytes);
    const std::size_t from = first_bit / 8 / unit * unit;
    const std::size_t to = (first_bit + voxels * bits + 7) / 8;
    packed.assign((to - from + unit - 1) / unit * unit, 0);
    stream.seekg(static_cast<std::streamoff>(file.pixel_offset) +
                 static_cast<std::streamoff>(from));
    stream.read(packed.data(), static_cast<std::streamsize>(packed.size()));
    if (stream.gcount() < static_cast<std::streamsize>(to - from)) {
      throw WorkError(file.path, "its pixels are cut short", "is the file complete?");
    }
    stream.clear();
    for (auto at = packed.begin(); unit > 1 && at != packed.end();
         at += static_cast<std::ptrdiff_t>(unit)) {
      std::reverse(at, at + static_cast<std::ptrdiff_t>(unit));
    }
    use(frame, file.packing, packed.data(), (first_bit - 8 * from) / bits);
  }
}

void read_encoded(const DicomFile& file, std::size_t begin, std::size_t end, const UseFrame& use) {
  const auto fail = [&](const std::string& why) {
    throw WorkError(file.path,
                    "its pixels " + why + " (transfer syntax " + file.transfer_syntax + ")",
                    "is the file complete?");
  };
  const std::size_t first = file.is_in_pieces ? begin : 0;  // else all come
  const double frame_voxels = 1.0 * file.columns * file.rows;
  const double promised = frame_voxels * static_cast<double>(end - first) *
                          std::max(8, file.packing.bits_allocated) / 8;
  check_memory(promised, file.path);
  const FenceLimits limits{.seconds = 10 + promised / 4e6,
                           .memory = 512e6 + 4 * promised + 2 * size_of(file.path)};
  const std::size_t voxels = static_cast<std::size_t>(file.columns) * file.rows;
  try {
    Fence fence(limits,
                [&](FenceOutput& output) { decode_dicom_pixels(file, first, end, output); });
    if (const std::string why = fence.receive_text(); !why.empty()) fail(why);
    PixelPacking packing;
    fence.receive(&packing, sizeof packing);
    const auto bits = static_cast<std::size_t>(packing.bits_allocated);
    if (!is_sound(packing) || voxels * bits % 8 != 0) fail("are packed in an unknown way");
    std::vector<char> packed(voxels * bits / 8);
    for (std::size_t frame = first; frame < end; ++frame) {
      fence.receive(packed.data(), packed.size());
      if (frame >= begin) use(frame, packing, packed.data(), 0);
    }
  } catch (const FenceBroken& broken) {
    fail(broken.what());
  }
}

}  // namespace

std::vector<DicomFile> describe_dicom_files(const std::vector<std::string>& paths,
                                            const ProgressListener& listener) {
  constexpr std::size_t kGrain = 32;
  Progress progress(listener, "looking", paths.size());
  std::vector<std::vector<DicomFile>> pieces((paths.size() + kGrain - 1) / kGrain);
  parallel_for(pieces.size(), 1, [&](std::size_t begin, std::size_t) {
    const std::size_t first = begin * kGrain;
    const std::size_t count = std::min(kGrain, paths.size() - first);
    std::vector<DicomFile>& files = pieces[begin];
    while (files.size() < count) {
      describe_some(&paths[first + files.size()], count - files.size(), files);
    }
    progress.advance(count);
  });
  std::vector<DicomFile> all;
  for (std::vector<DicomFile>& piece : pieces) std::ranges::move(piece, std::back_inserter(all));
  return all;
}

void read_dicom_frames(const DicomFile& file, std::size_t begin, std::size_t end,
                       const UseFrame& use) {
  (file.is_plain() ? read_plain : read_encoded)(file, begin, end, use);
}

}  // namespace isolux
