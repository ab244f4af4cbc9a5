// SPDX-License-Identifier: Apache-2.0
// Learns a curve with a band from noisy points, finds the number of rules by itself, saves it and loads it again.
// How to build it outside of this tree: CMakeLists.txt.
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "anfis/model/rule_base.h"
#include "anfis/persist/model_json.h"
#include "anfis/select/structure_search.h"
#include "anfis/select/uncertainty.h"
#include "anfis/train/learner.h"
#include "base/random.h"

namespace anfis = soak::anfis;

namespace {

/// Eight runs over 21 temperatures. Each run has its own offset; 1/weight is the variance of a point.
anfis::TrainingData measured_points() {
  soak::base::Random random(2026);
  anfis::TrainingData data;
  for (int run = 0; run < 8; ++run) {
    const double offset = 0.02 * random.gaussian();
    for (int i = 0; i <= 20; ++i) {
      const double temp_c = -30.0 + 5.0 * i;
      const double drift =
          0.25 * std::tanh((temp_c - 20.0) / 30.0) + 0.1 * std::exp(-0.01 * std::pow(temp_c - 35.0, 2));
      data.x.push_back(temp_c);
      data.y.push_back(drift + offset + 0.002 * random.gaussian());
      data.weight.push_back(1.0 / (0.002 * 0.002));
      data.group.push_back(run);
    }
  }
  data.group_variance = 0.02 * 0.02;
  return data;
}

int fail(const soak::base::Error& error) {
  std::fprintf(stderr, "%s: %s\n", error.where.c_str(), error.message.c_str());
  return 1;
}

}  // namespace

int main() {
  const anfis::TrainingData data = measured_points();

  // How many rules? Runs are left out in turn, whole: two of the eight at a time.
  anfis::VariableProjectionOptions learner;
  learner.smoothness = 1e-7;
  anfis::StructureSearchOptions search;
  search.rule_base.shape = anfis::Shape::gaussian;
  search.learner = learner;
  std::vector<int> fold;
  for (const int run : data.group) fold.push_back(run % 4);
  const auto found = anfis::search_structure(data, fold, search);
  if (!found) return fail(found.error());
  for (const anfis::StructureSearchPoint& point : found->curve) {
    std::printf("%2d rules: error on runs left out %.5f +- %.5f%s\n", point.rules, point.mean_error,
                point.standard_error, point.memberships == found->chosen ? "  <- chosen" : "");
  }

  // Train that structure on all runs.
  anfis::RuleBaseOptions rule_base = search.rule_base;
  rule_base.memberships = {found->chosen};
  const auto initial = anfis::grid_rules(data, rule_base);
  if (!initial) return fail(initial.error());
  const auto training = anfis::train(*initial, data, search.learner);
  if (!training) return fail(training.error());
  std::printf("%s\n", training->summary.one_line().c_str());

  // The curve with the half-width of its 95 % band (normal quantile).
  const auto variance = anfis::PredictionVariance::of(training->model, data, learner.smoothness);
  if (!variance) return fail(variance.error());
  for (const double temp_c : {-30.0, 0.0, 35.0, 70.0, 85.0}) {
    const anfis::Inference inference = anfis::infer(training->model, std::span(&temp_c, 1));
    std::printf("%6.1f: %8.5f +- %.5f%s\n", temp_c, inference.value, 1.96 * std::sqrt(variance->at(temp_c)),
                inference.in_range ? "" : "  outside the range of the data");
  }

  // To text and back: every number is the same.
  const auto saved = anfis::model_to_json(training->model);
  if (!saved) return fail(saved.error());
  const auto loaded = anfis::model_from_json(nlohmann::json::parse(saved->dump()));
  if (!loaded) return fail(loaded.error());
  return *loaded == training->model ? 0 : 1;
}
