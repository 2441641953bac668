#include "isolux/io/nrrd_header.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <set>

#include "isolux/base/error.h"
#include "isolux/base/number_text.h"
#include "isolux/io/data_file.h"
#include "isolux/io/header_text.h"

namespace isolux {
namespace {

namespace fs = std::filesystem;

// Field names may be written with or without their space ("data file", "datafile").
std::string field_name(const std::string& text) {
  std::string name;
  for (const char c : text) {
    if (c != ' ') name += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  }
  return name;
}

std::string lower_case(std::string text) {
  for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

std::optional<StoredType> stored_type(const std::string& name) {
  using enum StoredType;
  static const std::map<std::string, StoredType> types = {{"signed char", kI8},
                                                          {"int8", kI8},
                                                          {"int8_t", kI8},
                                                          {"uchar", kU8},
                                                          {"unsigned char", kU8},
                                                          {"uint8", kU8},
                                                          {"uint8_t", kU8},
                                                          {"short", kI16},
                                                          {"short int", kI16},
                                                          {"signed short", kI16},
                                                          {"signed short int", kI16},
                                                          {"int16", kI16},
                                                          {"int16_t", kI16},
                                                          {"ushort", kU16},
                                                          {"unsigned short", kU16},
                                                          {"unsigned short int", kU16},
                                                          {"uint16", kU16},
                                                          {"uint16_t", kU16},
                                                          {"int", kI32},
                                                          {"signed int", kI32},
                                                          {"int32", kI32},
                                                          {"int32_t", kI32},
                                                          {"uint", kU32},
                                                          {"unsigned int", kU32},
                                                          {"uint32", kU32},
                                                          {"uint32_t", kU32},
                                                          {"longlong", kI64},
                                                          {"long long", kI64},
                                                          {"long long int", kI64},
                                                          {"signed long long", kI64},
                                                          {"signed long long int", kI64},
                                                          {"int64", kI64},
                                                          {"int64_t", kI64},
                                                          {"ulonglong", kU64},
                                                          {"unsigned long long", kU64},
                                                          {"unsigned long long int", kU64},
                                                          {"uint64", kU64},
                                                          {"uint64_t", kU64},
                                                          {"float", kF32},
                                                          {"double", kF64}};
  const auto found = types.find(name);
  return found == types.end() ? std::nullopt : std::optional(found->second);
}

// One name for each encoding; nothing for an unknown one.
std::string encoding_of(const std::string& name) {
  static const std::map<std::string, std::string> names = {
      {"raw", "raw"},    {"gzip", "gzip"}, {"gz", "gzip"},  {"bzip2", "bzip2"}, {"bz2", "bzip2"},
      {"ascii", "text"}, {"text", "text"}, {"txt", "text"}, {"hex", "hex"}};
  const auto found = names.find(name);
  return found == names.end() ? std::string() : found->second;
}

// The space's full name; nothing for an unknown one.
std::string space_of(const std::string& name) {
  static const std::map<std::string, std::string> kShort = {{"ras", "right-anterior-superior"},
                                                            {"las", "left-anterior-superior"},
                                                            {"lps", "left-posterior-superior"}};
  static const std::set<std::string> kKnown = {"right-anterior-superior", "left-anterior-superior",
                                               "left-posterior-superior", "scanner-xyz",
                                               "3d-right-handed",         "3d-left-handed"};
  // With time as a fourth axis the places along the first three are the same.
  const bool has_time = name.ends_with("-time") || (name.size() == 4 && name.ends_with('t'));
  const std::string places = !has_time          ? name
                             : name.size() == 4 ? name.substr(0, 3)
                                                : name.substr(0, name.size() - 5);
  const auto found = kShort.find(places);
  if (found != kShort.end()) return found->second;
  return kKnown.contains(places) ? places : std::string();
}

// Reads the fields of one header, line by line.
class HeaderParser {
 public:
  explicit HeaderParser(const std::string& path) : path_(path), file_(path, std::ios::binary) {}

  NrrdHeader parse() {
    std::string line;
    std::getline(file_, line);
    const auto version = parse_whole_number(std::string_view(trimmed(line)).substr(4));
    if (!version || *version < 1 || *version > 6) {
      throw damaged("it begins with '" + trimmed(line).substr(0, 40) + "'");
    }
    constexpr int kMostLines = 100'000;
    for (int n = 0; n < kMostLines && std::getline(file_, line); ++n) {
      if (trimmed(line).empty()) break;
      if (!line.starts_with('#')) take_line(line);
    }
    file_.clear();
    const auto end = static_cast<std::streamoff>(file_.tellg());
    header_.header_bytes = static_cast<std::uint64_t>(std::max<std::streamoff>(0, end));
    if (!has_type_) throw damaged("it has no type");
    if (header_.encoding.empty()) throw damaged("it has no encoding");
    if (header_.axes.empty()) throw damaged("it has no sizes");
    if (!has_endian_ && header_.encoding != "text" && bytes_of(header_.type) > 1) {
      throw damaged("it has no endian");
    }
    if (header_.axes.size() != dimension_) throw damaged("dimension and sizes disagree");
    for (const auto& [name, words] : later_) take_axis_words(name, words);
    return header_;
  }

 private:
  WorkError damaged(const std::string& why) const {
    return {path_, "damaged NRRD header: " + why, "compare it with the file that wrote it"};
  }

  void take_line(const std::string& line) {
    if (const std::size_t sign = line.find(":="); sign != std::string::npos) {
      header_.key_values[trimmed(line.substr(0, sign))] = trimmed(line.substr(sign + 2));
      return;
    }
    const std::size_t colon = line.find(':');
    if (colon == std::string::npos) {
      throw damaged("a line has no field: '" + trimmed(line).substr(0, 40) + "'");
    }
    take_field(field_name(line.substr(0, colon)), trimmed(line.substr(colon + 1)));
  }

  void take_field(const std::string& name, const std::string& value) {
    const std::string keyword = lower_case(value);  // NRRD's own words know no case
    if (name == "type") {
      const auto type = stored_type(keyword);
      if (!type) throw damaged("type '" + value + "' is not a number type");
      header_.type = *type;
      has_type_ = true;
    } else if (name == "dimension") {
      dimension_ = static_cast<std::size_t>(whole("dimension", value, 1, 16));
    } else if (name == "sizes") {
      header_.axes.clear();
      for (const std::string& word : words(value)) {
        constexpr long long kLongest = 1LL << 40;
        header_.axes.push_back({.size = static_cast<std::uint64_t>(whole(name, word, 1, kLongest)),
                                .spacing = {},
                                .direction = {},
                                .kind = {},
                                .unit = {}});
      }
    } else if (name == "encoding") {
      header_.encoding = encoding_of(keyword);
      if (header_.encoding.empty()) throw damaged("encoding '" + value + "' is not known");
    } else if (name == "byteskip") {
      header_.byte_skip = whole("byte skip", value, -1, 1LL << 60);
    } else if (name == "lineskip") {
      header_.line_skip = static_cast<int>(whole("line skip", value, 0, 1 << 30));
    } else if (name == "endian") {
      if (keyword != "big" && keyword != "little") throw damaged("endian is '" + value + "'");
      header_.big_endian = keyword == "big";
      has_endian_ = true;
    } else if (name == "space") {
      header_.space = space_of(keyword);
      if (header_.space.empty()) throw damaged("space '" + value + "' is not known");
    } else if (name == "spaceorigin") {
      const auto vectors = vectors_of(value);
      if (vectors.size() == 1 && vectors[0]) header_.origin = *vectors[0];
    } else if (name == "spaceunits") {
      header_.space_units = quoted(value);
    } else if (name == "datafile") {
      take_data_files(value);
    } else if (name == "spacings" || name == "spacedirections" || name == "kinds" ||
               name == "units") {
      later_[name] = value;  // these need the number of axes, which may follow
    }
  }

  // A value for each axis.
  void take_axis_words(const std::string& name, const std::string& value) {
    std::vector<NrrdAxis>& axes = header_.axes;
    const auto check_count = [&](std::size_t count) {
      if (count == axes.size()) return;
      throw damaged(name + " has " + std::to_string(count) + " values for " +
                    std::to_string(axes.size()) + " axes");
    };
    if (name == "spacedirections") {
      const auto vectors = vectors_of(value);
      check_count(vectors.size());
      for (std::size_t n = 0; n < axes.size(); ++n) axes[n].direction = vectors[n];
      return;
    }
    const std::vector<std::string> list = name == "units" ? quoted(value) : words(value);
    check_count(list.size());
    for (std::size_t n = 0; n < axes.size(); ++n) {
      if (name == "units") axes[n].unit = list[n];
      if (name == "kinds") axes[n].kind = lower_case(list[n]);
      if (name != "spacings" || lower_case(list[n]) == "nan") continue;
      axes[n].spacing = parse_number(list[n]);
      if (!axes[n].spacing) throw damaged("a spacing is '" + list[n] + "'");
    }
  }

  // "(1,0,0) none (0, 0, 1)"; of longer vectors the first three numbers.
  std::vector<std::optional<Vec3>> vectors_of(const std::string& text) const {
    std::vector<std::optional<Vec3>> vectors;
    for (std::size_t at = 0; (at = text.find_first_not_of(" \t", at)) != std::string::npos;) {
      if (text[at] != '(') {
        const std::size_t end = std::min(text.find_first_of(" \t", at), text.size());
        if (lower_case(text.substr(at, end - at)) != "none") throw damaged("'" + text + "'");
        vectors.emplace_back();
        at = end;
        continue;
      }
      const std::size_t end = text.find(')', at);
      if (end == std::string::npos) throw damaged("a vector has no end: '" + text + "'");
      vectors.push_back(vector_of(text.substr(at + 1, end - at - 1)));
      at = end + 1;
    }
    return vectors;
  }

  std::optional<Vec3> vector_of(std::string text) const {
    std::ranges::replace(text, ',', ' ');
    Vec3 vector{0, 0, 0};
    bool is_told = true;
    const std::vector<std::string> numbers = words(text);
    for (std::size_t n = 0; n < std::min<std::size_t>(numbers.size(), 3); ++n) {
      if (lower_case(numbers[n]) == "nan") {
        is_told = false;
        continue;
      }
      const auto number = parse_number(numbers[n]);
      if (!number) throw damaged("a vector holds '" + numbers[n] + "'");
      vector[static_cast<int>(n)] = *number;
    }
    return is_told ? std::optional(vector) : std::nullopt;
  }

  // The texts between quotes.
  static std::vector<std::string> quoted(const std::string& text) {
    std::vector<std::string> list;
    for (std::size_t at = 0; (at = text.find('"', at)) != std::string::npos;) {
      const std::size_t end = text.find('"', at + 1);
      if (end == std::string::npos) break;
      list.push_back(trimmed(text.substr(at + 1, end - at - 1)));
      at = end + 1;
    }
    return list;
  }

  void take_data_files(const std::string& value) {
    const std::vector<std::string> w = words(value);
    std::vector<std::string>& files = header_.data_files;
    if (!w.empty() && w[0] == "LIST") {
      for (std::string line; std::getline(file_, line);) {
        if (!trimmed(line).empty()) files.push_back(trimmed(line));
      }
    } else if (w.size() >= 4 && w[0].find('%') != std::string::npos) {
      // "name.%03d.raw 1 93 1": one file for each number.
      const auto first = parse_whole_number(w[1]), last = parse_whole_number(w[2]),
                 step = parse_whole_number(w[3]);
      if (first && last && step) files = numbered_files(w[0], *first, *last, *step);
      if (files.empty()) throw damaged("data file pattern '" + w[0] + "' is not understood");
    } else {
      files = {value};
    }
    for (std::string& file : files) file = data_file_beside(path_, file);
  }

  long long whole(const std::string& name, const std::string& value, long long low,
                  long long high) const {
    const auto number = parse_whole_number(value);
    if (!number || *number < low || *number > high) throw damaged(name + " is '" + value + "'");
    return *number;
  }

  std::string path_;
  std::ifstream file_;
  NrrdHeader header_;
  std::size_t dimension_ = 0;
  bool has_type_ = false, has_endian_ = false;
  std::map<std::string, std::string> later_;
};

void check_sizes(const std::string& path, const NrrdHeader& header) {
  double available = 0;
  std::vector<std::string> files = header.data_files;
  const auto before = static_cast<double>(std::max<std::int64_t>(header.byte_skip, 0));
  if (files.empty()) files.push_back(path);
  for (const std::string& file : files) {
    std::error_code error;
    const double size = static_cast<double>(fs::file_size(file, error));
    if (error) {
      throw WorkError(path, "its data file " + file + " cannot be read: " + error.message(),
                      "a detached header needs its data files beside it");
    }
    available += std::max(0.0, size - before);
  }
  if (header.data_files.empty()) available -= static_cast<double>(header.header_bytes);
  const bool is_text = header.encoding == "text" || header.encoding == "hex";
  // A number as text takes a digit and, but for the last, a blank; a byte in hexadecimal two
  // digits.
  const double promised =
      header.encoding == "text"
          ? 2 * header.data_bytes() / static_cast<double>(bytes_of(header.type)) - 1
          : (is_text ? 2 : 1) * header.data_bytes();
  check_promise(path, promised, available, is_text ? "raw" : header.encoding);
}

}  // namespace

double NrrdHeader::data_bytes() const {
  auto bytes = static_cast<double>(bytes_of(type));
  for (const NrrdAxis& axis : axes) bytes *= static_cast<double>(axis.size);
  return bytes;
}

NrrdHeader read_nrrd_header(const std::string& path) {
  NrrdHeader header = HeaderParser(path).parse();
  check_sizes(path, header);
  return header;
}

}  // namespace isolux
