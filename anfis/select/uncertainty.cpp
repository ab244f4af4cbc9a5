// SPDX-License-Identifier: Apache-2.0
#include "anfis/select/uncertainty.h"

#include <cassert>
#include <cmath>
#include <cstddef>
#include <span>
#include <string>

#include "anfis/linear/least_squares.h"
#include "anfis/select/detail/linearised.h"
#include "base/linear/dense_solve.h"

namespace soak::anfis {
namespace {

constexpr double kSingularTolerance = 1e-6;

// F with F F^T = (J^T J)^+, for a whitened J.
Eigen::MatrixXd covariance_factor(const Eigen::MatrixXd& j) {
  Eigen::VectorXd scale = j.colwise().norm().transpose();
  scale = (scale.array() > kZeroColumn * scale.maxCoeff()).select(scale.cwiseInverse(), 0.0);
  const base::Svd svd = base::thin_svd(j * scale.asDiagonal());
  const Eigen::VectorXd& s = svd.singular;
  const Eigen::Index kept = (s.array() > kSingularTolerance * s(0)).count();
  return scale.asDiagonal() * svd.v.leftCols(kept) * s.head(kept).cwiseInverse().asDiagonal();
}

double whitened_residual_squares(const Model& model, const TrainingData& data, const GroupWhitening& whitening) {
  std::vector<double> r = residuals(data, model);
  Eigen::Map<Eigen::VectorXd> whitened(r.data(), static_cast<Eigen::Index>(r.size()));
  whitening.apply(whitened);
  return whitened.squaredNorm() + data.squares_within;
}

}  // namespace

base::Result<PredictionVariance> PredictionVariance::of(const Model& model, const TrainingData& data,
                                                        double smoothness) {
  if (auto status = validate_linearisation(model, data, smoothness); !status) return base::forward_error(status);
  const GroupWhitening whitening(data);
  const auto [j, price] = linearise(model, data, smoothness, whitening);
  PredictionVariance variance;
  variance.model_ = model;
  if (smoothness > 0.0) {
    Eigen::MatrixXd all(j.rows() + price.rows(), j.cols());
    all << j, price;
    variance.factor_ = covariance_factor(all);
    // trace of the matrix that makes fitted values of the rows
    variance.effective_parameters_ = (j * variance.factor_).squaredNorm();
  } else {
    variance.factor_ = covariance_factor(j);
    variance.effective_parameters_ = static_cast<double>(variance.factor_.cols());
  }
  variance.degrees_of_freedom_ = static_cast<double>(data.measured_rows()) - variance.effective_parameters_;
  if (variance.degrees_of_freedom_ < 1.0) {
    return base::bad_input(std::to_string(data.measured_rows()) + " rows for " +
                               std::to_string(std::lround(variance.effective_parameters_)) +
                               " parameters leave nothing to judge the noise by: use fewer rules or more data",
                           "x");
  }
  variance.residual_variance_ = whitened_residual_squares(model, data, whitening) / variance.degrees_of_freedom_;
  return variance;
}

base::Result<double> effective_parameters(const Model& model, const TrainingData& data, double smoothness) {
  if (auto status = validate_linearisation(model, data, smoothness); !status) return base::forward_error(status);
  const GroupWhitening whitening(data);
  const auto [j, price] = linearise(model, data, smoothness, whitening);
  const Eigen::MatrixXd of_rows = j.transpose() * j;
  const Eigen::MatrixXd all = of_rows + price.transpose() * price;
  Eigen::VectorXd scale = all.diagonal().cwiseSqrt();
  scale = (scale.array() > kZeroColumn * scale.maxCoeff()).select(scale.cwiseInverse(), 0.0);
  const base::SymmetricEigen eigen =
      base::symmetric_eigen(Eigen::MatrixXd(scale.asDiagonal() * all * scale.asDiagonal()));
  // trace((J^T J + P^T P)^+ J^T J), direction by direction
  const Eigen::MatrixXd directions = scale.asDiagonal() * eigen.vectors;
  const double least = kSingularTolerance * kSingularTolerance * eigen.values.maxCoeff();
  double sum = 0.0;
  for (Eigen::Index i = 0; i < directions.cols(); ++i) {
    if (eigen.values[i] <= least) continue;
    sum += directions.col(i).dot(of_rows * directions.col(i)) / eigen.values[i];
  }
  return sum;
}

double PredictionVariance::at(std::span<const double> x, double sigma_squared) const {
  assert(x.size() == model_.inputs.size());
  TrainingData point;
  point.x.assign(x.begin(), x.end());
  point.y = {0.0};
  point.inputs = x.size();
  return sigma_squared * (jacobian(model_, point) * factor_).squaredNorm();
}

double PredictionVariance::at(double x, double sigma_squared) const { return at(std::span(&x, 1), sigma_squared); }

}  // namespace soak::anfis
