#include <archive.h>
#include <archive_entry.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <filesystem>
#include <map>
#include <pugixml.hpp>

#include "isolux/base/error.h"
#include "isolux/base/number_text.h"
#include "isolux/io/format.h"
#include "isolux/io/read_fenced.h"
#include "isolux/io/stored_voxels.h"

// An InVesalius project: a tar.gz of one folder with main.plist (an Apple property list in XML) and
// the voxels as a bare little-endian matrix, whose name, shape and type main.plist tells.

namespace isolux {
namespace {

constexpr std::size_t kLargestPlist = 16 << 20;

WorkError damaged(const std::string& path, const std::string& why) {
  return {path, "damaged InVesalius project: " + why, "save it again with InVesalius"};
}

class Archive {
 public:
  explicit Archive(const std::string& path) : path_(path), archive_(archive_read_new()) {
    archive_read_support_filter_gzip(archive_);
    archive_read_support_format_tar(archive_);
    if (archive_read_open_filename(archive_, path.c_str(), 1 << 16) != ARCHIVE_OK) {
      const std::string why = message();
      archive_read_free(archive_);
      throw WorkError(path, "cannot be opened as a tar.gz archive: " + why,
                      "is the file complete?");
    }
  }
  ~Archive() { archive_read_free(archive_); }
  Archive(const Archive&) = delete;
  Archive& operator=(const Archive&) = delete;

  /// Goes to the next entry; false at the end.
  bool next() {
    const int status = archive_read_next_header(archive_, &entry_);
    if (status == ARCHIVE_EOF) return false;
    if (status != ARCHIVE_OK && status != ARCHIVE_WARN) throw damaged(path_, message());
    return true;
  }

  std::string name() const {
    const char* name = archive_entry_pathname(entry_);
    return name ? name : "";
  }
  double size() const { return static_cast<double>(archive_entry_size(entry_)); }

  /// Sends the whole of the entry.
  void send_to(FenceOutput& output) {
    std::vector<char> piece(1 << 18);
    const auto count = static_cast<std::size_t>(size());
    for (std::size_t done = 0; done < count;) {
      const auto got =
          archive_read_data(archive_, piece.data(), std::min(piece.size(), count - done));
      if (got <= 0) throw damaged(path_, got < 0 ? message() : "it ends too early");
      output.send(piece.data(), static_cast<std::size_t>(got));
      done += static_cast<std::size_t>(got);
    }
  }

 private:
  std::string message() const {
    const char* text = archive_error_string(archive_);
    return text ? text : "unknown error";
  }

