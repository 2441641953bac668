#include "isolux/io/reader.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <optional>
#include <utility>

#include "isolux/base/error.h"
#include "isolux/base/memory.h"
#include "isolux/base/number_text.h"
#include "isolux/io/dicom_signature.h"
#include "isolux/io/format.h"
#include "isolux/io/placement_fault.h"
#include "isolux/io/unpacked_archive.h"
#include "isolux/mesh/smooth_normals.h"

namespace isolux {
namespace {

namespace fs = std::filesystem;

std::string first_bytes_of(const std::string& path) {
  std::error_code error;
  if (!fs::exists(path, error)) {
    throw WorkError(path, "there is no such file", "check the name, or see `isolux --help`");
  }
  // Opening a pipe would wait for whoever fills it; and it could be read once only.
  if (fs::is_fifo(path, error) || fs::is_socket(path, error)) {
    throw WorkError(path, "is a pipe, not a file", "write it to a file first");
  }
  errno = 0;
  std::ifstream file(path, std::ios::binary);
  std::string bytes(512, '\0');
  file.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  if (file.bad() || (!file && file.gcount() == 0 && !file.eof())) {
    throw WorkError(path, std::string("cannot be read: ") + std::strerror(errno),
                    "check its permissions");
  }
  bytes.resize(static_cast<std::size_t>(file.gcount()));
  return bytes;
}

// The grid as the file places it, with another distance between the voxels.
void replace_spacing(Volume& volume, Vec3 spacing) {
  const Mat3 unit = direction(volume);
  volume.world_from_index.linear = unit * diagonal(spacing);
}

std::vector<Format> formats() {
  // DICOM before TIFF: a DICOM file may begin with a TIFF header as well.
  return {nrrd_format(),  nifti_format(), metaimage_format(), inv3_format(),
          dicom_format(), tiff_format(),  vti_format(),       mesh_format()};
}

const Format* format_of(const std::vector<Format>& among, const ReadRequest& request) {
  const std::string first_bytes = first_bytes_of(request.name);
  const auto found = std::ranges::find_if(
      among, [&](const Format& format) { return format.recognises(request, first_bytes); });
  return found == among.end() ? nullptr : &*found;
}

// A stack of files: a DICOM series, or TIFFs. Nothing where the folder holds neither.
std::optional<OpenedInput> open_stack(const ReadRequest& request) {
  const std::vector<std::string> slices = find_dicom_files(request.name);
  if (!slices.empty()) return open_dicom_folder(request, slices);
  std::vector<std::string> tiffs;
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(request.name, error)) {
    if (!entry.is_regular_file(error)) continue;
    const std::string path = entry.path().string();
    if (tiff_format().recognises({path, request.grid}, first_bytes_of(path))) {
      tiffs.push_back(path);
    }
  }
  if (tiffs.empty()) return std::nullopt;
  return open_tiff_folder(request, tiffs);
}

// The one stack in a folder, or else the one volume or mesh.
OpenedInput open_folder(const ReadRequest& request) {
  if (auto stack = open_stack(request)) return *stack;
  const std::vector<Format> known = formats();
  std::optional<OpenedInput> found;
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(request.name, error)) {
    if (!entry.is_regular_file(error)) continue;
    const ReadRequest inside{entry.path().string(), request.grid, request.listener};
    const Format* format = format_of(known, inside);
    if (!format) continue;
    OpenedInput opened = format->open(inside);
    // A header and its voxels may each be a way to the same volume.
    if (found && opened.result.files == found->result.files) continue;
    if (found) {
      throw WorkError(request.name, "holds several volumes or meshes", "name the wanted file");
    }
    opened.result.notes.insert(opened.result.notes.begin(),
                               "read from " + entry.path().filename().string());
    found = std::move(opened);
  }
  if (found) return *found;
  throw WorkError(request.name, "holds nothing that this version reads",
                  "`isolux --help` lists the formats");
}

