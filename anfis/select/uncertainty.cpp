// SPDX-License-Identifier: Apache-2.0
#include "anfis/select/uncertainty.h"

#include <cassert>
#include <cmath>
#include <cstddef>
#include <span>
#include <string>

#include "anfis/linear/least_squares.h"
#include "anfis/objective/layer.h"
#include "anfis/objective/projected_problem.h"
#include "anfis/train/detail/training_steps.h"
#include "base/linear/dense_solve.h"

namespace soak::anfis {
namespace {

constexpr double kSingularTolerance = 1e-6;
// Columns below this share of the largest are rounding error of a derivative that is zero: unit norm would make them
// real.
constexpr double kZeroColumn = 1e-10;

/// df/d(consequents, premises) of the scaled output at the rows of data.
Eigen::MatrixXd jacobian(const Model& model, const TrainingData& points) {
  training::Layer layer(model, points);
  layer.compute(model);
  layer.compute_output(model);
  Eigen::MatrixXd consequents(layer.padded_rows(), static_cast<Eigen::Index>(consequent_count(model)));
  layer.consequent_matrix(model, consequents);
  const Eigen::MatrixXd premises = layer.jacobian(model);
  Eigen::MatrixXd all(premises.rows(), consequents.cols() + premises.cols());
  all << consequents.topRows(premises.rows()), premises;
  return all;
}

/// What a fit looks like to its parameters: rows and price of curvature (no rows without one), whitened.
struct Linearised {
  Eigen::MatrixXd rows;
  Eigen::MatrixXd price;
};

Linearised linearise(const Model& model, const TrainingData& data, double smoothness, const GroupWhitening& whitening) {
  Linearised fit;
  fit.rows = jacobian(model, data);
  whitening.apply(fit.rows);
  fit.price.resize(0, fit.rows.cols());
  if (smoothness > 0.0) {
    training::CurvaturePenalty penalty(model, data, smoothness * whitening.total_weight());
    fit.price = penalty.jacobian(model);
  }
  return fit;
}

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

base::Status validate_arguments(const Model& model, const TrainingData& data, double smoothness) {
  if (auto status = validate(model); !status) return status;
  if (auto status = validate(data, 0); !status) return status;
  if (data.inputs != model.inputs.size()) {
    return base::bad_input("the data have " + std::to_string(data.inputs) + " inputs, the model has " +
                               std::to_string(model.inputs.size()),
                           "x");
  }
  if (std::isinf(data.group_variance)) {
    return base::bad_input("free group offsets leave the level of the curve no finite variance: give an estimate of it",
                           "group_variance");
  }
  return training::validate_smoothness(smoothness, data.inputs);
}

}  // namespace

base::Result<PredictionVariance> PredictionVariance::of(const Model& model, const TrainingData& data,
                                                        double smoothness) {
  if (auto status = validate_arguments(model, data, smoothness); !status) return base::forward_error(status);
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
  if (auto status = validate_arguments(model, data, smoothness); !status) return base::forward_error(status);
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
