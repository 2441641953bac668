#include "isolux/render/denoise.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <limits>
#include <numbers>
#include <random>
#include <utility>

#include "every_instruction_set.h"
#include "isolux/base/parallel.h"
#include "isolux/render/path_tracer.h"
#include "isolux/render/ray_caster.h"
#include "isolux/render/session.h"
#include "isolux/render/test_scenes.h"
#include "isolux/volume/phantom.h"

namespace isolux {
namespace {

using nlohmann::json;

// The denoiser's own reach: taps 2 steps away, of 1 + 2 + 4 + 8 + 16 pixels.
constexpr int kReach = 2 * (1 + 2 + 4 + 8 + 16);
// A smoothed level is off by some 27 roundings of 2^-24: a sum of 13 products over a sum of 13.
// Each of five details is the difference of two levels.
constexpr double kRounding = 5 * 28 / 16777216.0;

// What a camera at (0, -100, 0) sees that looks along +y, 1 mm a pixel there.
struct View {
  Camera camera;
  SurfaceBuffer buffer;
  RgbLayer light;
  std::vector<float> variance;

  View(int width, int height, bool is_orthographic)
      : camera(description(height, is_orthographic), width, height, {}),
        buffer(width, height),
        light(buffer.pixels()),
        variance(buffer.pixels()) {}

  static CameraDescription description(int height, bool is_orthographic) {
    return {.eye = Vec3{0, -100, 0},
            .target = Vec3{},
            .up = Vec3{0, 0, 1},
            .orthographic = is_orthographic,
            .fov_deg = 2 * std::atan(height / 200.0) * 180 / std::numbers::pi,
            .height_mm = is_orthographic ? std::optional<double>(height) : std::nullopt};
  }

  /// Shows the plane through (0, y_mm, 0) with that normal, seen as surface `number`.
  void show(int x, int y, std::int32_t number, Vec3 normal = {0, -1, 0}, double y_mm = 0) {
    const Ray ray = camera.ray(x, y);
    const Vec3 through{0, y_mm, 0};
    SurfaceSample sample;
    sample.depth_mm = dot(normal, through - ray.origin) / dot(normal, ray.direction);
    sample.normal_x = static_cast<float>(normal.x);
    sample.normal_y = static_cast<float>(normal.y);
    sample.normal_z = static_cast<float>(normal.z);
    sample.surface = number;
    buffer.set(buffer.at(x, y), sample);
  }

