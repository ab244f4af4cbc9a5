// SPDX-License-Identifier: Apache-2.0
// One to three runs: no run can be held out that would say much. The curve in the file shall be nearly as good as the
// best of the families, and its band shall hold the truth as often as it says, both over units whose curves are known.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <string>
#include <vector>

#include "calib/curve/constant_fit.h"
#include "calib/curve/curve_fit.h"
#include "calib/curve/families.h"
#include "tests/calib/few_runs_samples.h"
#include "tests/long_tests.h"

namespace soak::calib {
namespace {

constexpr int kCurvesOfSample = 10;  ///< of each cell; the proof takes more (tools/prove/few-runs)

int curves_per_cell() {
  const char* asked = std::getenv("SOAK_FEW_RUNS_CURVES");
  return asked == nullptr ? kCurvesOfSample : std::atoi(asked);
}

/// P(at least k of n) at probability p.
double binomial_tail(int k, int n, double p) {
  double sum = 0.0;
  for (int i = k; i <= n; ++i) {
    const double log_ways = std::lgamma(n + 1.0) - std::lgamma(i + 1.0) - std::lgamma(n - i + 1.0);
    sum += std::exp(log_ways + i * std::log(p) + (n - i) * std::log1p(-p));
  }
  return sum;
}

/// Lower end of the exact 95 % interval of a share (Clopper & Pearson 1934).
double lower_end(int k, int n) {
  if (k == 0) return 0.0;
  double low = 0.0;
  double high = 1.0;
  for (int i = 0; i < 60; ++i) {
    const double p = 0.5 * (low + high);
    (binomial_tail(k, n, p) < 0.025 ? low : high) = p;
  }
  return low;
}
double upper_end(int k, int n) { return 1.0 - lower_end(n - k, n); }

/// Counts over some units.
struct Tally {
  std::vector<double> ratios;  ///< error of the deployed curve over that of the best family
  int far_off = 0;             ///< ratios beyond 2
  int inside = 0;              ///< truths within ci95, at one temperature of each unit
  double share_inside = 0.0;   ///< sum over units of the share of all temperatures
  int anfis = 0;

