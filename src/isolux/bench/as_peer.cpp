#include "isolux/bench/as_peer.h"

#include <fstream>
#include <memory>
#include <optional>

#include "isolux/base/error.h"
#include "isolux/base/number_text.h"
#include "isolux/bench/line_protocol.h"
#include "isolux/bench/loose_rays.h"
#include "isolux/bench/mesh_works.h"
#include "isolux/bench/own_renderer.h"
#include "isolux/bench/ppm.h"
#include "isolux/bench/ray_sets.h"
#include "isolux/bench/timing.h"

namespace isolux {
namespace {

Vec3 read_vec3(std::istringstream& words) {
  Vec3 v;
  words >> v.x >> v.y >> v.z;
  return v;
}

class OwnPeer {
 public:
  std::string size(std::istringstream& words) {
    words >> width_ >> height_;
    renderer_.reset();
    return {};
  }

  std::string volume(std::istringstream& words) {
    std::string path;
    Volume volume;
    words >> path >> volume.dims[0] >> volume.dims[1] >> volume.dims[2];
    volume.world_from_index.linear = diagonal(read_vec3(words));
    std::vector<std::int16_t> voxels(static_cast<std::size_t>(volume.dims[0]) *
                                     static_cast<std::size_t>(volume.dims[1]) *
                                     static_cast<std::size_t>(volume.dims[2]));
    std::ifstream file(path, std::ios::binary);
    file.read(reinterpret_cast<char*>(voxels.data()),
              static_cast<std::streamsize>(voxels.size() * sizeof voxels[0]));
    if (!file) throw WorkError(path, "cannot be read, or is too short", "check its name");
    volume.voxels = std::move(voxels);
    volume_ = std::make_shared<const Volume>(std::move(volume));
    renderer_.reset();
    return {};
  }

  std::string iso(std::istringstream& words) {
    double value = 0;
    words >> value;
    if (!volume_) throw WorkError("iso", "there is no volume", "send `volume` first");
    if (renderer_ && renderer_->scene().surfaces[0].volume) {
      renderer_->set_iso(value);
    } else {
      renderer_.emplace(bench_scene(volume_, value, width_, height_));
    }
    tracer_.reset();
    return to_text(milliseconds([&] { renderer_->prepare(); }));
  }

  std::string read_mesh(std::istringstream& words) {
    std::string path;
    words >> path;
    const auto mesh = mesh_from_peer(read_peer_mesh(path));
    renderer_.emplace(bench_scene(mesh, width_, height_));
    tracer_.reset();
    return to_text(milliseconds([&] { renderer_->prepare(); }));
  }

  std::string visibility(std::istringstream& words) {
    std::string way;
    words >> way;
    if (way != "raycast" && way != "raster") {
      throw WorkError("visibility", "is " + way, "raycast or raster");
    }
    renderer().set_visibility(way == "raster" ? Visibility::kRaster : Visibility::kRaycast);
    return to_text(milliseconds([&] { renderer_->prepare(); }));
  }

  std::string lamp(std::istringstream& words) {
    renderer().set_lamp(read_vec3(words));
    return {};
  }

  std::string headlight(std::istringstream&) {
    renderer().set_lamp(std::nullopt);
    return {};
  }

  std::string paths(std::istringstream& words) {
    int spp = 0, bounces = 0;
    words >> spp >> bounces;
    renderer().set_paths(spp, bounces);
    return {};
  }

  std::string frame(std::istringstream& words) {
    View view;
    view.eye = read_vec3(words);
    view.target = read_vec3(words);
    words >> view.fov_deg;
    renderer().look(view);
    const double ms = milliseconds([&] { renderer_->frame(); });
    const auto& rgb = renderer_->picture().rgb;
    return to_text(ms) + " " + std::to_string(renderer_->hit_pixels()) + " " +
           std::to_string(checksum_of(rgb.data(), rgb.size()));
  }

  std::string rays(std::istringstream& words) { return traced(words, false); }
  std::string shadows(std::istringstream& words) { return traced(words, true); }

  std::string picture(std::istringstream& words) {
    std::string path;
    words >> path;
    const Picture& picture = renderer().picture();
    write_ppm(path, picture.width, picture.height, picture.rgb);
    return {};
  }

 private:
  std::string traced(std::istringstream& words, bool to_lamp) {
    std::string path;
    words >> path;
    const std::vector<Ray> rays = read_rays(path);
    std::optional<Vec3> lamp;
    if (to_lamp) lamp = read_vec3(words);
    if (!tracer_) {
      tracer_.emplace(renderer().scene().surfaces[0]);
      for (int n = 0; n < 2; ++n) tracer_->count_hits(rays, lamp);  // makes what is made once
    }
    std::size_t hits = 0;
    const double ms = milliseconds([&] { hits = tracer_->count_hits(rays, lamp); });
    return to_text(ms) + " " + std::to_string(hits);
  }

  OwnRenderer& renderer() {
    if (!renderer_) throw WorkError("peer", "there is no surface", "send `iso` first");
    return *renderer_;
  }

  int width_ = 1024;
  int height_ = 1024;
  std::shared_ptr<const Volume> volume_;
  std::optional<OwnRenderer> renderer_;
  std::optional<LooseRays> tracer_;
};

}  // namespace

void answer_as_peer(const std::string& name) {
  OwnPeer peer;
  const auto answering = [&](std::string (OwnPeer::*answer)(std::istringstream&)) {
    return [&peer, answer](std::istringstream& words) { return (peer.*answer)(words); };
  };
  answer_requests(name, {{"size", answering(&OwnPeer::size)},
                         {"volume", answering(&OwnPeer::volume)},
                         {"iso", answering(&OwnPeer::iso)},
                         {"lamp", answering(&OwnPeer::lamp)},
                         {"headlight", answering(&OwnPeer::headlight)},
                         {"paths", answering(&OwnPeer::paths)},
                         {"frame", answering(&OwnPeer::frame)},
                         {"rays", answering(&OwnPeer::rays)},
                         {"shadows", answering(&OwnPeer::shadows)},
                         {"read-mesh", answering(&OwnPeer::read_mesh)},
                         {"visibility", answering(&OwnPeer::visibility)},
                         {"picture", answering(&OwnPeer::picture)}});
}

}  // namespace isolux
