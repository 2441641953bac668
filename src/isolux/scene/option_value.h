#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>

#include "isolux/scene/option_table.h"

// An option's value has two written forms, the command line's text and the scene file's JSON. Both
// are read by the one table, so both know the same options, ranges and refusals.

namespace isolux {

/// The JSON form of a command line text. `what` names the option in errors ("--surface").
/// @throws UsageError  where the text is not of the option's type, out of range, or refused.
nlohmann::json value_from_text(const Option& option, std::string_view text,
                               const std::string& what);

/// The command line form of a JSON value that `check_value` passed.
std::string text_from_value(const Option& option, const nlohmann::json& value);

/// @throws UsageError  where a JSON value (one item of a repeatable option) is not of the option's
/// type, out of range, refused, or a record with unknown fields.
void check_value(const Option& option, const nlohmann::json& value, const std::string& what);

/// What the option's value looks like, for help: "X:Y:Z", "srgb|raw", "iso=V[,input=N]...".
std::string value_pattern(const Option& option);

}  // namespace isolux
