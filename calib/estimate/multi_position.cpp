// SPDX-License-Identifier: Apache-2.0
#include "calib/estimate/multi_position.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <unsupported/Eigen/NonLinearOptimization>

#include "base/linear/dense_solve.h"
#include "base/statistics.h"

namespace soak::calib {
namespace {

// The triad's model.

/// Parameters in the order of TriadParameter.
using Parameters = Eigen::Matrix<double, 9, 1>;

Eigen::Matrix3d misalignment_matrix(const Parameters& p) {
  Eigen::Matrix3d m = Eigen::Matrix3d::Identity();
  m(0, 1) = p[6];
  m(0, 2) = p[7];
  m(1, 2) = p[8];
  return m;
}

Eigen::Vector3d solve_upper(const Eigen::Matrix3d& m, const Eigen::Vector3d& v) {
  return m.triangularView<Eigen::UnitUpper>().solve(v);
}

/// f = M⁻¹·diag(k)⁻¹·(raw − b).
Eigen::Vector3d force_from(const Parameters& p, const Eigen::Vector3d& raw) {
  return solve_upper(misalignment_matrix(p), (raw - p.head<3>()).cwiseQuotient(p.segment<3>(3)));
}

/// Derivative of |f| by the nine parameters. That by the raw readings is −1 times its first three entries.
Parameters magnitude_gradient(const Parameters& p, const Eigen::Vector3d& raw) {
  const Eigen::Matrix3d m = misalignment_matrix(p);
  const Eigen::Vector3d f = force_from(p, raw);
  // n = f/|f|; q = M⁻ᵀ n, so that n·M⁻¹ e_i = q_i.
  const Eigen::Vector3d q = m.triangularView<Eigen::UnitUpper>().transpose().solve(f.normalized());
  const Eigen::Vector3d k = p.segment<3>(3);
  // M f = diag(k)⁻¹ (raw − b)
  const Eigen::Vector3d mf = m * f;
  Parameters gradient;
  // ∂f/∂b_i = −M⁻¹ e_i / k_i;  ∂f/∂k_i = −M⁻¹ e_i (M f)_i / k_i;  ∂f/∂m_ij = −M⁻¹ e_i f_j
  gradient.head<3>() = -q.cwiseQuotient(k);
  gradient.segment<3>(3) = -q.cwiseProduct(mf).cwiseQuotient(k);
  gradient[6] = -q[0] * f[1];
  gradient[7] = -q[0] * f[2];
  gradient[8] = -q[1] * f[2];
  return gradient;
}

/// What one unit of each parameter means to a reading of 1 g: k·g for biases, k for scales, 1 for misalignments.
Parameters natural_units(const Parameters& p, double gravity_mps2) {
  Parameters units = Parameters::Ones();
  units.head<3>() = p.segment<3>(3) * gravity_mps2;
  units.segment<3>(3) = p.segment<3>(3);
  return units;
}

/// Start: centre and common scale of the sphere through the readings, |raw − b|² = (k g)², linear in b and
/// (k g)² − |b|²; no misalignment. Directions without spread keep the mean reading as bias.
Parameters sphere_start(std::span<const AttitudeMean> attitudes, double gravity_mps2) {
  const auto n = static_cast<Eigen::Index>(attitudes.size());
  Eigen::MatrixX3d raw(n, 3);
  for (Eigen::Index i = 0; i < n; ++i) {
    raw.row(i) = Eigen::Map<const Eigen::RowVector3d>(attitudes[static_cast<std::size_t>(i)].mean.data());
  }
  const Eigen::RowVector3d middle = raw.colwise().mean();
  raw.rowwise() -= middle;
  const double size = std::sqrt(raw.rowwise().squaredNorm().mean());
  // With readings about their mean in units of their size: 2 raw·b + ((k g)² − |b|²) = |raw|²
  raw /= size;
  Eigen::MatrixX4d a(n, 4);
  a << 2.0 * raw, Eigen::VectorXd::Ones(n);
  const Eigen::VectorXd squares = raw.rowwise().squaredNorm();
  const Eigen::Vector4d x = base::solve_svd(a, squares, 1e-3);
  const double radius_squared = x[3] + x.head<3>().squaredNorm();
  Parameters start = Parameters::Zero();
  start.head<3>() = middle.transpose() + size * x.head<3>();
  start.segment<3>(3).setConstant(size * std::sqrt(std::max(0.01, radius_squared)) / gravity_mps2);
  return start;
}

// The fit.

constexpr std::size_t kLeastAttitudes = 6;
constexpr int kReweightings = 20;
/// Singular value of the Jacobian in natural units, per attitude and g, under which a direction counts as not seen:
/// tilts of half a degree from a face, second-order effects.
constexpr double kWeakest = 0.01;
/// Share of a parameter in an unseen direction from which the parameter counts as not seen. A bias of 0.03 g for a
/// misalignment of 1 rad: what misalignments of 0.01 rad do to it is 0.3 mg.
constexpr double kShare = 0.03;
/// Probability of a χ² up to which the standard errors are believed. Of 36,000 simulated 95 % intervals (24 attitudes)
/// 95.9 % held the truth with no further scatter, 93.9 % with two thirds as much as noise, 95.1 % with far more. Less
/// raises the first figure, more lowers the second.
constexpr double kChance = 0.8;
constexpr double kLargestResidual = 0.05;  ///< of g, root mean square
/// Standard deviations below this share of g are rounding: weights stay finite.
constexpr double kRounding = 1e-12;

using Free = std::vector<Eigen::Index>;

Eigen::Vector3d vector_of(const Vector3& v) { return {v[0], v[1], v[2]}; }

Eigen::MatrixXd jacobian(std::span<const AttitudeMean> attitudes, const Parameters& p) {
  Eigen::MatrixXd j(static_cast<Eigen::Index>(attitudes.size()), 9);
  for (std::size_t n = 0; n < attitudes.size(); ++n) {
    j.row(static_cast<Eigen::Index>(n)) = magnitude_gradient(p, vector_of(attitudes[n].mean)).transpose();
  }
  return j;
}

Eigen::VectorXd residuals(std::span<const AttitudeMean> attitudes, const Parameters& p, double gravity_mps2) {
  Eigen::VectorXd r(static_cast<Eigen::Index>(attitudes.size()));
  for (std::size_t n = 0; n < attitudes.size(); ++n) {
    r[static_cast<Eigen::Index>(n)] = force_from(p, vector_of(attitudes[n].mean)).norm() - gravity_mps2;
  }
  return r;
}

/// u²: variance of |f| from the standard errors of the means, first order.
Eigen::VectorXd noise_variance(std::span<const AttitudeMean> attitudes, const Parameters& p) {
  Eigen::VectorXd variance(static_cast<Eigen::Index>(attitudes.size()));
  for (std::size_t n = 0; n < attitudes.size(); ++n) {
    const Eigen::Vector3d by_raw = magnitude_gradient(p, vector_of(attitudes[n].mean)).head<3>();
    variance[static_cast<Eigen::Index>(n)] = by_raw.cwiseProduct(vector_of(attitudes[n].standard_error)).squaredNorm();
  }
  return variance;
}

/// The problem that Eigen's Levenberg-Marquardt solves: x are the free parameters in natural units about `centre`.
struct WeightedProblem {
  using Scalar = double;
  using InputType = Eigen::VectorXd;
  using ValueType = Eigen::VectorXd;
  using JacobianType = Eigen::MatrixXd;

