// SPDX-License-Identifier: Apache-2.0
#include "anfis/uncertainty.h"

#include <Eigen/Dense>
#include <array>
#include <cmath>
#include <cstddef>
#include <span>
#include <string>

#include "anfis/group_whitening.h"
#include "anfis/training/premise_layer.h"
#include "anfis/training/trainer.h"

namespace soak::anfis {
namespace {

constexpr double kSingularTolerance = 1e-6;
// Columns below this share of the largest are rounding error of a derivative that is zero: unit norm would make them
// real.
constexpr double kZeroColumn = 1e-10;

// df/d(consequents, premises) of the scaled output at scaled inputs.
Eigen::MatrixXd jacobian(const Model& model, std::span<const double> scaled_inputs) {
  training::PremiseLayer layer(scaled_inputs);
  layer.compute(model.membership, model.rules);
  const Eigen::MatrixXd consequents = layer.consequent_matrix(model.order);
  const Eigen::MatrixXd premises = layer.premise_jacobian(model.membership, model.rules);
  Eigen::MatrixXd all(consequents.rows(), consequents.cols() + premises.cols());
  all << consequents, premises;
  return all;
}

// F with F F^T = (J^T J)^+, for a whitened J.
Eigen::MatrixXd covariance_factor(const Eigen::MatrixXd& j) {
  Eigen::VectorXd scale = j.colwise().norm().transpose();
  scale = (scale.array() > kZeroColumn * scale.maxCoeff()).select(scale.cwiseInverse(), 0.0);
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(j * scale.asDiagonal(), Eigen::ComputeThinU | Eigen::ComputeThinV);
  const Eigen::VectorXd& s = svd.singularValues();
  const Eigen::Index kept = (s.array() > kSingularTolerance * s(0)).count();
  return scale.asDiagonal() * svd.matrixV().leftCols(kept) * s.head(kept).cwiseInverse().asDiagonal();
}

double whitened_residual_squares(const Model& model, const TrainingData& data, const GroupWhitening& whitening) {
  Eigen::VectorXd r(static_cast<Eigen::Index>(data.rows()));
  evaluate(model, data.x, std::span<double>(r.data(), data.rows()));
  r = Eigen::Map<const Eigen::VectorXd>(data.y.data(), r.size()) - r;
  whitening.apply(r);
  return r.squaredNorm();
}

}  // namespace

base::Result<PredictionVariance> PredictionVariance::of(const Model& model, const TrainingData& data) {
  if (auto status = validate(model); !status) {
    return base::forward_error(status);
  }
  if (auto status = validate(data, 0); !status) {
    return base::forward_error(status);
  }
  if (std::isinf(data.group_variance)) {
    return base::bad_input("free group offsets leave the level of the curve no finite variance: give an estimate of it",
                           "group_variance");
  }
  const GroupWhitening whitening(data.rows(), data.weight, data.group, data.group_variance);
  Eigen::MatrixXd j = jacobian(model, training::scaled_inputs(model, data));
  whitening.apply(j);
  PredictionVariance variance;
  variance.model_ = model;
  variance.factor_ = covariance_factor(j);
  variance.degrees_of_freedom_ = static_cast<int>(data.rows()) - variance.effective_parameters();
  if (variance.degrees_of_freedom_ < 1) {
    return base::bad_input(std::to_string(data.rows()) + " rows for " +
                               std::to_string(variance.effective_parameters()) +
                               " parameters leave nothing to judge the noise by: use fewer rules or more data",
                           "x");
  }
  variance.residual_variance_ = whitened_residual_squares(model, data, whitening) / variance.degrees_of_freedom_;
  return variance;
}

double PredictionVariance::at(double x, double sigma_squared) const {
  const std::array<double, 1> u = {(x - model_.input_centre) / model_.input_half_range};
  return sigma_squared * (jacobian(model_, u) * factor_).squaredNorm();
}

}  // namespace soak::anfis
