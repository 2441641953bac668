#pragma once

#include <string>
#include <vector>

#include "isolux/io/dicom_file.h"
#include "isolux/io/dicom_geometry.h"
#include "isolux/io/reader.h"
#include "isolux/volume/volume.h"

namespace isolux {

/// A frame of one of several files.
struct DicomSlice {
  std::size_t file;
  std::size_t frame;
};

/// Reads slices of one size, on all cores, each straight into its place. The voxels take the
/// narrowest type that holds every value, as voxels_read (stored_voxels.h) has it: a stored type
/// that needs no rescaling is kept, whole numbers stay whole. Notes where floats round. The slices
/// are then mixed into `layers` where they lie, whole numbers rounded; without layers, they are the
/// layers.
/// @throws WorkError  as read_dicom_frames, or where memory is short.
VoxelArray read_dicom_slices(const ReadRequest& request, const std::vector<DicomFile>& files,
                             const std::vector<DicomSlice>& slices,
                             const std::vector<Layer>& layers, std::vector<std::string>& notes);

/// The most bytes that a voxel of read_dicom_slices takes.
double dicom_bytes_per_voxel_most(const std::vector<DicomFile>& files,
                                  const std::vector<DicomSlice>& slices);

}  // namespace isolux
