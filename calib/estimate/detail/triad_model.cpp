// SPDX-License-Identifier: Apache-2.0
#include "calib/estimate/detail/triad_model.h"

#include <Eigen/Dense>
#include <cmath>

namespace soak::calib::multi_position {
namespace {

Eigen::Matrix3d misalignment(const Parameters& p) {
  Eigen::Matrix3d m = Eigen::Matrix3d::Identity();
  m(0, 1) = p[6];
  m(0, 2) = p[7];
  m(1, 2) = p[8];
  return m;
}

Eigen::Vector3d solve_upper(const Eigen::Matrix3d& m, const Eigen::Vector3d& v) {
  return m.triangularView<Eigen::UnitUpper>().solve(v);
}

}  // namespace

Eigen::Vector3d specific_force(const Parameters& p, const Eigen::Vector3d& raw) {
  return solve_upper(misalignment(p), (raw - p.head<3>()).cwiseQuotient(p.segment<3>(3)));
}

Parameters magnitude_gradient(const Parameters& p, const Eigen::Vector3d& raw) {
  const Eigen::Matrix3d m = misalignment(p);
  const Eigen::Vector3d f = specific_force(p, raw);
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

Parameters natural_units(const Parameters& p, double gravity_mps2) {
  Parameters units = Parameters::Ones();
  units.head<3>() = p.segment<3>(3) * gravity_mps2;
  units.segment<3>(3) = p.segment<3>(3);
  return units;
}

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
  Eigen::JacobiSVD<Eigen::MatrixXd> svd(a, Eigen::ComputeThinU | Eigen::ComputeThinV);
  svd.setThreshold(1e-3);
  const Eigen::Vector4d x = svd.solve(raw.rowwise().squaredNorm().eval());
  const double radius_squared = x[3] + x.head<3>().squaredNorm();
  Parameters start = Parameters::Zero();
  start.head<3>() = middle.transpose() + size * x.head<3>();
  start.segment<3>(3).setConstant(size * std::sqrt(std::max(0.01, radius_squared)) / gravity_mps2);
  return start;
}

}  // namespace soak::calib::multi_position
