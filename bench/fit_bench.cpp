// SPDX-License-Identifier: Apache-2.0
// Cost of the whole fit of one curve, and of one unit. An evaluation of the learner contains one least-squares solution
// for the consequents: counter "per_least_squares" counts how many of them the fit takes the time of, in the same run.
// Counter "of_limit" is the processor time of a unit over 0.12 s.
#include <benchmark/benchmark.h>

#include <Eigen/Core>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <ctime>
#include <string>

#include "anfis/data/training_data.h"
#include "anfis/linear/least_squares.h"
#include "base/random.h"
#include "calib/curve/curve_fit.h"
#include "calib/model/unit_model.h"
#include "calib/vocabulary/position.h"

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

constexpr double kGravity_mps2 = 9.80665;

/// Six positions at one plateau: a bias curve of its own for each sensor.
void add_visit(int visit, double plateau_c, const std::array<double, 6>& offset, base::Random& random,
               calib::RunInput& run) {
  for (std::size_t p = 0; p < calib::kSixPositionLabels.size(); ++p) {
    calib::Segment segment;
    segment.key = {run.run_id, "U", visit, std::string(calib::kSixPositionLabels[p]), 0};
    segment.sweep = visit < 21 ? calib::Sweep::up : calib::Sweep::down;
    segment.plateau_c = plateau_c;
    segment.position = calib::position_named(calib::kSixPositionLabels[p]);
    segment.t_start_s = 1200.0 * visit + 70.0 * static_cast<double>(p);
    segment.t_end_s = segment.t_start_s + 60.0;
    segment.temp_c = plateau_c + 0.1 * random.gaussian();
    segment.sensor_temp_c.fill(segment.temp_c);
    for (std::size_t s = 0; s < calib::kSensorCount; ++s) {
      const double size = s < 3 ? 0.002 : 0.02;
      const double noise = 0.001 * size;
      const bool along = s >= 3 && p / 2 == s - 3;
      const double force_mps2 = along ? (p % 2 == 0 ? kGravity_mps2 : -kGravity_mps2) : 0.0;
      const double bias = 4.0 * size * drift_dps(segment.temp_c + 5.0 * static_cast<double>(s));
      segment.sensor[s] = {6000, force_mps2 + bias + offset[s] + noise * random.gaussian(), 6000.0 * noise * noise,
                           noise};
    }
    run.segments.push_back(std::move(segment));
  }
}

/// `runs` runs over 21 plateaus, up and down.
calib::UnitInput unit_of(int runs) {
  base::Random random(1);
  calib::UnitInput input;
  input.unit = "U";
  for (int number = 0; number < runs; ++number) {
    calib::RunInput run;
    run.run_id = run.label = "R" + std::to_string(number + 1);
    run.site.gravity_mps2 = kGravity_mps2;
    std::array<double, 6> offset{};
    for (std::size_t s = 0; s < offset.size(); ++s) offset[s] = (s < 3 ? 2e-5 : 2e-4) * random.gaussian();
    for (int visit = 0; visit < 42; ++visit) {
      add_visit(visit, -30.0 + 5.0 * (visit < 21 ? visit : 41 - visit), offset, random, run);
    }
    input.runs.push_back(std::move(run));
  }
  return input;
}

/// All curves of a unit's six sensors from its segments; argument: runs.
void UnitFit(benchmark::State& state) {
  constexpr double kLimit_s = 0.12;
  const calib::UnitInput input = unit_of(static_cast<int>(state.range(0)));
  const std::clock_t start = std::clock();
  for (auto _ : state) {
    const auto rows = calib::make_rows(input);
    if (!rows) return state.SkipWithError(rows.error().message.c_str());
    for (std::size_t s = 0; s < calib::kSensorCount; ++s) {
      benchmark::DoNotOptimize(calib::fit_sensor(*rows, static_cast<calib::Sensor>(s), {}));
    }
  }
  state.counters["of_limit"] =
      static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC / kLimit_s / static_cast<double>(state.iterations());
}
BENCHMARK(UnitFit)->Arg(3)->Arg(20)->Unit(benchmark::kMillisecond)->Iterations(1);

}  // namespace
}  // namespace soak
