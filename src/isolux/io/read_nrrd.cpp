#include <NrrdIO.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <fstream>
#include <memory>
#include <optional>

#include "isolux/base/error.h"
#include "isolux/base/number_text.h"
#include "isolux/io/chosen_volume.h"
#include "isolux/io/format.h"
#include "isolux/io/nrrd_header.h"
#include "isolux/io/placement_fault.h"
#include "isolux/io/stored_bytes.h"
#include "isolux/io/stored_voxels.h"

// By ITK's NrrdIO, the reading part of teem. ITK's own class on top of it (itkNrrdImageIO) is left
// aside, since it refuses headers that give a space but plain spacings (VTK's headsq).

namespace isolux {
namespace {

bool recognises(const ReadRequest&, std::string_view first_bytes) {
  return first_bytes.starts_with("NRRD");
}

using NrrdPointer = std::unique_ptr<Nrrd, decltype(&nrrdNuke)>;

// Reads the header alone, or the data as well.
NrrdPointer load(const std::string& path, bool with_data) {
  NrrdPointer nrrd(nrrdNew(), nrrdNuke);
  const std::unique_ptr<NrrdIoState, decltype(&nrrdIoStateNix)> state(nrrdIoStateNew(),
                                                                      nrrdIoStateNix);
  nrrdIoStateSet(state.get(), nrrdIoStateSkipData, with_data ? 0 : 1);
  if (nrrdLoad(nrrd.get(), path.c_str(), state.get()) == 0) return nrrd;
  const std::unique_ptr<char, decltype(&std::free)> message(biffGetDone(NRRD), std::free);
  // The first line of the message is the outermost; the last says what went wrong in the end.
  std::string why = message ? message.get() : "unknown error";
  while (why.ends_with('\n')) why.pop_back();
  why.erase(0, why.rfind('\n') + 1);
  throw WorkError(path, "cannot be read as NRRD: " + why, "is the file complete?");
}

// Where the data of one file begin, behind `lines` lines.
std::uint64_t behind_lines(const std::string& path, std::uint64_t offset, int lines) {
  std::ifstream file(path, std::ios::binary);
  file.seekg(static_cast<std::streamoff>(offset));
  std::string line;
  for (int n = 0; n < lines; ++n) {
    if (!std::getline(file, line)) {
      throw WorkError(path, "has fewer lines than its header skips", "mend the line skip");
    }
  }
  return static_cast<std::uint64_t>(file.tellg());
}

// Where the data lie, raw, gzip or bzip2, in all files one behind the other.
std::vector<Stretch> stretches(const std::string& path, const NrrdHeader& header,
                               std::uint64_t bytes) {
  const bool deflated = header.encoding == "gzip" || header.encoding == "gz";
  const bool bzip2 = header.encoding == "bzip2" || header.encoding == "bz2";
  const bool attached = header.data_files.empty();
  const std::vector<std::string> files =
      attached ? std::vector<std::string>{path} : header.data_files;
  const std::uint64_t share = bytes / files.size();
  if (share * files.size() != bytes) {
    throw WorkError(path, "its data do not fill its data files evenly", "mend the header");
  }
  std::vector<Stretch> list;
  for (const std::string& file : files) {
    const auto begin = attached ? static_cast<std::uint64_t>(header.header_bytes) : 0;
    StoredBytes stored{file, behind_lines(file, begin, header.line_skip), deflated, bzip2};
    std::uint64_t skip = header.byte_skip > 0 ? static_cast<std::uint64_t>(header.byte_skip) : 0;
    if (header.byte_skip < 0) {  // the data stand at the end
      if (deflated || bzip2) {
        throw WorkError(file, "a byte skip of -1 does not go with compression", "mend the header");
      }
      stored.offset = 0;
      skip = static_cast<std::uint64_t>(stored_size(stored)) - share;
    }
    list.push_back({stored, skip, share});
  }
  return list;
}

// The bytes [begin, begin + count) of what stretches hold together.
std::vector<Stretch> part_of(const std::vector<Stretch>& stretches, std::uint64_t begin,
                             std::uint64_t count) {
  std::vector<Stretch> part;
  std::uint64_t before = 0;
  for (const Stretch& stretch : stretches) {
    const std::uint64_t first = std::max(begin, before);
    const std::uint64_t last = std::min(begin + count, before + stretch.bytes);
    if (first < last) part.push_back({stretch.file, stretch.skip + first - before, last - first});
    before += stretch.bytes;
  }
  return part;
}

std::optional<StoredType> stored_type(int nrrd_type) {
  switch (nrrd_type) {
    case nrrdTypeChar:
      return StoredType::kI8;
    case nrrdTypeUChar:
      return StoredType::kU8;
    case nrrdTypeShort:
      return StoredType::kI16;
    case nrrdTypeUShort:
      return StoredType::kU16;
    case nrrdTypeInt:
      return StoredType::kI32;
    case nrrdTypeUInt:
      return StoredType::kU32;
    case nrrdTypeLLong:
      return StoredType::kI64;
    case nrrdTypeULLong:
      return StoredType::kU64;
    case nrrdTypeFloat:
      return StoredType::kF32;
    case nrrdTypeDouble:
      return StoredType::kF64;
    default:
      return std::nullopt;
  }
}

// The file's space into LPS, as a factor along each of its axes.
Vec3 lps_factors(int space, ReadResult& result) {
  switch (space) {
    case nrrdSpaceRightAnteriorSuperior:
    case nrrdSpaceRightAnteriorSuperiorTime:
      result.notes.push_back("right-anterior-superior was carried over to LPS");
      return {-1, -1, 1};
    case nrrdSpaceLeftAnteriorSuperior:
    case nrrdSpaceLeftAnteriorSuperiorTime:
      result.notes.push_back("left-anterior-superior was carried over to LPS");
      return {1, -1, 1};
    case nrrdSpaceLeftPosteriorSuperior:
    case nrrdSpaceLeftPosteriorSuperiorTime:
    case nrrdSpaceScannerXYZ:
    case nrrdSpaceScannerXYZTime:
      return {1, 1, 1};
    default:
      result.notes.push_back(
          "the file does not say how it lies in the patient: its axes are taken as LPS");
      return {1, 1, 1};
  }
}

Affine placement(const Nrrd& nrrd, ReadResult& result) {
  const Vec3 factors = lps_factors(nrrd.space, result);
  Affine world_from_index;
  const unsigned axes = std::min(nrrd.dim, 3u);
  for (unsigned axis = 0; axis < axes; ++axis) {
    Vec3& column = world_from_index.linear.column[axis];
    const NrrdAxisInfo& info = nrrd.axis[axis];
    if (std::isfinite(info.spaceDirection[0])) {
      for (int row = 0; row < 3; ++row) {
        column[row] = static_cast<unsigned>(row) < nrrd.spaceDim
                          ? factors[row] * info.spaceDirection[row]
                          : 0;
      }
    } else {
      // NrrdIO makes a spacing that the header lacks NaN, as it does one that the header calls NaN.
      if (info.spacing <= 0) {
        throw WorkError(
            result.name,
            "has a spacing of " + to_text(info.spacing) + " along axis " + std::to_string(axis),
            "mend its header, or turn the axis by a direction");
      }
      const bool is_given = std::isfinite(info.spacing);
      if (!is_given) {
        result.notes.push_back("axis " + std::to_string(axis) + " has no spacing: 1 mm");
      }
      column = factors[static_cast<int>(axis)] * (is_given ? info.spacing : 1) * column;
    }
  }
  const unsigned origin_axes = std::min(nrrd.spaceDim, 3u);
  for (unsigned row = 0; row < origin_axes; ++row) {
    const double at = nrrd.spaceOrigin[row];
    if (std::isfinite(at)) {
      world_from_index.offset[static_cast<int>(row)] = factors[static_cast<int>(row)] * at;
    }
  }
  if (const std::string fault = placement_fault(world_from_index); !fault.empty()) {
    throw WorkError(result.name, "its placement " + fault, "mend its header");
  }
  return world_from_index;
}

// The value of one of the header's own "key:=value" lines, or an empty text.
std::string key_value(const Nrrd& nrrd, const char* key) {
  const std::unique_ptr<char, decltype(&std::free)> value(nrrdKeyValueGet(&nrrd, key), std::free);
  return value ? value.get() : "";
}

ReadResult read(const ReadRequest& request) {
  const NrrdHeader header = read_nrrd_header(request.name);
  ReadResult result{nullptr, request.name, "NRRD", {request.name}, {}};
  result.files.insert(result.files.end(), header.data_files.begin(), header.data_files.end());

  // Text and hexadecimal numbers are NrrdIO's.
  constexpr const char* kOurs[] = {"raw", "gzip", "gz", "bzip2", "bz2"};
  const bool by_us = std::ranges::find(kOurs, header.encoding) != std::end(kOurs);
  const NrrdPointer nrrd = load(request.name, !by_us);
  std::size_t volumes = 1;
  for (unsigned axis = 0; axis < nrrd->dim; ++axis) {
    const bool is_values = axis == 0 && nrrd->axis[axis].kind != nrrdKindUnknown &&
                           !nrrdKindIsDomain(nrrd->axis[axis].kind);
    if (is_values) {
      throw WorkError(request.name,
                      "has " + std::to_string(nrrd->axis[axis].size) + " values a voxel",
                      "isolux draws surfaces of one value; extract a channel first");
    }
    if (axis > 2) volumes *= nrrd->axis[axis].size;
  }
  auto volume = std::make_shared<Volume>();
  volume->dims = {1, 1, 1};
  std::size_t count = 1;
  for (unsigned axis = 0; axis < std::min(nrrd->dim, 3u); ++axis) {
    if (nrrd->axis[axis].size > 1 << 30) {
      throw WorkError(request.name, "is too long along an axis", "crop it first");
    }
    volume->dims[axis] = static_cast<int>(nrrd->axis[axis].size);
    count *= nrrd->axis[axis].size;
  }
  volume->world_from_index = placement(*nrrd, result);
  volume->modality = key_value(*nrrd, "modality");
  volume->units = key_value(*nrrd, "units");
  const std::string unit = nrrd->spaceUnits[0] ? nrrd->spaceUnits[0] : "";
  if (!unit.empty() && unit != "mm" && unit != "millimeter" && unit != "millimeters") {
    result.notes.push_back("its lengths are in '" + unit + "' and taken as mm, number for number");
  }
  result.volume_count = static_cast<int>(std::min<std::size_t>(volumes, 1 << 30));
  const std::uint64_t chosen = chosen_volume(request, result);
  const auto type = stored_type(nrrd->type);
  if (!type) throw WorkError(result.name, "its voxel type is not a number", "convert it first");
  if (by_us) {
    constexpr bool kThisMachineIsBig = std::endian::native == std::endian::big;
    const std::uint64_t bytes = count * bytes_of(*type);
    const std::vector<Stretch> list =
        part_of(stretches(request.name, header, bytes * volumes), chosen * bytes, bytes);
    volume->voxels = voxels_of_stretches(request, *type, header.big_endian != kThisMachineIsBig, {},
                                         list, result.notes);
  } else {
    const char* data = static_cast<const char*>(nrrd->data) + chosen * count * bytes_of(*type);
    const auto from_the_first = [&]() -> ReadNext {
      return [next = data](char* to, std::size_t bytes) mutable {
        std::copy_n(next, bytes, to);
        next += bytes;
      };
    };
    volume->voxels =
        voxels_read(request.name, *type, count, false, {}, from_the_first, result.notes);
  }
  result.volume = volume;
  return result;
}

}  // namespace

Format nrrd_format() { return {recognises, read}; }

}  // namespace isolux
