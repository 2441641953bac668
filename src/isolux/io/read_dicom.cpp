#include <algorithm>
#include <filesystem>
#include <set>
#include <tuple>

#include "isolux/base/error.h"
#include "isolux/base/number_text.h"
#include "isolux/io/chosen_volume.h"
#include "isolux/io/dicom_geometry.h"
#include "isolux/io/dicom_series.h"
#include "isolux/io/dicom_signature.h"
#include "isolux/io/dicom_voxels.h"
#include "isolux/io/format.h"
#include "isolux/io/natural_order.h"

// DICOM files are described (dicom_file.h), sorted into series (dicom_series.h), their slices into
// a grid (dicom_geometry.h), and then each slice is decoded straight into its layer.

namespace isolux {
namespace {

namespace fs = std::filesystem;

void require_sound(const DicomFile& file) {
  if (file.fault.empty()) return;
  throw WorkError(file.path, file.fault, "is the file complete, and an image?");
}

// --- What to read ---

// Sorted by time, then as they were taken. Copies of one image count once; `named`, where it is one
// of them, is the one that is kept.
std::vector<DicomFile> sorted_files(std::vector<DicomFile> files, const std::string& named,
                                    ReadResult& result) {
  std::ranges::sort(files, [](const DicomFile& a, const DicomFile& b) {
    const auto key = [](const DicomFile& f) {
      return std::tuple(f.frames.empty() ? 0 : f.frames[0].time, f.instance_number);
    };
    return key(a) != key(b) ? key(a) < key(b) : comes_before(a.path, b.path);
  });
  const auto is_named = [&](const DicomFile& f) { return f.path == named; };
  const auto found = std::ranges::find_if(files, is_named);
  if (found != files.end() && !found->frames.empty() && !found->frames[0].position.empty()) {
    std::rotate(files.begin(), found, found + 1);
  }
  std::set<std::string> seen;
  const std::size_t before = files.size();
  std::erase_if(files, [&](const DicomFile& f) {
    return !f.instance_uid.empty() && !seen.insert(f.instance_uid).second;
  });
  if (files.size() < before) {
    result.notes.push_back("copies of one image (by its SOPInstanceUID): " +
                           std::to_string(before - files.size()) + " left out");
  }
  return files;
}

std::vector<DicomFile> usable_files(const DicomSeries& series, const std::string& named,
                                    ReadResult& result) {
  std::vector<DicomFile> files;
  std::string colors;
  for (const DicomFile& file : series.files) {
    require_sound(file);
    if (file.samples == 1 && file.photometric != "PALETTE COLOR") {
      files.push_back(file);
    } else {
      colors = file.photometric;
    }
  }
  if (files.empty()) {
    throw WorkError(result.name, "holds colours (" + colors + "), not one value a voxel",
                    "isolux draws surfaces of one value");
  }
  if (!colors.empty()) result.notes.push_back("images in colour were left out");
  return sorted_files(std::move(files), named, result);
}

std::vector<DicomSlice> slices_of(const std::vector<DicomFile>& files) {
  std::vector<DicomSlice> slices;
  for (std::size_t f = 0; f < files.size(); ++f) {
    const auto frames = static_cast<std::size_t>(files[f].frame_count);
    for (std::size_t n = 0; n < frames; ++n) slices.push_back({f, n});
  }
  std::ranges::stable_sort(slices, {}, [&](const DicomSlice& slice) {
    return files[slice.file].frame(slice.frame).time;
  });
  return slices;
}

// Of a segmentation's several segments, keeps one.
void choose_segment(const ReadRequest& request, const std::vector<DicomFile>& files,
                    std::vector<DicomSlice>& slices, ReadResult& result) {
  const auto segment = [&](const DicomSlice& s) { return files[s.file].frame(s.frame).segment; };
  std::set<int> numbers;
  for (const DicomSlice& slice : slices) numbers.insert(segment(slice));
  if (numbers.size() < 2) return;
  result.volume_count = static_cast<int>(numbers.size());
  result.notes.push_back("its segments (" + files[0].segments + ") are volumes");
  const auto chosen =
      *std::next(numbers.begin(), static_cast<std::ptrdiff_t>(chosen_volume(request, result)));
  std::erase_if(slices, [&](const DicomSlice& slice) { return segment(slice) != chosen; });
}

SlicePlace place_of(const DicomFile& file, const DicomFrame& frame) {
  SlicePlace place{.columns = file.columns, .rows = file.rows};
  if (const auto& p = frame.position; !p.empty()) place.position = Vec3{p[0], p[1], p[2]};
  if (const auto& o = frame.orientation; !o.empty()) {
    place.axes = {{Vec3{o[0], o[1], o[2]}, Vec3{o[3], o[4], o[5]}}};
  }
  // DICOM names the distance between rows, along j, first.
  if (const auto& s = frame.spacing; !s.empty()) place.spacing_mm = {{s[1], s[0]}};
  if (!frame.distance.empty()) place.distance_mm = frame.distance[0];
  return place;
}

// --- What to tell ---

void add_notes(const std::vector<DicomFile>& files, const std::vector<DicomSlice>& slices,
               std::vector<std::string>& notes) {
  const DicomFile& first = files[slices[0].file];
  const DicomFrame& frame = first.frame(slices[0].frame);
  if (first.photometric == "MONOCHROME1") {
    notes.push_back(
        "low values are meant to be shown bright (MONOCHROME1): that concerns display only, values "
        "are kept as stored");
  }
  if (!first.padding.empty()) {
    const double value = frame.slope * first.padding[0] + frame.intercept;
    notes.push_back("the value " + to_text(value) +
                    " pads what was not scanned (PixelPaddingValue); it is kept as a value");
  }
  if (first.packing.bits_allocated == 1) {
    notes.push_back("a segmentation of one bit a voxel: 1 inside (" + first.segments +
                    "), 0 outside; its surface is that of iso value 0.5");
  }
  const bool differ = std::ranges::any_of(slices, [&](const DicomSlice& slice) {
    const DicomFrame& other = files[slice.file].frame(slice.frame);
    return other.slope != frame.slope || other.intercept != frame.intercept;
  });
  if (differ) notes.push_back("slices differ in their rescaling: each has its own");
  std::set<std::string> remarks;
  for (const DicomSlice& slice : slices) {
    for (const std::string& remark : files[slice.file].remarks) {
      if (remarks.insert(remark).second) notes.push_back(remark);
    }
  }
}

std::string stored_type_name(const PixelPacking& packing) {
  return (packing.is_float    ? "f"
          : packing.is_signed ? "i"
                              : "u") +
         std::to_string(packing.bits_allocated);
}

std::string units_of(const DicomFile& file) {
  if (file.modality == "CT") return file.units.empty() || file.units == "HU" ? "HU" : "";
  return file.modality == "PT" || file.modality == "RTDOSE" ? file.units : "";
}

// --- All together ---

OpenedInput open_series(const ReadRequest& request, const DicomSeries& series,
                        const std::string& named, ReadResult result) {
  const auto files =
      std::make_shared<const std::vector<DicomFile>>(usable_files(series, named, result));
  std::vector<DicomSlice> slices = slices_of(*files);
  choose_segment(request, *files, slices, result);
  const bool has_segments = result.volume_count > 1;

  std::vector<SlicePlace> slice_places;
  for (const DicomSlice& slice : slices) {
    const DicomFile& file = (*files)[slice.file];
    slice_places.push_back(place_of(file, file.frame(slice.frame)));
  }
  const SliceStack stack = stack_slices(request.name, slice_places);
  std::ranges::copy(stack.notes, std::back_inserter(result.notes));
  std::uint64_t chosen = 0;
  if (!has_segments) {
    result.volume_count = stack.volume_count();
    chosen = chosen_volume(request, result);
  }
  std::vector<DicomSlice> kept;
  std::set<std::string> kept_paths;
  for (const auto& place : stack.places) {
    kept.push_back(slices[place[chosen]]);
    const std::string& path = (*files)[kept.back().file].path;
    if (kept_paths.insert(path).second) result.files.push_back(path);
  }
  add_notes(*files, kept, result.notes);

  OpenedInput opened;
  const DicomFile& first = (*files)[kept[0].file];
  opened.volume.dims = {first.columns, first.rows, static_cast<int>(stack.layers.size())};
  opened.volume.world_from_index = stack.world_from_index;
  opened.volume.modality = first.modality;
  opened.volume.units = units_of(first);
  opened.result = std::move(result);
  opened.stored_type = stored_type_name(first.packing);
  opened.bytes_per_voxel_most = dicom_bytes_per_voxel_most(*files, kept);
  const std::vector<Layer> mix = stack.is_resampled ? stack.layers : std::vector<Layer>{};
  opened.read_voxels = [=](std::vector<std::string>& notes) {
    const VoxelArray voxels = read_dicom_slices(request, *files, kept, notes);
    return mix.empty() ? voxels : mixed(request.name, voxels, kept.size(), mix);
  };
  return opened;
}

// The first file that is at fault, where all are.
[[noreturn]] void refuse(const std::string& name, const std::vector<DicomFile>& files) {
  for (const DicomFile& file : files) require_sound(file);
  throw WorkError(name, "holds no DICOM image", "name a folder of images");
}

OpenedInput open_files(const ReadRequest& request, const std::vector<std::string>& paths,
                       const std::string& named) {
  ReadResult result{
      .volume = nullptr, .name = request.name, .format = "DICOM", .files = {}, .notes = {}};
  std::vector<DicomFile> files = describe_dicom_files(paths, request.listener);
  std::vector<const DicomFile*> unread;
  std::size_t without_image = 0;
  std::string named_uid;
  for (const DicomFile& file : files) {
    if (file.path == named) {
      require_sound(file);
      named_uid = file.series_uid;
    }
    if (!file.fault.empty() && file.series_uid.empty()) unread.push_back(&file);
    without_image += !file.series_uid.empty() && !file.has_image();
  }
  if (!unread.empty()) {
    result.notes.push_back("damaged DICOM files, left out: " + std::to_string(unread.size()) +
                           ", the first is " + unread[0]->path + ", which " + unread[0]->fault);
  }
  if (without_image > 0) {
    result.notes.push_back("DICOM files without an image (reports, plans, ...), left out: " +
                           std::to_string(without_image));
  }
  const std::vector<DicomSeries> series = series_among(files);
  if (series.empty()) refuse(request.name, files);
  result.series_count = static_cast<int>(series.size());
  std::size_t chosen = 0;
  if (request.grid.series) {
    chosen = chosen_series(series, *request.grid.series);
  } else if (!named.empty()) {
    const auto holds_named = [&](const DicomSeries& s) {
      return std::ranges::any_of(s.files, [&](const DicomFile& f) { return f.path == named; });
    };
    chosen = static_cast<std::size_t>(std::ranges::find_if(series, holds_named) - series.begin());
  } else {
    chosen = largest_series(series);
  }
  if (series.size() > 1 && (named.empty() || request.grid.series)) {
    result.notes.push_back(
        "there are " + std::to_string(series.size()) + " series (" + series_list(series) +
        "): number " + std::to_string(chosen + 1) +
        (request.grid.series ? " was read" : ", the largest, was read; --series takes another"));
  }
  return open_series(request, series[chosen], named, std::move(result));
}

bool recognises(const ReadRequest&, std::string_view first_bytes) {
  return dicom_start(first_bytes).has_value();
}

// One file stands for its series, in the folder that it lies in; a file of many frames, and one
// that does not say where it lies, for itself.
OpenedInput open(const ReadRequest& request) {
  const std::vector<DicomFile> alone = describe_dicom_files({request.name}, {});
  require_sound(alone[0]);
  if (alone[0].frame_count > 1) return open_files(request, {request.name}, request.name);
  if (alone[0].frames[0].position.empty()) {
    OpenedInput opened = open_files(request, {request.name}, request.name);
    opened.result.notes.push_back("it was read alone: name its folder to stack all of its series");
    return opened;
  }
  const fs::path path(request.name);
  const fs::path folder = path.has_parent_path() ? path.parent_path() : ".";
  std::vector<std::string> paths;
  std::error_code error;
  for (std::string& other : find_dicom_files(folder.string())) {
    if (fs::path(other).parent_path() == folder && !fs::equivalent(other, path, error)) {
      paths.push_back(std::move(other));
    }
  }
  paths.push_back(request.name);
  return open_files(request, paths, request.name);
}

}  // namespace

Format dicom_format() { return {recognises, open}; }

OpenedInput open_dicom_folder(const ReadRequest& request, const std::vector<std::string>& files) {
  return open_files(request, files, {});
}

}  // namespace isolux
