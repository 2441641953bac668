#include "isolux/bench/contest.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>

#include "isolux/base/number_text.h"
#include "isolux/base/output_file.h"
#include "isolux/base/temporary_path.h"
#include "isolux/bench/peer.h"
#include "isolux/bench/ppm.h"
#include "isolux/bench/ray_sets.h"
#include "isolux/bench/timing.h"
#include "isolux/image/png.h"

namespace isolux {
namespace {

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

}  // namespace

std::string words(Vec3 v) { return to_text(v.x) + " " + to_text(v.y) + " " + to_text(v.z); }

std::string frame_request(const View& view) {
  return "frame " + words(view.eye) + " " + words(view.target) + " " + to_text(view.fov_deg);
}

Work Contest::view_work(const std::string& name, OwnRenderer& renderer, const ViewOfTurn& view_of,
                        int turns, const TakesPart& takes_part) const {
  Work work{name, turns, [&renderer, view_of](int turn) {
              renderer.look(view_of(turn));
              return milliseconds([&] { renderer.frame(); });
            }};
  renderer.look(view_of(0));
  renderer.frame();
  const double pixels = options_.width * options_.height;
  work.note = percent(static_cast<double>(renderer.hit_pixels()), pixels);
  keep_picture(name, "isolux", renderer.picture());
  for (Rival& rival : rivals_.all()) {
    if (!takes_part(rival)) continue;
    Peer& peer = *rival.peer;
    const int every = rival.is_slow ? (turns + kFewTurns - 1) / kFewTurns : 1;
    const double hits = peer.ask(frame_request(view_of(0)), 2)[1];
    work.others.push_back(
        {peer.name(),
         [&peer, view_of](int turn) { return peer.ask_ms(frame_request(view_of(turn))); }, every,
         percent(hits, pixels) + ", " + compared_picture(name, renderer, peer)});
  }
  return work;
}

Work Contest::ray_work(const std::string& name, const OwnRenderer& renderer,
                       const std::vector<Ray>& rays, const std::optional<Vec3>& lamp,
                       const TakesPart& takes_part) const {
  const std::string file = scratch_.path() + "/rays";
  write_rays(file, rays);
  const std::string request = lamp ? "shadows " + file + " " + words(*lamp) : "rays " + file;
  Work work = rays_work(name, renderer, read_rays(file), lamp, few_turns());
  for (Rival& rival : rivals_.all()) {
    if (!rival.traces_rays || !takes_part(rival)) continue;
    Peer& peer = *rival.peer;
    work.others.push_back({peer.name(), [&peer, request](int) {
                             peer.ask(request);  // as isolux goes twice
                             return peer.ask_ms(request);
                           }});
  }
  return work;
}

Measurement Contest::measured(const Work& work) const {
  options_.tell(subject_ + ": " + work.name);
  return measure(work);
}

// How far a peer's last picture is from the renderer's, to see that both draw the same.
std::string Contest::compared_picture(const std::string& work, const OwnRenderer& renderer,
                                      Peer& peer) const {
  const std::string file = scratch_.path() + "/picture";
  peer.ask("picture " + file);
  const Ppm ppm = read_ppm(file);
  keep_picture(work, peer.name(), {ppm.width, ppm.height, ppm.rgb});
  char text[60];
  std::snprintf(text, sizeof text, "differs by %.1f of 255",
                mean_difference(renderer.picture().rgb, ppm.rgb));
  return text;
}

void Contest::keep_picture(const std::string& work, const std::string& who,
                           const Picture& picture) const {
  if (options_.pictures_folder.empty()) return;
  std::string name = subject_ + " " + work + " " + who;
  std::ranges::replace_if(
      name, [](char c) { return c == ' ' || c == '/'; }, '_');
  write_whole_file(options_.pictures_folder + "/" + name + ".png", encode_png(picture, {}, true));
}

}  // namespace isolux
