// SPDX-License-Identifier: Apache-2.0
#include "calib/gap/noise/whitening.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace soak::calib::gap {
namespace {

/// Lower triangular factor of the covariance of rows [first, last) of `rows`, which belong to one visit.
Eigen::MatrixXd covariance_factor(const Observations& observations, const std::vector<Eigen::Index>& rows,
                                  std::size_t first, std::size_t last, const NoiseComponents& noise) {
  const auto m = static_cast<Eigen::Index>(last - first);
  // A noise-free simulation still has to have a factor.
  const double total = noise.block * noise.block + noise.placement * noise.placement + noise.visit * noise.visit;
  const double own = std::max(noise.block * noise.block, 1e-12 * total + 1e-300);
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Constant(m, m, noise.visit * noise.visit);
  for (Eigen::Index a = 0; a < m; ++a) {
    for (Eigen::Index b = 0; b < m; ++b) {
      const auto& row = observations.rows[static_cast<std::size_t>(rows[first + static_cast<std::size_t>(a)])];
      const auto& other = observations.rows[static_cast<std::size_t>(rows[first + static_cast<std::size_t>(b)])];
      if (row.placement == other.placement) covariance(a, b) += noise.placement * noise.placement;
    }
    covariance(a, a) += own;
  }
  return covariance.llt().matrixL();
}

}  // namespace

Whitening::Whitening(const Observations& observations, Sensor sensor, const NoiseComponents& noise,
                     const std::vector<bool>& keep) {
  const std::size_t s = index_of(sensor);
  for (std::size_t i = 0; i < observations.rows.size(); ++i) {
    const SensorStatistics& statistics = observations.rows[i].sensor[s];
    if (keep[i] && statistics.count > 0 && std::isfinite(statistics.mean))
      rows_.push_back(static_cast<Eigen::Index>(i));
  }
  const auto visit_at = [&](std::size_t k) {
    const auto& row = observations.rows[static_cast<std::size_t>(rows_[k])];
    return std::pair{row.run, row.visit};
  };
  for (std::size_t first = 0; first < rows_.size();) {
    std::size_t last = first + 1;
    while (last < rows_.size() && visit_at(last) == visit_at(first)) ++last;
    visits_.push_back({static_cast<Eigen::Index>(first), covariance_factor(observations, rows_, first, last, noise)});
    first = last;
  }
}

Eigen::MatrixXd Whitening::apply(const Eigen::Ref<const Eigen::MatrixXd>& columns) const {
  Eigen::MatrixXd result(static_cast<Eigen::Index>(rows_.size()), columns.cols());
  for (std::size_t k = 0; k < rows_.size(); ++k) result.row(static_cast<Eigen::Index>(k)) = columns.row(rows_[k]);
  for (const Visit& visit : visits_) {
    visit.factor.triangularView<Eigen::Lower>().solveInPlace(result.middleRows(visit.first, visit.factor.rows()));
  }
  return result;
}

}  // namespace soak::calib::gap
