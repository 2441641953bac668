#include "isolux/bench/rivals.h"

#include <algorithm>
#include <string_view>

#include "isolux/base/error.h"
#include "isolux/base/number_text.h"
#include "isolux/base/output_file.h"
#include "isolux/base/temporary_path.h"
#include "isolux/bench/peer_contest.h"

namespace isolux {

Rivals::Rivals(const ContestOptions& options, const TemporaryPath& scratch)
    : options_(options),
      log_file_(scratch.path() + "/log"),
      volume_file_(scratch.path() + "/volume"),
      mesh_file_(scratch.path() + "/mesh") {
  const std::string embree = options.peers_folder + "/embree_peer";
  const std::string vtk = options.peers_folder + "/vtk_peer";
  const std::string threads = std::to_string(options.threads);
  start("VTK mesh", {vtk, "mesh", threads},
        {.reads_mesh = true, .rasterises = true, .makes_mesh = true, .is_slow = true});
  start("VTK volume, ct-head", {vtk, "volume", threads}, {.is_slow = true});
  start("VTK volume, opaque step", {vtk, "step", threads}, {.fills_inside = true, .is_slow = true});
  if (std::ranges::any_of(rivals_, &Rival::makes_mesh)) {
    start("Embree", {embree, threads},
          {.reads_mesh = true, .takes_mesh = true, .traces_rays = true});
    std::rotate(rivals_.begin(), rivals_.end() - 1, rivals_.end());  // it is told first
  } else {
    options.tell("left out: Embree: it draws the mesh that VTK extracts");
  }
  const auto start_isolux = [&](const std::string& program, const std::string& name,
                                const std::vector<std::string>& extra, Rival traits) {
    std::vector<std::string> command{program, "bench", "--as-peer", name};
    command.insert(command.end(), extra.begin(), extra.end());
    start(name, command, std::move(traits));
  };
  if (!options.other_isolux.empty()) {
    start_isolux(options.other_isolux, "other isolux", options.own_options,
                 {.reads_mesh = true, .rasterises = true, .is_isolux = true, .traces_rays = true});
  }
  const std::string self = "/proc/self/exe";
  start_isolux(self, "isolux again", options.own_options, {.is_control = true});
  start_isolux(self, "isolux, 1 thread", {"--threads", "1"}, {.is_control = true});
  start_isolux(self, "isolux, --isa avx2", {"--threads", threads, "--isa", "avx2"},
               {.is_control = true});
}

void Rivals::start(const std::string& name, const std::vector<std::string>& command, Rival traits) {
  try {
    traits.peer = std::make_unique<Peer>(name, command, log_file_ + std::to_string(rivals_.size()));
    traits.peer->ask("size " + std::to_string(options_.width) + " " +
                     std::to_string(options_.height));
    rivals_.push_back(std::move(traits));
  } catch (const WorkError& error) {
    options_.tell(std::string("left out: ") + error.what());
  }
}

void Rivals::set_volume(const Volume& volume) {
  visit_voxels(volume, [&](const auto& view) {
    write_whole_file(volume_file_,
                     {reinterpret_cast<const char*>(view.voxels), voxel_bytes(volume)});
  });
  std::string request = "volume " + volume_file_;
  for (const int count : volume.dims) request += " " + std::to_string(count);
  const Vec3 spacing = spacing_mm(volume);
  for (int axis = 0; axis < 3; ++axis) request += " " + to_text(spacing[axis]);
  for (Rival& rival : rivals_) {
    if (!rival.takes_mesh) rival.peer->ask(request);
  }
}

double Rivals::extract_mesh(double iso) {
  const auto maker = std::ranges::find_if(rivals_, &Rival::makes_mesh);
  const double ms = maker->peer->ask_ms("iso " + to_text(iso));
  maker->peer->ask("write-mesh " + mesh_file_);
  return ms;
}

double Rivals::set_iso(Rival& rival, double iso) {
  if (!rival.takes_mesh) return rival.peer->ask_ms("iso " + to_text(iso));
  const double extraction_ms = extract_mesh(iso);
  return extraction_ms + rival.peer->ask_ms("read-mesh " + mesh_file_);
}

}  // namespace isolux
