// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "calib/vocabulary/position.h"

namespace soak::calib {

/// Mean reading of an accelerometer triad over one static interval, in the triad's own unit (counts, m/s², g).
struct AttitudeMean {
  Vector3 mean{};
  Vector3 standard_error{};  ///< of the mean, ≥ 0; all zero = not known
};

/// Parameters of a triad, in the order of every list of nine here.
enum class TriadParameter : std::size_t {
  bias_x,
  bias_y,
  bias_z,
  scale_x,
  scale_y,
  scale_z,
  misalignment_xy,
  misalignment_xz,
  misalignment_yz
};
inline constexpr std::size_t kTriadParameterCount = 9;
inline constexpr std::array<std::string_view, kTriadParameterCount> kTriadParameterNames = {
    "bias_x",  "bias_y",          "bias_z",          "scale_x",        "scale_y",
    "scale_z", "misalignment_xy", "misalignment_xz", "misalignment_yz"};

constexpr std::size_t index_of(TriadParameter parameter) { return static_cast<std::size_t>(parameter); }

/// Nine-parameter model of an accelerometer triad and how well it is known:
///
///     raw = diag(k)·M·f + b,   M = [1 m_xy m_xz; 0 1 m_yz; 0 0 1]
///
/// b in raw units, k > 0 in raw units per m/s² (1 + scale error where raw is m/s²), m in rad. M is triangular because
/// |f| does not change when the body turns: that fixes the frame. Body z is the input axis of the z accelerometer, body
/// y lies in the plane of the input axes y and z, x completes the right-handed set. |f| cannot show a sign either: k is
/// that of axes that read + along f.
struct TriadCalibration {
  std::array<double, kTriadParameterCount> value{};
  /// Diagonal roots of `covariance`; 0 for parameters that are not observable.
  std::array<double, kTriadParameterCount> standard_error{};
  /// Half-widths of two-sided 95 % intervals: Student's t at `degrees_of_freedom` where the residuals say more than the
  /// standard errors (lack of fit), else the normal distribution's.
  std::array<double, kTriadParameterCount> ci95{};
  /// false: the attitudes do not show it; a misalignment then counts as 0. Bias and scale are always observable.
  std::array<bool, kTriadParameterCount> observable{};
  Eigen::Matrix<double, 9, 9> covariance = Eigen::Matrix<double, 9, 9>::Zero();
  /// Largest over smallest singular value of the Jacobian by the observable parameters, each in units of what it does
  /// to a reading (bias in g, scale relative, misalignment in rad). Evenly spread attitudes: about 5.
  double condition = 0.0;
  std::size_t degrees_of_freedom = 0;  ///< attitudes − observable parameters
  std::vector<double> residual_mps2;   ///< |f| − g of each attitude
  double residual_rms_mps2 = 0.0;
  double reduced_chi_squared = 0.0;  ///< against the standard errors alone; 0 where they or the freedoms are none
  /// Scatter of |f| − g beyond the standard errors (motion, temperature, model), standard deviation.
  double lack_of_fit_mps2 = 0.0;

  [[nodiscard]] double operator[](TriadParameter parameter) const { return value[index_of(parameter)]; }
  /// f = M⁻¹·diag(k)⁻¹·(raw − b), m/s².
  [[nodiscard]] Vector3 specific_force(const Vector3& raw) const;
};

/// Calibrates an accelerometer triad from static attitudes that nobody knows: weighted least squares on |f| − g
/// (Levenberg-Marquardt), the model of Tedaldi, Pretto, Menegatti, ICRA 2014. Weights are 1/(u² + τ²): u the standard
/// error of |f| from those of the means, τ the lack of fit, such that χ² equals its freedoms (Mandel and Paule 1982)
/// where it would else exceed its 80 % quantile. Covariance is that of the weighted fit, linearised.
///
/// What the attitudes show: within first order |f| sees bias and scale of an axis that has pointed up and down, a
/// misalignment only where both its axes share gravity; six faces show no misalignment at all. Those are told by
/// `observable`, not estimated, and taken as 0: where attitudes are tilted by θ from the faces that costs θ·m·g.
///
/// Refuses fewer attitudes than what is to be estimated (six for six faces, nine in general), attitudes that leave a
/// bias or scale open (named), those that leave no freedom for the residuals while standard errors are unknown, and
/// readings that are no triad's: |f| off by over 5 % of g (root mean square).
[[nodiscard]] base::Result<TriadCalibration> calibrate_triad(std::span<const AttitudeMean> attitudes,
                                                             double gravity_mps2);

}  // namespace soak::calib
