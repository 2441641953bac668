#define HWY_DISABLED_TARGETS HWY_SSSE3
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "isolux/render/relight_lanes.cpp"
#include <hwy/foreach_target.h>
// Highway compiles what follows once for each instruction set.
#include <hwy/highway.h>

#include <cstring>

#include "isolux/base/lane_math-inl.h"
#include "isolux/render/relight_inputs.h"

HWY_BEFORE_NAMESPACE();
namespace isolux::relighting::HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

#if HWY_TARGET == HWY_SCALAR

// A machine without SSE4: the plain form does everything.
void light_tiles(const Inputs& in, std::size_t begin, std::size_t end, const Outputs& out) {
  light_plainly(in, begin, end, out);
}

void show_tiles(const Inputs& in, std::size_t begin, std::size_t end, const Outputs& out) {
  show_plainly(in, begin, end, out);
}

void light_further_tiles(const Inputs& in, std::size_t begin, std::size_t end, const Outputs& out) {
  light_further_plainly(in, begin, end, out);
}

#else

using isolux::HWY_NAMESPACE::lane_pow_of_1_minus;

constexpr hn::CappedTag<float, SurfaceBuffer::kBlockPixels> kF;
constexpr hn::RebindToSigned<decltype(kF)> kI;
using VF = hn::Vec<decltype(kF)>;
using VI = hn::Vec<decltype(kI)>;
using MF = hn::Mask<decltype(kF)>;

struct Vector {
  VF x, y, z;
};

HWY_INLINE VF all(float value) { return hn::Set(kF, value); }
HWY_INLINE VF dot(const Vector& a, const Vector& b) {
  return hn::MulAdd(a.z, b.z, hn::MulAdd(a.y, b.y, hn::Mul(a.x, b.x)));
}
HWY_INLINE Vector scaled(const Vector& a, VF s) {
  return {hn::Mul(a.x, s), hn::Mul(a.y, s), hn::Mul(a.z, s)};
}

// Which lanes of the vector at `first` are set in the block's sixteen bits.
HWY_INLINE MF mask_of(std::uint32_t block_bits, std::size_t first) {
  const std::uint32_t mine = block_bits >> first;
  const std::uint8_t bits[8] = {static_cast<std::uint8_t>(mine),
                                static_cast<std::uint8_t>(mine >> 8)};
  return hn::LoadMaskBits(kF, bits);
}

HWY_INLINE Vector plane_at(const float (&first)[3], const float (&along_x)[3],
                           const float (&along_y)[3], VF x, VF y) {
  const auto one = [&](int a) HWY_ATTR {
    return hn::MulAdd(y, all(along_y[a]), hn::MulAdd(x, all(along_x[a]), all(first[a])));
  };
  return {one(0), one(1), one(2)};
}

struct Terms {
  VF ambient[3], diffuse[3], specular[3];
};

// One vector's lanes as the reflection model sees them. Positions are relative to the eye.
struct Points {
  Vector position, normal, to_eye;
};

HWY_INLINE Points points_at(const Inputs& in, std::size_t place, int x0, int y0,
                            std::size_t first) {
  const VI lane = hn::Iota(kI, static_cast<std::int32_t>(first));
  const VF x = hn::ConvertTo(kF, hn::Add(hn::And(lane, hn::Set(kI, 3)), hn::Set(kI, x0)));
  const VF y = hn::ConvertTo(kF, hn::Add(hn::ShiftRight<2>(lane), hn::Set(kI, y0)));
  const Vector along = plane_at(in.direction[0], in.direction[1], in.direction[2], x, y);
  const VF scale = hn::Div(all(1.0f), hn::Sqrt(dot(along, along)));
  const Vector forward = scaled(along, scale);
  const double* const from = in.buffer->depth_mm.data() + place;
  const hn::Rebind<double, hn::Half<decltype(kF)> > kD;
  const hn::Half<decltype(kF)> half;
  const VF depth = hn::Combine(kF, hn::DemoteTo(half, hn::LoadU(kD, from + hn::Lanes(kD))),
                               hn::DemoteTo(half, hn::LoadU(kD, from)));
  Vector position = scaled(forward, depth);
  if (in.is_orthographic) {
    const Vector origin = plane_at(in.origin[0], in.origin[1], in.origin[2], x, y);
    position = {hn::Add(position.x, origin.x), hn::Add(position.y, origin.y),
                hn::Add(position.z, origin.z)};
  }
  return {position,
          {hn::LoadU(kF, in.buffer->normal_x.data() + place),
           hn::LoadU(kF, in.buffer->normal_y.data() + place),
           hn::LoadU(kF, in.buffer->normal_z.data() + place)},
          {hn::Neg(forward.x), hn::Neg(forward.y), hn::Neg(forward.z)}};
}