  template <typename Body>
  void each(const Body& body) const {
    for (int y = 0; y < buffer.height(); ++y) {
      for (int x = 0; x < buffer.width(); ++x) body(x, y, buffer.at(x, y));
    }
  }
};

View wall(int width, int height, bool is_orthographic = true) {
  View view(width, height, is_orthographic);
  view.each([&](int x, int y, std::size_t) { view.show(x, y, 0); });
  return view;
}

RgbLayer denoised(const View& view) {
  RgbLayer light = view.light;
  Denoiser().denoise(view.camera, view.buffer, view.variance, light);
  return light;
}

// Normals all over the place, a hole, two surfaces, light and variance at random.
View rubble(int width, int height, bool is_orthographic) {
  View view(width, height, is_orthographic);
  std::mt19937 random(7);
  const auto draw = [&](double low, double high) {
    return low + (high - low) * static_cast<double>(random()) / 4294967296.0;
  };
  view.each([&](int x, int y, std::size_t place) {
    const Vec3 normal = normalize({draw(-0.4, 0.4), -1, draw(-0.4, 0.4)});
    for (int c = 0; c < 3; ++c) {
      view.light.channel(c)[place] = static_cast<float>(draw(0, 1) < 0.7 ? 0 : draw(0, 2));
    }
    view.variance[place] = static_cast<float>(draw(0, 0.1));
    if (std::hypot(x - 9, y - 9) > 4) view.show(x, y, x > 30 + y / 4, normal, draw(0, 0.2));
  });
  return view;
}

TEST(Denoiser, light_that_is_the_same_everywhere_stays_as_it_is) {
  for (const bool is_orthographic : {true, false}) {
    View view = rubble(70, 50, is_orthographic);
    view.each([&](int, int, std::size_t place) { view.light.set(place, {0.3, 0.7, 1.9}); });
    for (const bool is_known : {true, false}) {
      if (!is_known) view.variance.clear();
      const RgbLayer after = denoised(view);
      view.each([&](int, int, std::size_t place) {
        const Rgb expected = view.light.at(place), found = after.at(place);
        for (int c = 0; c < 3; ++c) EXPECT_NEAR(found[c], expected[c], kRounding * expected[c]);
      });
    }
  }
}

TEST(Denoiser, without_variance_nothing_changes) {
  View view = rubble(70, 50, false);
  std::ranges::fill(view.variance, 0.0f);
  const RgbLayer after = denoised(view);
  view.each([&](int, int, std::size_t place) { EXPECT_EQ(after.at(place), view.light.at(place)); });
}

TEST(Denoiser, light_does_not_cross_from_one_surface_normal_or_plane_to_another) {
  // On the right of x = 40: another surface; a wall that is turned by 90 degrees in all; a wall
  // that lies farther behind than 2 sqrt(16) pixels' widths of 1 mm.
  const double s = std::sqrt(0.5);
  for (const int kind : {0, 1, 2}) {
    for (const bool is_orthographic : {true, false}) {
      View view(80, 40, is_orthographic);
      std::mt19937 random(3);
      view.each([&](int x, int y, std::size_t place) {
        const bool is_right = x >= 40;
        const Vec3 normal = kind != 1 ? Vec3{0, -1, 0} : Vec3{is_right ? s : -s, -s, 0};
        view.show(x, y, kind == 0 && is_right, normal, kind == 2 && is_right ? 9.5 : 0);
        const double bright = static_cast<double>(random() % 1000) / 1000;
        view.light.set(place, {bright, is_right ? bright : 0, is_right ? 0 : bright});
        view.variance[place] = 0.1f;
      });
      const RgbLayer after = denoised(view);
      int changed = 0;
      view.each([&](int x, int, std::size_t place) {
        EXPECT_EQ(x < 40 ? after.g[place] : after.b[place], 0) << kind << " " << x;
        changed += after.r[place] != view.light.r[place];
      });
      EXPECT_GT(changed, 3000);
    }
  }
}

TEST(Denoiser, where_all_detail_is_noise_the_sum_of_the_light_is_kept) {
  // On a wall weights are those of the taps, the same both ways, as far as no tap is missing: light
  // in the middle does not reach those whose taps reach the border.
  constexpr int kLit = 20, kSize = kLit + 2 * (kReach + 32) + 2;
  View view = wall(kSize, kSize);
  std::mt19937 random(5);
  double sum = 0;
  view.each([&](int x, int y, std::size_t place) {
    if (std::max(std::abs(x - kSize / 2), std::abs(y - kSize / 2)) < kLit / 2) {
      view.light.g[place] = static_cast<float>(random() % 100);
      sum += view.light.g[place];
    }
    view.variance[place] = 1e6f;
  });
  const RgbLayer after = denoised(view);
  double found = 0, most = 0;
  view.each([&](int, int, std::size_t place) {
    found += after.g[place];
    most = std::max(most, static_cast<double>(after.g[place]));
  });
  EXPECT_NEAR(found, sum, kRounding * sum);
  // Taps have the variance 160 / 220, all levels 1 + 4 + 16 + 64 + 256 times that: 248. A Gaussian
  // of that variance each way is 1 / (2 pi 248) = 1 / 1558 high.
  EXPECT_LT(most, sum / 1558);
}

TEST(Denoiser, noise_goes_and_what_stands_out_of_it_stays) {
  // An edge of light from 0 to 1 without an edge of the surface, and noise of variance 0.01.
  View view = wall(160, 160, false);
  std::mt19937 random(9);
  view.each([&](int x, int, std::size_t place) {
    const double noise = std::sqrt(0.03) * (2 * static_cast<double>(random()) / 4294967296.0 - 1);
    const double value = 1 + (x < 80 ? 0 : 1) + noise;
    view.light.set(place, {value, value, value});
    view.variance[place] = 0.01f;
  });
  const RgbLayer after = denoised(view);
  double noise = 0, edge = 0;
  int away = 0, beside = 0;
  view.each([&](int x, int, std::size_t place) {
    const double off = after.g[place] - (x < 80 ? 1 : 2);
    if (std::abs(x - 79.5) > kReach) {
      noise += off * off;
      ++away;
    } else if (std::abs(x - 79.5) < 1) {
      edge += off;
      ++beside;
    }
  });
  EXPECT_LT(std::sqrt(noise / away), 0.25 * 0.1);
  EXPECT_LT(std::abs(edge / beside), 0.05);
  view.each([&](int x, int, std::size_t place) {
    if (x == 79 || x == 80) {
      EXPECT_NEAR(after.g[place], x == 79 ? 1 : 2, 0.3);
    }
  });
}

// The same from its definition, pixel by pixel in doubles, with points in space.
class Plainly {
 public:
  explicit Plainly(const View& view) : view_(view) {
    const std::size_t pixels = view.buffer.pixels();
    const bool is_known = !view.variance.empty();
    std::vector<Rgb> level(pixels), before;
    std::vector<double> variance(pixels), energy(pixels), noise(pixels);
    each([&](int, int, std::size_t p) {
      level[p] = view.light.at(p);
      variance[p] = is_known ? view.variance[p] : 0;
    });
    result_ = level;
    Wall on_wall;
    for (int n = 0; n <= 5; ++n) {
      const int step = 1 << std::min(n, 4);
      auto next = level;
      auto next_variance = variance, next_energy = energy, next_noise = noise;
      if (n < 5) on_wall.smooth(step);
      each([&](int x, int y, std::size_t p) {
        double weights = 0, squares = 0, around = 0, own = 0, energies = 0, noises = 0;
        Rgb sum;
        taps(x, y, step, [&](std::size_t q, double w) {
          weights += w;
          squares += w * w;
          around += w * variance[q];
          energies += w * energy[q];
          noises += w * noise[q];
          sum = sum + w * level[q];
          if (p == q) own = w;
        });
        if (n > 0 && noises > 0) {
          const double taken = std::min(1.0, (is_known ? 1.5 : 2) * noises / energies);
          result_[p] = result_[p] + -taken * (before[p] + -1.0 * level[p]);
        }
        next[p] = (1 / weights) * sum;
        const Rgb detail = level[p] + -1.0 * next[p];
        const double mean = (detail.r + detail.g + detail.b) / 3;
        const double left = squares / (weights * weights);
        next_energy[p] = mean * mean;
        around /= weights;
        if (n == 0 && !is_known) {
          const double of_1 = 1 - 2 * own / weights + left;
          next_variance[p] = of_1 > 1e-3 ? left * next_energy[p] / of_1 : 0;
          next_noise[p] = next_energy[p];
        } else {
          const double correlation =
              1 + (on_wall.correlation - 1) * (1 - left) / (1 - on_wall.taps_squared);
          next_variance[p] = around * left * (n == 0 ? 1 : correlation);
          next_noise[p] = n == 0 ? around * (1 - 2 * own / weights + left)
                                 : on_wall.detail * (around - next_variance[p]);
        }
      });
      before = std::exchange(level, next);
      variance = next_variance;
      energy = next_energy;
      noise = next_noise;
    }
  }

