#include "isolux/io/nrrd_header.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>

#include "isolux/base/error.h"
#include "isolux/base/memory.h"
#include "isolux/base/number_text.h"
#include "isolux/io/data_file.h"
#include "isolux/io/header_text.h"
#include "isolux/io/stored_voxels.h"

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

double sample_bytes(const std::string& type) {
  static const std::map<std::string, double> kBytes = {{"signed char", 1},
                                                       {"int8", 1},
                                                       {"int8_t", 1},
                                                       {"uchar", 1},
                                                       {"unsigned char", 1},
                                                       {"uint8", 1},
                                                       {"uint8_t", 1},
                                                       {"short", 2},
                                                       {"short int", 2},
                                                       {"signed short", 2},
                                                       {"signed short int", 2},
                                                       {"int16", 2},
                                                       {"int16_t", 2},
                                                       {"ushort", 2},
                                                       {"unsigned short", 2},
                                                       {"unsigned short int", 2},
                                                       {"uint16", 2},
                                                       {"uint16_t", 2},
                                                       {"int", 4},
                                                       {"signed int", 4},
                                                       {"int32", 4},
                                                       {"int32_t", 4},
                                                       {"uint", 4},
                                                       {"unsigned int", 4},
                                                       {"uint32", 4},
                                                       {"uint32_t", 4},
                                                       {"longlong", 8},
                                                       {"long long", 8},
                                                       {"long long int", 8},
                                                       {"signed long long", 8},
                                                       {"signed long long int", 8},
                                                       {"int64", 8},
                                                       {"int64_t", 8},
                                                       {"ulonglong", 8},
                                                       {"unsigned long long", 8},
                                                       {"unsigned long long int", 8},
                                                       {"uint64", 8},
                                                       {"uint64_t", 8},
                                                       {"float", 4},
                                                       {"double", 8}};
  const auto found = kBytes.find(type);
  return found == kBytes.end() ? 0 : found->second;
}

WorkError damaged(const std::string& path, const std::string& why) {
  return {path, "damaged NRRD header: " + why, "compare it with the file that wrote it"};
}

// "name.%03d.raw 1 93 1": one file for each number.
std::vector<std::string> pattern_files(const std::string& path, const std::vector<std::string>& w) {
  const auto first = parse_whole_number(w[1]), last = parse_whole_number(w[2]),
             step = parse_whole_number(w[3]);
  std::vector<std::string> files;
  if (first && last && step) files = numbered_files(w[0], *first, *last, *step);
  if (files.empty()) throw damaged(path, "data file pattern '" + w[0] + "' is not understood");
  return files;
}

std::vector<std::string> read_data_files(const std::string& path, const std::string& value,
                                         std::istream& rest) {
  const std::vector<std::string> w = words(value);
  if (!w.empty() && w[0] == "LIST") {
    std::vector<std::string> files;
    for (std::string line; std::getline(rest, line);) {
      if (!trimmed(line).empty()) files.push_back(trimmed(line));
    }
    return files;
  }
  if (w.size() >= 4 && w[0].find('%') != std::string::npos) return pattern_files(path, w);
  return {value};
}

double whole_field(const std::string& path, const std::string& name, const std::string& value,
                   double low) {
  const auto number = parse_whole_number(value);
  if (!number || static_cast<double>(*number) < low) {
    throw damaged(path, name + " is '" + value + "'");
  }
  return static_cast<double>(*number);
}

void check_sizes(const std::string& path, const NrrdHeader& header) {
  check_memory(header.data_bytes(), path);
  double available = 0;
  std::vector<std::string> files = header.data_files;
  const double before = header.byte_skip > 0 ? header.byte_skip : 0;
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
  if (header.data_files.empty()) available -= header.header_bytes;
  const bool is_text = header.encoding == "ascii" || header.encoding == "txt" ||
                       header.encoding == "text" || header.encoding == "hex";
  // A number of any width takes at least two bytes of text.
  const double promised =
      is_text ? 2 * header.data_bytes() / header.bytes_per_sample : header.data_bytes();
  check_promise(path, promised, available, is_text ? "raw" : header.encoding);
}

}  // namespace

double NrrdHeader::data_bytes() const {
  double bytes = bytes_per_sample;
  for (const double size : sizes) bytes *= size;
  return bytes;
}

NrrdHeader read_nrrd_header(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  NrrdHeader header;
  double dimension = 0;
  std::string line;
  if (!std::getline(file, line)) throw damaged(path, "it is empty");
  constexpr int kMostLines = 100'000;
  for (int n = 0; std::getline(file, line) && n < kMostLines; ++n) {
    if (trimmed(line).empty()) break;
    if (line.starts_with('#') || line.find(":=") != std::string::npos) continue;
    const std::size_t colon = line.find(':');
    if (colon == std::string::npos)
      throw damaged(path, "a line has no field: '" + trimmed(line).substr(0, 40) + "'");
    const std::string name = field_name(line.substr(0, colon));
    const std::string value = trimmed(line.substr(colon + 1));
    const std::string keyword = lower_case(value);  // NRRD's own words know no case
    if (name == "type") {
      header.bytes_per_sample = sample_bytes(keyword);
      if (header.bytes_per_sample == 0)
        throw damaged(path, "type '" + value + "' is not a number type");
    } else if (name == "dimension") {
      dimension = whole_field(path, name, value, 1);
    } else if (name == "sizes") {
      for (const std::string& word : words(value)) {
        header.sizes.push_back(whole_field(path, name, word, 1));
      }
    } else if (name == "encoding") {
      header.encoding = keyword;
    } else if (name == "byteskip") {
      header.byte_skip = whole_field(path, "byte skip", value, -1);
    } else if (name == "lineskip") {
      header.line_skip = static_cast<int>(whole_field(path, "line skip", value, 0));
    } else if (name == "endian") {
      header.big_endian = keyword == "big";
    } else if (name == "datafile") {
      header.data_files = read_data_files(path, value, file);
      for (std::string& data : header.data_files) data = data_file_beside(path, data);
      if (file.eof()) break;
    }
  }
  file.clear();
  header.header_bytes = static_cast<double>(std::max<std::streamoff>(0, file.tellg()));
  if (header.bytes_per_sample == 0) throw damaged(path, "it has no type");
  if (header.encoding.empty()) throw damaged(path, "it has no encoding");
  if (header.sizes.empty()) throw damaged(path, "it has no sizes");
  if (static_cast<double>(header.sizes.size()) != dimension) {
    throw damaged(path, "dimension and sizes disagree");
  }
  check_sizes(path, header);
  return header;
}

}  // namespace isolux