// `share`: of the light that shadows leave; null: all.
HWY_INLINE void add_lamp(const Inputs::Surface& surface, const Inputs::Lamp& lamp,
                         const float* share, const Points& at, Terms& terms) {
  const VF zero = hn::Zero(kF), one = all(1.0f);
  Vector to_light{all(lamp.place[0]), all(lamp.place[1]), all(lamp.place[2])};
  VF falloff = one;
  MF lit = hn::FirstN(kF, hn::Lanes(kF));
  if (lamp.is_point) {
    to_light = {hn::Sub(to_light.x, at.position.x), hn::Sub(to_light.y, at.position.y),
                hn::Sub(to_light.z, at.position.z)};
    const VF square = dot(to_light, to_light);
    lit = hn::Gt(square, zero);
    to_light = scaled(to_light, hn::Div(one, hn::Sqrt(square)));
    if (lamp.reference_square > 0) falloff = hn::Div(all(lamp.reference_square), square);
  }
  if (share) falloff = hn::Mul(falloff, hn::LoadU(kF, share));
  const VF cos_theta = dot(at.normal, to_light);
  lit = hn::And(lit, hn::Gt(cos_theta, zero));
  // r - e, with r = 2 (n . l) n - l. Half its square is 1 - r . e, and keeps all digits where a
  // large exponent needs them: near the middle of the highlight.
  const VF twice = hn::Add(cos_theta, cos_theta);
  const Vector off{hn::Sub(hn::MulSub(twice, at.normal.x, to_light.x), at.to_eye.x),
                   hn::Sub(hn::MulSub(twice, at.normal.y, to_light.y), at.to_eye.y),
                   hn::Sub(hn::MulSub(twice, at.normal.z, to_light.z), at.to_eye.z)};
  const VF u = hn::Min(hn::Mul(all(0.5f), dot(off, off)), one);
  const VF phong = surface.shininess == 0 ? one : lane_pow_of_1_minus(kF, u, surface.shininess);
  const VF lambert = hn::IfThenElseZero(lit, hn::Mul(cos_theta, falloff));
  const VF highlight = hn::IfThenElseZero(lit, hn::Mul(phong, falloff));
  for (int c = 0; c < 3; ++c) {
    const float kd = surface.kd[c] * lamp.intensity[c], ks = surface.ks[c] * lamp.intensity[c];
    terms.diffuse[c] = hn::MulAdd(lambert, all(kd), terms.diffuse[c]);
    terms.specular[c] = hn::MulAdd(highlight, all(ks), terms.specular[c]);
  }
}

HWY_INLINE VI bytes_of(const Inputs& in, VF radiance) {
  const DisplayTable& table = *in.table;
  const VI bits = hn::BitCast(kI, hn::Max(radiance, hn::Zero(kF)));
  const VI bucket = hn::Min(hn::Max(hn::Sub(hn::ShiftRight<DisplayTable::kBucketShift>(bits),
                                            hn::Set(kI, table.first_bucket())),
                                    hn::Zero(kI)),
                            hn::Set(kI, table.buckets() - 1));
  const VI base = hn::GatherIndex(kI, table.bases(), bucket);
  const VF next = hn::GatherIndex(kF, table.least() + 1, base);
  const VI more = hn::VecFromMask(kI, hn::RebindMask(kI, hn::Ge(radiance, next)));  // -1 or 0
  return hn::Sub(base, more);
}

