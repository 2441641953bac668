#include <cmath>
#include <optional>

#include "isolux/base/error.h"
#include "isolux/base/memory.h"
#include "isolux/base/number_text.h"
#include "isolux/base/output_file.h"
#include "isolux/cli/command.h"
#include "isolux/cli/loaded_scene.h"
#include "isolux/cli/terminal.h"
#include "isolux/io/write_volume.h"
#include "isolux/scene/option_value.h"
#include "isolux/volume/regrid.h"

namespace isolux {
namespace {

// "I0:J0:K0,I1:J1:K1", both included.
VoxelBlock parse_crop(const std::string& text, const std::array<int, 3>& dims) {
  const std::size_t comma = text.find(',');
  const Option corner{.name = "crop", .type = ValueType::kVector, .sentence = "a corner"};
  VoxelBlock block{};
  if (comma == std::string::npos) {
    throw UsageError("--crop", "'" + text + "' is no block", "give I0:J0:K0,I1:J1:K1");
  }
  const nlohmann::json first = value_from_text(corner, text.substr(0, comma), "--crop");
  const nlohmann::json last = value_from_text(corner, text.substr(comma + 1), "--crop");
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double low = first[axis].get<double>(), high = last[axis].get<double>();
    if (low != std::floor(low) || high != std::floor(high) || low < 0 || high < low ||
        high > dims[axis] - 1) {
      throw UsageError("--crop", "'" + text + "' is not a block of its voxels",
                       "the last voxel is " + std::to_string(dims[0] - 1) + ":" +
                           std::to_string(dims[1] - 1) + ":" + std::to_string(dims[2] - 1));
    }
    block.first[axis] = static_cast<int>(low);
    block.last[axis] = static_cast<int>(high);
  }
  return block;
}

Volume resampled_checked(const Volume& volume, const Vec3& spacing) {
  const auto dims = resampled_dims(volume, spacing);
  for (const double count : dims) {
    if (count > 1 << 20) {
      throw UsageError("--resample", "would make " + to_text(count) + " voxels along an axis",
                       "give a larger spacing");
    }
  }
  const double bytes_per_voxel =
      static_cast<double>(voxel_bytes(volume)) / static_cast<double>(voxel_count(volume));
  check_memory(dims[0] * dims[1] * dims[2] * bytes_per_voxel, "--resample");
  return resampled(volume, spacing);
}

}  // namespace

int run_convert(const Command& command, const Arguments& arguments) {
  if (arguments.inputs.size() != 2) {
    throw UsageError("isolux convert", "takes one INPUT and one OUT",
                     "such as `isolux convert head.nrrd head.nii.gz`");
  }
  const std::string output = arguments.inputs[1];
  check_volume_name(output);
  check_writable(output);
  Arguments of_input = arguments;
  of_input.inputs.pop_back();
  const SceneDescription description = describe(document_from(of_input), "convert");
  const ReadResult input = read_inputs(description, progress_bar(arguments)).front();
  require_volume(input);
  tell_notes(input);
  std::optional<Volume> changed;
  if (arguments.has("crop")) {
    changed = cropped(*input.volume, parse_crop(arguments.at("crop"), input.volume->dims));
  }
  if (arguments.has("resample")) {
    const nlohmann::json spacing = value_from_text(*find_option(command.options, "resample"),
                                                   arguments.at("resample"), "--resample");
    changed = resampled_checked(
        changed ? *changed : *input.volume,
        {spacing[0].get<double>(), spacing[1].get<double>(), spacing[2].get<double>()});
  }
  const Volume& written = changed ? *changed : *input.volume;
  write_volume(output, written);
  return 0;
}

}  // namespace isolux