  [[nodiscard]] int count() const { return static_cast<int>(ratios.size()); }
  [[nodiscard]] double median() const {
    std::vector<double> sorted = ratios;
    std::nth_element(sorted.begin(), sorted.begin() + count() / 2, sorted.end());
    return sorted[ratios.size() / 2];
  }
  [[nodiscard]] std::string line() const {
    const int n = count();
    return fmt::format(
        "{:5} curves, ANFIS in {:3.0f} %; ratio {:.2f}; beyond 2: {:4.1f} % [{:.1f}, {:.1f}]; ci95 holds {:.1f} % "
        "[{:.1f}, {:.1f}], over all temperatures {:.1f} %",
        n, 100.0 * anfis / n, median(), 100.0 * far_off / n, 100.0 * lower_end(far_off, n),
        100.0 * upper_end(far_off, n), 100.0 * inside / n, 100.0 * lower_end(inside, n), 100.0 * upper_end(inside, n),
        100.0 * share_inside / n);
  }
};

double rms_error(const Curve& curve, const CurveFit& fit, const few_runs::Unit& unit) {
  double squares = 0.0;
  for (const CurvePoint& p : fit.points) {
    squares += std::pow(evaluate(curve, p.temp_c) - unit.truth(p.temp_c) - unit.mean_offset, 2);
  }
  return std::sqrt(squares / static_cast<double>(fit.points.size()));
}

void judge(const few_runs::Unit& unit, std::uint64_t seed, std::vector<Tally*> tallies) {
  const auto fit = fit_curve(unit.data, {}, {"gyro_x", "deg/s", 1.0});
  const auto families = train_families(unit.data, {}, rule_choice(unit.data.runs.size()));
  ASSERT_TRUE(fit && families);
  double best = rms_error(fit->curve, *fit, unit);
  for (const auto& family : families->fitted) {
    if (family) best = std::min(best, rms_error(family->curve, *fit, unit));
  }
  const double ratio = rms_error(fit->curve, *fit, unit) / best;
  // One run says nothing of its own offset: its truth has it. Of more the band is that of the mean over all power-ons.
  const double offset = unit.data.runs.size() == 1 ? unit.mean_offset : 0.0;
  std::vector<bool> inside;
  for (const CurvePoint& p : fit->points) {
    inside.push_back(std::abs(p.value - unit.truth(p.temp_c) - offset) <= p.ci95);
  }
  const auto last = static_cast<int>(inside.size()) - 1;
  const auto at = static_cast<std::size_t>(few_runs::Dice(seed ^ 0x5eed).integer(0, last));
  for (Tally* tally : tallies) {
    tally->ratios.push_back(ratio);
    tally->far_off += ratio > 2.0 ? 1 : 0;
    tally->inside += inside[at] ? 1 : 0;
    tally->share_inside += static_cast<double>(std::count(inside.begin(), inside.end(), true)) / (last + 1);
    tally->anfis += fit->deployed == Family::anfis ? 1 : 0;
  }
}

/// Over all kinds of curves and both noises.
Tally judge_cell(const few_runs::Plan& plan, int cell, std::array<Tally, few_runs::kKinds.size()>& kinds, Tally& all) {
  Tally tally;
  for (int i = 0; i < curves_per_cell(); ++i) {
    few_runs::Plan measured = plan;
    measured.noise = (i / 5) % 2 == 0 ? 0.02 : 0.005;
    const std::uint64_t seed = 1'000'000U * static_cast<unsigned>(cell + 1) + static_cast<unsigned>(i);
    const auto kind = static_cast<std::size_t>(i) % kinds.size();
    judge(few_runs::make_unit(few_runs::kKinds[kind], measured, seed), seed, {&tally, &all, &kinds[kind]});
  }
  return tally;
}

void check_runs(int runs) {
  Tally all;
  std::array<Tally, few_runs::kKinds.size()> kinds;
  int cell = 10 * runs;
  for (const double step_c : {5.0, 10.0}) {
    for (const bool both_ways : {false, true}) {
      const Tally tally = judge_cell({runs, step_c, both_ways}, cell++, kinds, all);
      fmt::print("{} runs, {:2} K, {:10} {}\n", runs, step_c, both_ways ? "up, down:" : "up:", tally.line());
    }
  }
  for (std::size_t k = 0; k < kinds.size(); ++k) {
    fmt::print("{} runs, {:16} {}\n", runs, few_runs::kKinds[k], kinds[k].line());
  }
  fmt::print("{} runs, {:16} {}\n", runs, "all:", all.line());
  const int n = all.count();
  EXPECT_LE(all.median(), 1.2);
  EXPECT_LE(lower_end(all.far_off, n), 0.02);
  EXPECT_GE(upper_end(all.inside, n), 0.93);
  EXPECT_LE(lower_end(all.inside, n), 0.97);
}

/// A straight line of two or three runs whose offsets scatter by `offset` beside rows of `noise`.
few_runs::Unit line_of_runs(const few_runs::Plan& plan, std::uint64_t seed) {
  few_runs::Unit unit = few_runs::make_unit("smooth", plan, seed);
  for (CurveRow& row : unit.data.rows) row.value += 0.002 * row.temp_c - unit.truth(row.temp_c);
  unit.truth = [](double temp_c) { return 0.002 * temp_c; };
  return unit;
}

/// How often both bands hold what they should at 20 °C: many units, so the fits get two rules.
void check_bands_of_lines(const few_runs::Plan& plan) {
  constexpr int kUnits = 300;
  constexpr std::size_t kAt = 50;
  int inside = 0;
  int fresh_inside = 0;
  for (int i = 0; i < kUnits; ++i) {
    const auto seed = 77'000U + static_cast<unsigned>(i);
    const few_runs::Unit unit = line_of_runs(plan, seed);
    const auto fit = fit_curve(unit.data, {.rules = 2}, {"gyro_x", "deg/s", 1.0});
    ASSERT_TRUE(fit);
    const CurvePoint& point = fit->points[kAt];
    const double error = point.value - unit.truth(point.temp_c);
    inside += std::abs(error) <= point.ci95 ? 1 : 0;
    fresh_inside += std::abs(error - few_runs::Dice(seed ^ 0xf5e5).normal(plan.offset)) <= *point.pi95 ? 1 : 0;
  }
  EXPECT_GE(upper_end(inside, kUnits), 0.95) << inside << " of " << kUnits;
  EXPECT_GE(upper_end(fresh_inside, kUnits), 0.95) << fresh_inside << " of " << kUnits;
}

// Noise of a run's mean beside the offsets' scatter: a third and a fifth, where estimates below that noise are common.
TEST(FewRuns, TwoRunsKnowTheMeanOverPowerOnsAsWellAsTheySay) {
  check_bands_of_lines({.runs = 2, .step_c = 10.0, .both_ways = false, .noise = 0.02, .offset = 0.02});
}
TEST(FewRuns, ThreeRunsKnowTheMeanOverPowerOnsAsWellAsTheySay) {
  SOAK_LONG_TEST();
  check_bands_of_lines({.runs = 3, .step_c = 10.0, .both_ways = true, .noise = 0.02, .offset = 0.02});
}

/// Sessions at one temperature, a row each: normal offsets beside normal noise.
CurveData constant_sessions(int runs, double noise, few_runs::Dice& dice) {
  CurveData data;
  for (int run = 0; run < runs; ++run) {
    data.runs.push_back("R" + std::to_string(run + 1));
    data.rows.push_back({run, run, Sweep::unknown, 600.0, 25.0, dice.normal(1.0) + dice.normal(noise), noise});
  }
  return data;
}

TEST(FewRuns, ConstantsOfTwoAndThreeSessionsAreHeldAsOftenAsStated) {
  constexpr int kUnits = 4000;
  few_runs::Dice dice(2026);
  for (const int runs : {2, 3}) {
    for (const double noise : {0.1, 0.3, 1.0}) {
      int inside = 0;
      for (int i = 0; i < kUnits; ++i) {
        const auto fit =
            fit_constant(constant_sessions(runs, noise, dice), {"gyro_x", "deg/s", 1.0}, {25.0, 25.0, 0.0}, {}, {});
        ASSERT_TRUE(fit);
        inside += std::abs(fit->points[0].value) <= fit->points[0].ci95 ? 1 : 0;
      }
      EXPECT_GE(upper_end(inside, kUnits), 0.95) << runs << " sessions, noise " << noise;
      EXPECT_LE(lower_end(inside, kUnits), 0.99) << runs << " sessions, noise " << noise;
    }
  }
}

TEST(FewRuns, OneRunGetsNearlyTheBestFamilyAndABandThatHolds) { check_runs(1); }
TEST(FewRuns, TwoRunsGetNearlyTheBestFamilyAndABandThatHolds) {
  SOAK_LONG_TEST();
  check_runs(2);
}
TEST(FewRuns, ThreeRunsGetNearlyTheBestFamilyAndABandThatHolds) {
  SOAK_LONG_TEST();
  check_runs(3);
}

}  // namespace
}  // namespace soak::calib
