#include "isolux/bench/peer_contest.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <optional>

#include "isolux/base/error.h"
#include "isolux/base/number_text.h"
#include "isolux/base/output_file.h"
#include "isolux/base/temporary_path.h"
#include "isolux/bench/framing.h"
#include "isolux/bench/own_renderer.h"
#include "isolux/bench/peer.h"
#include "isolux/bench/ppm.h"
#include "isolux/bench/ray_sets.h"
#include "isolux/bench/rivals.h"
#include "isolux/bench/scene_works.h"
#include "isolux/bench/timing.h"
#include "isolux/image/png.h"
#include "isolux/volume/regrid.h"

namespace isolux {
namespace {

constexpr double kBone = 300, kSkin = -300;
// Enough for a median. A whole orbit, 360 turns, is for isolux and for peers of its speed alone.
constexpr int kFewTurns = 21;

using ViewOfTurn = View (*)(Vec3 box_mm, double turn_deg);

std::string words(Vec3 v) { return to_text(v.x) + " " + to_text(v.y) + " " + to_text(v.z); }

std::string frame_request(const View& view) {
  return "frame " + words(view.eye) + " " + words(view.target) + " " + to_text(view.fov_deg);
}

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

double mean_difference(const std::vector<std::uint8_t>& a, const std::vector<std::uint8_t>& b) {
  double sum = 0;
  for (std::size_t n = 0; n < std::min(a.size(), b.size()); ++n) sum += std::abs(a[n] - b[n]);
  return sum / static_cast<double>(a.size());
}

std::string percent(double part, double whole) {
  char text[40];
  std::snprintf(text, sizeof text, "%.1f %% hit", 100 * part / whole);
  return text;
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
        options_(options) {
    renderer_.prepare();
    for (Rival& rival : rivals_.all()) rivals_.set_iso(rival, iso);
  }

  Section measured(bool with_controls) {
    Section section{name_, {}};
    const auto add = [&](const Work& work) {
      options_.tell(name_ + ": " + work.name);
      section.measurements.push_back(measure(work));
    };
    const int few = std::min(options_.turns, kFewTurns);
    add(view_work("orbit", orbit_view, options_.turns, with_controls));
    add(view_work("close view", close_view, few, false));
    add(view_work("inside view", inside_view, few, false));
    renderer_.look(orbit_view(box_mm_, 0));
    renderer_.frame();
    const Camera& camera = *renderer_.scene().camera;
    add(ray_work("incoherent rays", "rays", cosine_rays(camera, renderer_.surfaces()),
                 RayQuery::kNearest, few));
    add(ray_work("shadow rays", "shadows",
                 shadow_rays(camera, renderer_.surfaces(), lamp_of_turn(renderer_.scene(), 0)),
                 RayQuery::kAny, few));
    add(lamps_work(few));
    put_lamps_out();
    add(isos_work(few));
    add(first_picture_work(renderer_, few));
    add(bricks_work(renderer_, few));
    return section;
  }

 private:
  Work view_work(const std::string& name, ViewOfTurn view_of, int turns, bool with_controls) {
    Work work{name, turns, [this, view_of](int turn) {
                renderer_.look(view_of(box_mm_, turn));
                return milliseconds([&] { renderer_.frame(); });
              }};
    renderer_.look(view_of(box_mm_, 0));
    renderer_.frame();
    const double pixels = options_.width * options_.height;
    work.note = percent(static_cast<double>(renderer_.hit_pixels()), pixels);
    keep_picture(name, "isolux", renderer_.picture());
    for (Rival& rival : rivals_.all()) {
      if (rival.is_control && !with_controls) continue;
      if (rival.fills_inside && is_in_body(volume(), iso_, view_of(box_mm_, 0))) continue;
      Peer& peer = *rival.peer;
      const int every = rival.is_slow ? (turns + kFewTurns - 1) / kFewTurns : 1;
      const double hits = peer.ask(frame_request(view_of(box_mm_, 0)), 2)[1];
      work.others.push_back({peer.name(),
                             [&peer, this, view_of](int turn) {
                               return peer.ask_ms(frame_request(view_of(box_mm_, turn)));
                             },
                             every, percent(hits, pixels) + ", " + compared_picture(name, peer)});
    }
    return work;
  }

  Work ray_work(const std::string& name, const std::string& request, const std::vector<Ray>& rays,
                RayQuery query, int turns) {
    const std::string file = scratch_.path() + "/" + request;
    write_rays(file, rays);
    Work work = rays_work(name, renderer_, read_rays(file), query, turns);
    for (Rival& rival : rivals_.all()) {
      if (!rival.traces_rays) continue;
      Peer& peer = *rival.peer;
      work.others.push_back(
          {peer.name(), [&peer, line = request + " " + file](int) { return peer.ask_ms(line); }});
    }
    return work;
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

  // How far a peer's last picture is from the renderer's, to see that both draw the same.
  std::string compared_picture(const std::string& work, Peer& peer) {
    const std::string file = scratch_.path() + "/picture";
    peer.ask("picture " + file);
    const Ppm ppm = read_ppm(file);
    keep_picture(work, peer.name(), {ppm.width, ppm.height, ppm.rgb});
    char text[60];
    std::snprintf(text, sizeof text, "differs by %.1f of 255",
                  mean_difference(renderer_.picture().rgb, ppm.rgb));
    return text;
  }

  void keep_picture(const std::string& work, const std::string& who, const Picture& picture) {
    if (options_.pictures_folder.empty()) return;
    std::string name = name_ + " " + work + " " + who;
    std::ranges::replace(name, ' ', '_');
    write_whole_file(options_.pictures_folder + "/" + name + ".png", encode_png(picture, {}, true));
  }

  const Volume& volume() const { return *renderer_.scene().surfaces[0].volume; }

  std::string name_;
  double iso_;
  Vec3 box_mm_;
  OwnRenderer renderer_;
  Rivals& rivals_;
  const TemporaryPath& scratch_;
  const ContestOptions& options_;
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

}  // namespace isolux
