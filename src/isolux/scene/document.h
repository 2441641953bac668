#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

// The scene's file form: a JSON object whose keys are the names of the option table, "input" for
// the list of inputs, and "isolux_scene" for the version of the form. The command line is first
// made into such a document as well, so that whatever either can say, both can.

namespace isolux {

inline constexpr int kSceneFormVersion = 1;

/// An empty document of the current version.
nlohmann::json empty_document();

/// The document that a text holds.
/// @throws UsageError  where it is not JSON, or an object in it has a key twice; `what` names the
/// file.
nlohmann::json parse_document(const std::string& text, const std::string& what);

/// @throws UsageError  on a wrong version, unknown keys, wrong types, values out of range or
/// refused; `what` names the file.
void check_document(const nlohmann::json& document, const std::string& what);

/// The document with every default of the option table written out, and numbers written in one way.
nlohmann::json with_defaults(const nlohmann::json& document);

/// The opposite: without what the option table's defaults say anyway.
nlohmann::json without_defaults(const nlohmann::json& document);

/// The `isolux render` command that says the same, without output and ready for a POSIX shell.
std::string command_of(const nlohmann::json& document);

}  // namespace isolux
