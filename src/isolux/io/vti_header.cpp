#include "isolux/io/vti_header.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <pugixml.hpp>
#include <string_view>

#include "isolux/base/error.h"
#include "isolux/base/mapped_file.h"
#include "isolux/base/number_text.h"
#include "isolux/io/header_text.h"
#include "isolux/io/placement_fault.h"

namespace isolux {
namespace {

WorkError damaged(const std::string& path, const std::string& why) {
  return {path, "damaged VTK image: " + why, "is the file complete?"};
}

WorkError not_read(const std::string& path, const std::string& why, const std::string& hint) {
  return {path, why, hint};
}

// The tags of the file without what stands in its arrays, which may be gigabytes, and is no XML
// where it is appended raw.
struct Skeleton {
  std::string xml;
  std::vector<std::pair<std::size_t, std::size_t>> contents;  // of each <DataArray>, in order
  std::size_t appended = std::string::npos;                   // behind the '_'
};

// The '>' that ends the tag at `begin`; one inside quotes does not.
std::size_t end_of_tag(std::string_view text, std::size_t begin) {
  char quote = 0;
  for (std::size_t at = begin; at < text.size(); ++at) {
    if (quote != 0) {
      if (text[at] == quote) quote = 0;
    } else if (text[at] == '"' || text[at] == '\'') {
      quote = text[at];
    } else if (text[at] == '>') {
      return at;
    }
  }
  return std::string_view::npos;
}

Skeleton skeleton_of(const std::string& path, std::string_view text) {
  constexpr std::size_t kLongest = 16 << 20;
  Skeleton skeleton;
  std::size_t copied = 0;
  const auto copy_to = [&](std::size_t end) {
    if (skeleton.xml.size() + (end - copied) > kLongest) throw damaged(path, "its tags do not end");
    skeleton.xml.append(text.substr(copied, end - copied));
    copied = end;
  };
  for (std::size_t at = 0; (at = text.find('<', at)) != std::string_view::npos;) {
    const std::string_view rest = text.substr(at);
    if (rest.starts_with("<!--")) {
      at = text.find("-->", at);
      if (at == std::string_view::npos) break;
      continue;
    }
    const bool is_array = rest.starts_with("<DataArray"),
               is_end = rest.starts_with("<AppendedData");
    const std::size_t end = end_of_tag(text, at);
    if (end == std::string_view::npos) throw damaged(path, "a tag does not end");
    if (is_end) {
      copy_to(end);
      skeleton.xml += "/></VTKFile>";
      const std::size_t mark = text.find('_', end);
      if (mark != std::string_view::npos) skeleton.appended = mark + 1;
      return skeleton;
    }
    if (is_array && text[end - 1] != '/') {
      const std::size_t close = text.find("</DataArray", end);
      if (close == std::string_view::npos) throw damaged(path, "an array does not end");
      copy_to(end + 1);
      skeleton.contents.emplace_back(end + 1, close);
      copied = at = close;
    } else if (is_array) {
      skeleton.contents.emplace_back(end + 1, end + 1);
      at = end;
    } else {
      at = end;
    }
  }
  copy_to(text.size());
  return skeleton;
}

std::vector<double> numbers(const std::string& path, const char* name, const std::string& text,
                            std::size_t count) {
  std::vector<double> list;
  for (const std::string& word : words(text)) {
    const auto number = parse_number(word);
    if (!number) throw damaged(path, std::string(name) + " holds '" + word.substr(0, 40) + "'");
    list.push_back(*number);
  }
  if (list.size() != count) {
    throw damaged(path, std::string(name) + " has " + std::to_string(list.size()) + " numbers");
  }
  return list;
}

void take_grid(const std::string& path, const pugi::xml_node& image, VtiHeader& header) {
  const auto attribute = [&](const char* name, const char* otherwise, std::size_t count) {
    return numbers(path, name, image.attribute(name).as_string(otherwise), count);
  };
  const std::vector<double> extent = attribute("WholeExtent", "", 6);
  const std::vector<double> origin = attribute("Origin", "0 0 0", 3);
  const std::vector<double> spacing = attribute("Spacing", "1 1 1", 3);
  const std::vector<double> turn = attribute("Direction", "1 0 0 0 1 0 0 0 1", 9);
  Vec3 first;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double low = extent[2 * axis], count = extent[2 * axis + 1] - low + 1;
    constexpr double kFarthest = 1 << 30;
    if (low != std::floor(low) || std::fabs(low) > kFarthest || count != std::floor(count) ||
        !(count >= 1 && count <= kFarthest)) {
      throw damaged(path, "its WholeExtent holds no points");
    }
    header.dims[axis] = static_cast<int>(count);
    first[static_cast<int>(axis)] = low;
    // The matrix is written row by row; its columns are the axes.
    for (std::size_t row = 0; row < 3; ++row) {
      header.world_from_index.linear.column[axis][static_cast<int>(row)] =
          spacing[axis] * turn[3 * row + axis];
    }
  }
  header.world_from_index.offset = {origin[0], origin[1], origin[2]};
  header.world_from_index.offset = header.world_from_index.point(first);
  if (const std::string fault = placement_fault(header.world_from_index); !fault.empty()) {
    throw not_read(path, "cannot be placed: its grid " + fault, "mend its header");
  }
  header.notes.push_back("VTK does not say how it lies in the patient: its axes are taken as LPS");
}

StoredType stored_type(const std::string& path, const std::string& name) {
  static const std::map<std::string, StoredType> types = {
      {"Int8", StoredType::kI8},    {"UInt8", StoredType::kU8},   {"Int16", StoredType::kI16},
      {"UInt16", StoredType::kU16}, {"Int32", StoredType::kI32},  {"UInt32", StoredType::kU32},
      {"Int64", StoredType::kI64},  {"UInt64", StoredType::kU64}, {"Float32", StoredType::kF32},
      {"Float64", StoredType::kF64}};
  const auto found = types.find(name);
  if (found == types.end()) {
    throw not_read(path, "holds values of type '" + name.substr(0, 40) + "'", "convert it first");
  }
  return found->second;
}

// The array that PointData calls its scalars, or the only one.
pugi::xml_node chosen_array(const std::string& path, const pugi::xml_node& points,
                            VtiHeader& header) {
  std::vector<pugi::xml_node> arrays;
  std::string names;
  for (const pugi::xml_node& array : points.children("DataArray")) {
    arrays.push_back(array);
    names +=
        (names.empty() ? "" : ", ") + std::string(array.attribute("Name").as_string("unnamed"));
  }
  if (arrays.empty()) {
    throw not_read(path, "holds no values at its points", "values in cells are not read");
  }
  const std::string scalars = points.attribute("Scalars").as_string();
  const auto found = std::ranges::find_if(arrays, [&](const pugi::xml_node& array) {
    return !scalars.empty() && array.attribute("Name").as_string() == scalars;
  });
  if (found == arrays.end() && arrays.size() > 1) {
    throw not_read(path,
                   "holds several arrays (" + names + ") and does not say which is its scalars",
                   "save it with one");
  }
  if (arrays.size() > 1) {
    header.notes.push_back("of its arrays (" + names + ") " + scalars + ", its scalars, was read");
  }
  return found == arrays.end() ? arrays[0] : *found;
}

VtiEncoding encoding_of(const std::string& path, const std::string& name) {
  if (name == "ascii") return VtiEncoding::kText;
  if (name == "binary" || name == "base64") return VtiEncoding::kBase64;
  if (name == "raw") return VtiEncoding::kRaw;
  throw damaged(path, "encoding '" + name.substr(0, 40) + "' is not known");
}

// Which <DataArray> of the file a node is, in the order in which they stand there.
std::size_t number_of(const pugi::xml_node& root, const pugi::xml_node& wanted) {
  struct Counter : pugi::xml_tree_walker {
    pugi::xml_node wanted;
    std::size_t number = 0;
    bool for_each(pugi::xml_node& node) override {
      if (node == wanted) return false;
      number += std::string_view(node.name()) == "DataArray" ? 1 : 0;
      return true;
    }
  } counter;
  counter.wanted = wanted;
  pugi::xml_node(root).traverse(counter);
  return counter.number;
}

void take_array(const std::string& path, const pugi::xml_document& document,
                const pugi::xml_node& array, const Skeleton& skeleton, std::size_t file_size,
                VtiHeader& header) {
  header.array_name = array.attribute("Name").as_string();
  header.type = stored_type(path, array.attribute("type").as_string());
  header.channels = array.attribute("NumberOfComponents").as_int(1);
  constexpr int kMostChannels = 1 << 20;
  if (header.channels < 1 || header.channels > kMostChannels) {
    throw damaged(path, "it has " + std::to_string(header.channels) + " values a voxel");
  }
  const std::string format = array.attribute("format").as_string("ascii");
  if (format != "appended") {
    const auto [begin, end] = skeleton.contents.at(number_of(document, array));
    header.encoding = encoding_of(path, format);
    header.data_offset = begin;
    header.data_end = end;
    return;
  }
  const pugi::xml_node appended = document.child("VTKFile").child("AppendedData");
  if (skeleton.appended == std::string::npos) throw damaged(path, "its appended data are missing");
  header.encoding = encoding_of(path, appended.attribute("encoding").as_string("base64"));
  const auto offset = parse_whole_number(array.attribute("offset").as_string());
  if (!offset || *offset < 0 ||
      static_cast<std::uint64_t>(*offset) >= file_size - skeleton.appended) {
    throw damaged(path, "its array begins behind the end of the file");
  }
  header.data_offset = skeleton.appended + static_cast<std::uint64_t>(*offset);
  header.data_end = file_size;
}

void take_file_form(const std::string& path, const pugi::xml_node& file, VtiHeader& header) {
  const std::string type = file.attribute("type").as_string();
  if (type != "ImageData") {
    throw not_read(path, "is a VTK file of " + type.substr(0, 40) + ", not of an image",
                   "isolux reads ImageData (.vti)");
  }
  header.big_endian = std::string_view(file.attribute("byte_order").as_string()) == "BigEndian";
  const std::string width = file.attribute("header_type").as_string("UInt32");
  if (width != "UInt32" && width != "UInt64") throw damaged(path, "header_type is '" + width + "'");
  header.header_bytes = width == "UInt64" ? 8 : 4;
  const std::string compressor = file.attribute("compressor").as_string();
  header.deflated = compressor == "vtkZLibDataCompressor";
  if (!compressor.empty() && !header.deflated) {
    throw not_read(path, "is compressed by " + compressor.substr(0, 40),
                   "save it with zlib, or without compression");
  }
}

}  // namespace

