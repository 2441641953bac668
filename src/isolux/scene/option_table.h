#pragma once

#include <limits>
#include <string>
#include <vector>

namespace isolux {

/// What an option's value looks like: on the command line | in a scene file.
enum class ValueType {
  kNumber,  ///< 0.5           | 0.5
  kWhole,   ///< 3             | 3
  kVector,  ///< 0:0:57        | [0, 0, 57]
  kColor,   ///< 1:0.8:0.6     | [1, 0.8, 0.6]   linear RGB
  kSize,    ///< 1024x768      | [1024, 768]     two or three whole numbers, see `parts`
  kChoice,  ///< srgb          | "srgb"
  kText,    ///< head.nrrd     | "head.nrrd"
  kFlag,    ///< (no value)    | true
  kRecord,  ///< iso=300,kd=1:0:0 | {"iso": 300, "kd": [1, 0, 0]}
};

/// One option, or one field of a record: everything that the command line, the scene file, the help
/// and the manual page say of it.
struct Option {
  std::string name;
  ValueType type = ValueType::kText;
  std::string sentence;  ///< what it does, one sentence without its full stop

  std::string default_text = {};  ///< as on the command line; empty: none
  std::string unit = {};
  double low = -std::numeric_limits<double>::infinity();
  double high = std::numeric_limits<double>::infinity();
  bool low_excluded = false;              ///< the value must be greater than `low`
  int parts = 2;                          ///< kSize: how many numbers
  std::vector<std::string> choices = {};  ///< kChoice
  bool repeatable = false;                ///< a list; in a scene file an array
  std::vector<Option> fields = {};        ///< kRecord
  bool kind_first = false;                ///< kRecord: the first field is written bare, without key
  /// Known to the contract but not to this version: why it is refused.
  std::string not_yet = {};
};

/// The options that say what is drawn. One order for help, manual and scene files.
const std::vector<Option>& scene_options();

/// The option of that name, or nullptr.
const Option* find_option(const std::vector<Option>& options, const std::string& name);

/// The known name nearest to a mistyped one (at most 2 edits away), or an empty text.
std::string nearest_name(const std::vector<Option>& options, const std::string& name);

}  // namespace isolux
