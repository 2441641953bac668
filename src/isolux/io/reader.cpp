#include "isolux/io/reader.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <optional>
#include <utility>

#include "isolux/base/error.h"
#include "isolux/io/format.h"
#include "isolux/io/placement_fault.h"
#include "isolux/io/unpacked_zip.h"

namespace isolux {
namespace {

namespace fs = std::filesystem;

std::string first_bytes_of(const std::string& path) {
  std::error_code error;
  if (!fs::exists(path, error)) {
    throw WorkError(path, "there is no such file", "check the name, or see `isolux --help`");
  }
  std::ifstream file(path, std::ios::binary);
  std::string bytes(512, '\0');
  file.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  if (file.bad() || (!file && file.gcount() == 0 && !file.eof())) {
    throw WorkError(path, "cannot be read", "check its permissions");
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
          dicom_format(), tiff_format(),  mesh_format()};
}

const Format* format_of(const std::vector<Format>& among, const ReadRequest& request) {
  const std::string first_bytes = first_bytes_of(request.name);
  const auto found = std::ranges::find_if(
      among, [&](const Format& format) { return format.recognises(request, first_bytes); });
  return found == among.end() ? nullptr : &*found;
}

// A stack of files: a DICOM series, or TIFFs. Nothing where the folder holds neither.
std::optional<ReadResult> read_stack(const ReadRequest& request) {
  const std::vector<std::string> slices = find_dicom_files(request.name);
  if (!slices.empty()) return read_dicom_folder(request, slices);
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
  return read_tiff_folder(request, tiffs);
}

// A folder holds one volume as a stack of files.
ReadResult read_folder(const ReadRequest& request) {
  if (auto stack = read_stack(request)) return *stack;
  throw WorkError(request.name, "is a folder without DICOM or TIFF files",
                  "give a file, or a folder of one stack");
}

// The one volume, or the one stack, in an unpacked zip.
ReadResult read_unpacked(const ReadRequest& request, const UnpackedZip& zip) {
  if (auto stack = read_stack({zip.folder().string(), request.grid, request.listener})) {
    return *stack;
  }
  const std::vector<Format> known = formats();
  std::optional<ReadResult> found;
  for (const fs::directory_entry& entry : fs::directory_iterator(zip.folder())) {
    const ReadRequest inside{entry.path().string(), request.grid, request.listener};
    const Format* format = format_of(known, inside);
    if (!format) continue;
    if (found) {
      throw WorkError(request.name, "holds several volumes", "unpack it and name the wanted one");
    }
    found = format->read(inside);
  }
  if (found) return *found;
  throw WorkError(request.name, "is a zip archive without a volume that this version reads",
                  "`isolux --help` lists the formats");
}

ReadResult read_zip(const ReadRequest& request) {
  const UnpackedZip zip(request.name);
  ReadResult result;
  try {
    result = read_unpacked(request, zip);
  } catch (const WorkError& error) {
    // It names a file in a folder that is gone when the message is read.
    std::string why = error.what();
    const std::string folder = zip.folder().string() + "/";
    for (std::size_t at = 0; (at = why.find(folder)) != std::string::npos;) {
      why.erase(at, folder.size());
    }
    throw WorkError(request.name, "in it, " + why.substr(0, why.rfind("; ")), "unpack it and look");
  }
  result.files = {request.name};
  result.notes.insert(result.notes.begin(),
                      "unpacked " + std::to_string(zip.file_count()) + " files from the zip");
  return result;
}

ReadResult read_known_format(const ReadRequest& request) {
  if (std::error_code error; fs::is_directory(request.name, error)) return read_folder(request);
  const std::vector<Format> known = formats();
  if (const Format* format = format_of(known, request)) return format->read(request);
  if (first_bytes_of(request.name).starts_with("PK\3\4")) return read_zip(request);
  if (request.grid.dims || request.grid.type) return read_raw(request);
  std::error_code error;
  const std::string guess = raw_guess(fs::file_size(request.name, error));
  throw WorkError(request.name, "is of no format that this version reads",
                  "a headerless raw file needs --dims and --type" +
                      (guess.empty() ? "; `isolux --help` lists the formats" : ": " + guess));
}

ReadResult read_file(const ReadRequest& request) {
  ReadResult result = read_known_format(request);
  if (!request.grid.spacing_mm || result.format == "raw" || result.mesh) return result;
  // Nobody else has the volume yet, so it can be placed anew where it is.
  replace_spacing(*std::const_pointer_cast<Volume>(result.volume), *request.grid.spacing_mm);
  if (const std::string fault = placement_fault(result.volume->world_from_index); !fault.empty()) {
    throw UsageError("--spacing", "with it, the placement " + fault, "give another spacing");
  }
  result.notes.push_back("the file's own spacing was replaced by --spacing");
  return result;
}

ReadResult read_example_head(const ReadRequest& request) {
  const std::string path = find_example_head();
  ReadResult result;
  if (path.empty()) {
    result = make_phantom({.name = "phantom:head", .grid = request.grid});
    result.notes.insert(result.notes.begin(),
                        "the CT head of Debian's package invesalius-examples is not on this "
                        "machine: the built-in head phantom takes its place");
  } else {
    result = read_file({path, request.grid, request.listener});
    result.name = request.name;
  }
  return result;
}

}  // namespace

ReadResult read_input(const ReadRequest& request) {
  if (request.name == kExampleHead) return read_example_head(request);
  if (request.name.starts_with("phantom:")) return make_phantom(request);
  ReadResult result = read_file(request);
  result.name = request.name;
  return result;
}

std::vector<ReadResult> read_inputs(const SceneDescription& description,
                                    const ProgressListener& listener) {
  std::vector<std::string> names = description.inputs;
  if (names.empty()) names.push_back(kExampleHead);
  std::vector<ReadResult> results;
  for (const std::string& name : names) {
    results.push_back(read_input({name, description.grid, listener}));
  }
  const GridDescription& grid = description.grid;
  const auto refuse_unless = [&](bool given, const char* option, const char* why, auto has_use) {
    if (!given || std::ranges::any_of(results, has_use)) return;
    throw UsageError(option, why, "leave it out");
  };
  const auto is_raw = [](const ReadResult& r) { return r.format == "raw"; };
  refuse_unless(grid.dims.has_value(), "--dims", "every input has its own header", is_raw);
  refuse_unless(grid.type.has_value(), "--type", "every input has its own header", is_raw);
  refuse_unless(grid.spacing_mm.has_value(), "--spacing", "no input is a volume",
                [](const ReadResult& r) { return r.volume != nullptr; });
  refuse_unless(grid.volume.has_value(), "--volume", "no input has several volumes",
                [](const ReadResult& r) { return r.volume_count > 1; });
  refuse_unless(grid.series.has_value(), "--series", "no input is a DICOM series",
                [](const ReadResult& r) { return r.format == "DICOM"; });
  return results;
}

void require_volume(const ReadResult& input) {
  if (input.volume) return;
  throw UsageError(input.name, "is a mesh, where a volume is wanted",
                   "`isolux render`, `info` and `mesh` take meshes");
}

}  // namespace isolux
