#include "isolux/bench/peer_contest.h"

#include <optional>

#include "isolux/base/error.h"
#include "isolux/base/temporary_path.h"
#include "isolux/bench/contest.h"
#include "isolux/bench/framing.h"
#include "isolux/bench/mesh_works.h"
#include "isolux/bench/own_renderer.h"
#include "isolux/bench/peer.h"
#include "isolux/bench/ray_sets.h"
#include "isolux/bench/rivals.h"
#include "isolux/bench/scene_works.h"
#include "isolux/volume/regrid.h"

namespace isolux {
namespace {

constexpr double kBone = 300, kSkin = -300;
std::string dims_text(const Volume& volume) {
  const auto [nx, ny, nz] = volume.dims;
  return std::to_string(nx) + "x" + std::to_string(ny) + "x" + std::to_string(nz);
}

std::shared_ptr<const Volume> as_raw_file(const Volume& volume) {
  if (voxel_type_name(volume) != "i16") {
    throw WorkError("--peers", "the voxels are " + voxel_type_name(volume),
                    "give a CT volume of 16-bit integers: that is what the peers read");
  }
  Volume raw = volume;
  raw.world_from_index = {diagonal(spacing_mm(volume)), {}};
  return std::make_shared<const Volume>(std::move(raw));
}

// Twice the voxels along each axis, in the same box.
std::shared_ptr<const Volume> doubled(const Volume& volume) {
  Vec3 spacing = spacing_mm(volume);
  for (int axis = 0; axis < 3; ++axis) {
    const double cells = volume.dims[static_cast<std::size_t>(axis)] - 1;
    spacing[axis] *= cells / (2 * cells + 1);
  }
  return std::make_shared<const Volume>(resampled(volume, spacing));
}

// Whether the view stands where the values are above the iso value: an eye in a body that is full
// sees nothing of its surface.
bool is_in_body(const Volume& volume, double iso, const View& view) {
  const Vec3 index = inverse(volume.world_from_index).point(view.eye);
  return visit_voxels(volume, [&](const auto& v) {
    for (int axis = 0; axis < 3; ++axis) {
      if (index[axis] < 0 || index[axis] > v.dims[static_cast<std::size_t>(axis)] - 1) return false;
    }
    return v.value(static_cast<int>(index.x), static_cast<int>(index.y),
                   static_cast<int>(index.z)) >= iso;
  });
}

bool traces_meshes(const Rival& rival) { return rival.reads_mesh && rival.traces_rays; }
bool rasterises(const Rival& rival) { return rival.reads_mesh && rival.rasterises; }

// One mesh, by isolux and by the rivals that read it.
class MeshSubject {
 public:
  MeshSubject(const Contest& contest, MeshRenderers& renderers, Vec3 box_mm,
              const TemporaryPath& scratch)
      : contest_(contest),
        renderers_(renderers),
        box_mm_(box_mm),
        file_(scratch.path() + "/own-mesh") {
    write_peer_mesh(file_, peer_mesh(*renderers.raycast.scene().surfaces[0].mesh));
    read_by_rivals();
  }

  void measure(std::vector<Measurement>& to) {
    const int few = contest_.few_turns();
    to.push_back(contest_.measured(trees_work(few)));
    read_by_rivals();
    set_visibility("raycast");
    to.push_back(contest_.measured(
        frames_work("mesh frame, raycast", renderers_.raycast, few, traces_meshes)));
    set_visibility("raster");
    to.push_back(
        contest_.measured(frames_work("mesh frame, raster", renderers_.raster, few, rasterises)));
    set_visibility("raycast");
    renderers_.raycast.look(orbit_view(box_mm_, 0));
    renderers_.raycast.frame();
    const Camera& camera = *renderers_.raycast.scene().camera;
    const SurfaceBuffer& surfaces = renderers_.raycast.surfaces();
    to.push_back(
        contest_.measured(contest_.ray_work("incoherent rays on mesh", renderers_.raycast,
                                            cosine_rays(camera, surfaces), {}, traces_meshes)));
    const Vec3 lamp = lamp_of_turn(renderers_.raycast.scene(), 0);
    to.push_back(contest_.measured(contest_.ray_work("shadow rays on mesh", renderers_.raycast,
                                                     shadow_rays(camera, surfaces, lamp), lamp,
                                                     traces_meshes)));
  }

 private:
  Work frames_work(const std::string& name, OwnRenderer& renderer, int turns,
                   const Contest::TakesPart& takes_part) {
    return contest_.view_work(
        name, renderer, [box = box_mm_](int turn) { return orbit_view(box, turn); }, turns,
        takes_part);
  }

  Work trees_work(int turns) {
    Work work = tree_work(renderers_, turns);
    for (Rival& rival : contest_.rivals().all()) {
      if (!traces_meshes(rival)) continue;
      work.others.push_back({rival.peer->name(), [&rival, line = "read-mesh " + file_](int) {
                               return rival.peer->ask_ms(line);
                             }});
    }
    return work;
  }

  void read_by_rivals() {
    for (Rival& rival : contest_.rivals().all()) {
      if (rival.reads_mesh) rival.peer->ask("read-mesh " + file_);
    }
  }
  void set_visibility(const std::string& way) {
    for (Rival& rival : contest_.rivals().all()) {
      if (rival.reads_mesh && rival.is_isolux) rival.peer->ask("visibility " + way);
    }
  }

