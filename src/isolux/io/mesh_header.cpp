#include "isolux/io/mesh_header.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <limits>
#include <sstream>

#include "isolux/base/error.h"
#include "isolux/base/number_text.h"

namespace isolux {
namespace {

constexpr std::size_t kStlHeader = 84;
constexpr double kStlFacet = 50;

double stl_facets(std::string_view first_bytes) {
  std::uint32_t count = 0;
  if (first_bytes.size() >= kStlHeader) std::memcpy(&count, first_bytes.data() + 80, 4);
  return count;
}

bool is_text(std::string_view bytes) {
  return std::ranges::none_of(bytes, [](char c) { return c >= 0 && c < ' ' && !std::isspace(c); });
}

// Some binary files begin with "solid" too: then their size gives them away.
bool is_binary_stl(std::string_view first_bytes, double bytes) {
  return first_bytes.size() >= kStlHeader &&
         bytes == kStlHeader + kStlFacet * stl_facets(first_bytes);
}

// Whether lines, up to the first that is no comment or blank, are of an OBJ file.
bool begins_as_obj(std::string_view text) {
  std::istringstream lines{std::string(text)};
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    std::string word, rest;
    if (!(words >> word) || word[0] == '#') continue;
    if (word == "v" || word == "vn" || word == "vt") {
      double number = 0;
      return static_cast<bool>(words >> number);
    }
    const bool is_keyword = word == "mtllib" || word == "o" || word == "g" || word == "usemtl";
    if (!is_keyword) return false;
    if (word == "mtllib") return static_cast<bool>(words >> rest);
  }
  return false;
}

// What of a file's first bytes may hold the tag: an STL's header, a PLY's, an OBJ's comments.
std::string_view header_of(const std::string& kind, std::string_view first_bytes) {
  if (kind == "ply") return first_bytes.substr(0, first_bytes.find("end_header"));
  if (kind == "stl") {
    return is_text(first_bytes) ? first_bytes.substr(0, first_bytes.find('\n'))
                                : first_bytes.substr(0, 80);
  }
  if (kind != "obj") return {};
  return first_bytes.starts_with("v ") ? std::string_view()
                                       : first_bytes.substr(0, first_bytes.find("\nv "));
}

// At least: a byte for each number, or its digit and a blank.
double least_bytes_of_ply(std::string_view header) {
  std::istringstream lines{std::string(header)};
  double least = 0, count = 0;
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    std::string word, name, number;
    words >> word;
    if (word == "element" && words >> name >> number) {
      count = parse_number(number).value_or(0);
      if (count < 0) return std::numeric_limits<double>::infinity();
    }
    if (word == "property") least += count;
  }
  return least;
}

}  // namespace

std::string mesh_kind(const std::string& path, std::string_view first_bytes, double bytes) {
  if (first_bytes.starts_with("ply\n") || first_bytes.starts_with("ply\r")) return "ply";
  if (first_bytes.starts_with("glTF")) return "glb";
  if (is_binary_stl(first_bytes, bytes)) return "stl";
  if (is_text(first_bytes)) {
    if (first_bytes.starts_with("solid")) return "stl";
    if (begins_as_obj(first_bytes)) return "obj";
    const bool is_json = first_bytes.starts_with("{");
    if (is_json && first_bytes.find("\"asset\"") != std::string_view::npos) return "gltf";
  }
  for (const char* kind : {"stl", "ply", "obj", "gltf", "glb"}) {
    if (path.ends_with(std::string(".") + kind)) return kind;
  }
  return "";
}

MeshSpace mesh_space(const std::string& kind, std::string_view first_bytes) {
  const bool is_ras = header_of(kind, first_bytes).find("SPACE=RAS") != std::string_view::npos;
  return is_ras ? MeshSpace::kRas : MeshSpace::kLps;
}

void check_mesh_promise(const std::string& path, const std::string& kind,
                        std::string_view first_bytes, double bytes) {
  if (kind == "ply" && first_bytes.find("end_header") == std::string_view::npos) {
    throw WorkError(path, "its header has no end", "is the file complete?");
  }
  double promised = 0;
  if (kind == "ply") promised = least_bytes_of_ply(header_of(kind, first_bytes));
  if (kind == "stl" && !is_text(first_bytes)) {
    promised = kStlHeader + kStlFacet * stl_facets(first_bytes);
  }
  if (promised > bytes) {
    throw WorkError(path, "promises " + to_text(promised) + " bytes and has " + to_text(bytes),
                    "is the file complete?");
  }
}

}  // namespace isolux
