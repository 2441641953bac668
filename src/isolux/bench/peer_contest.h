#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "isolux/bench/table.h"
#include "isolux/mesh/mesh.h"
#include "isolux/volume/volume.h"

namespace isolux {

struct ContestOptions {
  std::string peers_folder;
  std::string pictures_folder;  ///< where every side's pictures are kept as PNG; empty: nowhere
  std::string other_isolux;     ///< another build of isolux to take turns with; empty: none
  std::vector<std::string> own_options;  ///< of this run, for further processes of isolux
  int threads = 1;
  int turns = 1;
  int width = 0;
  int height = 0;
  /// Hears which peers are left out, and why, and what is being measured.
  std::function<void(const std::string&)> tell;
};

/// Times isolux against the peers of bench/peers, as far as they are there, on the bone and the
/// skin of a CT head as it is and with twice the voxels along each axis. The volume is taken as a
/// raw file would be: box from 0 to (n - 1) * spacing, no direction.
/// @throws WorkError  where the voxels are not 16-bit integers, or a peer fails on the way.
std::vector<Section> measure_against_peers(const Volume& head, const ContestOptions& options);

/// The same of a mesh, in white and with smooth normals where it has none.
std::vector<Section> measure_mesh_against_peers(const Mesh& mesh, const std::string& name,
                                                const ContestOptions& options);

}  // namespace isolux