  double at(std::size_t place, int c) const { return std::max(0.0, result_[place][c]); }

 private:
  // The middle of 1 4 6 4 1 by itself.
  template <typename Body>
  static void each_tap(const Body& body) {
    constexpr double kB3[] = {1, 4, 6, 4, 1};
    for (int dy = -2; dy <= 2; ++dy) {
      for (int dx = std::abs(dy) - 2; dx <= 2 - std::abs(dy); ++dx) {
        body(dx, dy, kB3[2 + dx] * kB3[2 + dy] / 220);
      }
    }
  }

  // White noise of variance 1 on an endless wall: squares of what one pixel becomes.
  struct Wall {
    static constexpr int kSize = 129;
    std::vector<double> level = std::vector<double>(kSize * kSize);
    double taps_squared = 0, correlation = 1, detail = 1;

    Wall() { level[kSize * kSize / 2] = 1; }
    void smooth(int step) {
      std::vector<double> next(level.size());
      for (int at = 0; at < kSize * kSize; ++at) {
        if (level[static_cast<std::size_t>(at)] == 0) continue;
        each_tap([&](int dx, int dy, double w) {
          next[static_cast<std::size_t>(at + step * (dy * kSize + dx))] +=
              w * level[static_cast<std::size_t>(at)];
        });
      }
      double before = 0, after = 0, lost = 0;
      for (std::size_t at = 0; at < level.size(); ++at) {
        before += level[at] * level[at];
        after += next[at] * next[at];
        lost += (level[at] - next[at]) * (level[at] - next[at]);
      }
      if (step == 1) taps_squared = after;
      correlation = after / (before * taps_squared);
      detail = lost / (before - after);
      level = next;
    }
  };

