// SPDX-License-Identifier: Apache-2.0
#include "anfis/select/detail/scaled_rows.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <map>
#include <utility>

#include "anfis/linear/group_whitening.h"
#include "anfis/linear/least_squares.h"

namespace soak::anfis::fuzzy {
namespace {

Scale scale_between(double low, double high) {
  return {0.5 * low + 0.5 * high, high > low ? 0.5 * high - 0.5 * low : 1.0};
}

Eigen::VectorXd mean_one_weights(const TrainingData& data) {
  const auto rows = static_cast<Eigen::Index>(data.rows());
  if (data.weight.empty()) {
    return Eigen::VectorXd::Ones(rows);
  }
  // Divided by the largest first: the sum of weights near the largest double would overflow.
  Eigen::VectorXd weight = Eigen::Map<const Eigen::VectorXd>(data.weight.data(), rows);
  weight /= weight.maxCoeff();
  return weight / weight.mean();
}

struct GroupSum {
  double weight = 0.0;
  double residual = 0.0;  ///< weighted
};

// Residuals of generalised least squares on all inputs and a constant. Free offsets have no constant beside them: its
// column would whiten to rounding errors, which least squares takes for a direction.
Eigen::VectorXd linear_residuals(const TrainingData& data, const ScaledRows& rows) {
  Eigen::MatrixXd a = rows.x;
  if (std::isfinite(data.group_variance)) {
    a.conservativeResize(Eigen::NoChange, a.cols() + 1);
    a.rightCols(1).setOnes();
  }
  const GroupWhitening whitening(data.rows(), data.weight, data.group, data.group_variance);
  Eigen::MatrixXd whitened = a;
  Eigen::VectorXd y = rows.y;
  whitening.apply(whitened);
  whitening.apply(y);
  return rows.y - a * least_squares_coefficients(whitened, y);
}

void remove_group_offsets(const TrainingData& data, ScaledRows& rows) {
  const Eigen::VectorXd residual = linear_residuals(data, rows);
  std::map<int, GroupSum> sums;
  for (std::size_t k = 0; k < data.rows(); ++k) {
    const double weight = data.weight.empty() ? 1.0 : data.weight[k];
    sums[data.group[k]].weight += weight;
    sums[data.group[k]].residual += weight * residual(static_cast<Eigen::Index>(k));
  }
  // b_g = s^2 sum w r / (1 + s^2 sum w), in the limit the weighted mean
  for (std::size_t k = 0; k < data.rows(); ++k) {
    const GroupSum& sum = sums[data.group[k]];
    rows.y(static_cast<Eigen::Index>(k)) -= sum.residual / (1.0 / data.group_variance + sum.weight);
  }
}

}  // namespace

Scales scales_of(const TrainingData& data) {
  Scales scales;
  for (std::size_t j = 0; j < data.inputs; ++j) {
    double low = data.x[j];
    double high = data.x[j];
    for (std::size_t k = 0; k < data.rows(); ++k) {
      low = std::min(low, data.row(k)[j]);
      high = std::max(high, data.row(k)[j]);
    }
    scales.inputs.push_back(scale_between(low, high));
  }
  const auto [low, high] = std::minmax_element(data.y.begin(), data.y.end());
  scales.output = scale_between(*low, *high);
  return scales;
}

ScaledValues scaled_values(const TrainingData& data, const Scales& scales) {
  const auto rows = static_cast<Eigen::Index>(data.rows());
  ScaledValues values{Eigen::MatrixXd(rows, static_cast<Eigen::Index>(data.inputs)), Eigen::VectorXd(rows)};
  for (Eigen::Index k = 0; k < rows; ++k) {
    const auto row = data.row(static_cast<std::size_t>(k));
    for (std::size_t j = 0; j < data.inputs; ++j) {
      values.x(k, static_cast<Eigen::Index>(j)) = scales.inputs[j].scaled(row[j]);
    }
    values.y(k) = scales.output.scaled(data.y[static_cast<std::size_t>(k)]);
  }
  return values;
}

ScaledRows scaled_rows(const TrainingData& data, const Scales& scales) {
  ScaledValues values = scaled_values(data, scales);
  ScaledRows rows{std::move(values.x), std::move(values.y), mean_one_weights(data)};
  if (data.group_variance > 0.0) {
    remove_group_offsets(data, rows);
  }
  return rows;
}

Eigen::VectorXd weighted_variances(const Eigen::Ref<const Eigen::MatrixXd>& values, const Eigen::VectorXd& weight) {
  const Eigen::RowVectorXd mean = weight.transpose() * values / weight.sum();
  return (values.rowwise() - mean).array().square().matrix().transpose() * weight / weight.sum();
}

}  // namespace soak::anfis::fuzzy
