#include "isolux/io/dicom_voxels.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <map>
#include <type_traits>

#include "isolux/base/fence.h"
#include "isolux/base/memory.h"
#include "isolux/base/parallel.h"

namespace isolux {
namespace {

// The slices of one file that are read at a stroke: frames [begin, end).
struct Errand {
  std::size_t file, begin, end;
};

// Makes layers of the slices that `voxels` begins with, column by column along k, so that no second
// grid is needed.
template <typename Voxel>
void mix(std::vector<Voxel>& voxels, std::size_t slice_count, std::size_t layer_voxels,
         const std::vector<Layer>& layers) {
  constexpr std::size_t kPiece = 1024;
  parallel_for(layer_voxels, kPiece, [&](std::size_t begin, std::size_t end) {
    const std::size_t width = end - begin;
    std::vector<Voxel> slices(slice_count * width);
    for (std::size_t n = 0; n < slice_count; ++n) {
      std::copy_n(&voxels[n * layer_voxels + begin], width, &slices[n * width]);
    }
    for (std::size_t k = 0; k < layers.size(); ++k) {
      const Voxel* lower = &slices[layers[k].lower * width];
      const Voxel* upper = &slices[layers[k].upper * width];
      const double share = layers[k].share_of_upper;
      Voxel* to = &voxels[k * layer_voxels + begin];
      for (std::size_t n = 0; n < width; ++n) {
        const double value =
            (1 - share) * static_cast<double>(lower[n]) + share * static_cast<double>(upper[n]);
        to[n] = static_cast<Voxel>(std::is_integral_v<Voxel> ? std::round(value) : value);
      }
    }
  });
  voxels.resize(layers.size() * layer_voxels);
}

class Decoder {
 public:
  // DicomSlice n of `slices` becomes slice n of the voxels, which `layers` mix, if there are any.
  Decoder(const ReadRequest& request, const std::vector<DicomFile>& files,
          const std::vector<DicomSlice>& slices, const std::vector<Layer>& layers)
      : request_(request),
        files_(files),
        slice_of_(files.size()),
        slice_count_(slices.size()),
        layers_(layers) {
    for (std::size_t n = 0; n < slices.size(); ++n) slice_of_[slices[n].file][slices[n].frame] = n;
    for (std::size_t f = 0; f < files.size(); ++f) {
      for (const auto& [frame, slice] : slice_of_[f]) {
        const bool goes_on = !errands_.empty() && errands_.back().file == f &&
                             frame - errands_.back().begin < files[f].frames_at_a_stroke();
        if (!goes_on) errands_.push_back({f, frame, frame});
        errands_.back().end = frame + 1;
      }
    }
    layer_voxels_ = static_cast<std::size_t>(files[slices[0].file].columns) *
                    static_cast<std::size_t>(files[slices[0].file].rows);
  }

  VoxelArray decode(bool& rounds) const {
    VoxelArray voxels;
    const bool is_kept = all([](const DicomSlice&, const DicomFile&, const DicomFrame& frame) {
      return frame.slope == 1 && frame.intercept == 0;
    });
    const bool is_whole =
        all([](const DicomSlice&, const DicomFile& file, const DicomFrame& frame) {
          return !file.packing.is_float && frame.slope == std::floor(frame.slope) &&
                 frame.intercept == std::floor(frame.intercept);
        });
    const bool is_byte = all([](const DicomSlice&, const DicomFile& file, const DicomFrame&) {
      return file.packing.bits_allocated <= 8 && !file.packing.is_signed;
    });
    const bool is_unsigned = all([](const DicomSlice&, const DicomFile& file, const DicomFrame&) {
      return file.packing.bits_allocated <= 16 && !file.packing.is_signed;
    });
    const bool fits = (is_whole && is_byte && fill<std::uint8_t>(voxels, rounds)) ||
                      (is_kept && is_unsigned && fill<std::uint16_t>(voxels, rounds)) ||
                      (is_whole && fill<std::int16_t>(voxels, rounds)) ||
                      (is_whole && fill<std::uint16_t>(voxels, rounds));
    if (!fits) fill<float>(voxels, rounds);
    return voxels;
  }

 private:
  template <typename Test>
  bool all(const Test& test) const {
    for (std::size_t f = 0; f < files_.size(); ++f) {
      for (const auto& [frame, slice] : slice_of_[f]) {
        if (!test(DicomSlice{f, frame}, files_[f], files_[f].frame(frame))) return false;
      }
    }
    return true;
  }

  template <typename Voxel>
  bool fill(VoxelArray& result, bool& rounds) const {
    result = VoxelArray();
    const std::size_t count = std::max(slice_count_, layers_.size()) * layer_voxels_;
    check_memory(static_cast<double>(count) * sizeof(Voxel), request_.name);
    std::vector<Voxel> voxels(count);
    keep_from_fences(voxels.data(), voxels.size() * sizeof(Voxel));
    Progress progress(request_.listener, "reading", errands_.size());
    std::atomic<bool> fits = true, any_rounds = false;
    parallel_for(errands_.size(), 1, [&](std::size_t begin, std::size_t) {
      if (!fits) return;
      const Errand& errand = errands_[begin];
      const DicomFile& file = files_[errand.file];
      bool rounds_here = false;
      read_dicom_frames(
          file, errand.begin, errand.end,
          [&](std::size_t n, const PixelPacking& packing, const void* packed, std::size_t first) {
            const auto slice = slice_of_[errand.file].find(n);
            if (slice == slice_of_[errand.file].end()) return;
            const DicomFrame& frame = file.frame(n);
            if (!unpack(packing, packed, first, layer_voxels_,
                        Rescale{frame.slope, frame.intercept},
                        &voxels[slice->second * layer_voxels_], rounds_here)) {
              fits = false;
            }
          });
      if (rounds_here) any_rounds = true;
      progress.advance();
    });
    if (!fits) return false;
    rounds = any_rounds;
    if (!layers_.empty()) mix(voxels, slice_count_, layer_voxels_, layers_);
    result = std::move(voxels);
    return true;
  }

  const ReadRequest& request_;
  const std::vector<DicomFile>& files_;
  std::vector<std::map<std::size_t, std::size_t>> slice_of_;  // of a file: frame -> slice
  std::size_t slice_count_;
  const std::vector<Layer>& layers_;
  std::vector<Errand> errands_;
  std::size_t layer_voxels_ = 0;
};

}  // namespace

VoxelArray read_dicom_slices(const ReadRequest& request, const std::vector<DicomFile>& files,
                             const std::vector<DicomSlice>& slices,
                             const std::vector<Layer>& layers, std::vector<std::string>& notes) {
  bool rounds = false;
  VoxelArray voxels = Decoder(request, files, slices, layers).decode(rounds);
  if (rounds) notes.push_back("its values are rounded to 32-bit floats");
  return voxels;
}

double dicom_bytes_per_voxel_most(const std::vector<DicomFile>& files,
                                  const std::vector<DicomSlice>& slices) {
  double most = 1;
  for (const DicomSlice& slice : slices) {
    const PixelPacking& packing = files[slice.file].packing;
    const DicomFrame& frame = files[slice.file].frame(slice.frame);
    const bool is_kept = frame.slope == 1 && frame.intercept == 0 && packing.bits_allocated <= 16;
    const bool is_byte = packing.bits_allocated <= 8 && !packing.is_signed;
    most = std::max(most, is_kept ? (is_byte ? 1.0 : 2.0) : 4.0);
  }
  return most;
}

}  // namespace isolux
