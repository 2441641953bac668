#pragma once

#include <memory>
#include <string>
#include <vector>

#include "isolux/bench/peer.h"
#include "isolux/volume/volume.h"

namespace isolux {

class TemporaryPath;
struct ContestOptions;

/// A peer, and what it can do and needs.
struct Rival {
  std::unique_ptr<Peer> peer = {};
  bool reads_mesh = false;    ///< draws a mesh that it is given
  bool rasterises = false;    ///< draws triangles without rays
  bool is_isolux = false;     ///< answers `visibility`
  bool takes_mesh = false;    ///< draws the mesh that another peer extracts; no volume
  bool makes_mesh = false;    ///< can write its surface as a mesh
  bool fills_inside = false;  ///< shows what is above the iso value as a body, not as a surface
  bool traces_rays = false;   ///< answers `rays` and `shadows`
  bool is_slow = false;       ///< a frame takes it several tenths of a second
  bool is_control = false;    ///< isolux in another process, threads or instruction set
};

/// All peers that could be started.
class Rivals {
 public:
  /// Starts them. Which are left out, and why, goes to `options.tell`.
  Rivals(const ContestOptions& options, const TemporaryPath& scratch);

  std::vector<Rival>& all() { return rivals_; }

  void set_volume(const Volume& volume);
  /// How many ms a rival needs until it can draw that surface, without its first frame. For one
  /// that takes a mesh: the extraction by the one that makes it, and its own structures over the
  /// mesh, but not the file between the two.
  double set_iso(Rival& rival, double iso);

 private:
  void start(const std::string& name, const std::vector<std::string>& command, Rival traits);
  /// The mesh goes to mesh_file_; how long the extraction took, in ms.
  double extract_mesh(double iso);

  const ContestOptions& options_;
  std::string log_file_, volume_file_, mesh_file_;
  std::vector<Rival> rivals_;
};

}  // namespace isolux
