#include <algorithm>
#include <cmath>
#include <filesystem>
#include <optional>

#include "isolux/base/error.h"
#include "isolux/base/number_text.h"
#include "isolux/io/channels.h"
#include "isolux/io/format.h"
#include "isolux/io/nifti_header.h"
#include "isolux/io/placement_fault.h"
#include "isolux/io/stored_bytes.h"

// NIfTI-1 and NIfTI-2, in one file (.nii) or as header and voxels (.hdr and .img), each of them
// plain or gzipped; and Analyze 7.5, the pair that NIfTI grew from.

namespace isolux {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kGzipMark = "\x1f\x8b";

// The path without ".gz".
fs::path without_gz(fs::path path) {
  if (path.extension() == ".gz" || path.extension() == ".GZ") path.replace_extension();
  return path;
}

// "a.hdr", "a.HDR.gz": whether the ending of a path is ".hdr", in either case.
bool ends_in(const std::string& path, const char* lower, const char* upper) {
  const fs::path ending = without_gz(path).extension();
  return ending == lower || ending == upper;
}

// The other file of a pair, under the endings that it may have; the first that exists.
std::optional<std::string> partner(const std::string& path, const std::string& lower,
                                   const std::string& upper) {
  const std::string stem = without_gz(path).replace_extension().string();
  std::error_code error;
  for (const std::string& ending : {lower, lower + ".gz", upper, upper + ".gz"}) {
    if (fs::is_regular_file(stem + ending, error)) return stem + ending;
  }
  return std::nullopt;
}

// The file that holds the header: `path` itself, or for an .img the .hdr beside it.
std::string header_path_of(const std::string& path) {
  if (!ends_in(path, ".img", ".IMG")) return path;
  return partner(path, ".hdr", ".HDR").value_or(path);
}

StoredBytes stored(const std::string& path) {
  return {path, 0, first_bytes({path}, kGzipMark.size()) == kGzipMark};
}

bool recognises(const ReadRequest& request, std::string_view first) {
  if (looks_like_nifti(first)) return true;
  const std::string path = header_path_of(request.name);
  if (path == request.name && !first.starts_with(kGzipMark)) return false;
  try {
    return looks_like_nifti(first_bytes(stored(path), kShortestNiftiHeader));
  } catch (const WorkError&) {
    return false;
  }
}

// The file with the voxels; those of an .img are compressed only where its name says so, since any
// bytes may be voxels.
StoredBytes voxel_file(const StoredBytes& header_file, const NiftiHeader& header) {
  if (!header.is_pair) return header_file;
  const auto image = partner(header_file.path, ".img", ".IMG");
  if (!ends_in(header_file.path, ".hdr", ".HDR") || !image) {
    throw WorkError(header_file.path, "is the header of a pair, but no .img file lies beside it",
                    "put both files, a .hdr and an .img of one name, into one folder");
  }
  return {*image, 0, image->ends_with(".gz")};
}

// A 2-D file need not say how thick its one slice is.
Affine with_thickness(Affine affine, const NiftiHeader& header) {
  Vec3* column = affine.linear.column;
  for (int axis = 0; axis < 3; ++axis) {
    if (header.dims[static_cast<std::size_t>(axis)] != 1 || column[axis] != Vec3{}) continue;
    const Vec3 normal = cross(column[(axis + 1) % 3], column[(axis + 2) % 3]);
    if (length(normal) > 0) column[axis] = normal / length(normal);
  }
  return affine;
}

// pixdim alone, and the origin in the centre of the first voxel.
Affine spacing_alone(const NiftiHeader& header) {
  const Vec3 s = header.spacing;
  return {diagonal({std::fabs(s.x), std::fabs(s.y), std::fabs(s.z)}), {}};
}

// The largest distance between where two affines place a voxel: one of the box's corners has it.
double largest_distance(const Affine& a, const Affine& b, const NiftiHeader& header) {
  double largest = 0;
  for (int corner = 0; corner < 8; ++corner) {
    Vec3 index;
    for (int axis = 0; axis < 3; ++axis) {
      const auto last = static_cast<double>(header.dims[static_cast<std::size_t>(axis)] - 1);
      index[axis] = (corner >> axis & 1) != 0 ? last : 0;
    }
    largest = std::max(largest, length(a.point(index) - b.point(index)));
  }
  return largest;
}

void compare_forms(const NiftiHeader& header, std::vector<std::string>& notes) {
  const Affine qform = with_thickness(header.qform, header);
  if (const std::string fault = placement_fault(qform); !fault.empty()) {
    notes.push_back("its qform " + fault + " and was left aside");
    return;
  }
  const double apart =
      header.mm_per_unit * largest_distance(with_thickness(header.sform, header), qform, header);
  constexpr double kNoticeableMm = 0.1;
  if (apart > kNoticeableMm) {
    notes.push_back("its qform places some voxels " + to_text(std::round(apart * 100) / 100) +
                    " mm from its sform");
  }
}

// By the NIfTI standard: the sform where its code says so, else the qform, both to RAS; else the
// spacing alone, to which, as nifti1.h has it, "no particular spatial orientation is attached".
Affine placement(const std::string& path, const NiftiHeader& header,
                 std::vector<std::string>& notes) {
  const bool by_sform = header.sform_code > 0, by_qform = !by_sform && header.qform_code > 0;
  const std::string form = by_sform ? "sform" : by_qform ? "qform" : "pixdim";
  Affine affine = by_sform ? header.sform : by_qform ? header.qform : spacing_alone(header);
  const Vec3 s = header.spacing;
  if (!by_sform && (s.x < 0 || s.y < 0 || s.z < 0)) {
    notes.push_back("negative spacings in pixdim are taken as positive");
  }
  affine = with_thickness(affine, header);
  if (const std::string fault = placement_fault(affine); !fault.empty()) {
    throw WorkError(path, "cannot be placed: its " + form + " " + fault, "mend its header");
  }
  affine.linear =
      affine.linear * diagonal({header.mm_per_unit, header.mm_per_unit, header.mm_per_unit});
  affine.offset = header.mm_per_unit * affine.offset;
  if (!by_sform && !by_qform) {
    notes.push_back(
        "the file does not say how it lies in the patient: its axes are taken as LPS, spaced by "
        "pixdim");
    return affine;
  }
  notes.push_back("placed by its " + form + ", carried over from RAS to LPS");
  if (by_sform && header.qform_code > 0) compare_forms(header, notes);
  for (int column = 0; column < 3; ++column) {
    Vec3& v = affine.linear.column[column];
    v = {-v.x, -v.y, v.z};
  }
  affine.offset = {-affine.offset.x, -affine.offset.y, affine.offset.z};
  return affine;
}

// Where the voxels of a volume lie, all of them being there.
Stretch stretch_of(std::uint64_t volume, const StoredBytes& file, const NiftiHeader& header,
                   ReadResult& result) {
  const std::size_t count =
      static_cast<std::size_t>(header.dims[0] * header.dims[1] * header.dims[2]);
  const std::size_t bytes =
      count * bytes_of(header.type) * static_cast<std::size_t>(header.channels);
  const std::uint64_t skip = header.voxel_offset + volume * bytes;

  const double size = stored_size(file);
  const double available = file.deflated ? size : size - static_cast<double>(skip);
  check_promise(file.path, static_cast<double>(bytes), available, file.deflated ? "gzip" : "raw");
  const double all = static_cast<double>(header.voxel_offset) +
                     static_cast<double>(bytes) * static_cast<double>(result.volume_count);
  if (!file.deflated && size < all) {
    result.notes.push_back("the file is cut short: its last volumes are missing");
  }

  return {file, skip, bytes};
}

OpenedInput open(const ReadRequest& request) {
  OpenedInput opened;
  ReadResult& result = opened.result;
  const StoredBytes header_file = stored(header_path_of(request.name));
  const NiftiHeader header = parse_nifti_header(
      header_file.path, first_bytes(header_file, kNiftiHeaderAndComment), result.notes);
  const StoredBytes file = voxel_file(header_file, header);
  result.format = header.version;
  result.files = {header_file.path};
  if (header.is_pair) result.files.push_back(file.path);

  for (std::size_t axis = 0; axis < 3; ++axis) {
    opened.volume.dims[axis] = static_cast<int>(header.dims[axis]);
  }
  opened.volume.world_from_index = placement(header_file.path, header, result.notes);
  if (header.is_labels) opened.volume.modality = kSegmentation;
  const bool is_colour = header.channels > 1;
  const auto [channels, volume] =
      choose_channel(request, header.type, header.channels, is_colour,
                     static_cast<std::uint64_t>(header.volume_count()), result);
  plan_voxels(opened, request, header.type, header.swapped, header.rescale,
              {stretch_of(volume, file, header, result)}, channels);
  return opened;
}

}  // namespace

Format nifti_format() { return {recognises, open}; }

}  // namespace isolux