// As write_block, for a block that lies wholly inside the picture.
HWY_INLINE void write_whole_block(const std::uint32_t* pixels, Picture& picture, int x0, int y0) {
  constexpr hn::CappedTag<std::uint8_t, 16> kBytes;
  alignas(16) static constexpr std::uint8_t kColours[16] = {0,  1,  2,  4,  5, 6, 8,  9,
                                                            10, 12, 13, 14, 3, 7, 11, 15};
  const auto colours = hn::Load(kBytes, kColours);
  const std::size_t stride = 3 * static_cast<std::size_t>(picture.width);
  std::uint8_t* row = picture.rgb.data() + static_cast<std::size_t>(y0) * stride + 3 * x0;
  for (int y = 0; y < 4; ++y, row += stride) {
    alignas(16) std::uint8_t packed[16];
    const auto four = hn::Load(kBytes, reinterpret_cast<const std::uint8_t*>(pixels + 4 * y));
    hn::Store(hn::TableLookupBytes(four, colours), kBytes, packed);
    std::memcpy(row, packed, 12);
  }
}

// The bytes of a block.
void show_block(const Inputs& in, const Outputs& out, std::size_t place, int x0, int y0,
                std::uint32_t hits) {
  alignas(64) std::uint32_t pixels[SurfaceBuffer::kBlockPixels];
  const hn::RebindToUnsigned<decltype(kF)> kU;
  for (std::size_t first = 0; first < SurfaceBuffer::kBlockPixels; first += hn::Lanes(kF)) {
    const std::size_t at = place + first;
    const VF red = hn::LoadU(kF, out.total->r.data() + at),
             green = hn::LoadU(kF, out.total->g.data() + at),
             blue = hn::LoadU(kF, out.total->b.data() + at);
    const MF lit = mask_of(hits, first);
    const MF grey = hn::And(hn::Eq(red, green), hn::Eq(red, blue));
    const VI r = bytes_of(in, red);
    VI g = r, b = r;
    if (!hn::AllFalse(kF, hn::AndNot(grey, lit))) {
      g = bytes_of(in, green);
      b = bytes_of(in, blue);
    }
    const VI rgb = hn::Or(r, hn::Or(hn::ShiftLeft<8>(g), hn::ShiftLeft<16>(b)));
    const auto hit = hn::RebindMask(kI, lit);
    const VI background = hn::Set(kI, static_cast<std::int32_t>(in.background_bytes));
    hn::Store(hn::BitCast(kU, hn::IfThenElse(hit, rgb, background)), kU, pixels + first);
  }
  if (x0 + 4 <= out.picture->width && y0 + 4 <= out.picture->height) {
    write_whole_block(pixels, *out.picture, x0, y0);
  } else {
    write_block(pixels, *out.picture, x0, y0);
  }
}

// Ambient light, or kd E in its place; `irradiance` has the three channels of E, or nulls.
HWY_INLINE Terms without_lamps(const Inputs::Surface& surface,
                               const float* const (&irradiance)[3]) {
  Terms terms;
  for (int c = 0; c < 3; ++c) {
    terms.ambient[c] = irradiance[c] ? hn::Mul(all(surface.kd[c]), hn::LoadU(kF, irradiance[c]))
                                     : all(surface.ambient[c]);
    terms.diffuse[c] = terms.specular[c] = hn::Zero(kF);
  }
  return terms;
}

