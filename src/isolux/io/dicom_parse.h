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

/// Decodes frames [begin, end) and sends them: an empty text (or why it cannot be done), the
/// PixelPacking, then the voxels. One at a time where they are in pieces; else begin must be 0. May
/// throw anything.
void decode_dicom_pixels(const DicomFile& file, std::size_t begin, std::size_t end,
                         FenceOutput& output);

}  // namespace isolux