// A DICOMDIR tells what lies in its folder and below, which is found without it.
OpenedInput open_folder_of_index(const ReadRequest& request) {
  const fs::path path(request.name);
  const fs::path folder = path.has_parent_path() ? path.parent_path() : ".";
  OpenedInput opened = open_folder({folder.string(), request.grid, request.listener});
  opened.result.notes.insert(opened.result.notes.begin(),
                             "an index (DICOMDIR): its folder was read");
  return opened;
}

bool is_archive(const std::string& first_bytes) {
  constexpr std::size_t kTarMark = 257;
  return first_bytes.starts_with("PK\3\4") ||
         (first_bytes.size() > kTarMark && first_bytes.compare(kTarMark, 5, "ustar") == 0);
}

// Does `work`; what it says of files in the unpacked folder, it says of the archive: that folder is
// gone when the message is read.
template <typename Work>
auto about_archive(const std::string& name, const UnpackedArchive& archive, const Work& work) {
  try {
    return work();
  } catch (const WorkError& error) {
    std::string why = error.what();
    const std::string folder = archive.folder().string();
    const bool is_of_all = why.starts_with(folder + ": ");
    for (const std::string& hidden : {folder + "/", folder + ": "}) {
      for (std::size_t at = 0; (at = why.find(hidden)) != std::string::npos;) {
        why.erase(at, hidden.size());
      }
    }
    throw WorkError(name, (is_of_all ? "" : "in it, ") + why.substr(0, why.rfind("; ")),
                    "unpack it and look");
  }
}

OpenedInput open_archive(const ReadRequest& request) {
  const auto archive = std::make_shared<const UnpackedArchive>(request.name);
  OpenedInput opened = about_archive(request.name, *archive, [&] {
    return open_folder({archive->folder().string(), request.grid, request.listener});
  });
  opened.read_voxels = [archive, name = request.name,
                        read = opened.read_voxels](std::vector<std::string>& notes) {
    return about_archive(name, *archive, [&] { return read(notes); });
  };
  opened.result.files = {request.name};
  opened.result.notes.insert(
      opened.result.notes.begin(),
      "unpacked " + std::to_string(archive->file_count()) + " files from the archive");
  return opened;
}

OpenedInput open_known_format(const ReadRequest& request) {
  if (std::error_code error; fs::is_directory(request.name, error)) return open_folder(request);
  const std::vector<Format> known = formats();
  if (const Format* format = format_of(known, request)) return format->open(request);
  const std::string first_bytes = first_bytes_of(request.name);
  if (is_archive(first_bytes)) return open_archive(request);
  if (is_dicom_directory(first_bytes)) return open_folder_of_index(request);
  if (request.grid.dims || request.grid.type) return open_raw(request);
  std::error_code error;
  const std::string guess = raw_guess(fs::file_size(request.name, error));
  throw WorkError(request.name, "is of no format that this version reads",
                  "a headerless raw file needs --dims and --type" +
                      (guess.empty() ? "; `isolux --help` lists the formats" : ": " + guess));
}

void smooth(ReadResult& result, double crease_deg) {
  const Mesh& mesh = *result.mesh;
  constexpr double kBytesOfCorner = 2 * (sizeof(Vec3f) * 3 + sizeof(TexturePoint) + 8);
  check_memory(3 * kBytesOfCorner * static_cast<double>(mesh.triangles.size()), result.name);
  result.mesh = std::make_shared<const Mesh>(with_smooth_normals(mesh, crease_deg));
  result.is_smoothed = true;
  result.notes.push_back("without normals: made smooth but for edges sharper than " +
                         to_text(crease_deg) + " degrees");
}

OpenedInput open_file(const ReadRequest& request) {
  OpenedInput opened = open_known_format(request);
  if (request.grid.crease_deg && opened.result.mesh && opened.result.mesh->normals.empty()) {
    smooth(opened.result, *request.grid.crease_deg);
  }
  if (!request.grid.spacing_mm || opened.result.format == "raw" || opened.result.mesh)
    return opened;
  replace_spacing(opened.volume, *request.grid.spacing_mm);
  if (const std::string fault = placement_fault(opened.volume.world_from_index); !fault.empty()) {
    throw UsageError("--spacing", "with it, the placement " + fault, "give another spacing");
  }
  opened.result.notes.push_back("the file's own spacing was replaced by --spacing");
  return opened;
}

