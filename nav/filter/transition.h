// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>

#include "nav/inertial/mechanization.h"

/// The linear model of the errors of an inertial navigation and the arithmetic of its covariance.
namespace soak::nav {

inline constexpr int kMostStates = 21;
/// Row lengths in memory: even, for the processor's pairs of numbers.
inline constexpr int kRow = 22;

/// A symmetric matrix of 15 or 21 states, by rows; beyond the states zeros.
struct Covariance {
  alignas(16) std::array<double, static_cast<std::size_t>(kRow) * kRow> values{};
  double& at(int row, int column) { return values[index_of(row, column)]; }
  [[nodiscard]] double at(int row, int column) const { return values[index_of(row, column)]; }
  static std::size_t index_of(int row, int column) {
    return static_cast<std::size_t>(row) * kRow + static_cast<std::size_t>(column);
  }
};

/// F dt of the errors, 3×3 blocks, from the linearised mechanization [AH05 eq. 3.7; Bar-Itzhack and Berman 1988]. An
/// error is estimate less truth in m, m/s along east, north, up; of the attitude the vector φ with R̂ = (I − [φ×]) R; of
/// a sensor the excess of the corrected reading.
struct Transition {
  Eigen::Matrix3d rr, rv, vr, vv, vp, va, pr, pv, pp, pg;
  Eigen::Matrix3d vs, ps;  ///< of the scale factors; used with 21 states
  /// What is left of a bias after the interval, exp(−dt/T): accelerometers, then gyros.
  std::array<double, 6> kept{};
  bool has_scales = false;
};

/// The transition over `duration_s`; rate and force are the corrected readings in body axes. `kept` is left alone.
void find_transition(const StepTerms& terms, const Eigen::Vector3d& velocity_mps, const Eigen::Vector3d& rate_rps,
                     const Eigen::Vector3d& force_mps2, double duration_s, Transition& transition);

/// M ← Φ M with Φ = I + F dt; M need not be symmetric.
void apply(const Transition& transition, Covariance& m);

/// P ← Φ P Φᵀ.
void propagate(const Transition& transition, Covariance& p);

}  // namespace soak::nav