  const Contest& contest_;
  MeshRenderers& renderers_;
  Vec3 box_mm_;
  std::string file_;
};

// One isosurface of one volume, by isolux and by its rivals.
class Subject {
 public:
  Subject(const std::shared_ptr<const Volume>& volume, double iso, const std::string& name,
          Rivals& rivals, const TemporaryPath& scratch, const ContestOptions& options)
      : name_(name),
        iso_(iso),
        box_mm_(box_corners(*volume)[7]),
        renderer_(bench_scene(volume, iso, options.width, options.height)),
        rivals_(rivals),
        scratch_(scratch),
        contest_(name, rivals, scratch, options) {
    renderer_.prepare();
    for (Rival& rival : rivals_.all()) rivals_.set_iso(rival, iso);
  }

  Section measured(bool with_controls) {
    Section section{name_, {}};
    const auto add = [&](const Work& work) {
      section.measurements.push_back(contest_.measured(work));
    };
    const int few = contest_.few_turns();
    add(view_work("orbit", orbit_view, contest_.options().turns, with_controls));
    add(view_work("close view", close_view, few, false));
    add(view_work("inside view", inside_view, few, false));
    renderer_.look(orbit_view(box_mm_, 0));
    renderer_.frame();
    const auto all = [](const Rival&) { return true; };
    const Camera& camera = *renderer_.scene().camera;
    add(contest_.ray_work("incoherent rays", renderer_, cosine_rays(camera, renderer_.surfaces()),
                          {}, all));
    const Vec3 lamp = lamp_of_turn(renderer_.scene(), 0);
    add(contest_.ray_work("shadow rays", renderer_, shadow_rays(camera, renderer_.surfaces(), lamp),
                          lamp, all));
    add(lamps_work(few));
    put_lamps_out();
    add(isos_work(few));
    add(first_picture_work(renderer_, few));
    add(bricks_work(renderer_, few));
    add(extractions_work(few));
    renderer_.look(orbit_view(box_mm_, 0));
    const auto mesh = extracted_mesh(renderer_.scene());
    if (mesh->triangles.empty()) return section;
    MeshRenderers on_triangles(on_mesh(renderer_.scene(), mesh));
    MeshSubject(contest_, on_triangles, box_mm_, scratch_).measure(section.measurements);
    return section;
  }

 private:
  Work view_work(const std::string& name, View (*view_of)(Vec3, double), int turns,
                 bool with_controls) {
    const auto view = [=, box = box_mm_](int turn) { return view_of(box, turn); };
    return contest_.view_work(name, renderer_, view, turns, [=, this](const Rival& rival) {
      if (rival.is_control) return with_controls;
      return !rival.fills_inside || !is_in_body(volume(), iso_, view(0));
    });
  }

  // The peers keep no surfaces from frame to frame: their lamp moves with a whole frame.
  Work lamps_work(int turns) {
    Work work = lamp_work(renderer_, turns);
    for (Rival& rival : rivals_.all()) {
      if (rival.is_control) continue;
      Peer& peer = *rival.peer;
      const auto draw_under_lamp = [&peer, this](int turn) {
        peer.ask("lamp " + words(lamp_of_turn(renderer_.scene(), turn)));
        return peer.ask_ms(frame_request(orbit_view(box_mm_, 0)));
      };
      work.others.push_back({peer.name(), draw_under_lamp, 1, "whole frame"});
    }
    return work;
  }

  void put_lamps_out() {
    renderer_.set_lamp(std::nullopt);
    for (Rival& rival : rivals_.all()) rival.peer->ask("headlight");
  }

  Work isos_work(int turns) {
    Work work = iso_work(renderer_, turns);
    for (Rival& rival : rivals_.all()) {
      if (rival.is_control) continue;
      work.others.push_back(
          {rival.peer->name(), [&rival, this](int turn) {
             const double ready_ms = rivals_.set_iso(rival, iso_of_turn(iso_, turn));
             return ready_ms + rival.peer->ask_ms(frame_request(orbit_view(box_mm_, 0)));
           }});
    }
    return work;
  }

  Work extractions_work(int turns) {
    Work work = extraction_work(renderer_, turns);
    for (Rival& rival : rivals_.all()) {
      if (!rival.makes_mesh) continue;
      work.others.push_back({rival.peer->name(), [&rival, this](int turn) {
                               return rivals_.set_iso(rival, iso_of_turn(iso_, turn));
                             }});
    }
    return work;
  }

  const Volume& volume() const { return *renderer_.scene().surfaces[0].volume; }

  std::string name_;
  double iso_;
  Vec3 box_mm_;
  OwnRenderer renderer_;
  Rivals& rivals_;
  const TemporaryPath& scratch_;
  Contest contest_;
};

}  // namespace

std::vector<Section> measure_against_peers(const Volume& head, const ContestOptions& options) {
  const TemporaryPath scratch = temporary_folder("bench", "--peers");
  const auto raw = as_raw_file(head);
  Rivals rivals(options, scratch);
  std::vector<Section> sections;
  for (const auto& volume : {raw, doubled(*raw)}) {
    rivals.set_volume(*volume);
    for (const auto& [name, iso] : {std::pair{"bone", kBone}, std::pair{"skin", kSkin}}) {
      Subject subject(volume, iso, name + (" " + dims_text(*volume)), rivals, scratch, options);
      sections.push_back(subject.measured(sections.empty()));
    }
  }
  return sections;
}

std::vector<Section> measure_mesh_against_peers(const Mesh& mesh, const std::string& name,
                                                const ContestOptions& options) {
  const TemporaryPath scratch = temporary_folder("bench", "--peers");
  Rivals rivals(options, scratch);
  MeshRenderers renderers(bench_scene(bare_mesh(mesh), options.width, options.height));
  Section section{name, {}};
  MeshSubject(Contest(name, rivals, scratch, options), renderers,
              box_size(renderers.raycast.scene().surfaces[0]), scratch)
      .measure(section.measurements);
  return {section};
}

}  // namespace isolux
