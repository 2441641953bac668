#pragma once

#include <vector>

#include "isolux/bench/loose_rays.h"
#include "isolux/bench/own_renderer.h"
#include "isolux/bench/work.h"

// The works that any scene can be timed at, each one function. They keep `renderer`, which must
// have been prepared and have drawn a frame.

namespace isolux {

Work bricks_work(OwnRenderer& renderer, int turns);
Work visibility_work(OwnRenderer& renderer, int turns);
Work display_work(OwnRenderer& renderer, int turns);
Work frame_work(OwnRenderer& renderer, int turns);
/// Lighting and display again, which go in one pass, from the surfaces that are kept: one of ten
/// moves in a row.
Work lamp_work(OwnRenderer& renderer, int turns);
/// The same with shadow rays from every lit pixel.
Work shadow_work(OwnRenderer& renderer, int turns);
/// From another iso value to the picture.
Work iso_work(OwnRenderer& renderer, int turns);
/// From the voxels to the picture.
Work first_picture_work(OwnRenderer& renderer, int turns);
/// Whether rays of no picture meet the scene's first surface.
Work rays_work(const std::string& name, const OwnRenderer& renderer, std::vector<Ray> rays,
               const std::optional<Vec3>& lamp, int turns);
/// Incoherent rays and shadow rays from what the renderer's picture shows.
std::vector<Work> ray_works(const OwnRenderer& renderer, int turns);

/// All of a scene whose first surface is an isosurface.
std::vector<Work> scene_works(OwnRenderer& renderer, int turns);

/// The iso value of a turn of `iso_work`: always another one, and always nearly the same surface.
double iso_of_turn(double iso, int turn);

/// Where the lamp stands at a turn of `lamp_work`: outside the volume, over the viewer's left
/// shoulder, and elsewhere at each turn.
Vec3 lamp_of_turn(const Scene& scene, int turn);

}  // namespace isolux
