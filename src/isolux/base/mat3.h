#pragma once

#include "isolux/base/vec3.h"

namespace isolux {

/// A 3x3 matrix, held as its three columns.
struct Mat3 {
  Vec3 column[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};

  double at(int row, int col) const { return column[col][row]; }
  bool operator==(const Mat3&) const = default;
};

inline Mat3 diagonal(Vec3 d) { return {{{d.x, 0, 0}, {0, d.y, 0}, {0, 0, d.z}}}; }
inline Vec3 operator*(const Mat3& m, Vec3 v) {
  return v.x * m.column[0] + v.y * m.column[1] + v.z * m.column[2];
}
inline Mat3 operator*(const Mat3& a, const Mat3& b) {
  return {{a * b.column[0], a * b.column[1], a * b.column[2]}};
}
inline double determinant(const Mat3& m) {
  return dot(m.column[0], cross(m.column[1], m.column[2]));
}
inline Mat3 transpose(const Mat3& m) {
  return {{{m.at(0, 0), m.at(0, 1), m.at(0, 2)},
           {m.at(1, 0), m.at(1, 1), m.at(1, 2)},
           {m.at(2, 0), m.at(2, 1), m.at(2, 2)}}};
}

/// The inverse. Entries are not finite where `m` is singular.
inline Mat3 inverse(const Mat3& m) {
  const double det = determinant(m);
  const Mat3 rows{{cross(m.column[1], m.column[2]) / det, cross(m.column[2], m.column[0]) / det,
                   cross(m.column[0], m.column[1]) / det}};
  return transpose(rows);
}

}  // namespace isolux
