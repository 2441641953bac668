#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "isolux/base/affine.h"
#include "isolux/io/stored_voxels.h"

namespace isolux {

/// How many bytes a header takes: at least those of NIfTI-1 and Analyze 7.5, at most of NIfTI-2.
inline constexpr std::size_t kShortestNiftiHeader = 348, kLongestNiftiHeader = 540;

/// NIfTI-1 keeps its sform as 32-bit floats. Where they round, isolux writes the sform in full, row
/// by row, into a comment (an extension of the header) that begins so, and believes it again where
/// it rounds to the floats that are there.
inline constexpr std::string_view kFullSform = "isolux sform in full: ";
/// Enough bytes for a header and that comment.
inline constexpr std::size_t kNiftiHeaderAndComment = 1024;

/// What a NIfTI or Analyze 7.5 header says, in this machine's byte order, checked for sense but not
/// yet against the file's size (see nifti.nimh.nih.gov and nifti1.h).
struct NiftiHeader {
  std::string version;               ///< "NIfTI-1", "NIfTI-2", "Analyze 7.5"
  bool swapped = false;              ///< header and voxels are in the other byte order
  bool is_pair = false;              ///< the voxels lie in an .img file beside it
  std::array<std::int64_t, 7> dims;  ///< each at least 1; 1 beyond the file's own axes
  StoredType type = StoredType::kU8;
  int channels = 1;        ///< numbers a voxel: 3 or 4 where it is a colour
  bool is_labels = false;  ///< its values are the numbers of regions
  std::uint64_t voxel_offset = 0;
  Rescale rescale;
  double mm_per_unit = 1;
  Vec3 spacing;  ///< in the file's units; may be zero or not finite
  int qform_code = 0, sform_code = 0;
  Affine qform, sform;  ///< index -> RAS in the file's units; may be singular or not finite

  std::int64_t volume_count() const { return dims[3] * dims[4] * dims[5] * dims[6]; }
};

/// Whether the first bytes of a file (kShortestNiftiHeader are needed) are such a header.
bool looks_like_nifti(std::string_view first_bytes);

/// Reads the header from the first bytes of `path`, kNiftiHeaderAndComment of them; decisions go to
/// `notes`.
/// @throws WorkError  where it is damaged, or of a kind not read here.
NiftiHeader parse_nifti_header(const std::string& path, std::string_view first_bytes,
                               std::vector<std::string>& notes);

}  // namespace isolux
