// SPDX-License-Identifier: Apache-2.0
// Section 6.4.3 of the thesis: what a thermal calibration leaves of the position error of a unit that navigates alone,
// by eq. 6.6, the constant of the power-on removed. Simulated units whose gyro has a thermal curve of 0.5 deg/s and the
// noise of three makers' tables; their calibrations come from campaigns as the thesis' (21 plateaus) of 20 and of 6
// runs.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <utility>
#include <vector>

#include "base/random.h"
#include "base/units.h"
#include "calib/curve/curve_fit.h"
#include "nav/inertial/drift.h"
#include "nav/outages/bootstrap.h"
#include "nav/scenario/simulated_errors.h"
#include "station/nav/simulated_drive.h"

namespace soak::station {
namespace {

constexpr int kUnits = 12;
constexpr double kLowest_c = -30.0;
constexpr double kHighest_c = 70.0;
constexpr double kApart_c = 5.0;
/// Six positions of a minute at each plateau: each counts for the gyro's bias.
constexpr double kVisit_s = 360.0;
constexpr int kPowerOns = 200;

/// Standard deviation of a visit's mean: white noise and a Gauss-Markov process over kVisit_s.
double visit_sigma(const nav::SensorErrors& gyro) {
  const double share = gyro.markov_time_s / kVisit_s;
  const double markov = 2.0 * share * (1.0 - share * (1.0 - std::exp(-1.0 / share)));
  return std::hypot(gyro.white / std::sqrt(kVisit_s), gyro.markov_sigma * std::sqrt(markov));
}

/// A unit's curve: the smooth step of the simulated drives, somewhere else in each unit.
double curve_rps(double temp_c, double shift_c) { return example_curve(calib::Sensor::gyro_x, temp_c + shift_c); }

base::Result<calib::CurveFit> calibrated(const nav::SensorErrors& gyro, double shift_c, int runs,
                                         base::Random& random) {
  calib::CurveData data;
  const double sigma = visit_sigma(gyro);
  for (int run = 0; run < runs; ++run) {
    const double power_on = gyro.power_on_sigma * random.gaussian();
    for (double temp_c = kLowest_c; temp_c <= kHighest_c; temp_c += kApart_c) {
      const double value = curve_rps(temp_c, shift_c) + power_on + sigma * random.gaussian();
      data.rows.push_back({run, run, calib::Sweep::up, 0.0, temp_c, value, sigma});
    }
    data.runs.push_back(std::to_string(run));
    data.branches.push_back(std::to_string(run));
  }
  data.by_plateau = true;
  return calib::fit_curve(data, {}, {"gyro_x", "deg/s", 1.0 / base::kRadPerDeg});
}

/// Mean drifts of one unit over power-ons, in m.
struct Drift {
  double without_m = 0.0;
  double with_m = 0.0;
};

/// The temperature at power-on and the one in the outage are anywhere in the range.
Drift drift_of(const calib::Curve& model, double shift_c, double time_s, base::Random& random) {
  Drift drift;
  for (int i = 0; i < kPowerOns; ++i) {
    const double from_c = kLowest_c + (kHighest_c - kLowest_c) * random.uniform();
    const double to_c = kLowest_c + (kHighest_c - kLowest_c) * random.uniform();
    const double change = curve_rps(to_c, shift_c) - curve_rps(from_c, shift_c);
    const double left = change - (calib::evaluate(model, to_c) - calib::evaluate(model, from_c));
    const auto metres = [&](double bias_rps) {
      return std::abs(nav::drift_of_gyro_bias_m(bias_rps, time_s, base::kStandardGravity_mps2)) / kPowerOns;
    };
    drift.without_m += metres(change);
    drift.with_m += metres(left);
  }
  return drift;
}

void print_row(const nav::UnitErrors& errors, int runs) {
  base::Random random(64'300 + static_cast<std::uint64_t>(runs));
  std::vector<std::pair<double, calib::Curve>> units;
  for (int unit = 0; unit < kUnits; ++unit) {
    const double shift_c = 20.0 * (random.uniform() - 0.5);
    units.emplace_back(shift_c, calibrated(errors.gyro, shift_c, runs, random).value().curve);
  }
  for (const double time_s : {30.0, 60.0}) {
    std::vector<Drift> drifts;
    Drift mean;
    for (const auto& [shift_c, model] : units) {
      drifts.push_back(drift_of(model, shift_c, time_s, random));
      mean.without_m += drifts.back().without_m / kUnits;
      mean.with_m += drifts.back().with_m / kUnits;
    }
    const nav::Estimate less = nav::bootstrap(
        drifts.size(),
        [&](std::span<const std::size_t> drawn) {
          Drift sum;
          for (const std::size_t i : drawn) {
            sum.without_m += drifts[i].without_m;
            sum.with_m += drifts[i].with_m;
          }
          return 1.0 - sum.with_m / sum.without_m;
        },
        1);
    fmt::print("  {:<14} {:>4} {:>6.0f} {:>11.1f} {:>8.2f}   {:.1f} [{:.1f}, {:.1f}]\n", errors.name, runs, time_s,
               mean.without_m, mean.with_m, 100.0 * less.value, 100.0 * less.low, 100.0 * less.high);
  }
  std::fflush(stdout);
}

}  // namespace
}  // namespace soak::station

int main() {
  using namespace soak;
  fmt::print("free-inertial, a gyro's curve of 0.5 deg/s, {} units\n", station::kUnits);
  fmt::print("  {:<14} {:>4} {:>6} {:>11} {:>8}   {}\n", "noise of", "runs", "time s", "without m", "with m",
             "less % [95 %]");
  for (const nav::UnitErrors& errors : {nav::ahrs400ca(), nav::motionpak2(), nav::isi()}) {
    for (const int runs : {20, 6}) station::print_row(errors, runs);
  }
}
