#include <bit>
#include <cmath>
#include <filesystem>
#include <map>

#include "isolux/base/error.h"
#include "isolux/io/format.h"
#include "isolux/io/stored_voxels.h"

namespace isolux {
namespace {

struct RawType {
  StoredType stored;
  bool big_endian;
};

const std::map<std::string, RawType>& raw_types() {
  static const std::map<std::string, RawType> types = {
      {"u8", {StoredType::kU8, false}},    {"i16", {StoredType::kI16, false}},
      {"i16be", {StoredType::kI16, true}}, {"u16", {StoredType::kU16, false}},
      {"u16be", {StoredType::kU16, true}}, {"f32", {StoredType::kF32, false}},
      {"f32be", {StoredType::kF32, true}},
  };
  return types;
}

}  // namespace

std::string raw_guess(std::uintmax_t bytes) {
  // Square slices of the usual sizes, at least 16 of them and not many more than they are wide.
  for (const auto& [type, width] :
       {std::pair{"i16", 2u}, std::pair{"u8", 1u}, std::pair{"f32", 4u}}) {
    for (const std::uintmax_t side : {1024u, 512u, 256u, 128u, 64u, 32u}) {
      const std::uintmax_t slice = side * side * width;
      const std::uintmax_t slices = bytes / slice;
      if (bytes % slice != 0 || slices < 16 || slices > 4 * side) continue;
      const std::string edge = std::to_string(side);
      return std::to_string(bytes) + " bytes could be " + edge + "x" + edge + "x" +
             std::to_string(slices) + " " + type;
    }
  }
  // Or a cube of any size.
  for (const auto& [type, width] :
       {std::pair{"u8", 1u}, std::pair{"i16", 2u}, std::pair{"f32", 4u}}) {
    const auto side =
        static_cast<std::uintmax_t>(std::lround(std::cbrt(static_cast<double>(bytes) / width)));
    if (side < 16 || side > 1 << 14 || side * side * side * width != bytes) continue;
    const std::string edge = std::to_string(side);
    return std::to_string(bytes) + " bytes could be " + edge + "x" + edge + "x" + edge + " " + type;
  }
  return {};
}

OpenedInput open_raw(const ReadRequest& request) {
  if (!request.grid.dims || !request.grid.type) {
    throw UsageError(request.grid.dims ? "--dims" : "--type", "alone does not describe a raw file",
                     "give both --dims and --type");
  }
  const std::array<int, 3> dims = *request.grid.dims;
  const RawType& type = raw_types().at(*request.grid.type);
  const double wanted =
      static_cast<double>(dims[0]) * dims[1] * dims[2] * static_cast<double>(bytes_of(type.stored));
  std::error_code error;
  const double size = static_cast<double>(std::filesystem::file_size(request.name, error));
  if (error || size != wanted) {
    const std::string dims_text =
        std::to_string(dims[0]) + "x" + std::to_string(dims[1]) + "x" + std::to_string(dims[2]);
    char why[160];
    std::snprintf(why, sizeof why, "holds %.0f bytes, but %s voxels of type %s take %.0f",
                  error ? 0 : size, dims_text.c_str(), request.grid.type->c_str(), wanted);
    throw WorkError(request.name, why, "check --dims and --type");
  }

  OpenedInput opened;
  opened.volume.dims = dims;
  opened.volume.world_from_index.linear = diagonal(request.grid.spacing_mm.value_or(Vec3{1, 1, 1}));
  opened.result.format = "raw";
  opened.result.files = {request.name};
  if (!request.grid.spacing_mm) {
    opened.result.notes.push_back("no --spacing given: 1 mm along each axis");
  }
  constexpr bool kThisMachineIsBig = std::endian::native == std::endian::big;
  plan_voxels(opened, request, type.stored, type.big_endian != kThisMachineIsBig, {},
              {{{request.name}, 0, static_cast<std::uint64_t>(wanted)}});
  return opened;
}

}  // namespace isolux
