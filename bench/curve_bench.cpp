// SPDX-License-Identifier: Apache-2.0
// Two builds of the curve fit side by side: each fits the same made-up units, whose truths it never sees, and writes
// one line for each curve; then the lines of both are compared. Nothing of the generator is shared with the fit.
//   bench_curves fit FILE [UNITS [FIRST]]   UNITS of each shape and number of runs, 9 unless given: 216 curves;
//                                           FIRST: seed of the first of them, 0 unless given
//   bench_curves compare OLD NEW
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <functional>
#include <random>
#include <string>
#include <string_view>
#include <vector>

#include "calib/curve/curve_fit.h"

namespace soak {
namespace {

constexpr std::array kShapes = {"smooth", "feature", "kink", "hysteresis"};
constexpr std::array kRuns = {3, 4, 6, 8, 12, 20};
constexpr int kFreshRuns = 40;
constexpr double kCoolest_c = -30.0;
constexpr double kStep_c = 5.0;
constexpr int kPlateaus = 21;

using Truth = std::function<double(double temp_c)>;

/// One unit in deg/s, and how its runs are measured.
struct Unit {
  Truth truth;
  double half_gap_dps = 0.0;           ///< heating above, cooling below the truth by up to this
  double offset_dps = 0.0;             ///< standard deviation of a run's own offset
  double noise_dps = 0.0;              ///< white noise of a row: its stated standard error
  double instability_dps = 0.0;        ///< standard deviation of a bias that wanders from visit to visit
  double visits_of_memory = 0.0;       ///< of that bias
  double temperature_scatter_c = 0.0;  ///< of a plateau over the runs
};

class Dice {
 public:
  explicit Dice(std::uint64_t seed) : engine_(seed) {}
  double uniform(double low, double high) { return std::uniform_real_distribution(low, high)(engine_); }
  double normal(double sigma) { return sigma * std::normal_distribution()(engine_); }
  double sign() { return uniform(0.0, 1.0) < 0.5 ? -1.0 : 1.0; }