  template <typename Body>
  void each(const Body& body) const {
    view_.each([&](int x, int y, std::size_t place) {
      if (view_.buffer.is_hit(place)) body(x, y, place);
    });
  }

  template <typename Body>
  void taps(int x, int y, int step, const Body& body) const {
    const std::size_t p = view_.buffer.at(x, y);
    const SurfaceSample here = view_.buffer.sample(p);
    const Vec3 at = view_.camera.ray(x, y).at(here.depth_mm);
    const bool is_orthographic = view_.camera.is_orthographic();
    const double width =
        view_.camera.pixel_size() *
        (is_orthographic ? 1 : dot(at - view_.camera.eye(), Vec3{0, 1, 0}));  // looks along y
    each_tap([&](int dx, int dy, double weight) {
      const int i = x + step * dx, j = y + step * dy;
      if (i < 0 || j < 0 || i >= view_.buffer.width() || j >= view_.buffer.height()) return;
      const std::size_t q = view_.buffer.at(i, j);
      if (!view_.buffer.is_hit(q)) return;
      const SurfaceSample there = view_.buffer.sample(q);
      if (there.surface != here.surface) return;
      const Vec3 turn = there.normal() - here.normal();
      const double off = dot(here.normal(), view_.camera.ray(i, j).at(there.depth_mm) - at) / width;
      const double near = std::max(0.0, 1 - dot(turn, turn) - off * off / (4 * step));
      body(q, weight * near * near);
    });
  }

