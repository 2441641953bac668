#pragma once

#include <string>
#include <string_view>

namespace isolux {

/// The parts of a request's target that the server knows: "/open?name=head.nrrd".
struct Target {
  std::string path;
  std::string name;  ///< the value of the query's `name`, decoded
};

Target parse_target(std::string_view target);

/// A name that a file can safely have in a folder of its own: the last part of what looks like a
/// path, without control characters, at most 200 bytes of UTF-8; "file" where nothing is left.
std::string bare_file_name(std::string_view name);

}  // namespace isolux
