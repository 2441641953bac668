#include "isolux/bench/scene_works.h"

#include <memory>

#include "isolux/bench/limits.h"
#include "isolux/bench/ray_sets.h"
#include "isolux/bench/timing.h"
#include "isolux/volume/brick_grid.h"

namespace isolux {

double iso_of_turn(double iso, int turn) { return iso * (1 + 1e-4 * (turn + 1)); }

Vec3 lamp_of_turn(const Scene& scene, int turn) {
  const double size = length(box_size(scene.surfaces[0]));
  return scene.camera->world_from_camera().point({-size - turn, 1.3 * size, 0.2 * size});
}

namespace {

// A drag moves the lamp again and again: what takes about a millisecond is done so often in a turn,
// so that a turn is not all waking of threads and filling of caches.
constexpr int kInARow = 10;

double milliseconds_of_one(const std::function<void(int)>& work) {
  return milliseconds([&] {
           for (int n = 0; n < kInARow; ++n) work(n);
         }) /
         kInARow;
}

}  // namespace

Work bricks_work(OwnRenderer& renderer, int turns) {
  const std::shared_ptr<const Volume> volume = renderer.scene().surfaces[0].volume;
  return {"min-max bricks",
          turns,
          [=](int) { return milliseconds([&] { BrickGrid bricks(*volume); }); },
          {{"every voxel read once",
            [=](int) { return milliseconds([&] { read_voxels_once(*volume); }); }}}};
}

Work visibility_work(OwnRenderer& renderer, int turns) {
  return {"visibility", turns, [&](int) { return milliseconds([&] { renderer.trace(); }); }};
}

Work display_work(OwnRenderer& renderer, int turns) {
  return {"display", turns,
          [&](int) { return milliseconds_of_one([&](int) { renderer.redisplay(); }); }};
}

Work frame_work(OwnRenderer& renderer, int turns) {
  return {"frame", turns, [&](int) { return milliseconds([&] { renderer.frame(); }); }};
}

Work lamp_work(OwnRenderer& renderer, int turns) {
  const auto limit = std::make_shared<RelightingLimit>(renderer.surfaces(), renderer.hit_pixels());
  return {"lamp moved",
          turns,
          [&](int turn) {
            return milliseconds_of_one([&](int n) {
              renderer.set_lamp(lamp_of_turn(renderer.scene(), kInARow * turn + n));
              renderer.relight();
            });
          },
          {{"the same bytes streamed",
            [=](int) { return milliseconds_of_one([&](int) { limit->run(); }); }}}};
}

Work shadow_work(OwnRenderer& renderer, int turns) {
  return {"lamp moved, shadows", turns, [&](int turn) {
            renderer.set_lamp(lamp_of_turn(renderer.scene(), turn));
            renderer.set_shadows(true);
            const double ms = milliseconds([&] { renderer.relight(); });
            renderer.set_shadows(false);
            return ms;
          }};
}

Work iso_work(OwnRenderer& renderer, int turns) {
  const double iso = renderer.scene().surfaces[0].iso;
  return {"new iso value", turns, [&renderer, iso](int turn) {
            renderer.set_iso(iso_of_turn(iso, turn));
            return milliseconds([&] {
              renderer.prepare();
              renderer.frame();
            });
          }};
}

Work first_picture_work(OwnRenderer& renderer, int turns) {
  return {"first picture", turns, [&](int) {
            OwnRenderer fresh(renderer.scene());
            return milliseconds([&] {
              fresh.prepare();
              fresh.frame();
            });
          }};
}

Work rays_work(const std::string& name, const OwnRenderer& renderer, std::vector<Ray> rays,
               const std::optional<Vec3>& lamp, int turns) {
  const double count = static_cast<double>(rays.size());
  const auto kept = std::make_shared<const std::vector<Ray>>(std::move(rays));
  const auto tracer = std::make_shared<const LooseRays>(renderer.scene().surfaces[0]);
  return {.name = name,
          .turns = turns,
          .ms =
              [tracer, kept, lamp](int) {
                tracer->count_hits(*kept, lamp);  // wakes the threads
                return milliseconds([&] { tracer->count_hits(*kept, lamp); });
              },
          .rays = count};
}

std::vector<Work> ray_works(const OwnRenderer& renderer, int turns) {
  const Camera& camera = *renderer.scene().camera;
  const SurfaceBuffer& surfaces = renderer.surfaces();
  const Vec3 lamp = lamp_of_turn(renderer.scene(), 0);
  return {rays_work("incoherent rays", renderer, cosine_rays(camera, surfaces), {}, turns),
          rays_work("shadow rays", renderer, shadow_rays(camera, surfaces, lamp), lamp, turns)};
}

std::vector<Work> scene_works(OwnRenderer& renderer, int turns) {
  std::vector<Work> works{bricks_work(renderer, turns), visibility_work(renderer, turns),
                          display_work(renderer, turns), frame_work(renderer, turns)};
  for (Work& work : ray_works(renderer, turns)) works.push_back(std::move(work));
  works.push_back(lamp_work(renderer, turns));
  works.push_back(shadow_work(renderer, turns));
  works.push_back(iso_work(renderer, turns));
  works.push_back(first_picture_work(renderer, turns));
  return works;
}

}  // namespace isolux