  std::span<const AttitudeMean> attitudes;
  double gravity_mps2;
  Parameters centre;
  Parameters units;
  Free free;
  Eigen::VectorXd sigma;

  [[nodiscard]] int values() const { return static_cast<int>(attitudes.size()); }
  [[nodiscard]] Parameters parameters(const Eigen::VectorXd& x) const {
    Parameters p = centre;
    p(free) += units(free).cwiseProduct(x);
    return p;
  }
  int operator()(const Eigen::VectorXd& x, Eigen::VectorXd& r) const {
    r = residuals(attitudes, parameters(x), gravity_mps2).cwiseQuotient(sigma);
    return 0;
  }
  int df(const Eigen::VectorXd& x, Eigen::MatrixXd& j) const {
    j = sigma.cwiseInverse().asDiagonal() * jacobian(attitudes, parameters(x))(Eigen::all, free) *
        units(free).asDiagonal();
    return 0;
  }
};

Parameters minimise(std::span<const AttitudeMean> attitudes, double gravity_mps2, const Parameters& start,
                    const Free& free, const Eigen::VectorXd& sigma) {
  WeightedProblem problem{attitudes, gravity_mps2, start, natural_units(start, gravity_mps2), free, sigma};
  Eigen::LevenbergMarquardt<WeightedProblem> solver(problem);
  solver.parameters.xtol = 1e-14;
  solver.parameters.ftol = 1e-14;
  Eigen::VectorXd x = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(free.size()));
  solver.minimize(x);
  return problem.parameters(x);
}

/// τ with Σ r²/(u² + τ²) = freedoms [Mandel and Paule 1982]; 0 where chance alone may make the sum at τ = 0.
double lack_of_fit(const Eigen::VectorXd& r, const Eigen::VectorXd& noise, double freedoms, double floor) {
  if (freedoms < 1.0) return 0.0;
  const auto excess = [&](double variance) {
    return (r.array().square() / (noise.array() + variance).max(floor * floor)).sum() - freedoms;
  };
  if (excess(0.0) + freedoms <= base::chi_squared_quantile(kChance, freedoms)) return 0.0;
  double low = 0.0;
  double high = r.squaredNorm() / freedoms;
  for (int i = 0; i < 100; ++i) {
    const double middle = 0.5 * (low + high);
    (excess(middle) > 0.0 ? low : high) = middle;
  }
  return std::sqrt(high);
}

/// Which of the parameters `among` the attitudes leave open: those with a share in an unseen direction.
std::array<bool, kTriadParameterCount> unseen(std::span<const AttitudeMean> attitudes, const Parameters& p,
                                              double gravity_mps2) {
  const Parameters units = natural_units(p, gravity_mps2);
  const double per_attitude = 1.0 / (gravity_mps2 * std::sqrt(static_cast<double>(attitudes.size())));
  const Eigen::MatrixXd j = jacobian(attitudes, p) * units.asDiagonal() * per_attitude;
  const base::Svd svd = base::full_v_svd(j);
  std::array<bool, kTriadParameterCount> open{};
  for (Eigen::Index d = 0; d < 9; ++d) {
    if (d < svd.singular.size() && svd.singular[d] >= kWeakest) continue;
    for (std::size_t i = 0; i < open.size(); ++i) {
      open[i] = open[i] || std::abs(svd.v(static_cast<Eigen::Index>(i), d)) > kShare;
    }
  }
  return open;
}

base::Status check_attitudes(std::span<const AttitudeMean> attitudes, double gravity_mps2) {
  if (!(gravity_mps2 > 0.0) || !std::isfinite(gravity_mps2)) {
    return base::bad_input(fmt::format("gravity is {} m/s2, it must be above 0", gravity_mps2));
  }
  if (attitudes.size() < kLeastAttitudes) {
    return base::bad_input(
        fmt::format("{} static attitudes: bias and scale of three accelerometers need at least six (each axis up and "
                    "down), with misalignment nine, and more for an error that means something",
                    attitudes.size()));
  }
  if (std::all_of(attitudes.begin(), attitudes.end(),
                  [&](const AttitudeMean& attitude) { return attitude.mean == attitudes.front().mean; })) {
    return base::bad_input("all attitudes give the same reading: the unit was never turned");
  }
  for (std::size_t n = 0; n < attitudes.size(); ++n) {
    const Eigen::Vector3d mean = vector_of(attitudes[n].mean);
    const Eigen::Vector3d error = vector_of(attitudes[n].standard_error);
    if (mean.allFinite() && error.allFinite() && error.minCoeff() >= 0.0) continue;
    return base::bad_input("means must be finite, their standard errors finite and not negative",
                           fmt::format("attitude {}", n + 1));
  }
  return {};
}

/// The observable parameters; refuses attitudes that leave a bias or a scale open.
base::Result<Free> choose(std::span<const AttitudeMean> attitudes, const Parameters& p, double gravity_mps2) {
  const auto open = unseen(attitudes, p, gravity_mps2);
  Free free;
  std::vector<std::string_view> names;
  for (std::size_t i = 0; i < open.size(); ++i) {
    if (!open[i]) {
      free.push_back(static_cast<Eigen::Index>(i));
    } else if (i < index_of(TriadParameter::misalignment_xy)) {
      names.push_back(kTriadParameterNames[i]);
    }
  }
  if (names.empty()) return free;
  return base::bad_input(
      fmt::format("{} static attitudes do not show {}: add attitudes in which each of these axes points up and down, "
                  "and some between the faces (nine or more in all)",
                  attitudes.size(), fmt::join(names, ", ")));
}

void state_uncertainty(std::span<const AttitudeMean> attitudes, const Parameters& p, double gravity_mps2,
                       const Free& free, const Eigen::VectorXd& sigma, TriadCalibration& result) {
  const Parameters units = natural_units(p, gravity_mps2);
  const Eigen::MatrixXd natural = jacobian(attitudes, p)(Eigen::all, free) * units(free).asDiagonal();
  const Eigen::VectorXd singular = base::singular_values(natural);
  result.condition = singular[0] / singular[singular.size() - 1];
  // covariance = U (Jᵀ W J)⁻¹ U, from the singular values of W^½ J
  const base::Svd whitened = base::thin_svd(sigma.cwiseInverse().asDiagonal() * natural);
  const Eigen::MatrixXd root =
      units(free).asDiagonal() * whitened.v * whitened.singular.cwiseInverse().asDiagonal().toDenseMatrix();
  result.covariance(free, free) = root * root.transpose();
  const double factor = base::student_t_two_sided(
      0.95, result.lack_of_fit_mps2 > 0.0 ? static_cast<double>(result.degrees_of_freedom) : 1e6);
  for (const Eigen::Index i : free) {
    const auto at = static_cast<std::size_t>(i);
    result.observable[at] = true;
    result.standard_error[at] = std::sqrt(result.covariance(i, i));
    result.ci95[at] = factor * result.standard_error[at];
  }
}

/// Standard deviations of the residuals: √(u² + τ²), never 0.
Eigen::VectorXd deviations(const Eigen::VectorXd& noise, double tau, double floor) {
  return (noise.array() + tau * tau).sqrt().max(floor);
}

base::Status check_residuals(const TriadCalibration& result, double gravity_mps2, bool errors_known) {
  if (!(result.residual_rms_mps2 <= kLargestResidual * gravity_mps2)) {
    return base::bad_input(fmt::format(
        "|f| is off by {:.3g} m/s2 (root mean square) in the best fit: these are no readings of one accelerometer "
        "triad at rest, or gravity is not {} m/s2; leave out attitudes in which the unit moved",
        result.residual_rms_mps2, gravity_mps2));
  }
  if (result.degrees_of_freedom == 0 && !errors_known) {
    return base::bad_input(
        "as many attitudes as parameters, and standard errors are not known: nothing says how good the fit is; add "
        "attitudes or give the standard errors of the means");
  }
  return {};
}

}  // namespace

