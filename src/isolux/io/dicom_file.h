#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "isolux/base/progress.h"
#include "isolux/io/dicom_pixels.h"

namespace isolux {

/// What a DICOM file says of a frame. Lists are empty where it says nothing.
struct DicomFrame {
  std::vector<double> position;     ///< 3 numbers, ImagePositionPatient
  std::vector<double> orientation;  ///< 6 numbers, ImageOrientationPatient
  std::vector<double> spacing;      ///< 2 numbers: between rows, between columns
  std::vector<double> distance;     ///< 1 number: to the next slice
  double slope = 1;
  double intercept = 0;
  int time = 0;     ///< temporal position
  int segment = 0;  ///< of a segmentation
};

/// What a DICOM file says of its image; no pixels.
struct DicomFile {
  std::string path;
  std::string fault;  ///< why it cannot be used, as a WorkError's middle; empty: it can
  std::string instance_uid, series_uid, description, modality, date, units, segments;
  std::string transfer_syntax;  ///< its name and UID
  std::string photometric;      ///< MONOCHROME2, RGB, ...
  int series_number = 0;
  int instance_number = 0;
  int columns = 0, rows = 0, samples = 1;
  long long frame_count = 1;
  PixelPacking packing;
  std::vector<double> padding;  ///< PixelPaddingValue as stored
  std::vector<std::string> remarks;
  std::vector<DicomFrame> frames;  ///< one for all frames, or at least frame_count
  std::size_t start = 0;           ///< as dicom_start tells
  long long pixel_offset = -1;     ///< of uncompressed pixels in the file; -1: must be decoded
  int swapped_bytes = 1;           ///< groups to reverse in uncompressed pixels; 1: none

  bool is_plain() const { return pixel_offset >= 0; }
  /// Whether it is an image at all, if a damaged one.
  bool has_image() const { return columns != 0 || rows != 0; }
  const DicomFrame& frame(std::size_t n) const { return frames.size() > 1 ? frames[n] : frames[0]; }
  double voxel_count() const { return 1.0 * columns * rows * static_cast<double>(frame_count); }
};

/// Reads the headers of DICOM files on all cores, in the order of `paths`. Whatever is wrong with a
/// file, up to pixels that its size cannot hold, stands in its `fault`; nothing is thrown.
std::vector<DicomFile> describe_dicom_files(const std::vector<std::string>& paths,
                                            const ProgressListener& listener);

/// Receives a frame: its number and its voxels, which are number `first` on in `packed`.
using UseFrame = std::function<void(std::size_t frame, const PixelPacking& packing,
                                    const void* packed, std::size_t first)>;

/// Reads frames [begin, end) of a file without fault.
/// @throws WorkError  where the pixels are cut short or cannot be decoded.
void read_dicom_frames(const DicomFile& file, std::size_t begin, std::size_t end,
                       const UseFrame& use);

}  // namespace isolux
