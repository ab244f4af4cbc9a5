// SPDX-License-Identifier: Apache-2.0
#include "anfis/training/trainer.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>

#include "anfis/least_squares.h"

namespace soak::anfis::training {
namespace {

// Memberships that overlap so far that a consequent moves the curve by 1e-10 of its size are one membership.
constexpr double kConsequentTolerance = 1e-10;

double squared(double value) { return value * value; }

}  // namespace

Model initial_model(const TrainingData& data, const HybridOptions& options) {
  const auto [x_low, x_high] = std::minmax_element(data.x.begin(), data.x.end());
  const auto [y_low, y_high] = std::minmax_element(data.y.begin(), data.y.end());
  Model model;
  model.membership = options.membership;
  model.order = options.order;
  model.x_min = *x_low;
  model.x_max = *x_high;
  model.input_centre = 0.5 * *x_low + 0.5 * *x_high;
  model.input_half_range = 0.5 * *x_high - 0.5 * *x_low;
  model.output_centre = 0.5 * *y_low + 0.5 * *y_high;
  model.output_half_range = *y_high > *y_low ? 0.5 * *y_high - 0.5 * *y_low : 1.0;

  // [Jang93] a = range / (2 (n - 1)), b = 2; sigma = a / sqrt(2 ln 2) has the same crossing points
  const double intervals = options.rules - 1;
  const double half_width = 1.0 / intervals;
  for (int i = 0; i < options.rules; ++i) {
    Rule rule;
    rule.width = options.membership == Membership::bell ? half_width : half_width / std::sqrt(2.0 * std::numbers::ln2);
    rule.slope = options.membership == Membership::bell ? 2.0 : 0.0;
    rule.centre = -1.0 + 2.0 * i / intervals;
    model.rules.push_back(rule);
  }
  return model;
}

std::vector<double> scaled_inputs(const Model& model, const TrainingData& data) {
  std::vector<double> u(data.rows());
  std::transform(data.x.begin(), data.x.end(), u.begin(),
                 [&](double x) { return (x - model.input_centre) / model.input_half_range; });
  return u;
}

Eigen::VectorXd scaled_outputs(const Model& model, const TrainingData& data) {
  const Eigen::Map<const Eigen::VectorXd> y(data.y.data(), static_cast<Eigen::Index>(data.rows()));
  return (y.array() - model.output_centre) / model.output_half_range;
}

Trainer::Trainer(const TrainingData& data, const HybridOptions& options)
    : options_(options),
      model_(initial_model(data, options)),
      whitening_(data.rows(), data.weight, data.group, data.group_variance),
      inputs_(scaled_inputs(model_, data)),
      outputs_(scaled_outputs(model_, data)),
      whitened_outputs_(outputs_),
      layer_(inputs_),
      bounds_(options.membership, inputs_, model_.rules.size()) {
  whitening_.apply(whitened_outputs_);
  bounds_.apply(model_.rules);
}

double Trainer::solve_consequents() {
  layer_.compute(model_.membership, model_.rules);
  // [AH05 eq. 5.12-5.13] min || L (A X - B) ||, A: rows x consequents
  Eigen::MatrixXd a = layer_.consequent_matrix(model_.order);
  whitening_.apply(a);
  const Eigen::VectorXd x = least_squares_coefficients(a, whitened_outputs_, kConsequentTolerance);
  set_consequents(x, model_.order, model_.rules);
  whitened_residuals_ = whitened_outputs_ - a * x;
  return model_.output_half_range * std::sqrt(whitened_residuals_.squaredNorm() / whitening_.total_weight());
}

std::vector<Rule> Trainer::gradient() const {
  Eigen::VectorXd v = whitened_residuals_;
  whitening_.apply_transposed(v);
  // [AH05 eq. 5.17-5.20] dE/d theta = -2 (V^-1 r)^T df/d theta. The consequents are optimal, so that their own change
  // with the premises adds nothing.
  const Eigen::VectorXd g = -2.0 * (layer_.premise_jacobian(model_.membership, model_.rules).transpose() * v);
  const auto count = static_cast<Eigen::Index>(model_.rules.size());
  std::vector<Rule> gradient(model_.rules.size(), Rule{0.0, 0.0, 0.0, 0.0, 0.0});
  for (Eigen::Index i = 0; i < count; ++i) {
    Rule& rule = gradient[static_cast<std::size_t>(i)];
    rule.width = g(i);
    rule.slope = model_.membership == Membership::bell ? g(count + i) : 0.0;
    rule.centre = g(g.size() - count + i);
  }
  return gradient;
}

bool Trainer::move_premises(double step) {
  std::vector<Rule> descent = gradient();
  for (Rule& rule : descent) {
    rule = {-rule.width, -rule.slope, -rule.centre, 0.0, 0.0};
  }
  bounds_.block(model_.rules, descent);
  double norm = 0.0;
  for (const Rule& rule : descent) {
    norm += squared(rule.width) + squared(rule.slope) + squared(rule.centre);
  }
  norm = std::sqrt(norm);
  if (!std::isfinite(norm) || norm == 0.0) {
    return false;
  }
  // [AH05 eq. 5.21-5.22] delta theta = -kappa (dE/d theta) / || dE/d theta ||
  for (std::size_t i = 0; i < descent.size(); ++i) {
    model_.rules[i].width += step * descent[i].width / norm;
    model_.rules[i].slope += step * descent[i].slope / norm;
    model_.rules[i].centre += step * descent[i].centre / norm;
  }
  bounds_.apply(model_.rules);
  return true;
}

}  // namespace soak::anfis::training