 private:
  std::mt19937_64 engine_;
};

Truth make_truth(std::string_view shape, Dice& dice) {
  const double size = dice.uniform(0.1, 0.4);
  const double middle_c = dice.uniform(0.0, 40.0);
  const double phase = dice.uniform(0.0, 6.28);
  Truth wide = [=](double t) {
    return size * std::atan((t - middle_c) / 30.0) + 0.1 * size * std::sin(phase + t / 35.0);
  };
  const double place_c = dice.uniform(-20.0, 60.0);
  if (shape == "feature") {
    const double height = dice.sign() * dice.uniform(0.05, 0.15);
    const double width_c = dice.uniform(5.0, 9.0);
    return [=](double t) { return wide(t) + height * std::exp(-0.5 * std::pow((t - place_c) / width_c, 2)); };
  }
  if (shape == "kink") {
    const double slope = dice.sign() * dice.uniform(0.002, 0.01);
    return [=](double t) { return wide(t) + slope * std::abs(t - place_c); };
  }
  return wide;
}

Unit make_unit(std::string_view shape, Dice& dice) {
  Unit unit;
  unit.truth = make_truth(shape, dice);
  unit.half_gap_dps = shape == "hysteresis" ? dice.uniform(0.002, 0.01) : 0.0;
  unit.offset_dps = dice.uniform(0.003, 0.02);
  unit.noise_dps = std::pow(10.0, dice.uniform(-3.3, -2.3));
  unit.instability_dps = unit.noise_dps * dice.uniform(0.3, 1.5);
  unit.visits_of_memory = dice.uniform(1.0, 8.0);
  unit.temperature_scatter_c = dice.uniform(0.01, 0.3);
  return unit;
}

/// One run over all plateaus, up and down: rows numbered `run`.
void add_run(const Unit& unit, int run, Dice& dice, calib::CurveData& data) {
  const double offset = dice.normal(unit.offset_dps);
  const double keep = std::exp(-1.0 / unit.visits_of_memory);
  double wander = dice.normal(unit.instability_dps);
  for (int visit = 0; visit < 2 * kPlateaus; ++visit) {
    const bool up = visit < kPlateaus;
    const int plateau = up ? visit : 2 * kPlateaus - 1 - visit;
    const double temp_c = kCoolest_c + kStep_c * plateau + dice.normal(unit.temperature_scatter_c);
    // The loop closes at both ends.
    const double along = static_cast<double>(plateau) / (kPlateaus - 1);
    const double gap = (up ? 4.0 : -4.0) * unit.half_gap_dps * along * (1.0 - along);
    wander = keep * wander + std::sqrt(1.0 - keep * keep) * dice.normal(unit.instability_dps);
    data.rows.push_back({run, 2 * run + (up ? 0 : 1), up ? calib::Sweep::up : calib::Sweep::down, 1800.0 * visit,
                         temp_c, unit.truth(temp_c) + offset + gap + wander + dice.normal(unit.noise_dps),
                         unit.noise_dps, 0.0});
  }
  data.runs.push_back(fmt::format("R{}", run + 1));
  for (const char* way : {"up", "down"}) data.branches.push_back(fmt::format("R{} {}", run + 1, way));
}

calib::CurveData make_runs(const Unit& unit, int runs, Dice& dice) {
  calib::CurveData data;
  for (int run = 0; run < runs; ++run) add_run(unit, run, dice, data);
  return data;
}

/// What a build makes of one unit.
struct Outcome {
  std::string unit;
  std::string family;
  int rules = 0;
  double held_out_dps = 0.0;  ///< as stated: shape error of the deployed family on held-out runs
  double fresh_dps = 0.0;     ///< the same of the deployed curve on runs that no part of the fit has seen
  double truth_dps = 0.0;     ///< RMS error of the curve, its mean removed
  double inside_ci = 0.0;     ///< share of the points whose ci95 holds the truth
  double inside_pi = 0.0;     ///< share of the points whose pi95 holds a fresh run
  double cpu_s = 0.0;
};

double root_mean_square_about_mean(const std::vector<double>& errors) {
  double mean = 0.0;
  for (const double e : errors) mean += e / static_cast<double>(errors.size());
  double squares = 0.0;
  for (const double e : errors) squares += (e - mean) * (e - mean) / static_cast<double>(errors.size());
  return std::sqrt(squares);
}

double error_on(const calib::CurveData& fresh, const calib::Curve& curve) {
  double squares = 0.0;
  for (std::size_t run = 0; run < fresh.runs.size(); ++run) {
    std::vector<double> errors;
    for (const calib::CurveRow& row : fresh.rows) {
      if (row.run == static_cast<int>(run)) errors.push_back(row.value - calib::evaluate(curve, row.temp_c));
    }
    squares += std::pow(root_mean_square_about_mean(errors), 2) / static_cast<double>(fresh.runs.size());
  }
  return std::sqrt(squares);
}

void judge_points(const Unit& unit, const calib::CurveFit& fit, Dice& dice, Outcome& outcome) {
  std::vector<double> errors;
  const double share = 1.0 / static_cast<double>(fit.points.size());
  const double offset = dice.normal(unit.offset_dps);
  for (const calib::CurvePoint& point : fit.points) {
    errors.push_back(point.value - unit.truth(point.temp_c));
    const double along = std::clamp((point.temp_c - kCoolest_c) / (kStep_c * (kPlateaus - 1)), 0.0, 1.0);
    const double gap = dice.sign() * 4.0 * unit.half_gap_dps * along * (1.0 - along);
    const double of_run = offset + gap + dice.normal(unit.instability_dps);
    outcome.inside_ci += std::abs(errors.back()) <= point.ci95 ? share : 0.0;
    outcome.inside_pi += std::abs(errors.back() - of_run) <= point.pi95.value_or(0.0) ? share : 0.0;
  }
  outcome.truth_dps = root_mean_square_about_mean(errors);
}

Outcome fit_unit(std::string_view shape, int runs, int number) {
  Dice dice(1'000'000ULL * static_cast<std::uint64_t>(runs) + 1000ULL * shape.size() +
            static_cast<std::uint64_t>(number));
  const Unit unit = make_unit(shape, dice);
  const calib::CurveData data = make_runs(unit, runs, dice);
  const std::clock_t start = std::clock();
  const auto fit = calib::fit_curve(data, {}, {"gyro_x", "deg/s", 1.0});
  const std::clock_t end = std::clock();
  Outcome outcome;
  outcome.unit = fmt::format("{}-{}-{}", shape, runs, number);
  if (!fit) {
    fmt::print(stderr, "bench_curves: {}: {}\n", outcome.unit, fit.error().message);
    std::exit(1);
  }
  outcome.family = calib::name_of(fit->deployed);
  outcome.rules = fit->rules;
  outcome.held_out_dps = fit->deployed_error()->rmse_shape;
  outcome.fresh_dps = error_on(make_runs(unit, kFreshRuns, dice), fit->curve);
  judge_points(unit, *fit, dice, outcome);
  outcome.cpu_s = static_cast<double>(end - start) / CLOCKS_PER_SEC;
  return outcome;
}

int fit_all(const std::string& path, int units, int first) {
  std::ofstream file(path);
  for (const char* shape : kShapes) {
    for (const int runs : kRuns) {
      for (int number = first; number < first + units; ++number) {
        const Outcome o = fit_unit(shape, runs, number);
        file << fmt::format("{} {} {} {} {} {} {} {} {}\n", o.unit, o.family, o.rules, o.held_out_dps, o.fresh_dps,
                            o.truth_dps, o.inside_ci, o.inside_pi, o.cpu_s);
      }
    }
  }
  file.flush();
  if (file) return 0;
  fmt::print(stderr, "bench_curves: {} cannot be written\n", path);
  return 1;
}

std::vector<Outcome> read_outcomes(const std::string& path) {
  std::ifstream file(path);
  std::vector<Outcome> all;
  for (Outcome o; file >> o.unit >> o.family >> o.rules >> o.held_out_dps >> o.fresh_dps >> o.truth_dps >>
                  o.inside_ci >> o.inside_pi >> o.cpu_s;) {
    all.push_back(o);
  }
  return all;
}

double quantile(std::vector<double> values, double share) {
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(std::lround(share * static_cast<double>(values.size() - 1)))];
}

/// One line of the comparison, named `group`: of the curves that belong to it.
void compare_group(const std::vector<Outcome>& before, const std::vector<Outcome>& after,
                   const std::function<bool(const Outcome&)>& belongs, const std::string& group) {
  std::vector<double> held_out, fresh, truth, optimism_before, optimism_after;
  std::array<double, 2> ci{}, pi{}, anfis{}, cpu_s{};
  for (std::size_t i = 0; i < before.size(); ++i) {
    if (!belongs(before[i])) continue;
    held_out.push_back(after[i].held_out_dps / before[i].held_out_dps);
    fresh.push_back(after[i].fresh_dps / before[i].fresh_dps);
    truth.push_back(after[i].truth_dps / before[i].truth_dps);
    optimism_before.push_back(before[i].held_out_dps / before[i].fresh_dps);
    optimism_after.push_back(after[i].held_out_dps / after[i].fresh_dps);
    for (const auto& [k, o] : {std::pair(0U, &before[i]), std::pair(1U, &after[i])}) {
      ci[k] += o->inside_ci;
      pi[k] += o->inside_pi;
      anfis[k] += o->family == "anfis" ? 1.0 : 0.0;
      cpu_s[k] += o->cpu_s;
    }
  }
  const double share = 100.0 / static_cast<double>(held_out.size());
  fmt::print(
      "{:<11} {:>4} | {:.3f} {:.3f} | {:.3f} {:.3f} | {:.3f} {:.3f} {:.3f} | {:.3f} {:.3f} | {:5.1f} {:5.1f} | {:5.1f} "
      "{:5.1f} | "
      "{:3.0f} {:3.0f} | {:.4f} {:.4f}\n",
      group, held_out.size(), quantile(held_out, 0.5), quantile(held_out, 0.95), quantile(fresh, 0.5),
      quantile(fresh, 0.95), quantile(truth, 0.05), quantile(truth, 0.5), quantile(truth, 0.95),
      quantile(optimism_before, 0.5), quantile(optimism_after, 0.5), share * ci[0], share * ci[1], share * pi[0],
      share * pi[1], share * anfis[0], share * anfis[1], 0.01 * share * cpu_s[0], 0.01 * share * cpu_s[1]);
}

int compare(const std::string& before_path, const std::string& after_path) {
  const std::vector<Outcome> before = read_outcomes(before_path);
  const std::vector<Outcome> after = read_outcomes(after_path);
  const bool same_units = std::ranges::equal(before, after, {}, &Outcome::unit, &Outcome::unit);
  if (before.empty() || !same_units) {
    fmt::print(stderr, "bench_curves: {} and {} are not of the same units\n", before_path, after_path);
    return 1;
  }
  fmt::print(
      "new over old, 5th percentile, median and 95th percentile: error stated for held-out runs | error on fresh runs "
      "| error of the "
      "curve\nold, new: stated over fresh (median) | % in ci95 | % in pi95 | % ANFIS | CPU s a curve\n");
  for (const char* shape : kShapes) {
    compare_group(before, after, [=](const Outcome& o) { return o.unit.starts_with(shape); }, shape);
  }
  for (const int runs : kRuns) {
    const std::string part = fmt::format("-{}-", runs);
    compare_group(
        before, after, [=](const Outcome& o) { return o.unit.find(part) != std::string::npos; },
        fmt::format("{} runs", runs));
  }
  compare_group(before, after, [](const Outcome&) { return true; }, "all");
  return 0;
}

}  // namespace
}  // namespace soak

int main(int argc, char** argv) {
  const std::vector<std::string> words(argv + 1, argv + argc);
  if (words.size() >= 2 && words[0] == "fit") {
    const auto number = [&](std::size_t k, int otherwise) {
      return words.size() > k ? std::atoi(argv[k + 1]) : otherwise;
    };
    return soak::fit_all(words[1], number(2, 9), number(3, 0));
  }
  if (words.size() == 3 && words[0] == "compare") return soak::compare(words[1], words[2]);
  fmt::print(stderr, "bench_curves fit FILE [UNITS [FIRST]] | bench_curves compare OLD NEW\n");
  return 2;
}
