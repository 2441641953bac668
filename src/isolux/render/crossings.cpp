#include "isolux/render/crossings.h"

namespace isolux {

Crossings::Crossings(const PreparedSurface& surface, std::int32_t number, const RayPacket& rays)
    : surface_(surface), number_(number), rays_(rays) {}

double Crossings::step(int n) const { return surface_.step_mm() / length(rays_.ray(n).direction); }

void Crossings::find(std::uint32_t lanes, const double (&from)[RayPacket::kCount]) {
  // Rays start anew there, as doubles: so far from their origins floats are too coarse.
  RayPacket rest_of = rays_;
  hits_.hit &= ~lanes;
  for (std::uint32_t rest = lanes; rest != 0; rest &= rest - 1) {
    const int n = std::countr_zero(rest);
    const std::uint32_t bit = 1u << n;
    Ray ray = rays_.ray(n);
    ray.origin = ray.at(from[n]);
    rest_of.set(n, ray);
    rest_of.begin[n] = 0;
    rest_of.end[n] = static_cast<float>(rays_.end[n] - from[n]);
    if (!(rest_of.end[n] > 0)) lanes &= ~bit;
  }
  if (lanes == 0) return;
  surface_.first_hits(rest_of, lanes, number_, hits_);
  for (std::uint32_t rest = lanes & hits_.hit; rest != 0; rest &= rest - 1) {
    const int n = std::countr_zero(rest);
    hits_.t[n] += from[n];
    hits_.face(n, rays_.ray(n).direction);
  }
}

void Crossings::set_crossed(int n, double t, bool turned) {
  const std::uint32_t bit = 1u << n;
  hits_.hit |= bit;
  hits_.turned = turned ? hits_.turned | bit : hits_.turned & ~bit;
  hits_.t[n] = t;
}

void Crossings::pass(std::uint32_t lanes) {
  constexpr int kTries = 8;
  constexpr double kJustBehind = 100;  // steps
  for (int tries = 0; tries < kTries && lanes != 0; ++tries) {
    const std::uint32_t turned = hits_.turned;
    double from[RayPacket::kCount];
    for (std::uint32_t rest = lanes; rest != 0; rest &= rest - 1) {
      const int n = std::countr_zero(rest);
      from[n] = hits_.t[n] + step(n);
    }
    find(lanes, from);
    std::uint32_t again = 0;
    for (std::uint32_t rest = lanes & hits_.hit & ~(turned ^ hits_.turned); rest != 0;
         rest &= rest - 1) {
      const int n = std::countr_zero(rest);
      if (hits_.t[n] - from[n] < kJustBehind * step(n)) again |= 1u << n;
    }
    lanes = again;
  }
}

}  // namespace isolux
