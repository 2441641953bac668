#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "isolux/base/vec3.h"
#include "isolux/io/stored_voxels.h"

namespace isolux {

/// What the header says of one axis.
struct NrrdAxis {
  std::uint64_t size = 0;
  std::optional<double> spacing;
  std::optional<Vec3> direction;  ///< one step along the axis, in the space's own axes
  std::string kind;               ///< "domain", "list", "vector", ...; empty: not told
  std::string unit;               ///< of the spacing
};

/// An NRRD header, checked for sense and against the sizes of its files (see
/// teem.sourceforge.net/nrrd/format.html).
struct NrrdHeader {
  StoredType type = StoredType::kU8;
  std::string encoding;  ///< "raw", "gzip", "bzip2", "text" or "hex"
  bool big_endian = false;
  std::vector<NrrdAxis> axes;  ///< at least one, fastest first
  std::string space;           ///< "left-posterior-superior", ...; without time; empty: not told
  std::vector<std::string> space_units;
  Vec3 origin;
  std::map<std::string, std::string> key_values;
  std::int64_t byte_skip = 0;  ///< before the data in each file; -1: data are at the end
  int line_skip = 0;
  std::vector<std::string> data_files;  ///< where the data lie; empty: behind the header
  std::uint64_t header_bytes = 0;       ///< length of the header with its blank line

  double data_bytes() const;  ///< of the decoded data
};

/// Reads the header of an NRRD file and the sizes of the files that it names.
/// @throws WorkError  where the data cannot be in those files, or the header is malformed.
NrrdHeader read_nrrd_header(const std::string& path);

}  // namespace isolux
