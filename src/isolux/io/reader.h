#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "isolux/base/progress.h"
#include "isolux/mesh/mesh.h"
#include "isolux/scene/description.h"
#include "isolux/volume/volume.h"

namespace isolux {

/// The input that stands where the user names none: the real CT head of Debian's package
/// invesalius-examples, or the head phantom where it is not installed.
inline constexpr const char* kExampleHead = "example:ct-head";

/// One input to read: a file, a built-in volume such as "phantom:head,size=64", or kExampleHead.
struct ReadRequest {
  std::string name;
  GridDescription grid;
  ProgressListener listener = {};
};

/// A volume or a mesh, and what reading it found and decided.
struct ReadResult {
  std::shared_ptr<const Volume> volume;  ///< null where it is a mesh
  std::string name;                ///< as it is to be named again; differs for a missing example
  std::string format;              ///< "NRRD", "NIfTI-1", "MetaImage", "raw", "built-in", ...
  std::vector<std::string> files;  ///< every file that was read; empty for built-in volumes
  std::vector<std::string> notes;  ///< decisions, a sentence each
  int volume_count = 1;            ///< how many --volume could choose from
  int series_count = 1;            ///< how many --series could choose from
  std::shared_ptr<const Mesh> mesh = nullptr;  ///< null where it is a volume
  bool is_smoothed = false;  ///< a mesh whose normals are not its file's, but made by crease_deg
};

/// An input whose header is read and checked, and whose voxels are not read yet; or a mesh, which
/// is read whole: then only `result` counts.
struct OpenedInput {
  Volume volume;                    ///< placed and described, without voxels
  ReadResult result;                ///< without the volume
  std::string stored_type;          ///< of its numbers in the file: "i16", "f64", ...
  double bytes_per_voxel_most = 0;  ///< once they are read
  bool is_mapped = false;           ///< they will stay in the file
  /// Reads them; decisions go to `notes`.
  std::function<VoxelArray(std::vector<std::string>& notes)> read_voxels;

  double voxel_count() const;
  /// Memory that the voxels will hold at the most, in bytes.
  double voxel_memory() const;
};

/// Reads an input's header.
/// @throws as read_input.
OpenedInput open_input(const ReadRequest& request);

/// Reads an input; the format is found by content.
/// @throws WorkError   unreadable, damaged, of a kind not read here, or too large for memory.
/// @throws UsageError  an unknown phantom, or dims and type that contradict the file.
ReadResult read_input(const ReadRequest& request);

/// Opens all inputs of a scene in order; without any, kExampleHead.
/// @throws as read_inputs.
std::vector<OpenedInput> open_inputs(const SceneDescription& description,
                                     const ProgressListener& listener);

/// Reads all inputs of a scene in order; without any, kExampleHead.
/// @throws as read_input; UsageError also where dims, type, volume or series are given but no input
/// has use for them.
std::vector<ReadResult> read_inputs(const SceneDescription& description,
                                    const ProgressListener& listener);

/// @throws UsageError  where an input is a mesh.
void require_volume(const ReadResult& input);

}  // namespace isolux
