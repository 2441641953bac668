#pragma once

#include <cstdint>

namespace isolux {

/// A point of the unit square, [0, 1) x [0, 1).
struct UnitPoint {
  double u;
  double v;
};

/// A well-mixed number for each pair (the finalizer of MurmurHash3, Appleby 2011).
std::uint32_t mixed(std::uint32_t a, std::uint32_t b);

/// Point number `index` of a set that `seed` picks: the first two dimensions of the Sobol sequence,
/// of which every 2^n consecutive points from a multiple of 2^n lie one in each of the 2^n equal
/// boxes of any shape, with Owen's nested uniform scrambling, and in an order that is scrambled
/// likewise, so that sets of different seeds may be used beside each other. After Burley 2020,
/// "Practical hash-based Owen scrambling" (JCGT 9(4)), with the hash of Laine and Karras 2011.
UnitPoint sobol_point(std::uint32_t index, std::uint32_t seed);

}  // namespace isolux
