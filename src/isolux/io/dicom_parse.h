#pragma once

#include <string>

#include "isolux/base/fence.h"
#include "isolux/io/dicom_file.h"

namespace isolux {

/// The parts that GDCM does. It aborts and hangs on damaged files, so both are to be called inside
/// a fence only (isolux/base/fence.h).

/// Reads a file's header up to its pixels; all but the pixels' sizes is unchecked. May throw
/// anything.
DicomFile parse_dicom_header(const std::string& path, std::size_t start);

/// Decodes all frames and sends them: an empty text (or why it cannot be done), the PixelPacking,
/// then the voxels; frames that are a piece each one at a time. May throw anything.
void decode_dicom_pixels(const DicomFile& file, FenceOutput& output);

}  // namespace isolux
