// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

/// Attitudes. A body frame has its axes right, forward, up of the vehicle, so that a level vehicle that heads north has
/// the axes of the local level frame, east, north, up [AH05 §3.2]. R turns body vectors into level ones.
namespace soak::nav {

/// Eigen has the product of its own in a header that costs seconds.
inline Eigen::Vector3d cross(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return {a.y() * b.z() - a.z() * b.y(), a.z() * b.x() - a.x() * b.z(), a.x() * b.y() - a.y() * b.x()};
}

/// The matrix [a×] with [a×] b = a × b.
[[nodiscard]] Eigen::Matrix3d skew(const Eigen::Vector3d& a);

/// A rotation as a unit quaternion; it turns vectors as the matrix of to_matrix() does.
struct Quaternion {
  double w = 1.0;
  double x = 0.0;
  double y = 0.0;
  double z = 0.0;
};

/// The rotation `b`, then `a`.
inline Quaternion operator*(const Quaternion& a, const Quaternion& b) {
  return {a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z, a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y,
          a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x, a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w};
}

/// The rotation about the vector's direction by its length in rad.
[[nodiscard]] Quaternion rotation_of(const Eigen::Vector3d& vector_rad);
/// The vector of a rotation, at most half a turn long.
[[nodiscard]] Eigen::Vector3d vector_of(const Quaternion& rotation);

[[nodiscard]] Quaternion normalized(const Quaternion& rotation);
[[nodiscard]] Eigen::Matrix3d to_matrix(const Quaternion& rotation);
/// The quaternion of a rotation matrix, w not negative.
[[nodiscard]] Quaternion quaternion_of(const Eigen::Matrix3d& matrix);

/// Heading from north to east, nose up, right side down, in rad.
struct Euler {
  double heading_rad = 0.0;
  double pitch_rad = 0.0;
  double roll_rad = 0.0;
};

/// R = Rz(-heading) Rx(pitch) Ry(roll).
[[nodiscard]] Eigen::Matrix3d matrix_of(const Euler& angles);
/// The angles of R, heading and roll from -π to π. At a pitch of ±90° heading and roll are not defined.
[[nodiscard]] Euler euler_of(const Eigen::Matrix3d& body_to_level);

}  // namespace soak::nav
