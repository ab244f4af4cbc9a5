// SPDX-License-Identifier: Apache-2.0
#include "anfis/model.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>

#include "anfis/inference/membership.h"

namespace soak::anfis {
namespace {

// Keeps every power and product finite; no input of a real model comes near so many half ranges.
constexpr double kFarthest = 1e100;

double scaled_input(const Model& model, double x) {
  const double u = x / model.input_half_range - model.input_centre / model.input_half_range;
  return std::clamp(u, -kFarthest, kFarthest);
}

// Working memory of one evaluation: models are small, and evaluation is called point by point.
struct Scratch {
  explicit Scratch(std::size_t rules) : distance(rules), strength(rules) {}
  std::vector<double> distance;
  std::vector<double> strength;
};

void strengths_at(const Model& model, double u, Scratch& scratch) {
  for (std::size_t i = 0; i < model.rules.size(); ++i) {
    scratch.distance[i] = inference::distance_measure(model.membership, model.rules[i], u);
    scratch.strength[i] = inference::membership_degree(model.membership, model.rules[i], scratch.distance[i]);
  }
  inference::normalise_strengths(model.membership, model.rules, scratch.distance, scratch.strength);
}

double evaluate_with(const Model& model, double x, Scratch& scratch) {
  const double u = scaled_input(model, x);
  strengths_at(model, u, scratch);
  // [AH05 eq. 5.10-5.11] f = sum wbar_i (gain_i u + offset_i)
  double f = 0.0;
  for (std::size_t i = 0; i < model.rules.size(); ++i) {
    f += scratch.strength[i] * (model.rules[i].gain * u + model.rules[i].offset);
  }
  return model.output_centre + model.output_half_range * f;
}

base::Status validate_rule(const Model& model, const Rule& rule, const std::string& where) {
  if (!std::isfinite(rule.width) || !std::isfinite(rule.slope) || !std::isfinite(rule.centre) ||
      !std::isfinite(rule.gain) || !std::isfinite(rule.offset)) {
    return base::bad_input("a parameter of the rule is not a finite number", where);
  }
  if (rule.width <= 0.0) {
    return base::bad_input("the width must be positive", where);
  }
  if (model.membership == Membership::bell ? rule.slope <= 0.0 : rule.slope != 0.0) {
    return base::bad_input("the slope must be positive for a bell and 0 for a Gaussian", where);
  }
  if (model.order == 0 && rule.gain != 0.0) {
    return base::bad_input("the gain must be 0 in a model of order 0", where);
  }
  return {};
}

}  // namespace

std::string_view name(Membership membership) { return membership == Membership::bell ? "bell" : "gaussian"; }

base::Status validate(const Model& model) {
  if (model.order != 0 && model.order != 1) {
    return base::bad_input("the order must be 0 or 1, not " + std::to_string(model.order), "order");
  }
  if (!std::isfinite(model.input_centre) || !std::isfinite(model.output_centre)) {
    return base::bad_input("the centres of input and output must be finite numbers", "input_centre, output_centre");
  }
  if (!std::isfinite(model.input_half_range) || !std::isfinite(model.output_half_range) ||
      model.input_half_range <= 0.0 || model.output_half_range <= 0.0) {
    return base::bad_input("the half ranges of input and output must be positive finite numbers",
                           "input_half_range, output_half_range");
  }
  if (!std::isfinite(model.x_min) || !std::isfinite(model.x_max) || model.x_min > model.x_max) {
    return base::bad_input("the training range must be finite with x_min <= x_max", "x_min, x_max");
  }
  if (model.rules.empty()) {
    return base::bad_input("a model needs at least one rule", "rules");
  }
  for (std::size_t i = 0; i < model.rules.size(); ++i) {
    if (auto status = validate_rule(model, model.rules[i], "rules[" + std::to_string(i) + "]"); !status) {
      return status;
    }
  }
  return {};
}

double evaluate(const Model& model, double x) {
  Scratch scratch(model.rules.size());
  return evaluate_with(model, x, scratch);
}

void evaluate(const Model& model, std::span<const double> x, std::span<double> y) {
  Scratch scratch(model.rules.size());
  std::transform(x.begin(), x.end(), y.begin(), [&](double value) { return evaluate_with(model, value, scratch); });
}

void firing_strengths(const Model& model, double x, std::span<double> strengths) {
  Scratch scratch(model.rules.size());
  strengths_at(model, scaled_input(model, x), scratch);
  std::copy(scratch.strength.begin(), scratch.strength.end(), strengths.begin());
}

}  // namespace soak::anfis
