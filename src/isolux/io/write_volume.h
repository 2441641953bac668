#pragma once

#include <string>

#include "isolux/volume/volume.h"

namespace isolux {

/// Writes a volume in the format that the name's ending says, compressed, with its placement:
/// .nrrd (exact), .mha (exact), .nii and .nii.gz (NIfTI keeps the affine as 32-bit floats).
/// The file that was there survives a failure.
/// @throws UsageError  another ending. @throws WorkError  cannot be written.
void write_volume(const std::string& path, const Volume& volume);

/// Whether the format that the name says cannot hold the volume's placement exactly.
bool rounds_placement(const std::string& path, const Volume& volume);

/// @throws UsageError  where write_volume would not know the ending.
void check_volume_name(const std::string& path);

}  // namespace isolux
