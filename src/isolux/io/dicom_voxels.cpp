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

class Decoder {
 public:
  // DicomSlice n of `slices` becomes layer n of the voxels.
  Decoder(const ReadRequest& request, const std::vector<DicomFile>& files,
          const std::vector<DicomSlice>& slices)
      : request_(request), files_(files), layer_of_(files.size()) {
    for (std::size_t n = 0; n < slices.size(); ++n) layer_of_[slices[n].file][slices[n].frame] = n;
    for (std::size_t f = 0; f < files.size(); ++f) {
      if (layer_of_[f].empty()) continue;
      if (!files[f].is_plain()) {
        errands_.push_back({f, layer_of_[f].begin()->first, layer_of_[f].rbegin()->first + 1});
        continue;
      }
      for (const auto& [frame, layer] : layer_of_[f]) errands_.push_back({f, frame, frame + 1});
    }
    layer_voxels_ = static_cast<std::size_t>(files[slices[0].file].columns) *
                    static_cast<std::size_t>(files[slices[0].file].rows);
    layers_ = slices.size();
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
      for (const auto& [frame, layer] : layer_of_[f]) {
        if (!test(DicomSlice{f, frame}, files_[f], files_[f].frame(frame))) return false;
      }
    }
    return true;
  }

  template <typename Voxel>
  bool fill(VoxelArray& result, bool& rounds) const {
    result = VoxelArray();
    check_memory(static_cast<double>(layers_ * layer_voxels_) * sizeof(Voxel), request_.name);
    std::vector<Voxel> voxels(layers_ * layer_voxels_);
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
            const auto layer = layer_of_[errand.file].find(n);
            if (layer == layer_of_[errand.file].end()) return;
            const DicomFrame& frame = file.frame(n);
            if (!unpack(packing, packed, first, layer_voxels_,
                        Rescale{frame.slope, frame.intercept},
                        &voxels[layer->second * layer_voxels_], rounds_here)) {
              fits = false;
            }
          });
      if (rounds_here) any_rounds = true;
      progress.advance();
    });
    if (!fits) return false;
    rounds = any_rounds;
    result = std::move(voxels);
    return true;
  }

  const ReadRequest& request_;
  const std::vector<DicomFile>& files_;
  std::vector<std::map<std::size_t, std::size_t>> layer_of_;  // of a file: frame -> layer
  std::vector<Errand> errands_;
  std::size_t layer_voxels_ = 0;
  std::size_t layers_ = 0;
};

template <typename Voxel>
std::vector<Voxel> mixed_layers(const Voxels<Voxel>& slices, const std::vector<Layer>& layers,
                                std::size_t layer_voxels) {
  std::vector<Voxel> voxels(layers.size() * layer_voxels);
  parallel_for(layers.size(), 1, [&](std::size_t k, std::size_t) {
    const Voxel* lower = &slices[layers[k].lower * layer_voxels];
    const Voxel* upper = &slices[layers[k].upper * layer_voxels];
    const double share = layers[k].share_of_upper;
    Voxel* to = &voxels[k * layer_voxels];
    for (std::size_t n = 0; n < layer_voxels; ++n) {
      const double value =
          (1 - share) * static_cast<double>(lower[n]) + share * static_cast<double>(upper[n]);
      to[n] = static_cast<Voxel>(std::is_integral_v<Voxel> ? std::round(value) : value);
    }
  });
  return voxels;
}

}  // namespace

VoxelArray read_dicom_slices(const ReadRequest& request, const std::vector<DicomFile>& files,
                             const std::vector<DicomSlice>& slices,
                             std::vector<std::string>& notes) {
  bool rounds = false;
  VoxelArray voxels = Decoder(request, files, slices).decode(rounds);
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

VoxelArray mixed(const std::string& name, const VoxelArray& slices, std::size_t slice_count,
                 const std::vector<Layer>& layers) {
  return std::visit(
      [&]<typename Voxel>(const Voxels<Voxel>& voxels) -> VoxelArray {
        const std::size_t layer_voxels = voxels.size() / slice_count;
        check_memory(static_cast<double>(layers.size() * layer_voxels) * sizeof(Voxel), name);
        return mixed_layers(voxels, layers, layer_voxels);
      },
      slices);
}

}  // namespace isolux
