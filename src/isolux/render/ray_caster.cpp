#include "isolux/render/ray_caster.h"

#include "isolux/base/parallel.h"

namespace isolux {

SurfaceSample RayHit::sample() const {
  return {t, static_cast<float>(normal.x), static_cast<float>(normal.y),
          static_cast<float>(normal.z), static_cast<std::int32_t>(surface)};
}

RayCaster::RayCaster(const Scene& scene, const RayCaster* previous) {
  for (const IsoSurfaceItem& item : scene.surfaces) {
    auto& of_volume = bricks_[item.volume];
    if (!of_volume && previous && previous->bricks_.contains(item.volume)) {
      of_volume = previous->bricks_.at(item.volume);
    }
    if (!of_volume) of_volume = std::make_shared<const BrickGrid>(*item.volume);
    surfaces_.emplace_back(item.volume, of_volume, item.iso);
  }
}

std::optional<RayHit> RayCaster::first_hit(const Ray& ray) const {
  std::optional<IsoHit> nearest;
  std::size_t nearest_surface = 0;
  for (std::size_t n = 0; n < surfaces_.size(); ++n) {
    const auto hit =
        nearest ? surfaces_[n].first_hit(ray, nearest->t) : surfaces_[n].first_hit(ray);
    if (!hit || (nearest && hit->t >= nearest->t)) continue;
    nearest = hit;
    nearest_surface = n;
  }
  if (!nearest) return std::nullopt;
  const Vec3 to_eye = -ray.direction;
  const Vec3 outward = surfaces_[nearest_surface].normal(*nearest).value_or(to_eye);
  const bool turned = dot(outward, to_eye) < 0;
  return RayHit{nearest->t, nearest_surface, turned ? -outward : outward, turned};
}

SurfaceBuffer RayCaster::cast(const Camera& camera, const ProgressListener& listener) const {
  SurfaceBuffer buffer(camera.width(), camera.height());
  Progress progress(listener, "tracing", static_cast<std::size_t>(camera.height()));
  parallel_for(static_cast<std::size_t>(camera.height()), 4,
               [&](std::size_t begin, std::size_t end) {
                 for (int y = static_cast<int>(begin); y < static_cast<int>(end); ++y) {
                   for (int x = 0; x < camera.width(); ++x) {
                     const auto hit = first_hit(camera.ray(x, y));
                     if (hit) buffer.set(buffer.at(x, y), hit->sample());
                   }
                 }
                 progress.advance(end - begin);
               });
  return buffer;
}

}  // namespace isolux
