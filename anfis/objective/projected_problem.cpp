// SPDX-License-Identifier: Apache-2.0
#include "anfis/objective/projected_problem.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "anfis/premises/premise_bounds.h"

namespace soak::anfis::training {
namespace {

using Eigen::Index;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

/// Data whose groups, where they have offsets at all, have free ones.
TrainingData with_free_offsets(TrainingData data) {
  if (data.group_variance > 0.0) data.group_variance = std::numeric_limits<double>::infinity();
  return data;
}

Eigen::VectorXd padded_outputs(const TrainingData& data, const Scale& scale, Index padded_rows) {
  Eigen::VectorXd y = Eigen::VectorXd::Zero(padded_rows);
  for (std::size_t i = 0; i < data.rows(); ++i) y(static_cast<Index>(i)) = scale.scaled(data.y[i]);
  return y;
}

constexpr double kPointsPerGap = 4.0;
constexpr double kFewestPoints = 32.0;
constexpr double kMostPoints = 256.0;

/// A grid over the range of the inputs.
TrainingData grid(const Model& model, const TrainingData& data) {
  std::vector<double> scaled;
  for (const double x : data.x) scaled.push_back(model.inputs[0].scale.scaled(x));
  const InputGaps gaps(std::move(scaled));
  const double range = gaps.highest() - gaps.lowest();
  const double intervals = std::clamp(std::ceil(kPointsPerGap * range / gaps.widest()), kFewestPoints, kMostPoints);
  TrainingData points;
  for (double k = 0.0; k <= intervals; k += 1.0) {
    points.x.push_back(model.inputs[0].scale.unscaled(gaps.lowest() + range * k / intervals));
    points.y.push_back(0.0);
  }
  return points;
}

/// Rows of second differences of the columns of values on the grid.
template <class Values>
auto second_differences(const Values& values, Index rows) {
  return values.topRows(rows) - 2.0 * values.middleRows(1, rows) + values.middleRows(2, rows);
}

}  // namespace

ProjectedProblem::ProjectedProblem(const Model& model, const TrainingData& data, double smoothness,
                                   double initial_covariance)
    : model_(model),
      layer_(model, data),
      whitening_(data, static_cast<std::size_t>(layer_.padded_rows())),
      outputs_(padded_outputs(data, model.output, layer_.padded_rows())),
      curvature_(smoothness > 0.0
                     ? std::make_optional<CurvaturePenalty>(model, data, smoothness * whitening_.total_weight())
                     : std::nullopt),
      a_(layer_.padded_rows() + (curvature_ ? curvature_->rows() : 0), static_cast<Index>(consequent_count(model))),
      right_(Eigen::VectorXd::Zero(a_.rows())),
      solver_(a_.rows(), a_.cols()),
      residuals_(outputs_),
      pull_(outputs_.size()),
      sequential_(a_.cols(), initial_covariance),
      sequential_row_(a_.cols()) {
  whitening_.apply(residuals_);
  right_.head(outputs_.size()) = residuals_;
  squares_within_ = data.squares_within / (model.output.half_range * model.output.half_range);
}

void ProjectedProblem::compute_rows() {
  layer_.compute(model_);
  const Index rows = layer_.padded_rows();
  layer_.consequent_matrix(model_, a_.topRows(rows));
  whitening_.apply(a_.topRows(rows));
  if (curvature_) curvature_->consequent_rows(model_, a_.bottomRows(curvature_->rows()));
}

double ProjectedProblem::solve() {
  compute_rows();
  // [AH05 eq. 5.12-5.13] min || L (A X - B) ||, A: rows x consequents
  set_consequents(solver_.solve(a_, right_), model_);
  return measure();
}

double ProjectedProblem::solve_sequentially() {
  compute_rows();
  sequential_.restart();
  for (Index row = 0; row < static_cast<Index>(layer_.rows()); ++row) {
    sequential_row_ = a_.row(row);
    if (!sequential_.update(sequential_row_, right_(row))) return kNaN;
  }
  set_consequents(sequential_.coefficients(), model_);
  return measure();
}

double ProjectedProblem::measure() {
  layer_.compute_output(model_);
  residuals_ = outputs_ - layer_.output();
  whitening_.apply(residuals_);
  const double squares = residuals_.squaredNorm() + squares_within_;
  error_ = squares + (curvature_ ? curvature_->price(model_) : 0.0);
  return std::sqrt(squares / error_per_square_rmse());
}

double ProjectedProblem::error_per_square_rmse() const {
  return whitening_.total_weight() / (model_.output.half_range * model_.output.half_range);
}

void ProjectedProblem::gradient(std::span<double> gradient) {
  // [AH05 eq. 5.17] dE/df = -2 V^-1 r
  pull_ = residuals_;
  whitening_.apply_transposed(pull_);
  pull_ *= -2.0;
  layer_.gradient(model_, pull_, gradient);
  if (curvature_) curvature_->add_gradient(model_, gradient);
}

CheckingError::CheckingError(const Model& model, const TrainingData& data)
    : layer_(model, data),
      whitening_(with_free_offsets(data), static_cast<std::size_t>(layer_.padded_rows())),
      outputs_(padded_outputs(data, Scale{}, layer_.padded_rows())),
      residuals_(outputs_.size()) {}

double CheckingError::operator()(const Model& model) {
  layer_.compute(model);
  layer_.compute_output(model);
  residuals_.array() = outputs_.array() - model.output.centre - model.output.half_range * layer_.output().array();
  whitening_.apply(residuals_);
  return std::sqrt(residuals_.squaredNorm() / whitening_.total_weight());
}

CurvaturePenalty::CurvaturePenalty(const Model& model, const TrainingData& data, double factor)
    : layer_(model, grid(model, data)),
      consequents_(layer_.padded_rows(), static_cast<Index>(consequent_count(model))),
      difference_(layer_.padded_rows()),
      pull_(layer_.padded_rows()),
      own_gradient_(premise_count(model)) {
  // integral f''^2 du = sum d (second difference / d^2)^2
  const double d = layer_.inputs()(1, 0) - layer_.inputs()(0, 0);
  scale_ = std::sqrt(factor / (d * d * d));
}

void CurvaturePenalty::consequent_rows(const Model& model, Eigen::Ref<Eigen::MatrixXd> rows) {
  layer_.compute(model);
  layer_.consequent_matrix(model, consequents_);
  rows.topRows(inner()) = scale_ * second_differences(consequents_, inner());
  rows.bottomRows(rows.rows() - inner()).setZero();
}

Eigen::MatrixXd CurvaturePenalty::jacobian(const Model& model) {
  layer_.compute(model);
  layer_.compute_output(model);
  layer_.consequent_matrix(model, consequents_);
  const Eigen::MatrixXd premises = layer_.jacobian(model);
  Eigen::MatrixXd all(inner(), consequents_.cols() + premises.cols());
  all << second_differences(consequents_, inner()), second_differences(premises, inner());
  return scale_ * all;
}

double CurvaturePenalty::price(const Model& model) {
  layer_.compute_output(model);
  difference_.setZero();
  difference_.segment(1, inner()) = scale_ * second_differences(layer_.output(), inner());
  return difference_.squaredNorm();
}

void CurvaturePenalty::add_gradient(const Model& model, std::span<double> gradient) {
  // d price / df = 2 scale D^T (scale D f)
  const auto own = difference_.segment(1, inner());
  pull_.setZero();
  pull_.head(inner()) += own;
  pull_.segment(1, inner()) -= 2.0 * own;
  pull_.segment(2, inner()) += own;
  pull_ *= 2.0 * scale_;
  layer_.gradient(model, pull_, own_gradient_);
  for (std::size_t i = 0; i < gradient.size(); ++i) gradient[i] += own_gradient_[i];
}

}  // namespace soak::anfis::training
