#pragma once

#include <map>
#include <string>

namespace isolux {

/// Texts carried inside a picture file, by their key; UTF-8.
using Metadata = std::map<std::string, std::string>;

}  // namespace isolux
