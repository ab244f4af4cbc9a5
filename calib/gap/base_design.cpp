// SPDX-License-Identifier: Apache-2.0
#include "calib/gap/base_design.h"

#include "calib/gap/level_spline.h"

namespace soak::calib::gap {
namespace {

bool with_scale(const Observations& observations, Sensor sensor) {
  return !is_gyro(sensor) && observations.has_positions();
}

}  // namespace

BaseDesign base_design(const Observations& observations, Sensor sensor, const std::vector<double>& temp_c) {
  const auto n = static_cast<Eigen::Index>(observations.rows.size());
  const Eigen::Index levels = observations.level_count();
  const Eigen::Index offsets = observations.run_count() - 1;
  const bool scale = with_scale(observations, sensor);
  const LevelSpline spline(observations.level_c);
  BaseDesign design;
  design.levels = levels;
  design.offsets = offsets;
  design.columns = Eigen::MatrixXd::Zero(n, levels + (scale ? levels + 2 : 0) + offsets);
  const Eigen::Index first_offset = design.columns.cols() - offsets;
  const std::size_t axis = axis_of(sensor);
  for (Eigen::Index i = 0; i < n; ++i) {
    const Observation& row = observations.rows[static_cast<std::size_t>(i)];
    const Eigen::RowVectorXd weights = spline.weights(temp_c[static_cast<std::size_t>(i)]);
    design.columns.row(i).head(levels) = weights;
    if (scale) {
      design.columns.row(i).segment(levels, levels) = observations.force_g(row, axis) * weights;
      design.columns(i, 2 * levels) = observations.force_g(row, (axis + 1) % 3);
      design.columns(i, 2 * levels + 1) = observations.force_g(row, (axis + 2) % 3);
    }
    if (row.run > 0) design.columns(i, first_offset + row.run - 1) = 1.0;
  }
  return design;
}

Eigen::VectorXd base_slope(const Observations& observations, Sensor sensor, const std::vector<double>& temp_c,
                           const Eigen::VectorXd& coefficients) {
  const auto n = static_cast<Eigen::Index>(observations.rows.size());
  const Eigen::Index levels = observations.level_count();
  const bool scale = with_scale(observations, sensor);
  const LevelSpline spline(observations.level_c);
  Eigen::VectorXd slope(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const Observation& row = observations.rows[static_cast<std::size_t>(i)];
    const Eigen::RowVectorXd weights = spline.slope_weights(temp_c[static_cast<std::size_t>(i)]);
    slope(i) = weights.dot(coefficients.head(levels));
    if (scale) {
      slope(i) += observations.force_g(row, axis_of(sensor)) * weights.dot(coefficients.segment(levels, levels));
    }
  }
  return slope;
}

}  // namespace soak::calib::gap