Vector3 TriadCalibration::specific_force(const Vector3& raw) const {
  const Parameters p = Eigen::Map<const Parameters>(value.data());
  const Eigen::Vector3d f = force_from(p, vector_of(raw));
  return {f[0], f[1], f[2]};
}

base::Result<TriadCalibration> calibrate_triad(std::span<const AttitudeMean> attitudes, double gravity_mps2) {
  if (const auto sound = check_attitudes(attitudes, gravity_mps2); !sound) return base::forward_error(sound);
  const double floor = kRounding * gravity_mps2;
  Parameters p = sphere_start(attitudes, gravity_mps2);
  const auto free = choose(attitudes, p, gravity_mps2);
  if (!free) return base::forward_error(free);

  TriadCalibration result;
  result.degrees_of_freedom = attitudes.size() - free->size();
  const auto freedoms = static_cast<double>(result.degrees_of_freedom);
  Eigen::VectorXd sigma = Eigen::VectorXd::Constant(static_cast<Eigen::Index>(attitudes.size()), gravity_mps2);
  Eigen::VectorXd noise;
  Eigen::VectorXd r;
  for (int i = 0; i < kReweightings; ++i) {
    p = minimise(attitudes, gravity_mps2, p, *free, sigma);
    r = residuals(attitudes, p, gravity_mps2);
    noise = noise_variance(attitudes, p);
    const double tau = lack_of_fit(r, noise, freedoms, floor);
    const bool settled = i > 0 && std::abs(tau - result.lack_of_fit_mps2) <= 1e-6 * tau + floor;
    result.lack_of_fit_mps2 = tau;
    sigma = deviations(noise, tau, floor);
    if (settled) break;
  }

  Eigen::Map<Parameters>(result.value.data()) = p;
  result.residual_mps2.assign(r.begin(), r.end());
  result.residual_rms_mps2 = std::sqrt(r.squaredNorm() / static_cast<double>(r.size()));
  // A triad of vanishing gain about a far bias makes every reading g: seen at the solution only.
  if (const auto still = choose(attitudes, p, gravity_mps2); !still) return base::forward_error(still);
  const bool errors_known = noise.minCoeff() > 0.0;
  if (errors_known && freedoms > 0.0) {
    result.reduced_chi_squared = (r.array().square() / noise.array()).sum() / freedoms;
  }
  if (const auto sound = check_residuals(result, gravity_mps2, errors_known); !sound) return base::forward_error(sound);
  state_uncertainty(attitudes, p, gravity_mps2, *free, sigma, result);
  return result;
}

}  // namespace soak::calib
