// SPDX-License-Identifier: Apache-2.0
#include "nav/geometry/attitude.h"

#include <algorithm>
#include <cmath>

namespace soak::nav {

Eigen::Matrix3d skew(const Eigen::Vector3d& a) {
  Eigen::Matrix3d matrix;
  matrix << 0.0, -a.z(), a.y(), a.z(), 0.0, -a.x(), -a.y(), a.x(), 0.0;
  return matrix;
}

Quaternion rotation_of(const Eigen::Vector3d& vector_rad) {
  const double half2 = 0.25 * vector_rad.squaredNorm();
  // sin(h)/h and cos(h): by their series where the fourth order is below the last digit.
  if (half2 < 1e-4) {
    const double s = 0.5 * (1.0 - half2 / 6.0 * (1.0 - half2 / 20.0 * (1.0 - half2 / 42.0)));
    const double w = 1.0 - half2 / 2.0 * (1.0 - half2 / 12.0 * (1.0 - half2 / 30.0));
    return {w, s * vector_rad.x(), s * vector_rad.y(), s * vector_rad.z()};
  }
  const double half = std::sqrt(half2);
  const double s = 0.5 * std::sin(half) / half;
  return {std::cos(half), s * vector_rad.x(), s * vector_rad.y(), s * vector_rad.z()};
}

Eigen::Vector3d vector_of(const Quaternion& rotation) {
  const double sign = rotation.w < 0.0 ? -1.0 : 1.0;
  const Eigen::Vector3d imaginary(sign * rotation.x, sign * rotation.y, sign * rotation.z);
  const double sine = imaginary.norm();
  if (sine < 1e-12) return 2.0 * imaginary;
  return 2.0 * std::atan2(sine, sign * rotation.w) / sine * imaginary;
}

Quaternion normalized(const Quaternion& rotation) {
  const double scale = 1.0 / std::sqrt(rotation.w * rotation.w + rotation.x * rotation.x + rotation.y * rotation.y +
                                       rotation.z * rotation.z);
  return {scale * rotation.w, scale * rotation.x, scale * rotation.y, scale * rotation.z};
}

Eigen::Matrix3d to_matrix(const Quaternion& q) {
  Eigen::Matrix3d matrix;
  matrix << 1.0 - 2.0 * (q.y * q.y + q.z * q.z), 2.0 * (q.x * q.y - q.w * q.z), 2.0 * (q.x * q.z + q.w * q.y),
      2.0 * (q.x * q.y + q.w * q.z), 1.0 - 2.0 * (q.x * q.x + q.z * q.z), 2.0 * (q.y * q.z - q.w * q.x),
      2.0 * (q.x * q.z - q.w * q.y), 2.0 * (q.y * q.z + q.w * q.x), 1.0 - 2.0 * (q.x * q.x + q.y * q.y);
  return matrix;
}

Quaternion quaternion_of(const Eigen::Matrix3d& m) {
  // Of the four ways to begin, the one whose divisor is largest.
  const double trace = m.trace();
  Quaternion q;
  if (trace > std::max({m(0, 0), m(1, 1), m(2, 2)})) {
    q = {1.0 + trace, m(2, 1) - m(1, 2), m(0, 2) - m(2, 0), m(1, 0) - m(0, 1)};
  } else if (m(0, 0) >= m(1, 1) && m(0, 0) >= m(2, 2)) {
    q = {m(2, 1) - m(1, 2), 1.0 + 2.0 * m(0, 0) - trace, m(0, 1) + m(1, 0), m(0, 2) + m(2, 0)};
  } else if (m(1, 1) >= m(2, 2)) {
    q = {m(0, 2) - m(2, 0), m(0, 1) + m(1, 0), 1.0 + 2.0 * m(1, 1) - trace, m(1, 2) + m(2, 1)};
  } else {
    q = {m(1, 0) - m(0, 1), m(0, 2) + m(2, 0), m(1, 2) + m(2, 1), 1.0 + 2.0 * m(2, 2) - trace};
  }
  if (q.w < 0.0) q = {-q.w, -q.x, -q.y, -q.z};
  return normalized(q);
}

Eigen::Matrix3d matrix_of(const Euler& angles) {
  const double sh = std::sin(angles.heading_rad);
  const double ch = std::cos(angles.heading_rad);
  const double sp = std::sin(angles.pitch_rad);
  const double cp = std::cos(angles.pitch_rad);
  const double sr = std::sin(angles.roll_rad);
  const double cr = std::cos(angles.roll_rad);
  Eigen::Matrix3d r;
  r << ch * cr + sh * sp * sr, sh * cp, ch * sr - sh * sp * cr,   //
      -sh * cr + ch * sp * sr, ch * cp, -sh * sr - ch * sp * cr,  //
      -cp * sr, sp, cp * cr;
  return r;
}

Euler euler_of(const Eigen::Matrix3d& r) {
  return {std::atan2(r(0, 1), r(1, 1)), std::asin(std::clamp(r(2, 1), -1.0, 1.0)), std::atan2(-r(2, 0), r(2, 2))};
}

}  // namespace soak::nav
