// SPDX-License-Identifier: Apache-2.0
// Speed of learning. Every epoch contains one least-squares solution for the consequents: "per_least_squares" is its
// time over that of the general solver on a matrix of the same size, measured in the same run.
#include <benchmark/benchmark.h>

#include <Eigen/Core>
#include <algorithm>
#include <chrono>
#include <string>
#include <utility>

#include "anfis/linear/least_squares.h"
#include "anfis/model/rule_base.h"
#include "anfis/train/learner.h"
#include "base/random.h"
#include "tests/anfis/curves.h"
#include "tests/anfis/support.h"

namespace soak::anfis {
namespace {

double now_s() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

double seconds_of_least_squares(std::size_t rows, std::size_t columns) {
  const Eigen::MatrixXd a =
      Eigen::MatrixXd::Random(static_cast<Eigen::Index>(rows), static_cast<Eigen::Index>(columns));
  const Eigen::VectorXd b = Eigen::VectorXd::Random(static_cast<Eigen::Index>(rows));
  double least = 1e9;
  for (int i = 0; i < 20; ++i) {
    const double start = now_s();
    benchmark::DoNotOptimize(least_squares_coefficients(a, b));
    least = std::min(least, now_s() - start);
  }
  return least;
}

TrainingData scattered_rows(std::size_t rows) {
  TrainingData data;
  base::Random random(1);
  for (std::size_t i = 0; i < rows; ++i) {
    data.x.push_back(random.uniform(-30.0, 70.0));
    data.y.push_back(std::sin(data.x.back() / 15.0) + 0.01 * random.gaussian());
  }
  return data;
}

void train_epochs(benchmark::State& state, const TrainingData& data, int rules, int epochs) {
  RuleBaseOptions base;
  base.memberships = {rules};
  const Model initial = *grid_rules(data, base);
  HybridOptions options;
  options.epochs = epochs;
  double least = 1e9;
  for (auto _ : state) {
    const double start = now_s();
    benchmark::DoNotOptimize(train_hybrid(initial, data, options));
    least = std::min(least, now_s() - start);
  }
  state.counters["us_per_epoch"] = 1e6 * least / epochs;
  state.counters["per_least_squares"] =
      least / epochs / seconds_of_least_squares(data.rows(), consequent_count(initial));
}

/// 273 measured points, 13 runs of 21 temperatures as in [AH05 §6.4.2]: 6 bells, order 1, 100 epochs.
void HundredEpochs(benchmark::State& state) {
  TrainingData data = test::gyro_drift(true);
  data.group.clear();
  train_epochs(state, data, 6, 100);
}
BENCHMARK(HundredEpochs)->Unit(benchmark::kMillisecond);

/// The same with a random offset per run.
void HundredEpochsWithGroups(benchmark::State& state) {
  TrainingData data = test::gyro_drift(true);
  data.group_variance = 1.0;
  train_epochs(state, data, 6, 100);
}
BENCHMARK(HundredEpochsWithGroups)->Unit(benchmark::kMillisecond);

/// Two decades of rows; "ns_per_row" must stay level.
void EpochsByRows(benchmark::State& state) {
  const auto rows = static_cast<std::size_t>(state.range(0));
  train_epochs(state, scattered_rows(rows), 6, 20);
  state.counters["ns_per_row"] = 1e3 * state.counters["us_per_epoch"] / static_cast<double>(rows);
}
BENCHMARK(EpochsByRows)->RangeMultiplier(10)->Range(100, 10000)->Unit(benchmark::kMillisecond);

/// Two decades of rules. The inference is linear in them; least squares takes the square of their number.
void EpochsByRules(benchmark::State& state) {
  const auto rules = static_cast<int>(state.range(0));
  train_epochs(state, scattered_rows(2000), rules, 3);
  state.counters["us_per_rule"] = state.counters["us_per_epoch"] / rules;
}
BENCHMARK(EpochsByRules)->Arg(2)->Arg(6)->Arg(20)->Arg(60)->Arg(200)->Unit(benchmark::kMillisecond);

void EvaluateByRules(benchmark::State& state) {
  RuleBaseOptions base;
  base.memberships = {static_cast<int>(state.range(0))};
  const TrainingData data = scattered_rows(2000);
  const Model model = *grid_rules(data, base);
  std::vector<double> y(data.rows());
  double least = 1e9;
  for (auto _ : state) {
    const double start = now_s();
    evaluate(model, data.x, y);
    benchmark::DoNotOptimize(y.data());
    least = std::min(least, now_s() - start);
  }
  state.counters["ns_per_point_and_rule"] = 1e9 * least / (2000.0 * static_cast<double>(state.range(0)));
}
BENCHMARK(EvaluateByRules)->Arg(2)->Arg(6)->Arg(20)->Arg(60)->Arg(200)->Unit(benchmark::kMicrosecond);

/// Six sensors of 20 runs at 21 temperatures: search over 2..10 Gaussians (as far as the temperatures carry them), five
/// folds, at most 12 evaluations each, then variable projection on all runs, at most 200 evaluations. The product
/// searches two shapes, Gaussians and bells.
void WholeUnit(benchmark::State& state) {
  std::vector<TrainingData> sensors;
  for (unsigned seed = 1; seed <= 6; ++seed) sensors.push_back(test::drift_problem(seed, 20).data);
  std::size_t candidates = 0;
  double least = 1e9;
  for (auto _ : state) {
    const double start = now_s();
    for (const TrainingData& data : sensors) {
      const StructureSearch found = test::search_curve(data, 5, Shape::gaussian);
      candidates = found.curve.size();
      if (state.range(0) == 2) benchmark::DoNotOptimize(test::search_curve(data, 5, Shape::bell));
      benchmark::DoNotOptimize(test::learn_curve(data, found.chosen, Shape::gaussian));
    }
    least = std::min(least, now_s() - start);
  }
  state.counters["least_ms"] = 1e3 * least;
  state.counters["rule_counts"] = static_cast<double>(candidates);
  state.counters["per_least_squares"] = least / seconds_of_least_squares(420, 12);
}
BENCHMARK(WholeUnit)->ArgName("shapes")->Arg(1)->Arg(2)->Unit(benchmark::kMillisecond)->Iterations(10);

}  // namespace
}  // namespace soak::anfis
