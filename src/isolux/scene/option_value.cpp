#include "isolux/scene/option_value.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "isolux/base/error.h"
#include "isolux/base/number_text.h"

namespace isolux {
namespace {

using nlohmann::json;

std::string joined(const std::vector<std::string>& items, const char* separator) {
  std::string text;
  for (const std::string& item : items) text += (text.empty() ? "" : separator) + item;
  return text;
}

std::vector<std::string> split(std::string_view text, char separator) {
  std::vector<std::string> items;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find(separator, begin), text.size());
    items.emplace_back(text.substr(begin, end - begin));
    begin = end + 1;
  }
  return items;
}

std::string in_quotes(std::string_view text) { return "'" + std::string(text) + "'"; }

std::string range_text(const Option& o) {
  const bool has_low = std::isfinite(o.low), has_high = std::isfinite(o.high);
  if (has_low && o.low_excluded) return "a number above " + to_text(o.low);
  if (has_low && has_high) return "from " + to_text(o.low) + " to " + to_text(o.high);
  return "any number";
}

void check_number(const Option& o, double value, const std::string& what) {
  const bool too_low = o.low_excluded ? value <= o.low : value < o.low;
  if (!std::isfinite(value) || too_low || value > o.high) {
    throw UsageError(what, to_text(value) + " is out of range", "give " + range_text(o));
  }
}

void check_choice(const Option& o, const std::string& value, const std::string& what) {
  for (const std::string& choice : o.choices) {
    if (choice == value) return;
  }
  throw UsageError(what, in_quotes(value) + " is none of its values",
                   "give one of " + joined(o.choices, ", "));
}

std::string unknown_field_hint(const Option& record, const std::string& key) {
  const std::string near = nearest_name(record.fields, key);
  if (!near.empty()) return "did you mean " + near + "=...?";
  std::vector<std::string> names;
  for (const Option& field : record.fields) names.push_back(field.name);
  return "it has " + joined(names, ", ");
}

bool is_numbers(const json& value, std::size_t count) {
  if (!value.is_array() || value.size() != count) return false;
  for (const json& item : value) {
    if (!item.is_number()) return false;
  }
  return true;
}

std::size_t part_count(const Option& o) {
  return o.type == ValueType::kSize ? static_cast<std::size_t>(o.parts) : 3;
}

void check_record(const Option& option, const json& value, const std::string& what) {
  if (!value.is_object()) throw UsageError(what, "is not an object", "write { \"key\": value }");
  for (const auto& [key, item] : value.items()) {
    const Option* field = find_option(option.fields, key);
    if (!field) {
      throw UsageError(what, "has no field " + in_quotes(key), unknown_field_hint(option, key));
    }
    check_value(*field, item, what + " " + key);
  }
}

json record_from_text(const Option& option, std::string_view text, const std::string& what) {
  json record = json::object();
  const std::vector<std::string> items = split(text, ',');
  for (std::size_t n = 0; n < items.size(); ++n) {
    const std::string& item = items[n];
    const std::size_t equals = item.find('=');
    const bool is_kind = n == 0 && option.kind_first && equals == std::string::npos;
    if (!is_kind && equals == std::string::npos) {
      throw UsageError(what, in_quotes(item) + " is not key=value",
                       "it takes " + value_pattern(option));
    }
    const std::string key = is_kind ? option.fields[0].name : item.substr(0, equals);
    const Option* field = find_option(option.fields, key);
    if (!field) {
      throw UsageError(what, "has no field " + in_quotes(key), unknown_field_hint(option, key));
    }
    if (record.contains(key)) {
      throw UsageError(what, key + " is given twice", "give it once");
    }
    record[key] =
        value_from_text(*field, is_kind ? item : item.substr(equals + 1), what + " " + key);
  }
  return record;
}

json plain_from_text(const Option& option, std::string_view text, const std::string& what) {
  switch (option.type) {
    case ValueType::kNumber:
      if (const auto number = parse_number(text)) return *number;
      throw UsageError(what, in_quotes(text) + " is not a number", "give " + range_text(option));
    case ValueType::kWhole:
      if (const auto number = parse_whole_number(text)) return *number;
      throw UsageError(what, in_quotes(text) + " is not a whole number",
                       "give " + range_text(option));
    case ValueType::kVector:
    case ValueType::kColor: {
      json list = json::array();
      for (const std::string& part : split(text, ':')) {
        if (const auto number = parse_number(part)) list.push_back(*number);
      }
      if (list.size() == 3 && split(text, ':').size() == 3) return list;
      throw UsageError(what, in_quotes(text) + " is not three numbers",
                       "give them as " + value_pattern(option) + ", such as 0:0.5:1");
    }
    case ValueType::kSize: {
      json list = json::array();
      for (const std::string& part : split(text, 'x')) {
        if (const auto number = parse_whole_number(part)) list.push_back(*number);
      }
      if (list.size() == part_count(option) && split(text, 'x').size() == list.size()) return list;
      throw UsageError(
          what, in_quotes(text) + " is not a size",
          std::string("give it as ") + (option.parts == 3 ? "256x256x113" : "1024x768"));
    }
    default:
      return std::string(text);
  }
}

}  // namespace

