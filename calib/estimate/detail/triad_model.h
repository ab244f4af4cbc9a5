// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <span>

#include "calib/estimate/multi_position.h"

namespace soak::calib::multi_position {

/// Parameters in the order of TriadParameter.
using Parameters = Eigen::Matrix<double, 9, 1>;

/// f = M⁻¹·diag(k)⁻¹·(raw − b).
[[nodiscard]] Eigen::Vector3d specific_force(const Parameters& p, const Eigen::Vector3d& raw);

/// Derivative of |f| by the nine parameters. That by the raw readings is −1 times its first three entries.
[[nodiscard]] Parameters magnitude_gradient(const Parameters& p, const Eigen::Vector3d& raw);

/// What one unit of each parameter means to a reading of 1 g: k·g for biases, k for scales, 1 for misalignments.
[[nodiscard]] Parameters natural_units(const Parameters& p, double gravity_mps2);

/// Start: centre and common scale of the sphere through the readings, |raw − b|² = (k g)², linear in b and
/// (k g)² − |b|²; no misalignment. Directions without spread keep the mean reading as bias.
[[nodiscard]] Parameters sphere_start(std::span<const AttitudeMean> attitudes, double gravity_mps2);

}  // namespace soak::calib::multi_position