OpenedInput open_example_head(const ReadRequest& request) {
  const std::string path = find_example_head();
  if (!path.empty()) return open_file({path, request.grid, request.listener});
  OpenedInput opened = open_phantom({.name = "phantom:head", .grid = request.grid});
  opened.result.notes.push_back(
      "the CT head of Debian's package invesalius-examples is not on this machine: the built-in "
      "head phantom takes its place");
  return opened;
}

ReadResult finished(const OpenedInput& opened) {
  if (opened.result.mesh) return opened.result;
  auto volume = std::make_shared<Volume>(opened.volume);
  ReadResult result = opened.result;
  volume->voxels = opened.read_voxels(result.notes);
  result.volume = volume;
  return result;
}

}  // namespace

double OpenedInput::voxel_count() const {
  return static_cast<double>(volume.dims[0]) * volume.dims[1] * volume.dims[2];
}

double OpenedInput::voxel_memory() const {
  return is_mapped ? 0 : bytes_per_voxel_most * voxel_count();
}

OpenedInput open_input(const ReadRequest& request) {
  const bool is_built_in = request.name.starts_with("phantom:");
  const bool is_example = request.name == kExampleHead;
  OpenedInput opened = is_example    ? open_example_head(request)
                       : is_built_in ? open_phantom(request)
                                     : open_file(request);
  // A phantom that stands for the example keeps its own name.
  if (opened.result.format != "built-in") opened.result.name = request.name;
  return opened;
}

ReadResult read_input(const ReadRequest& request) { return finished(open_input(request)); }

std::vector<OpenedInput> open_inputs(const SceneDescription& description,
                                     const ProgressListener& listener) {
  std::vector<std::string> names = description.inputs;
  if (names.empty()) names.push_back(kExampleHead);
  std::vector<OpenedInput> inputs;
  for (const std::string& name : names) {
    inputs.push_back(open_input({name, description.grid, listener}));
  }
  const GridDescription& grid = description.grid;
  const auto refuse_unless = [&](bool given, const char* option, const char* why, auto has_use) {
    if (!given || std::ranges::any_of(inputs, has_use)) return;
    throw UsageError(option, why, "leave it out");
  };
  const auto is_raw = [](const OpenedInput& i) { return i.result.format == "raw"; };
  refuse_unless(grid.dims.has_value(), "--dims", "every input has its own header", is_raw);
  refuse_unless(grid.type.has_value(), "--type", "every input has its own header", is_raw);
  refuse_unless(grid.spacing_mm.has_value(), "--spacing", "no input is a volume",
                [](const OpenedInput& i) { return i.result.mesh == nullptr; });
  refuse_unless(grid.volume.has_value(), "--volume", "no input has several volumes",
                [](const OpenedInput& i) { return i.result.volume_count > 1; });
  refuse_unless(grid.series.has_value(), "--series", "no input is a DICOM series",
                [](const OpenedInput& i) { return i.result.format == "DICOM"; });
  refuse_unless(grid.crease_deg.has_value(), "--crease", "no input is a mesh without normals",
                [](const OpenedInput& i) { return i.result.is_smoothed; });
  return inputs;
}

std::vector<ReadResult> read_inputs(const SceneDescription& description,
                                    const ProgressListener& listener) {
  std::vector<ReadResult> results;
  for (const OpenedInput& opened : open_inputs(description, listener)) {
    results.push_back(finished(opened));
  }
  return results;
}

void require_volume(const ReadResult& input) {
  if (input.volume) return;
  throw UsageError(input.name, "is a mesh, where a volume is wanted",
                   "`isolux render`, `info` and `mesh` take meshes");
}

}  // namespace isolux
