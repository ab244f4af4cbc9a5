// SPDX-License-Identifier: Apache-2.0
#include "nav/learned/error_model.h"

#include <algorithm>
#include <cmath>

#include "anfis/data/training_data.h"
#include "anfis/select/fuzzy_ols.h"
#include "base/statistics.h"

namespace soak::nav {
namespace {

using Eigen::Vector3d;

constexpr std::size_t kFewestOutages = 4;
/// That what is believed does carry: two-sided, by Student's t.
constexpr double kConfidence = 0.95;
/// Consequents begin as they were learnt off line: one outage must not overturn what many have taught.
constexpr double kInitialCovariance = 3e-3;

Eigen::Index index(std::size_t output) { return static_cast<Eigen::Index>(output); }

ErrorInputs within_range(const anfis::Model& model, ErrorInputs inputs) {
  for (std::size_t j = 0; j < kErrorInputs; ++j) {
    inputs[j] = std::clamp(inputs[j], model.inputs[j].min, model.inputs[j].max);
  }
  return inputs;
}

/// The outputs that are judged together with this one.
std::span<const std::size_t> judged_with(std::size_t output) {
  static constexpr std::size_t kAll[] = {0, 1, 2, 3, 4, 5};
  const std::size_t first = output / 3 * 3;
  return output % 3 == 2 ? std::span(kAll).subspan(output, 1) : std::span(kAll).subspan(first, 2);
}

ErrorOutputs shape_after(double since_fix_s) {
  ErrorOutputs shape;
  shape << Vector3d::Constant(since_fix_s * since_fix_s), Vector3d::Constant(since_fix_s);
  return shape;
}

base::Result<anfis::Model> learn_output(const anfis::TrainingData& data, const ErrorLearning& learning) {
  anfis::FuzzyOlsOptions structure;
  structure.clusters = learning.rules;
  structure.clustering.starts = 1;
  structure.consequent_threshold = learning.consequent_threshold;
  auto learnt = anfis::fuzzy_ols(data, structure);
  if (!learnt) return base::forward_error(learnt);
  if (!learning.refinement) return std::move(learnt->model);
  auto refined = anfis::train(learnt->model, data, *learning.refinement);
  if (!refined) return base::forward_error(refined);
  return std::move(refined->model);
}

}  // namespace

void ErrorGrowth::add(double since_fix_s, const ErrorOutputs& error) {
  squares_ += error.cwiseAbs2();
  shapes_ += shape_after(since_fix_s).cwiseAbs2();
}

ErrorOutputs ErrorGrowth::sigma_after(double since_fix_s) const {
  if (shapes_(0) <= 0.0) return ErrorOutputs::Zero();
  return squares_.cwiseQuotient(shapes_).cwiseSqrt().cwiseProduct(shape_after(since_fix_s));
}

ExpectedError expected_error(const ErrorModel& model, const ErrorInputs& inputs) {
  ExpectedError expected{{}, model.growth.sigma_after(inputs.front())};
  for (std::size_t k = 0; k < kErrorOutputs; ++k) {
    expected.error(index(k)) = anfis::evaluate(model.outputs[k], within_range(model.outputs[k], inputs));
  }
  return expected;
}

base::Result<ErrorModel> learn_errors(std::span<const ErrorWindow> windows, const ErrorLearning& learning) {
  anfis::TrainingData data;
  data.inputs = kErrorInputs;
  std::array<std::vector<double>, kErrorOutputs> errors;
  for (std::size_t w = 0; w < windows.size(); ++w) {
    // Each outage begins with another row: a model that knows few times only may say anything between them.
    for (std::size_t i = w % learning.every; i < windows[w].rows.size(); i += learning.every) {
      const ErrorRow& row = windows[w].rows[i];
      data.x.insert(data.x.end(), row.inputs.begin(), row.inputs.end());
      data.group.push_back(static_cast<int>(w));
      for (std::size_t k = 0; k < kErrorOutputs; ++k) errors[k].push_back(row.error(index(k)));
    }
  }
  ErrorModel model;
  for (std::size_t k = 0; k < kErrorOutputs; ++k) {
    data.y = errors[k];
    auto output = learn_output(data, learning);
    if (!output) return base::forward_error(output);
    model.outputs[k] = *std::move(output);
  }
  for (const ErrorWindow& window : windows) {
    for (const ErrorRow& row : window.rows) {
      model.growth.add(row.inputs.front(), row.error - expected_error(model, row.inputs).error);
    }
  }
  return model;
}

base::Result<FollowingErrorModel> FollowingErrorModel::of(const ErrorModel& model, double rows_per_window) {
  anfis::OnlineOptions options;
  options.forgetting = 1.0 - 1.0 / rows_per_window;
  options.initial_covariance = kInitialCovariance;
  std::vector<anfis::OnlineConsequents> outputs;
  for (const anfis::Model& output : model.outputs) {
    auto following = anfis::OnlineConsequents::of(output, options);
    if (!following) return base::forward_error(following);
    outputs.push_back(*std::move(following));
  }
  return FollowingErrorModel(std::move(outputs));
}

ErrorOutputs FollowingErrorModel::foretell(const ErrorInputs& inputs) const {
  ErrorOutputs error;
  for (std::size_t k = 0; k < kErrorOutputs; ++k) {
    const anfis::Model& model = outputs_[k].model();
    error(index(k)) = anfis::evaluate(model, within_range(model, inputs));
  }
  return error;
}

void FollowingErrorModel::follow(const ErrorWindow& window) {
  if (window.rows.empty()) return;
  Score score{ErrorOutputs::Zero(), ErrorOutputs::Zero()};
  for (const ErrorRow& row : window.rows) {
    const ErrorOutputs left = row.error - foretell(row.inputs);
    score.before += row.error.cwiseAbs2();
    score.after += left.cwiseAbs2();
    growth_.add(row.inputs.front(), left);
  }
  const auto rows = static_cast<double>(window.rows.size());
  score.before = (score.before / rows).cwiseSqrt();
  score.after = (score.after / rows).cwiseSqrt();
  scores_.push_back(score);
  for (const ErrorRow& row : window.rows) {
    for (std::size_t k = 0; k < kErrorOutputs; ++k) {
      // A row that is refused leaves the consequents as they are, and the next one comes in a second.
      (void)outputs_[k].update(within_range(outputs_[k].model(), row.inputs), row.error(index(k)));
    }
  }
}

bool FollowingErrorModel::carries(std::size_t output) const {
  if (scores_.size() < kFewestOutages) return false;
  double sum = 0.0;
  double squares = 0.0;
  for (const Score& score : scores_) {
    double before = 0.0;
    double after = 0.0;
    for (const std::size_t k : judged_with(output)) {
      before = std::hypot(before, score.before(index(k)));
      after = std::hypot(after, score.after(index(k)));
    }
    sum += before - after;
    squares += (before - after) * (before - after);
  }
  const auto count = static_cast<double>(scores_.size());
  const double mean = sum / count;
  const double variance = std::max(0.0, squares / count - mean * mean) / (count - 1.0);
  return mean > base::student_t_two_sided(kConfidence, count - 1.0) * std::sqrt(variance);
}

ExpectedError FollowingErrorModel::expected(const ErrorInputs& inputs) const {
  ExpectedError expected{foretell(inputs), growth_.sigma_after(inputs.front())};
  for (std::size_t k = 0; k < kErrorOutputs; ++k) {
    if (carries(k)) continue;
    expected.error(index(k)) = 0.0;
    expected.sigma(index(k)) = kUnknownError;
  }
  return expected;
}

}  // namespace soak::nav
