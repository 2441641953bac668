#pragma once

#include <string>
#include <vector>

#include "isolux/io/dicom_file.h"

namespace isolux {

/// The images of a scan that belong together; at least one is without fault.
struct DicomSeries {
  std::vector<DicomFile> files;

  const DicomFile& first() const;  ///< without fault
  double voxel_count() const;      ///< of files that hold one value a voxel
};

/// All series among `files`, by their number in the scan. Files of no image, and series in which
/// every file has a fault, are left out.
std::vector<DicomSeries> series_among(std::vector<DicomFile> files);

/// "1: 'T1 axial', MR, 256x256x20, 2001-04-13; 2: ...".
std::string series_list(const std::vector<DicomSeries>& series);

/// Which of the series `choice` names, by its number in the list from 1 or its UID.
/// @throws UsageError  where it names none.
std::size_t chosen_series(const std::vector<DicomSeries>& series, const std::string& choice);

/// The series of most voxels.
std::size_t largest_series(const std::vector<DicomSeries>& series);

}  // namespace isolux
