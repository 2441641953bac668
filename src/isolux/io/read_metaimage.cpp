#include <algorithm>
#include <bit>

#include "isolux/base/error.h"
#include "isolux/io/channels.h"
#include "isolux/io/format.h"
#include "isolux/io/metaimage_header.h"
#include "isolux/io/placement_fault.h"
#include "isolux/io/stored_bytes.h"

// MetaImage, ITK's own format: a header of text, and raw or deflated voxels in the same file (.mha)
// or in others (.mhd). Why not by ITK's MetaIO: docs/decisions/0005-metaimage.md.

namespace isolux {
namespace {

bool recognises(const ReadRequest&, std::string_view first_bytes) {
  return looks_like_metaimage(first_bytes);
}

// Row i of the matrix is the direction of axis i; MetaIO's space is LPS, as ITK takes it. A file of
// fewer than three axes has one slice, 1 mm thick.
Affine placement(const std::string& path, const MetaImageHeader& header) {
  Affine affine;
  const std::size_t axes = std::min<std::size_t>(header.axes, 3);
  for (std::size_t axis = 0; axis < axes; ++axis) {
    for (std::size_t row = 0; row < axes; ++row) {
      affine.linear.column[axis][static_cast<int>(row)] =
          header.spacing[axis] * header.matrix[axis * header.axes + row];
    }
    affine.offset[static_cast<int>(axis)] = header.origin[axis];
  }
  if (const std::string fault = placement_fault(affine); !fault.empty()) {
    throw WorkError(path, "cannot be placed: its TransformMatrix " + fault, "mend its header");
  }
  return affine;
}

// Where the bytes [begin, end) of all data files' contents, one behind the other, lie. Each file
// holds `share` of them.
std::vector<Stretch> stretches(const MetaImageHeader& header, std::uint64_t share,
                               std::uint64_t begin, std::uint64_t end) {
  std::vector<Stretch> list;
  for (std::size_t n = 0; n < header.data_files.size(); ++n) {
    const std::uint64_t first = std::max(begin, n * share), last = std::min(end, (n + 1) * share);
    if (first >= last) continue;
    Stretch stretch{{header.data_files[n], header.data_offset, header.deflated},
                    first - n * share,
                    last - first};
    if (header.data_at_end) {
      const double before = stored_size({header.data_files[n]}) - static_cast<double>(share);
      stretch.file.offset = static_cast<std::uint64_t>(std::max(0.0, before));
    }
    list.push_back(stretch);
  }
  return list;
}

// Called before anything is allocated.
void check_promises(const std::vector<Stretch>& list) {
  for (const Stretch& stretch : list) {
    const double size = stored_size(stretch.file);
    const double available =
        stretch.file.deflated ? size : size - static_cast<double>(stretch.skip);
    check_promise(stretch.file.path, static_cast<double>(stretch.bytes), available,
                  stretch.file.deflated ? "zlib" : "raw");
  }
}

OpenedInput open(const ReadRequest& request) {
  OpenedInput opened;
  ReadResult& result = opened.result;
  result.format = "MetaImage";
  result.files = {request.name};
  const MetaImageHeader header = read_metaimage_header(request.name, result.notes);
  std::copy_n(header.dims.begin(), 3, opened.volume.dims.begin());
  opened.volume.world_from_index = placement(request.name, header);
  opened.volume.modality = header.modality;

  const auto dim = [&](std::size_t axis) { return static_cast<std::uint64_t>(header.dims[axis]); };
  const std::uint64_t bytes = dim(0) * dim(1) * dim(2) * bytes_of(header.type) *
                              static_cast<std::uint64_t>(header.channels);
  const std::uint64_t share = bytes * dim(3) / header.data_files.size();
  // MetaIO does not say whether three numbers of 8 bits are a colour; ITK writes colours so.
  const auto [channels, volume] =
      choose_channel(request, header.type, header.channels, header.channels > 1, dim(3), result);
  const std::uint64_t begin = volume * bytes;
  const std::vector<Stretch> list = stretches(header, share, begin, begin + bytes);
  check_promises(list);
  for (const Stretch& stretch : list) {
    if (stretch.file.path != request.name) result.files.push_back(stretch.file.path);
  }
  constexpr bool kThisMachineIsBig = std::endian::native == std::endian::big;
  plan_voxels(opened, request, header.type, header.big_endian != kThisMachineIsBig, header.rescale,
              list, channels);
  return opened;
}

}  // namespace

Format metaimage_format() { return {recognises, open}; }

}  // namespace isolux
