#include <algorithm>
#include <bit>
#include <cmath>
#include <fstream>
#include <limits>
#include <map>
#include <set>

#include "isolux/base/error.h"
#include "isolux/base/number_text.h"
#include "isolux/io/channels.h"
#include "isolux/io/format.h"
#include "isolux/io/nrrd_header.h"
#include "isolux/io/number_text_file.h"
#include "isolux/io/placement_fault.h"
#include "isolux/io/stored_bytes.h"
#include "isolux/io/stored_voxels.h"

namespace isolux {
namespace {

bool recognises(const ReadRequest&, std::string_view first_bytes) {
  return first_bytes.starts_with("NRRD");
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

// Where the data of one file begin.
StoredBytes data_of(const std::string& file, const NrrdHeader& header) {
  const std::uint64_t begin = header.data_files.empty() ? header.header_bytes : 0;
  return {file, behind_lines(file, begin, header.line_skip), header.encoding == "gzip",
          header.encoding == "bzip2"};
}

// Where the data lie, raw, gzip or bzip2, in all files one behind the other.
std::vector<Stretch> stretches(const std::string& path, const NrrdHeader& header,
                               const std::vector<std::string>& files, std::uint64_t bytes) {
  const std::uint64_t share = bytes / files.size();
  if (share * files.size() != bytes) {
    throw WorkError(path, "its data do not fill its data files evenly", "mend the header");
  }
  std::vector<Stretch> list;
  for (const std::string& file : files) {
    StoredBytes stored = data_of(file, header);
    auto skip = static_cast<std::uint64_t>(std::max<std::int64_t>(header.byte_skip, 0));
    if (header.byte_skip < 0) {  // the data stand at the end
      if (stored.deflated || stored.bzip2) {
        throw WorkError(file, "a byte skip of -1 does not go with compression", "mend the header");
      }
      stored.offset = 0;
      const double size = stored_size(stored);
      if (size < static_cast<double>(share)) {
        throw WorkError(file, "is shorter than its share of the voxels", "is the file complete?");
      }
      skip = static_cast<std::uint64_t>(size) - share;
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

// The file's space into LPS, as a factor along each of its axes.
Vec3 lps_factors(const std::string& space, std::vector<std::string>& notes) {
  if (space == "right-anterior-superior") {
    notes.push_back("right-anterior-superior was carried over to LPS");
    return {-1, -1, 1};
  }
  if (space == "left-anterior-superior") {
    notes.push_back("left-anterior-superior was carried over to LPS");
    return {1, -1, 1};
  }
  if (space == "3d-left-handed") {
    notes.push_back(
        "the file does not say how it lies in the patient, but that its space is left-handed: its "
        "axes are taken as left, posterior and inferior, so that nothing is mirrored");
    return {1, 1, -1};
  }
  if (space != "left-posterior-superior" && space != "scanner-xyz") {
    notes.push_back("the file does not say how it lies in the patient: its axes are taken as LPS");
  }
  return {1, 1, 1};
}

// How many mm a length is that is 1 in this unit; says what it did with any but mm.
double mm_per_unit(const std::string& unit, std::vector<std::string>& notes) {
  static const std::map<std::string, double> units = {{"", 1},
                                                      {"mm", 1},
                                                      {"millimeter", 1},
                                                      {"millimeters", 1},
                                                      {"millimetre", 1},
                                                      {"millimetres", 1},
                                                      {"nm", 1e-6},
                                                      {"nanometers", 1e-6},
                                                      {"um", 1e-3},
                                                      {"\u00b5m", 1e-3},
                                                      {"\u03bcm", 1e-3},
                                                      {"micron", 1e-3},
                                                      {"microns", 1e-3},
                                                      {"micrometer", 1e-3},
                                                      {"micrometers", 1e-3},
                                                      {"cm", 10},
                                                      {"centimeter", 10},
                                                      {"centimeters", 10},
                                                      {"m", 1000},
                                                      {"meter", 1000},
                                                      {"meters", 1000},
                                                      {"in", 25.4},
                                                      {"inch", 25.4},
                                                      {"inches", 25.4}};
  const auto found = units.find(unit);
  if (found == units.end()) {
    notes.push_back("its lengths are in '" + unit + "' and taken as mm, number for number");
    return 1;
  }
  if (found->second != 1) {
    notes.push_back("its lengths in '" + unit + "' were turned into mm: 1 is " +
                    to_text(found->second) + " mm");
  }
  return found->second;
}

// The units along the axes of the space; one note for each unit.
Vec3 mm_per_space_unit(const NrrdHeader& header, std::vector<std::string>& notes) {
  Vec3 factors{1, 1, 1};
  std::map<std::string, double> known;
  for (std::size_t n = 0; n < std::min<std::size_t>(header.space_units.size(), 3); ++n) {
    const std::string& unit = header.space_units[n];
    if (!known.contains(unit)) known[unit] = mm_per_unit(unit, notes);
    factors[static_cast<int>(n)] = known[unit];
  }
  return factors;
}

Vec3 scaled(Vec3 a, Vec3 b) { return {a.x * b.x, a.y * b.y, a.z * b.z}; }

Affine placement(const NrrdHeader& header, ReadResult& result) {
  const Vec3 factors =
      scaled(lps_factors(header.space, result.notes), mm_per_space_unit(header, result.notes));
  Affine world_from_index;
  std::map<std::string, double> known;  // units of spacings
  for (std::size_t n = 0; n < std::min<std::size_t>(header.axes.size(), 3); ++n) {
    Vec3& column = world_from_index.linear.column[n];
    const NrrdAxis& axis = header.axes[n];
    if (axis.direction) {
      column = scaled(factors, *axis.direction);
      continue;
    }
    if (axis.spacing && *axis.spacing <= 0) {
      throw WorkError(
          result.name,
          "has a spacing of " + to_text(*axis.spacing) + " along axis " + std::to_string(n),
          "mend its header, or turn the axis by a direction");
    }
    if (!axis.spacing)
      result.notes.push_back("axis " + std::to_string(n) + " has no spacing: 1 mm");
    if (!known.contains(axis.unit)) known[axis.unit] = mm_per_unit(axis.unit, result.notes);
    column = factors[static_cast<int>(n)] * known[axis.unit] * axis.spacing.value_or(1) * column;
  }
  world_from_index.offset = scaled(factors, header.origin);
  if (const std::string fault = placement_fault(world_from_index); !fault.empty()) {
    throw WorkError(result.name, "its placement " + fault, "mend its header");
  }
  return world_from_index;
}

// The numbers of one voxel, where the first axis runs through them.
struct ValueAxis {
  int size = 1;
  bool is_colour = false;
};

// Takes the first axis away where it runs through the numbers of a voxel: its kind says so, or it
// alone has no direction in space.
ValueAxis take_value_axis(NrrdHeader& header) {
  static const std::set<std::string> kPlaces = {"domain", "space"},
                                     kUntold = {"", "???", "none", "list", "time"},
                                     kColours = {"rgb-color", "rgba-color", "3-color", "4-color"};
  std::vector<NrrdAxis>& axes = header.axes;
  const NrrdAxis first = axes.front();
  const bool is_alone = !first.direction && axes.size() > 3 && axes[1].direction.has_value();
  const bool is_told =
      !kPlaces.contains(first.kind) && (!kUntold.contains(first.kind) || first.kind == "list");
  if (axes.size() < 2 || first.size > 1 << 30 || kPlaces.contains(first.kind) ||
      !(is_told || is_alone)) {
    return {};
  }
  axes.erase(axes.begin());
  return {static_cast<int>(first.size), kColours.contains(first.kind)};
}

// Along the axes of the grid there are to be voxels, not the numbers of one voxel.
void check_kinds(const std::string& path, const NrrdHeader& header) {
  for (std::size_t n = 0; n < std::min<std::size_t>(header.axes.size(), 3); ++n) {
    const auto& [size, spacing, direction, kind, unit] = header.axes[n];
    const bool is_domain = kind.empty() || kind == "???" || kind == "none" || kind == "domain" ||
                           kind == "space" || kind == "time" || size == 1;
    if (!is_domain) {
      throw WorkError(path, "has " + std::to_string(size) + " values a voxel",
                      "isolux draws surfaces of one value; extract a channel first");
    }
  }
}

std::string value_of(const NrrdHeader& header, const char* key) {
  const auto found = header.key_values.find(key);
  return found == header.key_values.end() ? std::string() : found->second;
}

// Text and hexadecimal digits are decoded as they are read; of several volumes, those before the
// chosen one are read and forgotten.
void plan_text(OpenedInput& opened, const ReadRequest& request, const NrrdHeader& header,
               const std::vector<std::string>& files, std::uint64_t count, std::uint64_t before,
               const Channels& channels) {
  std::vector<Stretch> texts;
  for (const std::string& file : files) {
    StoredBytes text = data_of(file, header);
    text.offset += static_cast<std::uint64_t>(std::max<std::int64_t>(header.byte_skip, 0));
    texts.push_back({text, 0, std::numeric_limits<std::uint64_t>::max()});
  }
  constexpr bool kThisMachineIsBig = std::endian::native == std::endian::big;
  const bool is_hex = header.encoding == "hex";
  const bool swapped = is_hex && header.big_endian != kThisMachineIsBig;
  opened.stored_type = name_of(header.type);
  opened.bytes_per_voxel_most = bytes_per_voxel_most(header.type, {});
  opened.read_voxels = [=, type = header.type](std::vector<std::string>& notes) {
    const auto from_the_first = [&]() -> ReadNext {
      const ReadNext next = is_hex ? read_hex_text(texts) : read_number_text(texts, type);
      std::vector<char> one(bytes_of(type));
      for (std::uint64_t n = 0; n < before; ++n) next(one.data(), one.size());
      return one_a_voxel(next, type, channels);
    };
    return voxels_read(request.name, type, count / static_cast<std::uint64_t>(channels.count),
                       swapped, {}, from_the_first, notes);
  };
}

OpenedInput open(const ReadRequest& request) {
  NrrdHeader header = read_nrrd_header(request.name);
  OpenedInput opened;
  ReadResult& result = opened.result;
  result.name = request.name;
  result.format = "NRRD";
  result.files = {request.name};
  result.files.insert(result.files.end(), header.data_files.begin(), header.data_files.end());
  const ValueAxis values = take_value_axis(header);
  check_kinds(request.name, header);
  opened.volume.dims = {1, 1, 1};
  std::uint64_t count = 1, volumes = 1;
  for (std::size_t n = 0; n < header.axes.size(); ++n) {
    const std::uint64_t size = header.axes[n].size;
    if (size > 1 << 30) throw WorkError(request.name, "is too long along an axis", "crop it first");
    (n < 3 ? count : volumes) *= size;  // no overflow: data_bytes() lie in files
    if (n < 3) opened.volume.dims[n] = static_cast<int>(size);
  }
  opened.volume.world_from_index = placement(header, result);
  opened.volume.modality = value_of(header, "modality");
  opened.volume.units = value_of(header, "units");
  const bool has_segments = header.key_values.contains("Segment0_ID");  // as 3D Slicer writes them
  if (has_segments) opened.volume.modality = kSegmentation;
  const auto [channels, chosen] =
      choose_channel(request, header.type, values.size, values.is_colour, volumes, result);
  count *= static_cast<std::uint64_t>(channels.count);  // from here on of numbers, not of voxels

  const std::vector<std::string> files =
      header.data_files.empty() ? std::vector{request.name} : header.data_files;
  if (header.encoding == "text" || header.encoding == "hex") {
    plan_text(opened, request, header, files, count, chosen * count, channels);
    return opened;
  }
  constexpr bool kThisMachineIsBig = std::endian::native == std::endian::big;
  const std::uint64_t bytes = count * bytes_of(header.type);
  plan_voxels(
      opened, request, header.type, header.big_endian != kThisMachineIsBig, {},
      part_of(stretches(request.name, header, files, bytes * volumes), chosen * bytes, bytes),
      channels);
  return opened;
}

}  // namespace

Format nrrd_format() { return {recognises, open}; }

}  // namespace isolux