json value_from_text(const Option& option, std::string_view text, const std::string& what) {
  json value = option.type == ValueType::kRecord ? record_from_text(option, text, what)
                                                 : plain_from_text(option, text, what);
  check_value(option, value, what);
  return value;
}

void check_value(const Option& option, const json& value, const std::string& what) {
  switch (option.type) {
    case ValueType::kNumber:
      if (!value.is_number()) throw UsageError(what, "is not a number", "write 0.5");
      check_number(option, value.get<double>(), what);
      break;
    case ValueType::kWhole:
      if (!value.is_number_integer()) throw UsageError(what, "is not a whole number", "write 3");
      check_number(option, value.get<double>(), what);
      break;
    case ValueType::kVector:
    case ValueType::kColor:
    case ValueType::kSize:
      if (!is_numbers(value, part_count(option))) {
        throw UsageError(what,
                         "is not a list of " + std::to_string(part_count(option)) + " numbers",
                         "write [1, 2, 3]");
      }
      for (const json& item : value) {
        if (option.type == ValueType::kSize && !item.is_number_integer()) {
          throw UsageError(what, "holds a number that is not whole", "write [1024, 768]");
        }
        check_number(option, item.get<double>(), what);
      }
      break;
    case ValueType::kChoice:
      if (!value.is_string()) {
        throw UsageError(what, "is not a text", "write one of " + joined(option.choices, ", "));
      }
      check_choice(option, value.get<std::string>(), what);
      break;
    case ValueType::kText:
      if (!value.is_string()) throw UsageError(what, "is not a text", "write \"...\"");
      break;
    case ValueType::kFlag:
      if (!value.is_boolean()) throw UsageError(what, "is neither true nor false", "write true");
      break;
    case ValueType::kRecord:
      check_record(option, value, what);
      break;
  }
  if (!option.not_yet.empty()) throw UsageError(what, option.not_yet, "leave it out");
}

std::string text_from_value(const Option& option, const json& value) {
  switch (option.type) {
    case ValueType::kNumber:
    case ValueType::kWhole:
      return to_text(value.get<double>());
    case ValueType::kVector:
    case ValueType::kColor:
    case ValueType::kSize: {
      std::vector<std::string> parts;
      for (const json& item : value) parts.push_back(to_text(item.get<double>()));
      return joined(parts, option.type == ValueType::kSize ? "x" : ":");
    }
    case ValueType::kRecord: {
      std::vector<std::string> items;
      for (const Option& field : option.fields) {  // the table's order, not the alphabet's
        if (!value.contains(field.name)) continue;
        const bool bare = option.kind_first && items.empty() && &field == &option.fields[0];
        items.push_back((bare ? "" : field.name + "=") + text_from_value(field, value[field.name]));
      }
      return joined(items, ",");
    }
    case ValueType::kFlag:
      return value.get<bool>() ? "true" : "false";
    default:
      return value.get<std::string>();
  }
}

std::string value_pattern(const Option& option) {
  switch (option.type) {
    case ValueType::kNumber:
      return "V";
    case ValueType::kWhole:
      return "N";
    case ValueType::kVector:
      return "X:Y:Z";
    case ValueType::kColor:
      return "R:G:B";
    case ValueType::kSize:
      return option.parts == 3 ? "NXxNYxNZ" : "WxH";
    case ValueType::kChoice:
      return joined(option.choices, "|");
    case ValueType::kText:
      return "TEXT";
    case ValueType::kFlag:
      return "";
    case ValueType::kRecord:
      break;
  }
  std::vector<std::string> items;
  for (const Option& field : option.fields) {
    const bool bare = option.kind_first && items.empty();
    items.push_back((bare ? "" : field.name + "=") + value_pattern(field));
  }
  return joined(items, ",");
}

}  // namespace isolux
