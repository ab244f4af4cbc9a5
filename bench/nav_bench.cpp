// SPDX-License-Identifier: Apache-2.0
// Inertial navigation: IMU epochs per second of one core's time, mechanization alone, with the prediction of 15 and 21
// states, and with a fix at every 100th epoch as well. Beside it the limit of the plain way, measured in the same run:
// the dense product Φ P Φᵀ alone. Then outages on all processors against the same on one thread, in the same run.
#include <benchmark/benchmark.h>

#include <Eigen/Core>
#include <algorithm>
#include <cstddef>
#include <ctime>
#include <limits>
#include <span>
#include <thread>
#include <vector>

#include "base/units.h"
#include "nav/filter/navigation_filter.h"
#include "nav/inertial/mechanization.h"
#include "nav/outages/pipeline.h"
#include "station/nav/outage_batch.h"
#include "station/nav/simulated_drive.h"

namespace soak::nav {
namespace {

using Eigen::Vector3d;

constexpr double kStep_s = 0.01;
constexpr int kEpochsPerFix = 100;
const Vector3d kRate_rps(0.01, -0.02, 0.1);
const Vector3d kForce_mps2(0.1, 0.3, 9.8);
const NavState kBegin{{51.0 * base::kRadPerDeg, -2.0, 1000.0}, {5.0, 10.0, 0.0}, {}};

double seconds_of(clockid_t clock) {
  timespec now{};
  ::clock_gettime(clock, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// Processor time of this thread: what others do on the machine does not count.
double cpu_s() { return seconds_of(CLOCK_THREAD_CPUTIME_ID); }

/// Seconds of one dense Φ P Φᵀ.
template <int N>
double dense_seconds() {
  using Square = Eigen::Matrix<double, N, N>;
  const Square phi = Square::Identity() + 1e-3 * Square::Random();
  Square p = Square::Identity();
  constexpr int kProducts = 100'000;
  const double begin_s = cpu_s();
  for (int i = 0; i < kProducts; ++i) {
    Square half;
    half.noalias() = phi * p;
    p.noalias() = half * phi.transpose();
    p /= p(0, 0);
    benchmark::DoNotOptimize(p.data());
  }
  return (cpu_s() - begin_s) / kProducts;
}

void count_epochs(benchmark::State& state, double seconds) {
  state.counters["epochs_per_s"] = static_cast<double>(state.iterations()) / seconds;
}

void MechanizationAlone(benchmark::State& state) {
  Mechanization ins(kBegin);
  const Increment increment{kStep_s, kStep_s * kRate_rps, kStep_s * kForce_mps2};
  const double begin_s = cpu_s();
  for (auto _ : state) {
    ins.step(increment);
    benchmark::DoNotOptimize(ins.state().velocity_mps.data());
  }
  count_epochs(state, cpu_s() - begin_s);
}
BENCHMARK(MechanizationAlone);

/// Arguments: states; epochs per fix, 0: none.
void Filter(benchmark::State& state) {
  Start start;
  start.state = kBegin;
  FilterOptions options;
  options.sensors = typical_mems();
  options.scale_states = state.range(0) == 21;
  options.gate_probability = 0.0;
  NavigationFilter filter(start, options, {0.2, 0.8, 0.6});
  const auto per_fix = static_cast<std::size_t>(state.range(1));
  GnssFix fix;
  std::size_t epoch = 0;
  const double begin_s = cpu_s();
  for (auto _ : state) {
    filter.predict(kRate_rps, kForce_mps2, kStep_s);
    if (per_fix == 0 || ++epoch % per_fix != 0) continue;
    fix.position = filter.antenna();
    fix.velocity_mps = filter.antenna_velocity_mps();
    filter.update_position(fix);
    filter.update_velocity(fix);
  }
  const double seconds = cpu_s() - begin_s;
  count_epochs(state, seconds);
  const double dense_s = options.scale_states ? dense_seconds<21>() : dense_seconds<15>();
  state.counters["dense_products_per_s"] = 1.0 / dense_s;
  state.counters["of_dense"] = static_cast<double>(state.iterations()) / seconds * dense_s;
}
BENCHMARK(Filter)->Args({15, 0})->Args({15, kEpochsPerFix})->Args({15, 1})->Args({21, kEpochsPerFix});

/// The least time that some outages took.
struct Fastest {
  double wall_s = std::numeric_limits<double>::infinity();
  double cpu_s = std::numeric_limits<double>::infinity();  ///< of all threads

  void run(const Drive& drive, std::span<const station::OutageTask> tasks, std::span<const Pipeline> pipelines,
           int jobs) {
    const double wall_begin_s = seconds_of(CLOCK_MONOTONIC);
    const double cpu_begin_s = seconds_of(CLOCK_PROCESS_CPUTIME_ID);
    const auto results = station::run_outages({&drive, 1}, tasks, pipelines, jobs, [](double) { return true; });
    benchmark::DoNotOptimize(results.value().data());
    wall_s = std::min(wall_s, seconds_of(CLOCK_MONOTONIC) - wall_begin_s);
    cpu_s = std::min(cpu_s, seconds_of(CLOCK_PROCESS_CPUTIME_ID) - cpu_begin_s);
  }
};

/// `faster`: by how much all processors are faster than one thread; others on the machine make it less. `cpu_ratio`:
/// processor time of the one over that of the other, whatever others do; above 1 the threads are in each other's way.
void OutageRunner(benchmark::State& state) {
  constexpr std::size_t kOutages = 24;
  station::DriveRequest request;
  request.errors = ahrs400ca();
  const Drive drive = station::simulated_drive(request);
  std::vector<station::OutageTask> tasks;
  const auto outages = spread_outages(drive, 120.0, 30.0, kOutages).value();
  for (const Outage& outage : outages) tasks.push_back({0, outage});
  const std::vector<Pipeline> pipelines = {filter_pipeline(station::raw_filter())};
  Fastest alone;
  Fastest together;
  for (auto _ : state) {
    alone.run(drive, tasks, pipelines, 1);
    together.run(drive, tasks, pipelines, 0);
  }
  state.counters["threads"] = static_cast<double>(std::thread::hardware_concurrency());
  state.counters["faster"] = alone.wall_s / together.wall_s;
  state.counters["cpu_ratio"] = together.cpu_s / alone.cpu_s;
}
BENCHMARK(OutageRunner)->Iterations(5)->UseRealTime()->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace soak::nav
