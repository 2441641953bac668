#pragma once

#include <string>
#include <vector>

namespace isolux {

/// What an NRRD header promises of its data, read before ITK reads the file, so that no promise
/// is believed before it is checked (see teem.sourceforge.net/nrrd/format.html).
struct NrrdHeader {
  std::vector<double> sizes;  ///< samples along each axis, fastest first
  std::string encoding;       ///< "raw", "gzip", "ascii", "hex", "bzip2"
  double bytes_per_sample = 0;
  double byte_skip = 0;  ///< before the data in each file; -1: data are at the end
  int line_skip = 0;
  bool big_endian = false;
  std::vector<std::string> data_files;  ///< where the data lie; empty: behind the header
  double header_bytes = 0;              ///< length of the header with its blank line

  double data_bytes() const;  ///< of the decoded data
};

/// Reads the header of an NRRD file and the sizes of the files that it names, and checks that the
/// data fit the files and this machine's memory.
/// @throws WorkError  where they do not, or the header is malformed.
NrrdHeader read_nrrd_header(const std::string& path);

}  // namespace isolux
