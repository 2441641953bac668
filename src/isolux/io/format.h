#pragma once

#include <string_view>

#include "isolux/io/reader.h"

namespace isolux {

/// One file format: how its files are known, and how they are read. The list of them is in
/// reader.cpp; a new format is one more file and one more line there.
struct Format {
  /// Whether a file's first bytes (up to 512) are of this format. `request` holds the name.
  bool (*recognises)(const ReadRequest& request, std::string_view first_bytes);
  ReadResult (*read)(const ReadRequest& request);
};

Format nrrd_format();
Format inv3_format();

/// Headerless voxels, described by the request's grid.
ReadResult read_raw(const ReadRequest& request);

/// "phantom:NAME" or "phantom:NAME,size=N".
ReadResult make_phantom(const ReadRequest& request);

/// Where the example head lies, or an empty text: Debian's documentation folder, then the cache
/// folder of isolux.
std::string find_example_head();

}  // namespace isolux
