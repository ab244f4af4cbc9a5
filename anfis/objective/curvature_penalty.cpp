// SPDX-License-Identifier: Apache-2.0
#include "anfis/objective/curvature_penalty.h"

#include <algorithm>
#include <cmath>

#include "anfis/premises/premise_bounds.h"

namespace soak::anfis::training {
namespace {

using Eigen::Index;

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
