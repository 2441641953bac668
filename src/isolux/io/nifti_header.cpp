#include "isolux/io/nifti_header.h"

#include <nifti/nifti2_io.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <optional>
#include <sstream>

#include "isolux/base/error.h"
#include "isolux/base/number_text.h"

// libnifti gives the layouts, the byte swaps and the quaternions. Its reading of whole files is
// left aside: it knows files by the end of their names alone, prints to standard error, and
// believes a header's sizes.

namespace isolux {
namespace {

WorkError damaged(const std::string& path, const std::string& why) {
  return {path, "damaged NIfTI header: " + why, "compare it with the file that wrote it"};
}

// The int16 or int32 at a place, swapped or not.
template <typename Number>
Number number_at(std::string_view bytes, std::size_t offset, bool swapped) {
  Number number{};
  std::memcpy(&number, bytes.data() + offset, sizeof number);
  constexpr StoredType kType = sizeof(Number) == 2 ? StoredType::kI16 : StoredType::kI32;
  if (swapped) swap_bytes(kType, &number, 1);
  return number;
}

constexpr double kNotANumber = std::numeric_limits<double>::quiet_NaN();
constexpr std::size_t kHeader1 = sizeof(nifti_1_header), kHeader2 = sizeof(nifti_2_header);
static_assert(kHeader1 == kShortestNiftiHeader && kHeader2 == kLongestNiftiHeader);

bool has_magic_1(std::string_view bytes) {
  const std::string_view magic = bytes.substr(offsetof(nifti_1_header, magic), 4);
  return magic == std::string_view("n+1\0", 4) || magic == std::string_view("ni1\0", 4);
}

bool has_magic_2(std::string_view bytes) {
  const std::string_view magic = bytes.substr(offsetof(nifti_2_header, magic), 8);
  return magic == std::string_view("n+2\0\r\n\032\n", 8) ||
         magic == std::string_view("ni2\0\r\n\032\n", 8);
}

// Whether the header is in the other byte order: sizeof_hdr tells.
std::optional<bool> is_swapped(std::string_view bytes) {
  const auto size = static_cast<std::int32_t>(has_magic_2(bytes) ? kHeader2 : kHeader1);
  for (const bool swapped : {false, true}) {
    if (number_at<std::int32_t>(bytes, 0, swapped) == size) return swapped;
  }
  return std::nullopt;
}

// Analyze 7.5 has no magic: it is known by sizeof_hdr and a sensible number of axes.
bool looks_like_analyze(std::string_view bytes) {
  const auto swapped = is_swapped(bytes);
  if (!swapped) return false;
  const auto axes = number_at<std::int16_t>(bytes, offsetof(nifti_1_header, dim), *swapped);
  return axes >= 1 && axes <= 7;
}

StoredType stored_type(const std::string& path, int datatype) {
  switch (datatype) {
    case NIFTI_TYPE_UINT8:
    case NIFTI_TYPE_RGB24:
    case NIFTI_TYPE_RGBA32:
      return StoredType::kU8;
    case NIFTI_TYPE_INT8:
      return StoredType::kI8;
    case NIFTI_TYPE_INT16:
      return StoredType::kI16;
    case NIFTI_TYPE_UINT16:
      return StoredType::kU16;
    case NIFTI_TYPE_INT32:
      return StoredType::kI32;
    case NIFTI_TYPE_UINT32:
      return StoredType::kU32;
    case NIFTI_TYPE_INT64:
      return StoredType::kI64;
    case NIFTI_TYPE_UINT64:
      return StoredType::kU64;
    case NIFTI_TYPE_FLOAT32:
      return StoredType::kF32;
    case NIFTI_TYPE_FLOAT64:
      return StoredType::kF64;
    case NIFTI_TYPE_COMPLEX64:
    case NIFTI_TYPE_COMPLEX128:
    case NIFTI_TYPE_COMPLEX256:
      throw WorkError(path, "has complex numbers for voxels",
                      "isolux draws surfaces of one value; take their magnitude first");
    case DT_BINARY:
    case NIFTI_TYPE_FLOAT128:
      throw WorkError(path, datatype == DT_BINARY ? "has voxels of one bit" : "has 128-bit floats",
                      "convert it to another voxel type first");
    default:
      throw damaged(path, "datatype " + std::to_string(datatype) + " is not known");
  }
}

template <typename Raw>
void set_dims(NiftiHeader& header, const std::string& path, const Raw& raw) {
  const std::int64_t axes = raw.dim[0];
  if (axes < 1 || axes > 7) throw damaged(path, "it has " + std::to_string(axes) + " axes");
  double voxels = 1;
  header.dims.fill(1);
  for (std::size_t axis = 0; axis < static_cast<std::size_t>(axes); ++axis) {
    const std::int64_t size = raw.dim[axis + 1];
    if (size < 1) {
      throw damaged(path, "it is " + std::to_string(size) + " voxels long along axis " +
                              std::to_string(axis + 1));
    }
    constexpr std::int64_t kLongest = 1 << 30;
    if (axis < 3 && size > kLongest) throw WorkError(path, "is too long along an axis", "crop it");
    header.dims[axis] = size;
    voxels *= static_cast<double>(size);
  }
  constexpr double kMostVoxels = 1e18;  // so that no product of dims and bytes overflows
  if (voxels > kMostVoxels) throw damaged(path, "it promises " + to_text(voxels) + " voxels");
}

void set_voxel_offset(NiftiHeader& header, const std::string& path, double offset,
                      std::size_t header_bytes, std::vector<std::string>& notes) {
  constexpr double kLargest = 1e15;
  const double least = header.is_pair ? 0 : static_cast<double>(header_bytes);
  if (offset == 0 && !header.is_pair) {
    offset = least + 4;  // the four bytes that say whether extensions follow
    notes.push_back("vox_offset is 0: its voxels are taken to begin behind the header, at byte " +
                    to_text(offset));
  }
  if (!(offset >= least && offset <= kLargest) || offset != std::floor(offset)) {
    throw damaged(path, "vox_offset is " + to_text(offset));
  }
  header.voxel_offset = static_cast<std::uint64_t>(offset);
}

// A slope of 0 means that there is no rescale; so does one that is no number, as nibabel writes it.
void set_rescale(NiftiHeader& header, const std::string& path, double slope, double intercept,
                 std::vector<std::string>& notes) {
  if (std::isnan(slope)) notes.push_back("scl_slope is no number: its values are not rescaled");
  if (slope == 0 || std::isnan(slope)) return;
  if (!std::isfinite(slope) || !std::isfinite(intercept)) {
    throw damaged(path,
                  "scl_slope and scl_inter are " + to_text(slope) + " and " + to_text(intercept));
  }
  header.rescale = {slope, intercept};
}

void set_unit(NiftiHeader& header, int xyzt_units, std::vector<std::string>& notes) {
  switch (XYZT_TO_SPACE(xyzt_units)) {
    case NIFTI_UNITS_METER:
      header.mm_per_unit = 1000;
      notes.push_back("its lengths are in metres: carried over to mm");
      break;
    case NIFTI_UNITS_MICRON:
      header.mm_per_unit = 1e-3;
      notes.push_back("its lengths are in microns: carried over to mm");
      break;
    case NIFTI_UNITS_MM:
      break;
    default:
      notes.push_back("it does not say its unit of length: taken as mm");
  }
}

template <typename Raw>
void set_forms(NiftiHeader& header, const Raw& raw) {
  header.spacing = {raw.pixdim[1], raw.pixdim[2], raw.pixdim[3]};
  header.qform_code = raw.qform_code;
  header.sform_code = raw.sform_code;
  // The library takes spacings that are not positive as 1; so they are multiplied in afterwards.
  const double qfac = raw.pixdim[0] < 0 ? -1 : 1;
  const nifti_dmat44 q =
      nifti_quatern_to_dmat44(raw.quatern_b, raw.quatern_c, raw.quatern_d, raw.qoffset_x,
                              raw.qoffset_y, raw.qoffset_z, 1, 1, 1, qfac);
  for (int row = 0; row < 3; ++row) {
    const auto& s = row == 0 ? raw.srow_x : row == 1 ? raw.srow_y : raw.srow_z;
    for (int column = 0; column < 3; ++column) {
      header.qform.linear.column[column][row] =
          q.m[row][column] * std::fabs(header.spacing[column]);
      header.sform.linear.column[column][row] = s[column];
    }
    header.qform.offset[row] = q.m[row][3];
    header.sform.offset[row] = s[3];
  }
}

// Puts the full numbers in place of the floats that they round to, where the first extension of the
// header has them.
void take_full_sform(NiftiHeader& header, std::string_view bytes) {
  constexpr std::size_t kFlag = kHeader1, kSize = kHeader1 + 4, kCode = kSize + 4,
                        kText = kCode + 4;
  if (bytes.size() < kText || bytes[kFlag] == 0) return;
  if (number_at<std::int32_t>(bytes, kCode, header.swapped) != NIFTI_ECODE_COMMENT) return;
  const std::string_view text = bytes.substr(kText);
  if (!text.starts_with(kFullSform)) return;
  std::istringstream numbers{std::string(text.substr(kFullSform.size(), text.find('\0')))};
  Affine full;
  for (int n = 0; n < 12; ++n) {
    std::string word;
    numbers >> word;
    const int row = n / 4, column = n % 4;
    const double found =
        column < 3 ? header.sform.linear.at(row, column) : header.sform.offset[row];
    const double number = parse_number(word).value_or(kNotANumber);
    if (static_cast<double>(static_cast<float>(number)) != found) return;
    (column < 3 ? full.linear.column[column] : full.offset)[row] = number;
  }
  header.sform = full;
}

template <typename Raw>
NiftiHeader header_from(const std::string& path, const Raw& raw, bool swapped,
                        const std::string& version, std::vector<std::string>& notes) {
  const bool is_nifti = !version.starts_with("Analyze");
  NiftiHeader header;
  header.version = version;
  header.swapped = swapped;
  header.is_pair = !is_nifti || raw.magic[1] == 'i';
  set_dims(header, path, raw);
  header.type = stored_type(path, raw.datatype);
  header.channels = raw.datatype == NIFTI_TYPE_RGB24    ? 3
                    : raw.datatype == NIFTI_TYPE_RGBA32 ? 4
                                                        : 1;
  set_voxel_offset(header, path, static_cast<double>(raw.vox_offset), sizeof raw, notes);
  set_forms(header, raw);
  if (is_nifti) {
    set_rescale(header, path, raw.scl_slope, raw.scl_inter, notes);
    set_unit(header, raw.xyzt_units, notes);
    header.is_labels = raw.intent_code == NIFTI_INTENT_LABEL;
  } else {
    // Other fields, or nothing, stand where NIfTI has these.
    header.qform_code = header.sform_code = 0;
    const double factor = raw.scl_slope;
    if (std::isfinite(factor) && factor != 0 && factor != 1) {
      notes.push_back("the scale factor " + to_text(factor) +
                      " that SPM may have put into its Analyze header is not applied");
    }
  }
  return header;
}

}  // namespace

bool looks_like_nifti(std::string_view first_bytes) {
  if (first_bytes.size() < kHeader1) return false;
  return has_magic_1(first_bytes) || has_magic_2(first_bytes) || looks_like_analyze(first_bytes);
}

NiftiHeader parse_nifti_header(const std::string& path, std::string_view first_bytes,
                               std::vector<std::string>& notes) {
  const auto swapped = is_swapped(first_bytes);
  if (!swapped) {
    throw damaged(
        path, "sizeof_hdr is " + std::to_string(number_at<std::int32_t>(first_bytes, 0, false)));
  }
  if (has_magic_2(first_bytes)) {
    if (first_bytes.size() < kHeader2) throw damaged(path, "the file ends inside it");
    nifti_2_header raw;
    std::memcpy(&raw, first_bytes.data(), sizeof raw);
    if (*swapped) nifti_swap_as_nifti2(&raw);
    return header_from(path, raw, *swapped, "NIfTI-2", notes);
  }
  nifti_1_header raw;
  std::memcpy(&raw, first_bytes.data(), sizeof raw);
  if (*swapped) nifti_swap_as_nifti1(&raw);
  const std::string version = has_magic_1(first_bytes) ? "NIfTI-1" : "Analyze 7.5";
  NiftiHeader header = header_from(path, raw, *swapped, version, notes);
  if (!header.is_pair) take_full_sform(header, first_bytes);
  return header;
}

}  // namespace isolux
