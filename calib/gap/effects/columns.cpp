// SPDX-License-Identifier: Apache-2.0
#include "calib/gap/effects/columns.h"

#include <algorithm>

#include "calib/gap/effects/meaning.h"

namespace soak::calib::gap {

double half_range_c(const Observations& observations) {
  const double half = 0.5 * (observations.level_c.back() - observations.level_c.front());
  return half > 0.0 ? half : 1.0;
}

Eigen::VectorXd reduced_temperature(const Observations& observations) {
  const double middle = middle_c(observations);
  const double half = half_range_c(observations);
  Eigen::VectorXd z(static_cast<Eigen::Index>(observations.rows.size()));
  for (Eigen::Index i = 0; i < z.size(); ++i) {
    z(i) = (observations.rows[static_cast<std::size_t>(i)].temp_c - middle) / half;
  }
  return z;
}

Eigen::VectorXd as_vector(const std::vector<double>& values) {
  return Eigen::Map<const Eigen::VectorXd>(values.data(), static_cast<Eigen::Index>(values.size()));
}

Eigen::MatrixXd with_temperature_shape(const Observations& observations, const Eigen::VectorXd& column) {
  Eigen::MatrixXd columns(column.size(), 2);
  columns.col(0) = column;
  columns.col(1) = column.cwiseProduct(reduced_temperature(observations));
  return columns;
}

void set_all(Candidate& candidate, const Eigen::MatrixXd& columns) { candidate.columns.fill(columns); }

void set_gyros(Candidate& candidate, const Eigen::MatrixXd& columns) {
  for (std::size_t s = 0; s < 3; ++s) candidate.columns[s] = columns;
}

void set_accelerometers(Candidate& candidate, const Eigen::MatrixXd& columns) {
  for (std::size_t s = 3; s < kSensorCount; ++s) candidate.columns[s] = columns;
}

Magnitude linear_magnitude(Sensor sensor, const Eigen::VectorXd& parameters, double factor, std::string_view per) {
  return {parameters(0) * factor * printed_per_si(sensor), std::string(printed_unit(sensor)) + std::string(per)};
}

}  // namespace soak::calib::gap
