#include "isolux/intersect/mesh_surface.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "every_instruction_set.h"
#include "isolux/base/parallel.h"
#include "isolux/intersect/ray_triangle.h"
#include "isolux/mesh/extract_isosurface.h"
#include "isolux/volume/phantom.h"

namespace isolux {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

std::shared_ptr<const Mesh> head() {
  static const auto mesh = std::make_shared<const Mesh>(extract_isosurface(head_phantom(48), 300));
  return mesh;
}

// All hits of a ray with t > 0, by trying every triangle; as the definition says.
std::vector<MeshHit> all_hits(const Mesh& mesh, const Ray& ray) {
  const RayTriangles triangles(ray);
  std::vector<MeshHit> hits;
  for (std::uint32_t n = 0; n < mesh.triangles.size(); ++n) {
    const auto hit = triangles.hit(corners(mesh, mesh.triangles[n]));
    if (hit && hit->t > 0) hits.push_back({hit->t, n, hit->u, hit->v});
  }
  return hits;
}

class RandomRays {
 public:
  Vec3 direction() {
    while (true) {
      const Vec3 d{number(), number(), number()};
      if (dot(d, d) > 0.01 && dot(d, d) <= 1) return normalize(d);
    }
  }
  double number() { return static_cast<double>(random_()) / 2147483647.5 - 1; }
  std::size_t below(std::size_t count) { return random_() % count; }

