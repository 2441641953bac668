#include "isolux/scene/document.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <set>

#include "isolux/base/error.h"
#include "isolux/scene/option_table.h"
#include "isolux/scene/option_value.h"

namespace isolux {
namespace {

using nlohmann::json;

void fill_defaults(const std::vector<Option>& options, json& values) {
  for (const Option& option : options) {
    if (option.type == ValueType::kRecord && values.contains(option.name)) {
      json& given = values[option.name];
      if (option.repeatable) {
        for (json& item : given) {
          // A mesh has coefficients of its own, which the defaults must not replace.
          const bool is_mesh = option.name == "surface" && !item.contains("iso");
          if (!is_mesh) fill_defaults(option.fields, item);
        }
      } else {
        fill_defaults(option.fields, given);
      }
    } else if (!option.default_text.empty() && !values.contains(option.name)) {
      values[option.name] = value_from_text(option, option.default_text, option.name);
    }
  }
}

// 18 and 18.0 are one number: the command line and a scene file are to give one document.
void write_as_doubles(const std::vector<Option>& options, json& values) {
  for (const Option& option : options) {
    if (!values.contains(option.name)) continue;
    json& given = values[option.name];
    if (option.type == ValueType::kRecord && option.repeatable) {
      for (json& item : given) write_as_doubles(option.fields, item);
    } else if (option.type == ValueType::kRecord) {
      write_as_doubles(option.fields, given);
    } else if (option.type == ValueType::kNumber) {
      given = given.get<double>();
    } else if (option.type == ValueType::kVector || option.type == ValueType::kColor) {
      for (json& part : given) part = part.get<double>();
    }
  }
}

void drop_defaults(const std::vector<Option>& options, json& values) {
  for (const Option& option : options) {
    if (!values.contains(option.name)) continue;
    json& given = values[option.name];
    if (option.type == ValueType::kRecord) {
      if (option.repeatable) {
        for (json& item : given) drop_defaults(option.fields, item);
      } else {
        drop_defaults(option.fields, given);
      }
    } else if (!option.default_text.empty() &&
               given == value_from_text(option, option.default_text, option.name)) {
      values.erase(option.name);
    }
  }
}

std::string shell_quoted(const std::string& text) {
  const auto is_plain = [](char c) {
    return std::isalnum(static_cast<unsigned char>(c)) ||
           std::string_view("_-.,:/=+@%").find(c) != std::string_view::npos;
  };
  if (!text.empty() && std::ranges::all_of(text, is_plain)) return text;
  std::string quoted = "'";
  for (const char c : text) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return quoted + "'";
}

void check_inputs(const json& inputs, const std::string& what) {
  const bool is_list_of_texts =
      inputs.is_array() &&
      std::ranges::all_of(inputs, [](const json& item) { return item.is_string(); });
  if (!is_list_of_texts) {
    throw UsageError(what + " input", "is not a list of texts", "write [\"head.nrrd\"]");
  }
}

}  // namespace

json empty_document() { return {{"isolux_scene", kSceneFormVersion}}; }

json parse_document(const std::string& text, const std::string& what) {
  // A key that comes twice would silently take the place of the first.
  std::vector<std::set<std::string>> keys;  // of the objects that are open
  const auto look = [&](int, json::parse_event_t event, json& parsed) {
    if (event == json::parse_event_t::object_start) keys.emplace_back();
    if (event == json::parse_event_t::object_end) keys.pop_back();
    if (event == json::parse_event_t::key &&
        !keys.back().insert(parsed.get<std::string>()).second) {
      throw UsageError(what, "has the key '" + parsed.get<std::string>() + "' twice in one object",
                       "give it once");
    }
    return true;
  };
  json document = json::parse(text, look, /*allow_exceptions=*/false);
  if (document.is_discarded()) {
    throw UsageError(what, "is not valid JSON", "check its commas and braces");
  }
  return document;
}

void check_document(const json& document, const std::string& what) {
  if (!document.is_object() || !document.contains("isolux_scene")) {
    throw UsageError(what, "is not an isolux scene",
                     "a scene is a JSON object with \"isolux_scene\": 1");
  }
  if (document["isolux_scene"] != kSceneFormVersion) {
    throw UsageError(what, "its scene form is version " + document["isolux_scene"].dump(),
                     "this program reads version " + std::to_string(kSceneFormVersion));
  }
  for (const auto& [key, value] : document.items()) {
    if (key == "isolux_scene") continue;
    if (key == "input") {
      check_inputs(value, what);
      continue;
    }
    const Option* option = find_option(scene_options(), key);
    if (!option) {
      const std::string near = nearest_name(scene_options(), key);
      throw UsageError(
          what, "has no key '" + key + "'",
          near.empty() ? "see docs/manual.md for the keys" : "did you mean " + near + "?");
    }
    if (!option->repeatable) {
      check_value(*option, value, what + " " + key);
      continue;
    }
    if (!value.is_array()) throw UsageError(what + " " + key, "is not a list", "write [ ... ]");
    for (const json& item : value) check_value(*option, item, what + " " + key);
  }
}

json with_defaults(const json& document) {
  json complete = document;
  fill_defaults(scene_options(), complete);
  write_as_doubles(scene_options(), complete);
  return complete;
}

json without_defaults(const json& document) {
  json brief = document;
  drop_defaults(scene_options(), brief);
  return brief;
}

std::string command_of(const json& document) {
  std::string command = "isolux render";
  if (document.contains("input")) {
    for (const json& input : document["input"]) {
      command += " " + shell_quoted(input.get<std::string>());
    }
  }
  for (const Option& option : scene_options()) {
    if (!document.contains(option.name)) continue;
    const json& value = document[option.name];
    const json items = option.repeatable ? value : json::array({value});
    for (const json& item : items) {
      command += " --" + option.name + " " + shell_quoted(text_from_value(option, item));
    }
  }
  return command;
}

}  // namespace isolux