VtiHeader read_vti_header(const std::string& path) {
  const MappedFile file(path);
  const Skeleton skeleton = skeleton_of(path, {file.data(), file.size()});
  pugi::xml_document document;
  const pugi::xml_parse_result parsed =
      document.load_buffer(skeleton.xml.data(), skeleton.xml.size(), pugi::parse_minimal);
  if (!parsed) throw damaged(path, std::string("its XML: ") + parsed.description());
  const pugi::xml_node root = document.child("VTKFile");
  VtiHeader header;
  take_file_form(path, root, header);
  const pugi::xml_node image = root.child("ImageData");
  take_grid(path, image, header);
  const pugi::xml_node piece = image.child("Piece");
  if (piece.next_sibling("Piece") || !piece) {
    throw not_read(path, "is in several pieces, or none", "save it in one piece");
  }
  const std::string whole = image.attribute("WholeExtent").as_string();
  const std::string part = piece.attribute("Extent").as_string(whole.c_str());
  if (numbers(path, "Extent", part, 6) != numbers(path, "WholeExtent", whole, 6)) {
    throw not_read(path, "holds only a part of its grid", "save it in one piece");
  }
  const pugi::xml_node array = chosen_array(path, piece.child("PointData"), header);
  take_array(path, document, array, skeleton, file.size(), header);
  return header;
}

}  // namespace isolux