  const View& view_;
  std::vector<Rgb> result_;
};

TEST(Denoiser, lanes_do_what_the_definition_says) {
  for (const bool is_orthographic : {true, false}) {
    for (const bool is_known : {true, false}) {
      View view = rubble(67, 45, is_orthographic);
      if (!is_known) view.variance.clear();
      const Plainly expected(view);
      on_every_instruction_set([&](const std::string& name) {
        const RgbLayer after = denoised(view);
        double changed = 0;
        view.each([&](int x, int y, std::size_t place) {
          if (!view.buffer.is_hit(place)) return;
          for (int c = 0; c < 3; ++c) {
            const double found = after.channel(c)[place];
            ASSERT_NEAR(found, expected.at(place, c), 1e-4) << name << " " << x << " " << y;
            changed = std::max(changed, std::abs(found - view.light.channel(c)[place]));
          }
        });
        EXPECT_GT(changed, 0.5);
      });
    }
  }
}

TEST(Denoiser, threads_and_instruction_sets_from_avx2_up_give_the_same_bits) {
  const View view = rubble(150, 90, false);
  std::vector<RgbLayer> all;
  on_every_instruction_set([&](const std::string& name) {
    if (name == "scalar" || name == "sse4") return;
    for (const int threads : {1, 2, 7}) {
      with_threads(threads, [&] { all.push_back(denoised(view)); });
    }
  });
  for (const RgbLayer& other : all) {
    view.each(
        [&](int, int, std::size_t place) { EXPECT_EQ(other.at(place), all.front().at(place)); });
  }
}

TEST(Denoiser, what_shows_no_surface_is_left_alone_and_harms_nothing) {
  View view(5, 3, false);
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  std::ranges::fill(view.buffer.normal_x, kNan);
  std::ranges::fill(view.buffer.depth_mm, std::numeric_limits<double>::infinity());
  std::ranges::fill(view.variance, kNan);
  std::ranges::fill(view.light.g, kNan);
  Denoiser denoiser;
  denoiser.denoise(view.camera, view.buffer, view.variance, view.light);
  EXPECT_TRUE(std::isnan(view.light.g[view.buffer.at(1, 1)]));
  view.show(1, 1, 0);
  const std::size_t place = view.buffer.at(1, 1);
  view.light.g[place] = 0.25f;
  view.variance[place] = 1;
  denoiser.denoise(view.camera, view.buffer, view.variance, view.light);
  EXPECT_NEAR(view.light.g[place], 0.25, kRounding);  // it has no neighbours
  EXPECT_TRUE(std::isnan(view.light.g[view.buffer.at(2, 1)]));
}

TEST(Denoiser, memory_of_an_earlier_picture_does_not_show) {
  const View first = rubble(60, 60, true), second = rubble(60, 44, false);
  View third = rubble(60, 60, false);
  third.variance.clear();
  Denoiser kept;
  for (const View* view : std::initializer_list<const View*>{&first, &third, &second, &first}) {
    RgbLayer light = view->light;
    kept.denoise(view->camera, view->buffer, view->variance, light);
    const RgbLayer alone = denoised(*view);
    view->each([&](int, int, std::size_t place) { EXPECT_EQ(light.at(place), alone.at(place)); });
  }
}

json room(int spp) {
  return {{"size", {96, 96}},
          {"surface", {{{"iso", 300}}}},
          {"camera", {{"view", "left"}, {"fov", 16}}},
          {"light", {{{"kind", "point"}, {"at", {-90, -200, 60}}}}},
          {"ambient", {0.5, 0.5, 0.5}},
          {"shadows", "on"},
          {"indirect", "path"},
          {"spp", spp}};
}

TEST(Denoiser, light_by_few_paths_comes_nearer_to_what_many_converge_to_and_its_mean_stays) {
  const SceneInput head = volume(head_phantom(64));
  Session session, judge;
  const RgbLayer converged = judge.indirect(scene_of({head}, room(1024))).pixels;
  for (const int spp : {1, 4}) {
    json settings = room(spp);
    const RgbLayer before = session.indirect(scene_of({head}, settings)).pixels;
    settings["denoise"] = "on";
    const Scene scene = scene_of({head}, settings);
    const RgbLayer after = session.indirect(scene).pixels;
    double error_before = 0, error_after = 0, sum = 0, mean_before = 0, mean_after = 0;
    const int hits = each_hit(session.surfaces(scene), [&](std::size_t place) {
      const double truth = converged.g[place];
      error_before += std::pow(before.g[place] - truth, 2);
      error_after += std::pow(after.g[place] - truth, 2);
      sum += truth;
      mean_before += before.g[place];
      mean_after += after.g[place];
    });
    ASSERT_GT(hits, 1000);
    EXPECT_LT(error_after, error_before / 2) << spp;
    // The mean of independent pixels is off by its standard error, and by as much again as taps
    // weigh pixels unevenly.
    const double standard_error = std::sqrt(error_before) / hits;
    EXPECT_NEAR(mean_before / hits, sum / hits, 4 * standard_error) << spp;
    EXPECT_NEAR(mean_after / hits, sum / hits, 8 * standard_error) << spp;
  }
}

TEST(Denoiser, direct_light_is_left_as_it_is) {
  const SceneInput head = volume(head_phantom(48));
  json settings = room(2);
  Session session;
  const Radiance before = session.radiance(scene_of({head}, settings));
  settings["denoise"] = "on";
  const Radiance after = session.radiance(scene_of({head}, settings));
  EXPECT_EQ(after.diffuse.g, before.diffuse.g);
  EXPECT_EQ(after.specular.g, before.specular.g);
  EXPECT_NE(after.indirect.g, before.indirect.g);
}

}  // namespace
}  // namespace isolux
