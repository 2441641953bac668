#include "isolux/base/sobol.h"

#include <initializer_list>

namespace isolux {
namespace {

std::uint32_t reversed(std::uint32_t bits) {
  bits = (bits & 0x55555555u) << 1 | (bits >> 1 & 0x55555555u);
  bits = (bits & 0x33333333u) << 2 | (bits >> 2 & 0x33333333u);
  bits = (bits & 0x0f0f0f0fu) << 4 | (bits >> 4 & 0x0f0f0f0fu);
  bits = (bits & 0x00ff00ffu) << 8 | (bits >> 8 & 0x00ff00ffu);
  return bits << 16 | bits >> 16;
}

// Changes each bit by a hash of the lower ones alone.
std::uint32_t scrambled_upwards(std::uint32_t bits, std::uint32_t seed) {
  bits += seed;
  for (const std::uint32_t even : {0x6c50b47cu, 0xb82f1e52u, 0xc7afe638u, 0x8d22f6e6u}) {
    bits ^= bits * even;
  }
  return bits;
}

// Owen's scrambling of bits already reversed.
std::uint32_t scrambled(std::uint32_t reversed_bits, std::uint32_t seed) {
  return reversed(scrambled_upwards(reversed_bits, seed));
}

// The second dimension's digits, highest last: each column of its matrix is the one before, added
// to itself moved by a digit.
std::uint32_t second_dimension_reversed(std::uint32_t index) {
  std::uint32_t digits = 0, column = 1;
  for (; index != 0; index >>= 1, column ^= column << 1) {
    if (index & 1) digits ^= column;
  }
  return digits;
}

double unit(std::uint32_t bits) { return bits * 0x1p-32; }

}  // namespace

std::uint32_t mixed(std::uint32_t a, std::uint32_t b) {
  std::uint32_t bits = a * 0x9e3779b9u ^ (b + 0x7f4a7c15u + (a << 6) + (a >> 2));
  bits = (bits ^ bits >> 16) * 0x85ebca6bu;
  bits = (bits ^ bits >> 13) * 0xc2b2ae35u;
  return bits ^ bits >> 16;
}

UnitPoint sobol_point(std::uint32_t index, std::uint32_t seed) {
  const std::uint32_t shuffled = scrambled(reversed(index), seed);
  // The first dimension is the index with its digits the other way round.
  return {unit(scrambled(shuffled, mixed(seed, 1))),
          unit(scrambled(second_dimension_reversed(shuffled), mixed(seed, 2)))};
}

}  // namespace isolux
