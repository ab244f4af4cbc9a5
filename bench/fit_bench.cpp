// SPDX-License-Identifier: Apache-2.0
// Cost of the whole fit of one curve. An evaluation of the learner contains one least-squares solution for the
// consequents: counter "per_least_squares" counts how many of them the fit takes the time of, in the same run.
#include <benchmark/benchmark.h>

#include <Eigen/Core>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <string>

#include "anfis/data/training_data.h"
#include "anfis/linear/least_squares.h"
#include "base/random.h"
#include "calib/curve/curve_fit.h"

namespace soak {
namespace {

double drift_dps(double temp_c) {
  return 0.25 * std::atan((temp_c - 15.0) / 25.0) + 0.1 * std::exp(-0.5 * std::pow((temp_c - 34.0) / 7.0, 2));
}

/// 21 temperatures × `runs`: 13 runs are the 273 points of [AH05 §6.4.2].
anfis::TrainingData drift_data(int runs) {
  anfis::TrainingData data;
  base::Random random(1);
  for (int run = 0; run < runs; ++run) {
    for (int plateau = 0; plateau < 21; ++plateau) {
      data.x.push_back(-30.0 + 5.0 * plateau);
      data.y.push_back(drift_dps(data.x.back()) + 0.002 * random.gaussian());
    }
  }
  return data;
}

double seconds_of_least_squares(std::size_t rows, int columns) {
  const Eigen::MatrixXd a = Eigen::MatrixXd::Random(static_cast<Eigen::Index>(rows), columns);
  const Eigen::VectorXd b = Eigen::VectorXd::Random(static_cast<Eigen::Index>(rows));
  constexpr int repetitions = 200;
  const auto start = std::chrono::steady_clock::now();
  for (int i = 0; i < repetitions; ++i) benchmark::DoNotOptimize(anfis::least_squares_coefficients(a, b));
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count() / repetitions;
}

/// Whole fit of one curve: rule search in inner folds, outer folds, baselines; argument: runs.
void CurveFit(benchmark::State& state) {
  calib::CurveData data;
  const anfis::TrainingData rows = drift_data(static_cast<int>(state.range(0)));
  for (std::size_t i = 0; i < rows.rows(); ++i) {
    const int run = static_cast<int>(i / 21);
    data.rows.push_back({run, run, calib::Sweep::up, 0.0, rows.x[i], rows.y[i], 0.002});
  }
  for (int run = 0; run < state.range(0); ++run) data.runs.push_back(std::to_string(run));
  data.branches = data.runs;
  double seconds = 0.0;
  for (auto _ : state) {
    const auto start = std::chrono::steady_clock::now();
    benchmark::DoNotOptimize(calib::fit_curve(data, {}, {"gyro_x", "deg/s", 1.0}));
    seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  }
  state.counters["per_least_squares"] =
      seconds / static_cast<double>(state.iterations()) / seconds_of_least_squares(rows.rows(), 12);
}
BENCHMARK(CurveFit)->Arg(4)->Arg(20)->Unit(benchmark::kMillisecond)->Iterations(2);

}  // namespace
}  // namespace soak
