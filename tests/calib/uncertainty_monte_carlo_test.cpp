// SPDX-License-Identifier: Apache-2.0
// The budget's propagation against drawing (JCGM 101): the whole fit again, premises and all, on rows drawn from what
// the budget says of them.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <vector>

#include "base/random.h"
#include "calib/curve/families.h"
#include "calib/model/unit_model.h"
#include "tests/calib/campaign_simulation.h"

namespace soak::calib {
namespace {

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr int kMonteCarloSample = 60;
#else
constexpr int kMonteCarloSample = 400;
#endif

int draws() {
  const char* asked = std::getenv("SOAK_MONTE_CARLO_DRAWS");
  return asked != nullptr ? std::atoi(asked) : kMonteCarloSample;
}

/// Rows of one draw: the fitted curve, read with a thermometer that is off, in runs that are off, with noise.
CurveData drawn(const CurveData& data, const CurveFit& fit, double thermometer_c, base::Random& random) {
  CurveData rows = data;
  const double off_c = thermometer_c * random.gaussian();
  std::vector<double> offset;
  for (std::size_t r = 0; r < data.runs.size(); ++r) offset.push_back(*fit.run_to_run_sigma * random.gaussian());
  for (CurveRow& row : rows.rows) {
    const double sigma = std::hypot(row.standard_error, fit.lack_of_fit_sigma);
    row.value =
        evaluate(fit.curve, row.temp_c + off_c) + offset[static_cast<std::size_t>(row.run)] + sigma * random.gaussian();
  }
  return rows;
}

TEST(UncertaintyMonteCarlo, RefitsScatterAsTheBudgetSays) {
  base::Random random(21);
  const simulated::Scatter scatter;
  const auto truth = simulated::Truth::draw(random);
  UnitInput input = simulated::campaign(truth, Sensor::gyro_x, 8, scatter, random);
  input.type.temp_repeatability_c = scatter.thermometer_c;
  const auto rows = make_rows(input);
  ASSERT_TRUE(rows);
  const CurveData& data = *rows->bias[0];
  const auto fit = fit_sensor(*rows, Sensor::gyro_x, {});
  ASSERT_TRUE(fit);
  ASSERT_EQ(fit->bias.deployed, Family::anfis);
  const std::vector<CurvePoint>& points = fit->bias.points;
  std::vector<double> squares(points.size());
  std::vector<int> inside(points.size());
  const int n = draws();
  for (int i = 0; i < n; ++i) {
    const CurveData again = drawn(data, fit->bias, scatter.thermometer_c, random);
    const auto refit = train_families(again, {.rules = fit->bias.rules}, rule_choice(again.runs.size()));
    ASSERT_TRUE(refit);
    const Curve& curve = (*refit)[Family::anfis]->curve;
    for (std::size_t k = 0; k < points.size(); ++k) {
      const double error = evaluate(curve, points[k].temp_c) - points[k].value;
      squares[k] += error * error / n;
      inside[k] += std::abs(error) <= points[k].ci95 ? 1 : 0;
    }
  }
  double ratio = 0.0;
  double share = 0.0;
  for (std::size_t k = 0; k < points.size(); ++k) {
    double variance = 0.0;
    for (const Contribution& part : fit->bias.budget) variance += part.u.empty() ? 0.0 : part.u[k] * part.u[k];
    ratio += std::sqrt(squares[k] / variance) / static_cast<double>(points.size());
    share += static_cast<double>(inside[k]) / n / static_cast<double>(points.size());
  }
  std::printf("%d draws: scatter of the refits over the budget's %.3f, inside ci95 %.1f %%\n", n, ratio, 100.0 * share);
  // A standard deviation of n draws is known to 1/√(2n); three of those, and 8 % for the linearisation.
  const double slack = 0.08 + 3.0 / std::sqrt(2.0 * n);
  EXPECT_NEAR(ratio, 1.0, slack);
  // The t factor is for a scatter that is estimated; here it is known, so the band holds more than 95 %.
  EXPECT_GE(share, 0.94 - 3.0 * std::sqrt(0.05 / n));
}

}  // namespace
}  // namespace soak::calib
