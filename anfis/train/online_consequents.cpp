// SPDX-License-Identifier: Apache-2.0
#include "anfis/train/online_consequents.h"

#include <cmath>
#include <string>
#include <utility>
#include "anfis/train/detail/training_steps.h"

#include "anfis/objective/consequents.h"
#include "base/text.h"

namespace soak::anfis {
namespace {

base::Status validate_row(const Model& model, std::span<const double> x, double y) {
  if (x.size() != model.inputs.size()) {
    return base::bad_input(
        "the row has " + std::to_string(x.size()) + " inputs, the model " + std::to_string(model.inputs.size()), "x");
  }
  for (std::size_t j = 0; j < x.size(); ++j) {
    if (x[j] >= model.inputs[j].min && x[j] <= model.inputs[j].max) continue;
    return base::bad_input("the input is not a number in the range of the model: leave the row out",
                           "x[" + std::to_string(j) + "]");
  }
  if (std::isfinite(y)) return {};
  return base::bad_input("the output is not a finite number: leave the row out", "y");
}

Eigen::VectorXd consequents_of(const Model& model) {
  Eigen::VectorXd consequents(static_cast<Eigen::Index>(consequent_count(model)));
  Eigen::Index next = 0;
  training::for_each_consequent(model, [&](std::size_t i, int j) {
    const Rule& rule = model.rules[i];
    consequents(next++) = j < 0 ? rule.offset : rule.gains[static_cast<std::size_t>(j)];
  });
  return consequents;
}

}  // namespace

base::Status OnlineOptions::validate() const {
  return training::check_options({{
      {"forgetting", forgetting, forgetting > 0.0 && forgetting <= 1.0, "above 0, at most 1"},
      {"initial_covariance", initial_covariance, initial_covariance > 0.0 && initial_covariance <= 1e9,
       "above 0, at most 1e9"},
  }});
}

base::Result<OnlineConsequents> OnlineConsequents::of(Model model, const OnlineOptions& options) {
  if (auto status = options.validate(); !status) return base::forward_error(status);
  if (auto status = validate(model); !status) return base::forward_error(status);
  return OnlineConsequents(std::move(model), options);
}

OnlineConsequents::OnlineConsequents(Model model, const OnlineOptions& options)
    : model_(std::move(model)),
      solver_(consequent_count(model_), options.initial_covariance, options.forgetting),
      strengths_(model_.rules.size()),
      regressors_(solver_.coefficients().size()) {
  solver_.restart(consequents_of(model_));
}

base::Status OnlineConsequents::update(std::span<const double> x, double y) {
  if (auto status = validate_row(model_, x, y); !status) return status;
  set_regressors(x);
  const bool taken = solver_.update(regressors_, model_.output.scaled(y));
  if (!taken || solver_.coefficients().cwiseAbs().maxCoeff() > kLargestNumber) {
    if (taken) solver_.restart(consequents_of(model_));
    return base::bad_input("the output is so large that the consequents would exceed 1e100: leave the row out", "y");
  }
  training::set_consequents(solver_.coefficients(), model_);
  return {};
}

/// [AH05 eq. 5.11] row of A: wbar_i (u, 1), rule by rule
void OnlineConsequents::set_regressors(std::span<const double> x) {
  firing_strengths(model_, x, strengths_);
  Eigen::Index next = 0;
  training::for_each_consequent(model_, [&](std::size_t i, int j) {
    const auto input = static_cast<std::size_t>(j);
    regressors_(next++) = strengths_[i] * (j < 0 ? 1.0 : model_.inputs[input].scale.scaled(x[input]));
  });
}

}  // namespace soak::anfis
