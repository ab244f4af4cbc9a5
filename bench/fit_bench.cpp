// SPDX-License-Identifier: Apache-2.0
// Cost of fitting. An epoch of hybrid learning contains one least-squares solution for the consequents, so that is the
// limit that it is compared with: counter "per_least_squares" is their ratio in the same run.
#include <benchmark/benchmark.h>

#include <Eigen/Core>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <string>

#include "anfis/hybrid_learning.h"
#include "anfis/least_squares.h"
#include "base/random.h"
#include "calib/curve_fit.h"

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

/// 100 epochs, six bells, order 1; argument: runs.
void Epochs(benchmark::State& state) {
  const anfis::TrainingData data = drift_data(static_cast<int>(state.range(0)));
  anfis::HybridOptions options;
  options.rules = 6;
  options.epochs = 100;
  double seconds = 0.0;
  for (auto _ : state) {
    const auto start = std::chrono::steady_clock::now();
    benchmark::DoNotOptimize(anfis::train_hybrid(data, options));
    seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  }
  const double per_epoch = seconds / (static_cast<double>(state.iterations()) * options.epochs);
  state.counters["ms_per_epoch"] = per_epoch * 1e3;
  state.counters["per_least_squares"] = per_epoch / seconds_of_least_squares(data.rows(), 12);
}
BENCHMARK(Epochs)->Arg(4)->Arg(13)->Arg(40)->Unit(benchmark::kMillisecond);

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
  for (auto _ : state) benchmark::DoNotOptimize(calib::fit_curve(data, {}, {"gyro_x", "deg/s", 1.0}));
}
BENCHMARK(CurveFit)->Arg(4)->Arg(20)->Unit(benchmark::kMillisecond)->Iterations(2);

}  // namespace
}  // namespace soak