  std::string path_;
  archive* archive_;
  archive_entry* entry_ = nullptr;
};

// The value after <key>name</key> in a <dict>.
pugi::xml_node value_of(const pugi::xml_node& dict, const char* name) {
  const pugi::xml_node key = dict.find_child([&](const pugi::xml_node& node) {
    return std::string(node.name()) == "key" && std::string(node.text().get()) == name;
  });
  return key.next_sibling();
}

struct Project {
  std::string folder;       // of main.plist inside the archive, with its slash
  std::string matrix_name;  // beside main.plist
  std::array<int, 3> dims;
  std::string dtype;
  Vec3 spacing;
  std::string modality;
  long long orientation;
};

std::vector<double> numbers_of(const pugi::xml_node& array) {
  std::vector<double> numbers;
  for (const pugi::xml_node& item : array.children()) {
    numbers.push_back(parse_number(item.text().get()).value_or(std::nan("")));
  }
  return numbers;
}

Project parse_project(const std::string& path, const std::string& entry_name,
                      const std::string& plist) {
  pugi::xml_document document;
  const pugi::xml_parse_result parsed = document.load_buffer(plist.data(), plist.size());
  if (!parsed) throw damaged(path, std::string("main.plist: ") + parsed.description());
  const pugi::xml_node dict = document.child("plist").child("dict");
  const pugi::xml_node matrix = value_of(dict, "matrix");
  const std::vector<double> shape = numbers_of(value_of(matrix, "shape"));
  const std::vector<double> spacing = numbers_of(value_of(dict, "spacing"));
  if (shape.size() != 3 || spacing.size() != 3) {
    throw damaged(path, "main.plist does not tell the matrix's shape and spacing");
  }
  Project project;
  project.folder = entry_name.substr(0, entry_name.rfind('/') + 1);
  project.matrix_name = value_of(matrix, "filename").text().get();
  project.dtype = value_of(matrix, "dtype").text().get();
  project.modality = value_of(dict, "modality").text().get();
  project.orientation = value_of(dict, "orientation").text().as_llong(1);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double count = shape[2 - axis];  // slowest first, as numpy has it
    if (!(count >= 1 && count <= 1 << 20) || count != std::floor(count)) {
      throw damaged(path, "its matrix has a shape of " + to_text(count) + " along an axis");
    }
    project.dims[axis] = static_cast<int>(count);
    if (!(spacing[axis] > 0) || !std::isfinite(spacing[axis])) {
      throw damaged(path, "its spacing is not positive");
    }
    project.spacing[static_cast<int>(axis)] = spacing[axis];
  }
  return project;
}

StoredType stored_type(const std::string& path, const std::string& dtype) {
  static const std::map<std::string, StoredType> types = {{"int16", StoredType::kI16},
                                                          {"uint16", StoredType::kU16},
                                                          {"uint8", StoredType::kU8},
                                                          {"float32", StoredType::kF32}};
  const auto found = types.find(dtype);
  if (found == types.end()) throw damaged(path, "voxel type '" + dtype + "' is not known");
  return found->second;
}

bool is_main_plist(const std::string& name) {
  return name == "main.plist" || name.ends_with("/main.plist");
}

void send_project(const std::string& path, FenceOutput& output) {
  Archive archive(path);
  while (archive.next()) {
    if (!is_main_plist(archive.name())) continue;
    if (archive.size() > kLargestPlist) throw damaged(path, "its main.plist is too large");
    const std::string name = archive.name();
    const auto lengths = std::array{name.size(), static_cast<std::size_t>(archive.size())};
    output.send(lengths.data(), sizeof lengths);
    output.send(name.data(), name.size());
    archive.send_to(output);
    return;
  }
  throw damaged(path, "it holds no main.plist");
}

Project find_project(const std::string& path) {
  const ReadNext next =
      read_fenced(path, 0, [&](FenceOutput& output) { send_project(path, output); });
  std::array<std::size_t, 2> lengths{};
  next(reinterpret_cast<char*>(lengths.data()), sizeof lengths);
  if (std::max(lengths[0], lengths[1]) > kLargestPlist) throw damaged(path, "a name is too long");
  std::string name(lengths[0], '\0'), plist(lengths[1], '\0');
  next(name.data(), name.size());
  next(plist.data(), plist.size());
  return parse_project(path, name, plist);
}

// gzip, and the name ends in .inv3 or the archive holds a main.plist.
bool recognises(const ReadRequest& request, std::string_view first_bytes) {
  if (!first_bytes.starts_with("\x1f\x8b")) return false;
  if (request.name.ends_with(".inv3")) return true;
  try {
    find_project(request.name);
    return true;
  } catch (const WorkError&) {
    return false;
  }
}

double voxel_count(const Project& project) {
  return static_cast<double>(project.dims[0]) * project.dims[1] * project.dims[2];
}

void send_matrix(const std::string& path, const Project& project, double bytes,
                 FenceOutput& output) {
  Archive archive(path);
  while (archive.next()) {
    if (archive.name() != project.folder + project.matrix_name) continue;
    if (archive.size() == bytes) return archive.send_to(output);
    throw damaged(path, "its matrix holds " + to_text(archive.size()) + " bytes, not the " +
                            to_text(bytes) + " of its shape");
  }
  throw damaged(path, "it holds no '" + project.matrix_name + "'");
}

VoxelArray read_matrix(const ReadRequest& request, const Project& project, StoredType type,
                       std::vector<std::string>& notes) {
  const double bytes = voxel_count(project) * static_cast<double>(bytes_of(type));
  Progress progress(request.listener, "reading", static_cast<std::size_t>(bytes));
  const auto from_the_first = [&]() -> ReadNext {
    const ReadNext next = read_fenced(request.name, 0, [&](FenceOutput& output) {
      send_matrix(request.name, project, bytes, output);
    });
    return [&progress, next](char* to, std::size_t count) {
      constexpr std::size_t kPiece = 1 << 20;
      for (std::size_t done = 0; done < count; done += kPiece) {
        const std::size_t piece = std::min(kPiece, count - done);
        next(to + done, piece);
        progress.advance(piece);
      }
    };
  };
  return voxels_read(request.name, type, static_cast<std::size_t>(voxel_count(project)),
                     std::endian::native == std::endian::big, {}, from_the_first, notes);
}

OpenedInput open(const ReadRequest& request) {
  const Project project = find_project(request.name);
  const StoredType type = stored_type(request.name, project.dtype);
  check_promise(request.name, voxel_count(project) * static_cast<double>(bytes_of(type)),
                static_cast<double>(std::filesystem::file_size(request.name)), "gzip");
  OpenedInput opened;
  opened.volume.dims = project.dims;
  // The matrix is stored axial whatever the scan was: i to the patient's left, j to anterior, k up.
  opened.volume.world_from_index.linear =
      diagonal({project.spacing.x, -project.spacing.y, project.spacing.z});
  opened.volume.modality = project.modality;
  if (project.modality == "CT") opened.volume.units = "HU";
  opened.result.format = "InVesalius project";
  opened.result.files = {request.name};
  if (project.orientation != 1) {
    opened.result.notes.push_back(project.orientation == 2
                                      ? "the scan was coronal; its matrix is axial"
                                      : "the scan was sagittal; its matrix is axial");
  }
  opened.stored_type = name_of(type);
  opened.bytes_per_voxel_most = bytes_per_voxel_most(type, {});
  opened.read_voxels = [=](std::vector<std::string>& notes) {
    return read_matrix(request, project, type, notes);
  };
  return opened;
}

}  // namespace

Format inv3_format() { return {recognises, open}; }

}  // namespace isolux
