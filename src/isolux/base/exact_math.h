#pragma once

// Elementary functions with the same bits on every x86-64 machine. The C library's choose another
// code path where the processor has fused multiply-add, and then differ in their last bit, which
// the promise "same bytes on every instruction set" cannot afford. Plain polynomials in double,
// compiled without contraction; relative error below 1e-14 for the arguments of a renderer.

namespace isolux::exact {

/// x to the power y, for x, y >= 0. pow(x, 0) = 1, pow(0, y) = 0 and pow(inf, y) = inf for y > 0.
double pow(double x, double y);
/// e to the power x. 0 below about -745, infinite above about 709.
double exp(double x);
/// Angles in radians, |x| up to about 1e6.
double sin(double x);
double cos(double x);
double tan(double x);

inline constexpr double kPi = 3.14159265358979323846;

inline double radians(double degrees) { return degrees * (kPi / 180.0); }

}  // namespace isolux::exact
