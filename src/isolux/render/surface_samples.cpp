#include "isolux/render/surface_samples.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

#include "isolux/base/exact_math.h"
#include "isolux/base/parallel.h"
#include "isolux/mesh/mesh_sheets.h"

namespace isolux {
namespace {

// Normals of one group make at most this cosine with the group's mean.
constexpr double kLikeness = 0.6;

// What lies within so many edges of blocks is close.
constexpr double kClose = 5;

struct Group {
  std::uint32_t sheet;
  Vec3 normals;    // sum
  Vec3 positions;  // sum
  int count = 0;
};

// Which group each place of a block belongs to.
template <typename SheetOf>
std::vector<Group> groups_of(std::span<const SurfacePlace> places, const SheetOf& sheet_of,
                             std::vector<std::size_t>& of) {
  std::vector<Group> groups;
  of.clear();
  for (const SurfacePlace& place : places) {
    const Vec3 normal = as_double(place.normal);
    const std::uint32_t sheet = sheet_of(place);
    std::size_t best = groups.size();
    double most = kLikeness;
    for (std::size_t g = 0; g < groups.size(); ++g) {
      const double likeness = dot(normal, groups[g].normals) / length(groups[g].normals);
      if (groups[g].sheet == sheet && likeness > most) {
        most = likeness;
        best = g;
      }
    }
    if (best == groups.size()) groups.push_back({sheet, {}, {}, 0});
    Group& group = groups[best];
    group.normals = group.normals + normal;
    group.positions = group.positions + place.position;
    ++group.count;
    of.push_back(best);
  }
  return groups;
}

}  // namespace

bool is_inside(const PreparedSurface& surface, Vec3 position, const MeshPoint& point, Vec3 outward,
               Vec3 direction) {
  const Vec3 normal = surface.true_normal(position, point).value_or(outward);
  // A triangle's normal is taken to be on the side of its vertices' normals.
  const bool opposes = surface.mesh() && dot(normal, outward) < 0;
  return dot(opposes ? -normal : normal, direction) > 0;
}

SurfaceSamples::SurfaceSamples(const SceneSurfaces& surfaces, int edge) {
  for (std::size_t s = 0; s < surfaces.all().size(); ++s) {
    add(surfaces.all()[s], static_cast<std::int32_t>(s), edge);
  }
}

void SurfaceSamples::add(const PreparedSurface& surface, std::int32_t number, int edge) {
  Grid& grid = grids_.emplace_back();
  grid.block_from_world = block_from_world(surface, edge);
  grid.blocks_from_covector = transpose(inverse(grid.block_from_world.linear));
  grid.close_mm =
      kClose / exact::pow(std::fabs(determinant(grid.block_from_world.linear)), 1.0 / 3);
  const std::vector<SurfacePlace> places = surface.lanes()
                                               ? places_of(*surface.lanes(), edge)
                                               : places_of(*surface.mesh(), grid.block_from_world);
  sheets_.push_back(surface.mesh() ? sheets_of(*surface.mesh()) : std::vector<std::uint32_t>());
  const auto sheet_of = [&](const SurfacePlace& place) { return sheet(number, place.point); };
  const auto starts_block = [&](std::size_t n) {
    return n == 0 || n == places.size() || !(places[n].block == places[n - 1].block);
  };
  // Of the blocks that begin in a piece; runs are counted from the piece's first site.
  struct Piece {
    std::vector<SampleSite> sites;
    std::vector<std::pair<BlockIndex, Run>> runs;
  };
  constexpr std::size_t kPlacesAPiece = 4096;
  std::vector<Piece> pieces((places.size() + kPlacesAPiece - 1) / kPlacesAPiece);
  const auto add_block = [&](std::span<const SurfacePlace> in_block, Piece& piece,
                             std::vector<std::size_t>& group_of) {
    const std::vector<Group> groups = groups_of(in_block, sheet_of, group_of);
    piece.runs.push_back({in_block[0].block,
                          {static_cast<std::uint32_t>(piece.sites.size()),
                           static_cast<std::uint32_t>(groups.size())}});
    for (std::size_t g = 0; g < groups.size(); ++g) {
      // The place nearest to the middle stands for its group.
      const Vec3 middle = groups[g].positions / groups[g].count;
      const SurfacePlace* nearest = nullptr;
      double least = std::numeric_limits<double>::infinity();
      for (std::size_t n = 0; n < in_block.size(); ++n) {
        const double distance = length(in_block[n].position - middle);
        if (group_of[n] != g || !(distance < least)) continue;
        least = distance;
        nearest = &in_block[n];
      }
      piece.sites.push_back(
          {nearest->position, as_float(grid.block_from_world.point(nearest->position)),
           nearest->normal, nearest->true_normal, number, nearest->point, groups[g].sheet});
    }
  };
  parallel_for(pieces.size(), 1, [&](std::size_t first, std::size_t last) {
    std::vector<std::size_t> group_of;
    for (std::size_t p = first; p < last; ++p) {
      std::size_t begin = p * kPlacesAPiece;
      while (!starts_block(begin)) ++begin;
      const std::size_t piece_end = std::min(places.size(), (p + 1) * kPlacesAPiece);
      for (std::size_t end; begin < piece_end; begin = end) {
        for (end = begin + 1; !starts_block(end);) ++end;
        add_block({&places[begin], end - begin}, pieces[p], group_of);
      }
    }
  });
  for (const Piece& piece : pieces) {
    for (const auto& [block, run] : piece.runs) {
      grid.add(block, {count() + run.first, run.count});
    }
    sites_.insert(sites_.end(), piece.sites.begin(), piece.sites.end());
  }
}

std::uint32_t SurfaceSamples::find_in_blocks(std::int32_t surface, Vec3 at, std::uint32_t sheet,
                                             Vec3 outward, SeenSide side) const {
  std::uint32_t found = kNone;
  double best = -std::numeric_limits<double>::infinity();
  const auto look = [&](std::uint32_t site) {
    // A turn by a right angle counts as much as two blocks' distance, another sheet as one.
    const double score = 2 * dot(as_double(sites_[site].normal), outward) -
                         length(as_double(sites_[site].in_blocks) - at) -
                         (sites_[site].sheet == sheet ? 0 : 1);
    if (score > best) {
      best = score;
      found = sample(site, side);
    }
  };
  const BlockIndex block = block_of(at);
  each_site(surface, block, block, look);
  // Nothing in its own block comes near enough to what there may be beside it.
  if (constexpr double kGood = 0; best >= kGood) return found;
  for (const std::int32_t reach : {1, 4}) {
    each_site(surface, {block[0] - reach, block[1] - reach, block[2] - reach},
              {block[0] + reach, block[1] + reach, block[2] + reach}, look);
    if (found != kNone) return found;
  }
  return kNone;
}

double SurfaceSamples::block_mm(std::int32_t surface) const {
  const auto& [x, y, z] = grids_[static_cast<std::size_t>(surface)].block_from_world.linear.column;
  return 1 / std::cbrt(std::fabs(dot(x, cross(y, z))));
}

double SurfaceSamples::bytes() const {
  double sum = static_cast<double>(sites_.size() * sizeof(SampleSite));
  for (const Grid& grid : grids_) sum += grid.bytes();
  for (const auto& sheets : sheets_) sum += static_cast<double>(sheets.size() * sizeof(sheets[0]));
  return sum;
}

std::uint64_t SurfaceSamples::Grid::key(const BlockIndex& at) {
  constexpr int kBits = 21;
  constexpr std::uint64_t kMask = (std::uint64_t{1} << kBits) - 1;
  const auto field = [](std::int32_t value) { return static_cast<std::uint64_t>(value) & kMask; };
  // The highest bit keeps it from being 0, which says that nothing is there.
  return std::uint64_t{1} << 63 | field(at[2]) << (2 * kBits) | field(at[1]) << kBits |
         field(at[0]);
}

namespace {

std::size_t hashed(std::uint64_t key) {
  key *= 0x9e3779b97f4a7c15u;
  return static_cast<std::size_t>(key ^ key >> 32);
}

}  // namespace

const SurfaceSamples::Row* SurfaceSamples::Grid::row(const BlockIndex& at) const {
  if (slots_.empty()) return nullptr;
  const std::uint64_t wanted = key(at);
  for (std::size_t n = hashed(wanted);; ++n) {
    const Slot& slot = slots_[n & (slots_.size() - 1)];
    if (slot.key == wanted) return &rows_[slot.place];
    if (slot.key == 0) return nullptr;
  }
}

void SurfaceSamples::Grid::add(const BlockIndex& block, Run run) {
  if (2 * (rows_.size() + 1) > slots_.size()) grow();
  const std::uint64_t wanted = key({block[0] >> kRowShift, block[1], block[2]});
  Slot& slot = slot_for(wanted);
  if (slot.key == 0) {
    slot = {wanted, static_cast<std::uint32_t>(rows_.size())};
    rows_.emplace_back();
  }
  rows_[slot.place][static_cast<std::size_t>(block[0] & (kRow - 1))] = run;
}

// The one that holds a key, or a free one for it.
SurfaceSamples::Grid::Slot& SurfaceSamples::Grid::slot_for(std::uint64_t wanted) {
  std::size_t n = hashed(wanted);
  while (true) {
    Slot& slot = slots_[n++ & (slots_.size() - 1)];
    if (slot.key == 0 || slot.key == wanted) return slot;
  }
}

void SurfaceSamples::Grid::grow() {
  const std::vector<Slot> before = std::move(slots_);
  slots_.assign(std::max<std::size_t>(64, 2 * before.size()), {});
  for (const Slot& slot : before) {
    if (slot.key != 0) slot_for(slot.key) = slot;
  }
}

double SurfaceSamples::Grid::bytes() const {
  return static_cast<double>(slots_.size() * sizeof(Slot) + rows_.size() * sizeof(Row));
}

}  // namespace isolux