void light_block(const Inputs& in, const Outputs& out, std::size_t place, int x0, int y0,
                 std::uint32_t hits) {
  for (std::size_t first = 0; first < SurfaceBuffer::kBlockPixels; first += hn::Lanes(kF)) {
    const std::size_t at = place + first;
    std::uint32_t pending = hits >> first & ((1u << hn::Lanes(kF)) - 1);
    if (pending == 0) continue;
    const Points points = points_at(in, at, x0, y0, first);
    const VI numbers = hn::LoadU(kI, in.buffer->surface.data() + at);
    // All lanes of one surface at a time; nearly always there is but one.
    while (pending != 0) {
      const std::int32_t number =
          in.buffer->surface[at + hwy::Num0BitsBelowLS1Bit_Nonzero32(pending)];
      const MF mine = hn::RebindMask(kF, hn::Eq(numbers, hn::Set(kI, number)));
      const MF lanes = hn::And(mine, mask_of(pending << first, first));
      std::uint8_t bits[8] = {};
      hn::StoreMaskBits(kF, lanes, bits);
      pending &= ~static_cast<std::uint32_t>(bits[0] | bits[1] << 8);

      const Inputs::Surface& surface = in.surfaces[static_cast<std::size_t>(number)];
      const float* irradiance[3] = {};
      for (int c = 0; c < 3 && !in.indirect->empty(); ++c) {
        irradiance[c] = in.indirect->pixels.channel(c) + at;
      }
      Terms terms = without_lamps(surface, irradiance);
      for (std::size_t l = 0; l < in.lamps.size(); ++l) {
        const bool is_dimmed = !in.shadows->empty();
        const float* share = is_dimmed ? in.shadows->pixels[l].data() + at : nullptr;
        add_lamp(surface, in.lamps[l], share, points, terms);
      }
      for (int c = 0; c < 3; ++c) {
        const VF total = hn::Add(hn::Add(terms.ambient[c], terms.diffuse[c]), terms.specular[c]);
        hn::BlendedStore(total, lanes, kF, out.total->channel(c) + at);
        if (!out.ambient) continue;
        hn::BlendedStore(terms.ambient[c], lanes, kF, out.ambient->channel(c) + at);
        hn::BlendedStore(terms.diffuse[c], lanes, kF, out.diffuse->channel(c) + at);
        hn::BlendedStore(terms.specular[c], lanes, kF, out.specular->channel(c) + at);
      }
    }
  }
}

// A vector's worth of further points, beginning with number `first` of a tile.
void light_further(const Inputs& in, const Outputs& out, std::size_t tile, std::size_t first) {
  const FurtherPoints& further = in.buffer->further[tile];
  const std::size_t count = std::min(hn::Lanes(kF), further.size() - first);
  alignas(64) float vectors[9][SurfaceBuffer::kBlockPixels] = {};
  for (std::size_t n = 0; n < count; ++n) {
    const FurtherPoint& point = further[first + n];
    for (int a = 0; a < 3; ++a) {
      vectors[a][n] = static_cast<float>(point.position[a] - in.eye[a]);
      vectors[3 + a][n] = point.normal[a];
      vectors[6 + a][n] = point.to_eye[a];
    }
  }
  const auto vector = [&](int at) HWY_ATTR {
    return Vector{hn::Load(kF, vectors[at]), hn::Load(kF, vectors[at + 1]),
                  hn::Load(kF, vectors[at + 2])};
  };
  const Points points{vector(0), vector(3), vector(6)};
  alignas(64) float lit[9][SurfaceBuffer::kBlockPixels] = {};
  std::int32_t of_surface = FurtherPoint::kBackground;
  for (std::size_t n = 0; n < count; ++n) {
    const FurtherPoint& point = further[first + n];
    const bool is_background = point.surface == FurtherPoint::kBackground;
    if (!is_background && in.scene->surfaces[static_cast<std::size_t>(point.surface)].is_painted) {
      add_further_plainly(in, tile, first + n, out);
      continue;
    }
    // Neighbours are mostly of one surface: all lanes are lit as of this one, until another comes.
    if (!is_background && point.surface != of_surface) {
      of_surface = point.surface;
      const Inputs::Surface& surface = in.surfaces[static_cast<std::size_t>(of_surface)];
      alignas(64) float e[3][SurfaceBuffer::kBlockPixels] = {};
      const bool is_indirect = !in.indirect->empty();
      for (std::size_t m = 0; is_indirect && m < count; ++m) {
        const auto& of_point = in.indirect->further[tile][first + m];
        for (std::size_t c = 0; c < 3; ++c) e[c][m] = of_point[c];
      }
      const float* irradiance[3] = {};
      for (int c = 0; c < 3 && is_indirect; ++c) irradiance[c] = e[c];
      Terms terms = without_lamps(surface, irradiance);
      for (std::size_t l = 0; l < in.lamps.size(); ++l) {
        alignas(64) float shares[SurfaceBuffer::kBlockPixels] = {};
        const bool is_dimmed = !in.shadows->empty();
        for (std::size_t m = 0; is_dimmed && m < count; ++m) {
          shares[m] = in.shadows->further[tile][l * further.size() + first + m];
        }
        add_lamp(surface, in.lamps[l], is_dimmed ? shares : nullptr, points, terms);
      }
      for (int c = 0; c < 3; ++c) {
        hn::Store(terms.ambient[c], kF, lit[c]);
        hn::Store(terms.diffuse[c], kF, lit[3 + c]);
        hn::Store(terms.specular[c], kF, lit[6 + c]);
      }
    }
    const float ambient[3] = {lit[0][n], lit[1][n], lit[2][n]};
    const float diffuse[3] = {lit[3][n], lit[4][n], lit[5][n]};
    const float specular[3] = {lit[6][n], lit[7][n], lit[8][n]};
    add_further(in, tile, point, ambient, diffuse, specular, out);
  }
}