 private:
  std::mt19937 random_{7};
};

TEST(MeshSurface, the_first_hit_is_that_of_trying_all_triangles_to_the_last_bit) {
  const MeshSurface surface(head());
  RandomRays random;
  int hits = 0;
  for (int n = 0; n < 300; ++n) {
    // Half of them aimed at a vertex, from near, afar, and inside.
    const Vec3 target = n % 2 ? as_double(head()->positions[random.below(head()->positions.size())])
                              : 60 * Vec3{random.number(), random.number(), random.number()};
    const double distance = n % 3 == 0 ? 1e5 : n % 3 == 1 ? 300 : 20;
    const Vec3 direction = random.direction();
    const Ray ray{target - distance * direction, (n % 5 == 0 ? 7.0 : 1.0) * direction};
    std::optional<MeshHit> nearest;
    for (const MeshHit& hit : all_hits(*head(), ray)) {
      if (!nearest || hit.t < nearest->t) nearest = hit;
    }
    const auto found = surface.first_hit(ray);
    ASSERT_EQ(found.has_value(), nearest.has_value()) << n;
    EXPECT_EQ(surface.any_hit(ray, 0, kInfinity), nearest.has_value());
    if (!found) continue;
    ++hits;
    EXPECT_EQ(found->t, nearest->t);
    EXPECT_EQ(found->triangle, nearest->triangle);
    EXPECT_EQ(found->u, nearest->u);
    EXPECT_EQ(found->v, nearest->v);
    EXPECT_FALSE(surface.first_hit(ray, found->t * (1 - 1e-15)).has_value());
    EXPECT_TRUE(surface.first_hit(ray, found->t).has_value());
    EXPECT_FALSE(surface.any_hit(ray, 0, found->t));
  }
  EXPECT_GT(hits, 150);
}

RayLanes in_lanes(const std::vector<Ray>& rays, float begin, float end) {
  RayLanes lanes;
  for (std::size_t n = 0; n < RayLanes::kCount; ++n) {
    for (int axis = 0; axis < 3; ++axis) {
      lanes.origin[axis][n] = rays[n].origin[axis];
      lanes.direction[axis][n] = rays[n].direction[axis];
    }
    lanes.begin[n] = begin;
    lanes.end[n] = end;
  }
  return lanes;
}

// What any ray of `lanes` has to meet between begin and end, by trying every triangle.
std::optional<MeshHit> first_of(const Mesh& mesh, const Ray& ray, double begin, double end) {
  std::optional<MeshHit> first;
  for (const MeshHit& hit : all_hits(mesh, ray)) {
    if (hit.t > begin && hit.t <= end && (!first || hit.t < first->t)) first = hit;
  }
  return first;
}

// A packet of rays, and what trying all triangles says of it.
struct Case {
  RayLanes rays;
  std::uint32_t asked;
  std::vector<std::optional<MeshHit>> wanted;
};

std::vector<Case> cases_for(const Mesh& mesh, Vec3 on_needle) {
  RandomRays random;
  std::vector<Case> cases;
  for (int packet = 0; packet < 24; ++packet) {
    const bool run_together = packet % 2 == 0;  // from one eye; else each its own way
    const Vec3 eye = 300 * random.direction();
    std::vector<Ray> rays;
    for (int n = 0; n < RayLanes::kCount; ++n) {
      Vec3 target = 50 * random.direction();
      if (n % 4 == 0) target = on_needle + Vec3{30 * random.number(), 0, 0};
      if (n % 4 == 1) target = as_double(mesh.positions[random.below(mesh.positions.size())]);
      const Vec3 from = run_together ? eye : 200 * random.direction();
      rays.push_back({from, normalize(target - from)});
    }
    const float begin = packet % 3 == 0 ? 0 : 150, end = packet % 3 == 2 ? 210 : 1e9f;
    Case one{in_lanes(rays, begin, end), packet == 5 ? 0x00ff00f0 : ~0u, {}};
    for (const Ray& ray : rays) one.wanted.push_back(first_of(mesh, ray, begin, end));
    cases.push_back(one);
  }
  return cases;
}

TEST(MeshSurface, rays_side_by_side_meet_what_trying_all_triangles_finds_on_every_instruction_set) {
  // With a needle that is longer than the head, and narrower than Embree's floats can tell.
  Mesh mesh = extract_isosurface(head_phantom(24), 300);
  const auto first = static_cast<std::uint32_t>(mesh.positions.size());
  for (const Vec3f& p : {Vec3f{-90, -100, 1}, Vec3f{90, -100, 1}, Vec3f{0, -100, 1.0001f}}) {
    mesh.positions.push_back(p);
  }
  mesh.triangles.push_back({first, first + 1, first + 2});
  const auto needle = static_cast<std::uint32_t>(mesh.triangles.size() - 1);
  const std::vector<Case> cases = cases_for(mesh, {0, -100, 1.00005});
  on_every_instruction_set([&](const std::string& set) {
    const MeshSurface surface(std::make_shared<const Mesh>(mesh));
    int hits_of_needle = 0, hits = 0;
    for (const Case& one : cases) {
      MeshHitLanes found;
      surface.first_hits(one.rays, one.asked, found);
      EXPECT_EQ(surface.occluded(one.rays, one.asked), found.hit);  // no hit lies just at the end
      EXPECT_EQ(found.hit & ~one.asked, 0u);
      for (std::size_t n = 0; n < RayLanes::kCount; ++n) {
        if (!(one.asked >> n & 1)) continue;
        const auto& wanted = one.wanted[n];
        ASSERT_EQ(found.hit >> n & 1, wanted.has_value()) << set << " " << n;
        if (!wanted) continue;
        ++hits;
        hits_of_needle += wanted->triangle == needle;
        EXPECT_EQ(found.triangle[n], wanted->triangle);
        EXPECT_EQ(found.t[n], wanted->t);
      }
    }
    EXPECT_GT(hits, 300);
    EXPECT_GT(hits_of_needle, 20);
  });
}

TEST(MeshSurface, rays_at_vertices_and_edges_of_a_closed_mesh_cross_it_an_even_number_of_times) {
  const Mesh& mesh = *head();
  RandomRays random;
  for (int n = 0; n < 400; ++n) {
    const Mesh::Triangle& triangle = mesh.triangles[random.below(mesh.triangles.size())];
    const auto [a, b, c] = corners(mesh, triangle);
    Vec3 target = a;
    if (n % 2) target = 0.5 * (a + b);
    // Along an axis the shear is nothing, so that edges are met exactly.
    Vec3 direction = random.direction();
    if (n % 4 > 1)
      direction = n % 3 == 0 ? Vec3{1, 0, 0} : n % 3 == 1 ? Vec3{0, 1, 0} : Vec3{0, 0, -1};
    const Ray ray{target - 512 * direction, direction};
    EXPECT_EQ(all_hits(mesh, ray).size() % 2, 0u) << n;
  }
}

TEST(MeshSurface, a_ray_along_an_edge_of_two_triangles_meets_exactly_one) {
  Mesh square;
  square.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  square.triangles = {{0, 1, 2}, {0, 2, 3}};
  for (const double at : {0.0, 0.25, 0.5, 1.0}) {
    for (const double z : {1.0, -1.0}) {
      const auto hits = all_hits(square, {{at, at, z}, {0, 0, -z}});
      // The ends are on the border: there the square may or may not have it.
      if (at > 0 && at < 1) {
        EXPECT_EQ(hits.size(), 1u);
      } else {
        EXPECT_LE(hits.size(), 1u);
      }
      for (const MeshHit& hit : hits) EXPECT_EQ(hit.t, 1);
    }
  }
}

TEST(MeshSurface, of_two_triangles_in_one_place_the_lower_number_is_met) {
  Mesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  mesh.triangles = {{0, 1, 2}, {0, 1, 2}, {1, 2, 0}};
  const MeshSurface surface(std::make_shared<const Mesh>(mesh));
  const auto hit = surface.first_hit({{0.25, 0.25, 3}, {0, 0, -1}});
  ASSERT_TRUE(hit.has_value());
  EXPECT_EQ(hit->triangle, 0u);
  EXPECT_EQ(hit->t, 3);
  EXPECT_EQ(hit->u, 0.25);
  EXPECT_EQ(hit->v, 0.25);
}

TEST(MeshSurface, triangles_without_area_are_met_by_nothing_and_harm_nothing) {
  Mesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}};
  mesh.triangles = {{0, 1, 2}};
  const MeshSurface surface(std::make_shared<const Mesh>(mesh));
  EXPECT_FALSE(surface.first_hit({{0.5, 0, 3}, {0, 0, -1}}).has_value());
  EXPECT_FALSE(surface.any_hit({{0.5, -1, 0}, {0, 1, 0}}, 0, kInfinity));
}

// ctest gives each test a process of its own, so that Embree is the first to use threads here.
TEST(MeshSurface, building_its_tree_leaves_the_arithmetic_of_small_numbers_alone) {
  Mesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  mesh.triangles = {{0, 1, 2}};
  const MeshSurface surface(std::make_shared<const Mesh>(mesh));
  std::vector<double> halves(1000);
  volatile double smallest = std::numeric_limits<double>::min();
  parallel_for(halves.size(), 1,
               [&](std::size_t begin, std::size_t) { halves[begin] = smallest / 2; });
  for (const double half : halves) EXPECT_GT(half, 0);
}

}  // namespace
}  // namespace isolux
