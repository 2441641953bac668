#include "isolux/server/drawing.h"

#include <algorithm>
#include <chrono>
#include <nlohmann/json.hpp>

#include "isolux/image/jpeg.h"
#include "isolux/image/png.h"
#include "isolux/render/shown_layer.h"

namespace isolux {
namespace {

using nlohmann::json;
using Clock = std::chrono::steady_clock;

constexpr double kMovingFrame_ms = 40;      // what tracing or sending may take of a moving frame
constexpr double kMovingIndirect_ms = 100;  // and linking surfaces or following paths
constexpr int kMostReduced = 4;
constexpr int kMovingQuality = 82;

double ms_since(Clock::time_point begin) {
  return std::chrono::duration<double, std::milli>(Clock::now() - begin).count();
}

json numbers(Vec3 v) { return {v.x, v.y, v.z}; }

json camera_json(const Camera& camera) {
  const Affine placed = camera.world_from_camera();
  return {{"eye", numbers(placed.offset)},          {"right", numbers(placed.linear.column[0])},
          {"up", numbers(placed.linear.column[1])}, {"back", numbers(placed.linear.column[2])},
          {"half_height", camera.half_height()},    {"orthographic", camera.orthographic()}};
}

json lights_json(const Scene& scene) {
  json lights = json::array();
  for (const Light& light : scene.lights) {
    lights.push_back(
        {{"point", light.kind == Light::Kind::kPoint}, {"place", numbers(light.place)}});
  }
  return lights;
}

// Of what is seen, the point nearest to the chosen lamp.
json foot_json(const Scene& scene, const SurfaceBuffer& buffer, std::size_t chosen) {
  if (chosen >= scene.lights.size()) return nullptr;
  const Light& light = scene.lights[chosen];
  if (light.kind != Light::Kind::kPoint) return nullptr;
  const auto foot = nearest_seen(*scene.camera, buffer, light.place);
  if (!foot) return nullptr;
  return {{"position", numbers(*foot)}, {"distance", length(*foot - light.place)}};
}

json part_json(const std::optional<PicturePart>& part) {
  if (!part) return nullptr;
  return {part->left, part->top, part->right, part->bottom};
}

json legend_json(const std::optional<Legend>& legend) {
  if (!legend) return nullptr;
  return {{"low", legend->low},
          {"high", legend->high},
          {"unit", legend->unit},
          {"colors", legend->colors}};
}

json counters_json(const Session::Counters& counters) {
  return {{"skip_structure", counters.skip_structure},
          {"visibility", counters.visibility},
          {"shadows", counters.shadows},
          {"indirect", counters.indirect},
          {"lighting", counters.lighting},
          {"display", counters.display}};
}

bool same_rays(const Scene& a, const Scene& b) {
  return a.camera == b.camera && a.visibility == b.visibility &&
         std::ranges::equal(a.surfaces, b.surfaces, [](const auto& one, const auto& other) {
           return one.volume == other.volume && one.mesh == other.mesh && one.iso == other.iso;
         });
}

// The mean of blocks of `by` x `by` pixels.
Picture reduced(const Picture& picture, int by) {
  if (by == 1) return picture;
  Picture small{std::max(1, picture.width / by), std::max(1, picture.height / by), {}};
  small.rgb.resize(static_cast<std::size_t>(3 * small.width) *
                   static_cast<std::size_t>(small.height));
  std::size_t out = 0;
  for (int y = 0; y < small.height; ++y) {
    for (int x = 0; x < small.width; ++x) {
      for (int c = 0; c < 3; ++c) {
        int sum = 0, count = 0;
        for (int row = y * by; row < std::min(picture.height, (y + 1) * by); ++row) {
          for (int column = x * by; column < std::min(picture.width, (x + 1) * by); ++column) {
            sum += picture.rgb[static_cast<std::size_t>(3 * (row * picture.width + column) + c)];
            ++count;
          }
        }
        small.rgb[out++] = static_cast<std::uint8_t>(sum / count);
      }
    }
  }
  return small;
}

std::string framed(const json& header, const std::vector<std::string>& files) {
  const std::string text = header.dump();
  std::string bytes;
  for (int shift = 0; shift < 32; shift += 8) {
    bytes += static_cast<char>((text.size() >> shift) & 255);
  }
  bytes += text;
  for (const std::string& file : files) bytes += file;
  return bytes;
}

}  // namespace

int Drawing::reduction_for(const Scene& whole, bool settled) const {
  if (settled) return 1;
  const double pixels = static_cast<double>(whole.camera->width()) * whole.camera->height();
  const double shadows_ms = whole.shadows ? shadow_ms_per_pixel_ * pixels : 0;
  const bool has_paths = whole.indirect == IndirectMethod::kPath;
  const double paths_ms = has_paths ? path_ms_per_pixel_ * pixels : 0;
  const auto is_soon = [&](double frame_ms, int by) {
    return frame_ms / (by * by) <= kMovingFrame_ms && paths_ms / (by * by) <= kMovingIndirect_ms;
  };
  const bool is_traced = whole_ && same_rays(*whole_, whole);
  if (is_traced && is_soon(shadows_ms, reduction_)) return reduction_;
  const double frame_ms = trace_ms_per_pixel_ * pixels + shadows_ms;
  int by = 1;
  while (by < kMostReduced && !is_soon(frame_ms, by)) ++by;
  return by;
}

std::string Drawing::frame(const ViewRequest& request, const SceneDescription& description,
                           const std::vector<SceneInput>& inputs, double bytes_per_ms,
                           const ProgressListener& listener) {
  SceneDescription drawn = description;
  // Paths take seconds, and nothing of them can be kept: moving frames show one for each pixel,
  // denoised. Of transport they show what there is by then.
  const bool is_preview = !request.settled && drawn.indirect == IndirectMethod::kPath;
  if (is_preview) {
    drawn.spp = 1;
    drawn.indirect_error.reset();
    drawn.denoise = true;
  }
  Scene whole = resolve(drawn, inputs);
  const int by = reduction_for(whole, request.settled);
  drawn.width = std::max(1, description.width / by);
  drawn.height = std::max(1, description.height / by);
  Scene scene = by == 1 ? whole : resolve(drawn, inputs);
  const double pixels = static_cast<double>(drawn.width) * drawn.height;

  const auto begin = Clock::now();
  const int traced_before = session_.counters().visibility;
  const SurfaceBuffer& buffer = session_.surfaces(scene, listener);
  const double trace_ms = ms_since(begin);
  if (session_.counters().visibility > traced_before) {
    trace_ms_per_pixel_ = trace_ms / pixels;
    seen_ = seen_part(buffer);
  }
  scene_ = scene;
  whole_ = std::move(whole);
  reduction_ = by;

  const auto indirect = Clock::now();
  std::function<bool()> stop;
  // What is done before any link can be shot does not count, or a new surface would show none.
  std::optional<Clock::time_point> first_link;
  if (!request.settled) {
    stop = [&] {
      if (!first_link) first_link = Clock::now();
      return ms_since(*first_link) > kMovingIndirect_ms;
    };
  }
  const int found_before = session_.counters().indirect;
  session_.indirect(scene, listener, stop);
  const double indirect_ms = ms_since(indirect);
  if (is_preview && session_.counters().indirect > found_before) {
    path_ms_per_pixel_ = indirect_ms / pixels;
  }

  const auto lighting = Clock::now();
  std::vector<ShownPicture> pictures;
  for (const ShownLayer layer : request.show) {
    pictures.push_back(show_layer(layer, scene, request.light, session_));
  }
  const double light_ms = ms_since(lighting);
  if (scene.shadows) shadow_ms_per_pixel_ = light_ms / pixels;

  const auto encoding = Clock::now();
  int sent_by = 1;
  while (!request.settled && bytes_per_ms > 0 && sent_by < kMostReduced &&
         sent_bytes_per_pixel_ * pixels * static_cast<double>(pictures.size()) /
                 (sent_by * sent_by) >
             kMovingFrame_ms * bytes_per_ms) {
    ++sent_by;
  }
  std::vector<std::string> files;
  json lengths = json::array(), legends = json::array();
  for (const ShownPicture& one : pictures) {
    files.push_back(request.settled ? encode_png(one.picture, {}, false, PngEffort::kFast)
                                    : encode_jpeg(reduced(one.picture, sent_by), kMovingQuality));
    lengths.push_back(files.back().size());
    legends.push_back(legend_json(one.legend));
  }
  if (!request.settled) {
    sent_bytes_per_pixel_ = static_cast<double>(files[0].size()) * sent_by * sent_by / pixels;
  }
  const json header = {{"id", request.id},
                       {"settled", request.settled},
                       {"size", {drawn.width, drawn.height}},
                       {"type", request.settled ? "image/png" : "image/jpeg"},
                       {"lengths", lengths},
                       {"legends", legends},
                       {"camera", camera_json(*scene.camera)},
                       {"seen", part_json(seen_)},
                       {"lights", lights_json(scene)},
                       {"foot", foot_json(scene, session_.surfaces(scene), request.light)},
                       {"ms",
                        {{"trace", trace_ms},
                         {"indirect", indirect_ms},
                         {"light", light_ms},
                         {"encode", ms_since(encoding)}}},
                       {"counters", counters_json(session_.counters())}};
  return framed(header, files);
}

std::optional<Drawing::Picked> Drawing::pick(double across, double down) {
  if (!scene_) return std::nullopt;
  const SurfaceBuffer& buffer = session_.surfaces(*scene_);
  const int x = static_cast<int>(across * buffer.width());
  const int y = static_cast<int>(down * buffer.height());
  const SurfaceSample sample = buffer.sample(buffer.at(x, y));
  if (!sample.is_hit()) return std::nullopt;
  return Picked{scene_->camera->ray(x, y).at(sample.depth_mm), sample.normal(), sample.depth_mm};
}

}  // namespace isolux
