// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>
#include <random>
#include <string>
#include <string_view>
#include <vector>

#include "calib/estimate/curve_data.h"

namespace soak::calib::few_runs {

/// Units of one to three runs with a known curve; shares nothing with the simulator or the fit. In deg/s:
///   smooth  parabola and a tanh 25 to 45 K wide
///   tanh    smooth, and a step tanh((T − c)/w), w of 5 to 10 K
///   kinks   smooth, and one to three kinks, no two nearer than 8 K
///   spline  natural cubic spline through random values at six to nine knots, no two nearer than 8 K
///   waves   0.3 sin(T/12) + 0.1 cos(T/6)
inline constexpr std::array<std::string_view, 5> kKinds = {"smooth", "tanh", "kinks", "spline", "waves"};

using Truth = std::function<double(double)>;

class Dice {
 public:
  explicit Dice(std::uint64_t seed) : engine_(seed) {}
  double uniform(double low, double high) { return std::uniform_real_distribution(low, high)(engine_); }
  double normal(double sigma) { return sigma * std::normal_distribution()(engine_); }
  int integer(int low, int high) { return std::uniform_int_distribution(low, high)(engine_); }
  double sign() { return integer(0, 1) == 0 ? -1.0 : 1.0; }

 private:
  std::mt19937_64 engine_;
};

/// Rising, no two nearer than `apart`.
inline std::vector<double> random_places(Dice& dice, int count, double low, double high, double apart) {
  std::vector<double> places;
  for (int i = 0; i < count; ++i) places.push_back(dice.uniform(0.0, high - low - apart * (count - 1)));
  std::sort(places.begin(), places.end());
  for (int i = 0; i < count; ++i) places[static_cast<std::size_t>(i)] += low + apart * i;
  return places;
}

/// Natural cubic spline through points: second derivatives m from the usual tridiagonal equations (Thomas).
inline Truth natural_spline(std::vector<double> x, std::vector<double> y) {
  const std::size_t n = x.size();
  std::vector<double> upper(n, 0.0);
  std::vector<double> m(n, 0.0);
  for (std::size_t i = 1; i + 1 < n; ++i) {
    const double left = x[i] - x[i - 1];
    const double right = x[i + 1] - x[i];
    const double pivot = 2.0 * (left + right) - left * upper[i - 1];
    upper[i] = right / pivot;
    m[i] = (6.0 * ((y[i + 1] - y[i]) / right - (y[i] - y[i - 1]) / left) - left * m[i - 1]) / pivot;
  }
  for (std::size_t i = n - 1; i-- > 1;) m[i] -= upper[i] * m[i + 1];
  return [x = std::move(x), y = std::move(y), m = std::move(m)](double t) {
    const auto after = std::upper_bound(x.begin() + 1, x.end() - 1, t);
    const auto i = static_cast<std::size_t>(after - x.begin());
    const double h = x[i] - x[i - 1];
    const double a = (x[i] - t) / h;
    const double b = (t - x[i - 1]) / h;
    return a * y[i - 1] + b * y[i] + ((a * a * a - a) * m[i - 1] + (b * b * b - b) * m[i]) * h * h / 6.0;
  };
}

inline Truth smooth_curve(Dice& dice) {
  const std::array line = {dice.normal(0.1), dice.normal(0.1), dice.normal(0.05), dice.normal(0.15)};
  const double middle_c = dice.uniform(0.0, 40.0);
  const double width_c = dice.uniform(25.0, 45.0);
  return [=](double temp_c) {
    const double x = (temp_c - 20.0) / 50.0;
    return line[0] + line[1] * x + line[2] * x * x + line[3] * std::tanh((temp_c - middle_c) / width_c);
  };
}

inline Truth make_truth(std::string_view kind, Dice& dice) {
  if (kind == "waves") return [](double t) { return 0.3 * std::sin(t / 12.0) + 0.1 * std::cos(t / 6.0); };
  if (kind == "spline") {
    std::vector<double> knots_c = random_places(dice, dice.integer(6, 9), -34.0, 74.0, 8.0);
    knots_c.front() = -34.0;
    knots_c.back() = 74.0;
    std::vector<double> values;
    for (std::size_t i = 0; i < knots_c.size(); ++i) values.push_back(dice.normal(0.15));
    return natural_spline(std::move(knots_c), std::move(values));
  }
  Truth wide = smooth_curve(dice);
  if (kind == "smooth") return wide;
  if (kind == "tanh") {
    const double height = dice.sign() * dice.uniform(0.1, 0.4);
    const double centre_c = dice.uniform(-20.0, 60.0);
    const double width_c = dice.uniform(5.0, 10.0);
    return [=](double t) { return wide(t) + height * std::tanh((t - centre_c) / width_c); };
  }
  const std::vector<double> places_c = random_places(dice, dice.integer(1, 3), -25.0, 65.0, 8.0);
  std::vector<double> slopes;
  for (std::size_t i = 0; i < places_c.size(); ++i) slopes.push_back(dice.sign() * dice.uniform(0.002, 0.012));
  return [=](double t) {
    double value = wide(t);
    for (std::size_t i = 0; i < places_c.size(); ++i) value += slopes[i] * std::max(0.0, t - places_c[i]);
    return value;
  };
}

/// How a unit is measured: −30 to 70 °C.
struct Plan {
  int runs = 1;
  double step_c = 5.0;
  bool both_ways = true;
  double noise = 0.02;   ///< of a row
  double offset = 0.02;  ///< standard deviation of a run's own
};

struct Unit {
  Truth truth;               ///< the curve without any run's own offset
  double mean_offset = 0.0;  ///< of its runs
  CurveData data;
};

inline Unit make_unit(std::string_view kind, const Plan& plan, std::uint64_t seed) {
  Dice dice(seed);
  Unit unit;
  unit.truth = make_truth(kind, dice);
  const int levels = static_cast<int>(std::lround(100.0 / plan.step_c)) + 1;
  const int visits = plan.both_ways ? 2 * levels - 1 : levels;
  for (int run = 0; run < plan.runs; ++run) {
    const std::string label = "R" + std::to_string(run + 1);
    unit.data.runs.push_back(label);
    const double offset = dice.normal(plan.offset);
    unit.mean_offset += offset / plan.runs;
    for (int visit = 0; visit < visits; ++visit) {
      const bool up = visit < levels;
      const double temp_c = -30.0 + plan.step_c * (up ? visit : visits - 1 - visit) + dice.uniform(-0.2, 0.2);
      const int branch = plan.both_ways ? 2 * run + (up ? 0 : 1) : run;
      unit.data.rows.push_back({run, branch, up ? Sweep::up : Sweep::down, 1800.0 * (visit + 1), temp_c,
                                unit.truth(temp_c) + offset + dice.normal(plan.noise), plan.noise});
    }
    unit.data.branches.push_back(label + " up");
    if (plan.both_ways) unit.data.branches.push_back(label + " down");
  }
  return unit;
}

}  // namespace soak::calib::few_runs
