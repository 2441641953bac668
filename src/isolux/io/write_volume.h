#pragma once

#include <string>

#include "isolux/volume/volume.h"

namespace isolux {

/// Writes a volume in the format that the name's ending says, compressed, with its placement:
/// .nrrd, .mha, .nii or .nii.gz (which other programs read with an affine of 32-bit floats).
/// The file that was there survives a failure.
/// @throws UsageError  another ending. @throws WorkError  cannot be written.
void write_volume(const std::string& path, const Volume& volume);

/// @throws UsageError  where write_volume would not know the ending.
void check_volume_name(const std::string& path);

}  // namespace isolux