// Calls light or show for each block of tiles [begin, end) that has hits.
template <bool kLight>
HWY_INLINE void each_block(const Inputs& in, std::size_t begin, std::size_t end,
                           const Outputs& out) {
  const SurfaceBuffer& buffer = *in.buffer;
  const auto tiles_x = static_cast<std::size_t>(buffer.tiles_x());
  for (std::size_t tile = begin; tile < end; ++tile) {
    const std::uint64_t hits = buffer.hits[tile];
    const std::uint64_t drawn = out.drawn ? (*out.drawn)[tile] : 0;
    if ((hits | drawn) == 0) continue;
    for (std::size_t block = 0; block < 4; ++block) {
      const auto block_hits = static_cast<std::uint32_t>(hits >> (16 * block) & 0xFFFF);
      if (block_hits == 0 && (drawn >> (16 * block) & 0xFFFF) == 0) continue;
      const int x0 = static_cast<int>(8 * (tile % tiles_x) + 4 * (block & 1));
      const int y0 = static_cast<int>(8 * (tile / tiles_x) + 4 * (block >> 1));
      const std::size_t place = 64 * tile + 16 * block;
      if (kLight && block_hits != 0) {
        light_block(in, out, place, buffer.first_x + x0, buffer.first_y + y0, block_hits);
      }
      if (out.picture) show_block(in, out, place, x0, y0, block_hits);
    }
  }
}

void light_tiles(const Inputs& in, std::size_t begin, std::size_t end, const Outputs& out) {
  each_block<true>(in, begin, end, out);
}

void show_tiles(const Inputs& in, std::size_t begin, std::size_t end, const Outputs& out) {
  each_block<false>(in, begin, end, out);
}

void light_further_tiles(const Inputs& in, std::size_t begin, std::size_t end, const Outputs& out) {
  for (std::size_t tile = begin; tile < end; ++tile) {
    for (std::size_t n = 0; n < in.buffer->further[tile].size(); n += hn::Lanes(kF)) {
      light_further(in, out, tile, n);
    }
  }
}

#endif

}  // namespace
}  // namespace isolux::relighting::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace isolux::relighting {

HWY_EXPORT(light_tiles);
HWY_EXPORT(light_further_tiles);
HWY_EXPORT(show_tiles);

void light(const Inputs& in, std::size_t begin, std::size_t end, const Outputs& out) {
  const bool has_further = !in.buffer->further.empty();
  if (!in.has_painted && !has_further) {
    HWY_DYNAMIC_DISPATCH(light_tiles)(in, begin, end, out);
    return;
  }
  Outputs undrawn = out;
  undrawn.picture = nullptr;
  undrawn.drawn = nullptr;
  HWY_DYNAMIC_DISPATCH(light_tiles)(in, begin, end, undrawn);
  if (in.has_painted) light_painted(in, begin, end, undrawn);
  if (has_further) HWY_DYNAMIC_DISPATCH(light_further_tiles)(in, begin, end, undrawn);
  if (out.picture) show(in, begin, end, out);
}

void show(const Inputs& in, std::size_t begin, std::size_t end, const Outputs& out) {
  HWY_DYNAMIC_DISPATCH(show_tiles)(in, begin, end, out);
}

}  // namespace isolux::relighting
#endif
