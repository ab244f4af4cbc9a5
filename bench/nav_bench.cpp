// SPDX-License-Identifier: Apache-2.0
// Inertial navigation: IMU epochs per second of one core's time, mechanization alone, with the prediction of 15 and 21
// states, and with a fix at every 100th epoch as well. Beside it the limit of the plain way, measured in the same run:
// the dense product Φ P Φᵀ alone.
#include <benchmark/benchmark.h>

#include <Eigen/Core>
#include <cstddef>
#include <ctime>

#include "base/units.h"
#include "nav/filter/navigation_filter.h"
#include "nav/inertial/mechanization.h"
#include "nav/outages/pipeline.h"

namespace soak::nav {
namespace {

using Eigen::Vector3d;

constexpr double kStep_s = 0.01;
constexpr int kEpochsPerFix = 100;
const Vector3d kRate_rps(0.01, -0.02, 0.1);
const Vector3d kForce_mps2(0.1, 0.3, 9.8);
const NavState kBegin{{51.0 * base::kRadPerDeg, -2.0, 1000.0}, {5.0, 10.0, 0.0}, {}};

/// Processor time of this thread: what others do on the machine does not count.
double cpu_s() {
  timespec now{};
  ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

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

}  // namespace
}  // namespace soak::nav
