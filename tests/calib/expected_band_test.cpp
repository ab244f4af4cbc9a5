// SPDX-License-Identifier: Apache-2.0
#include "calib/plan/expected_band.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <random>
#include <stdexcept>
#include <utility>
#include <vector>

#include "tests/errors.h"

namespace soak::calib {
namespace {

constexpr double kNormal95 = 1.96;

SensorPicture some_picture() {
  SensorPicture picture;
  picture.scale = 0.1;
  picture.length_c = 20.0;
  picture.run_to_run = 0.01;
  picture.visit = 0.0003;
  picture.noise = 0.0008;
  return picture;
}

/// Up over the temperatures and back.
PlannedPowerOn loop(const std::vector<double>& temps_c, int count) {
  PlannedPowerOn power_on;
  power_on.count = count;
  for (const double temp_c : temps_c) power_on.visits.push_back({temp_c, Sweep::up});
  for (std::size_t i = temps_c.size() - 1; i > 0; --i) power_on.visits.push_back({temps_c[i - 1], Sweep::down});
  return power_on;
}

std::vector<double> every_5_c() {
  std::vector<double> temps_c;
  for (int i = 0; i <= 20; ++i) temps_c.push_back(-30.0 + 5.0 * i);
  return temps_c;
}

ExpectedBand band_of(const SensorPicture& picture, const CampaignDesign& design, const std::vector<double>& temps_c) {
  auto band = expected_band(picture, design, temps_c);
  if (!band) throw std::runtime_error(band.error().message);
  return *std::move(band);
}

// Nothing is known of the level but by the readings, so that at the one temperature that n power-ons visit the curve is
// off by √((σ² + v)/n), and from there to another by the difference of two values of the process, 2 s² (1 − ρ).
TEST(ExpectedBand, IsThatOfOneTemperatureByHand) {
  const SensorPicture picture = some_picture();
  const CampaignDesign design{{{{{20.0, Sweep::unknown}}, 5}}};
  const double at_visit = (1e-4 + 0.0003 * 0.0003 + 0.0008 * 0.0008) / 5.0;
  const ExpectedBand there = band_of(picture, design, {20.0});
  EXPECT_NEAR(there.level_sigma, std::sqrt(at_visit), 1e-9);
  EXPECT_NEAR(there.shape95.front(), 0.0, 1e-9);
  EXPECT_NEAR(there.level95, 2.776 * std::sqrt(at_visit), 1e-5);  // Student's t of four degrees of freedom
  EXPECT_NEAR(there.fresh95.front(), 2.776 * std::sqrt(at_visit + 1e-4), 1e-4);

  // Matérn 5/2 at one length: (1 + √5 + 5/3) e^−√5.
  const double correlated = 0.5239941088318203;
  const double difference = 2.0 * 0.01 * (1.0 - correlated);
  const ExpectedBand both = band_of(picture, design, {20.0, 40.0});
  EXPECT_NEAR(both.level_sigma, std::sqrt(at_visit + difference / 4.0), 1e-7);
  EXPECT_NEAR(both.shape95.back(), kNormal95 * std::sqrt(difference) / 2.0, 1e-5);
  EXPECT_NEAR(both.shape95.front(), both.shape95.back(), 1e-9);
}

TEST(ExpectedBand, LevelFallsWithTheRootOfThePowerOnsWhereverTheyAre) {
  SensorPicture picture = some_picture();
  picture.visit = picture.noise = 1e-5;
  const auto temps_c = every_5_c();
  for (const int runs : {4, 20}) {
    EXPECT_NEAR(band_of(picture, {{loop(temps_c, runs)}}, temps_c).level_sigma, 0.01 / std::sqrt(runs), 1e-6) << runs;
  }
  const CampaignDesign cycled{{{{{25.0, Sweep::unknown}}, 17}, loop(temps_c, 3)}};
  EXPECT_EQ(count_power_ons(cycled), 20);
  EXPECT_NEAR(band_of(picture, cycled, temps_c).level_sigma, 0.01 / std::sqrt(20.0), 1e-6);
}

TEST(ExpectedBand, HysteresisCancelsBothWaysAndStaysOneWay) {
  SensorPicture picture = some_picture();
  const CampaignDesign both{{loop({0.0, 20.0, 40.0}, 4)}};
  const CampaignDesign up{{{{{0.0, Sweep::up}, {20.0, Sweep::up}, {40.0, Sweep::up}}, 4}}};
  const double without = band_of(picture, both, {20.0}).level_sigma;
  const double one_way = band_of(picture, up, {20.0}).level_sigma;
  picture.half_gap = 0.03;
  EXPECT_NEAR(band_of(picture, both, {20.0}).level_sigma, without, 1e-9);
  EXPECT_NEAR(band_of(picture, up, {20.0}).level_sigma, std::hypot(one_way, 0.03), 0.001);
}

// Power-ons on one branch bring it into the level by their share; where the branches meet they bring nothing.
TEST(ExpectedBand, PowerOnsOnOneBranchMoveTheLevel) {
  SensorPicture picture = some_picture();
  picture.half_gap = 0.03;
  const auto sigma = [&](const PlannedVisit& visit) {
    return band_of(picture, {{loop({0.0, 20.0, 40.0}, 3), {{visit}, 27}}}, {20.0}).level_sigma;
  };
  EXPECT_GT(sigma({20.0, Sweep::up}), 0.8 * 0.9 * 0.03);
  EXPECT_LT(sigma({0.0, Sweep::unknown}), 0.1 * 0.03);
}

TEST(ExpectedBand, IsWidestBetweenThePlateausAndNarrowerWithMoreOfThem) {
  const SensorPicture picture = some_picture();
  std::vector<double> coarse_c;
  for (int i = 0; i <= 5; ++i) coarse_c.push_back(-30.0 + 20.0 * i);
  const ExpectedBand coarse = band_of(picture, {{loop(coarse_c, 4)}}, {10.0, 20.0, 30.0, 40.0, 50.0});
  EXPECT_GT(coarse.shape95[1], coarse.shape95[0]);
  EXPECT_GT(coarse.shape95[3], coarse.shape95[4]);
  EXPECT_LT(band_of(picture, {{loop(every_5_c(), 4)}}, every_5_c()).worst_shape(), 0.5 * coarse.worst_shape());
}

TEST(ExpectedBand, AShorterDwellAveragesLessNoiseAndALongerOneNoMore) {
  const SensorPicture picture = some_picture();
  EXPECT_NEAR(picture.visit_variance(150.0), 0.0003 * 0.0003 + 4.0 * 0.0008 * 0.0008, 1e-15);
  EXPECT_EQ(picture.visit_variance(6000.0), picture.visit_variance(600.0));
}

TEST(ExpectedBand, RefusesADesignThatCannotTellTheLevel) {
  const auto one = expected_band(some_picture(), {{loop({0.0, 20.0}, 1)}}, std::vector{10.0});
  ASSERT_FALSE(one);
  EXPECT_EQ(one.error().kind, base::ErrorKind::bad_input);
  EXPECT_FALSE(expected_band(some_picture(), {{loop({0.0, 20.0}, 2)}}, std::vector<double>()));
}

// Drawn campaigns, estimated as kriging with an unknown mean is written down (Cressie, Statistics for Spatial Data,
// 1993, 3.4): weights of the readings that sum up to one, with the least variance, by a dense system over all rows.

using Matrix = std::vector<std::vector<double>>;

/// Solves a x = b by elimination with pivots, all columns of b at once.
Matrix eliminated(Matrix a, Matrix b) {
  const std::size_t n = a.size();
  for (std::size_t k = 0; k < n; ++k) {
    std::size_t pivot = k;
    for (std::size_t i = k; i < n; ++i) pivot = std::abs(a[i][k]) > std::abs(a[pivot][k]) ? i : pivot;
    std::swap(a[k], a[pivot]);
    std::swap(b[k], b[pivot]);
    for (std::size_t i = 0; i < n; ++i) {
      if (i == k) continue;
      const double factor = a[i][k] / a[k][k];
      for (std::size_t j = k; j < n; ++j) a[i][j] -= factor * a[k][j];
      for (std::size_t j = 0; j < b[i].size(); ++j) b[i][j] -= factor * b[k][j];
    }
  }
  for (std::size_t i = 0; i < n; ++i) {
    for (double& value : b[i]) value /= a[i][i];
  }
  return b;
}

struct DrawnRow {
  double temp_c = 0.0;
  int power_on = 0;
};

double process_covariance(double apart_c) {
  const double r = std::sqrt(5.0) * std::abs(apart_c) / 20.0;
  return 0.01 * (1.0 + r + r * r / 3.0) * std::exp(-r);
}

/// Weights of the rows (and a last line for the mean's multiplier) for the value at each temperature.
Matrix kriging_weights(const std::vector<DrawnRow>& rows, double row_variance, const std::vector<double>& temps_c) {
  const std::size_t n = rows.size();
  Matrix a(n + 1, std::vector<double>(n + 1, 0.0));
  Matrix b(n + 1, std::vector<double>(temps_c.size(), 1.0));
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = 0; j < n; ++j) {
      a[i][j] =
          process_covariance(rows[i].temp_c - rows[j].temp_c) + (rows[i].power_on == rows[j].power_on ? 1e-4 : 0.0);
    }
    a[i][i] += row_variance;
    a[i][n] = a[n][i] = 1.0;
    for (std::size_t t = 0; t < temps_c.size(); ++t) b[i][t] = process_covariance(rows[i].temp_c - temps_c[t]);
  }
  return eliminated(a, b);
}

/// Two passes, and four power-ons that stay at 25 °C.
std::vector<DrawnRow> drawn_rows(const std::vector<double>& plateaus_c) {
  std::vector<DrawnRow> rows;
  for (int power_on = 0; power_on < 2; ++power_on) {
    for (const double temp_c : plateaus_c) rows.push_back({temp_c, power_on});
  }
  for (int power_on = 2; power_on < 6; ++power_on) rows.push_back({25.0, power_on});
  return rows;
}

TEST(ExpectedBand, IsTheScatterOfDrawnCampaignsThatAreKriged) {
  const std::vector<double> plateaus_c = {-30.0, -15.0, 0.0, 15.0, 30.0, 50.0, 70.0};
  const std::vector<double> wanted_c = {-30.0, -22.0, 22.5, 40.0, 60.0, 70.0};
  CampaignDesign design;
  PlannedPowerOn pass;
  for (const double temp_c : plateaus_c) pass.visits.push_back({temp_c, Sweep::unknown});
  pass.count = 2;
  design.power_ons = {pass, {{{25.0, Sweep::unknown}}, 4}};
  const ExpectedBand band = band_of(some_picture(), design, wanted_c);

  const double row_variance = 0.0003 * 0.0003 + 0.0008 * 0.0008;
  const auto rows = drawn_rows(plateaus_c);
  const Matrix weights = kriging_weights(rows, row_variance, wanted_c);
  // Values of the process at all temperatures together: a random sum of many cosines would only be near it, a Cholesky
  // factor is exact.
  std::vector<double> at_c = plateaus_c;
  at_c.push_back(25.0);
  at_c.insert(at_c.end(), wanted_c.begin(), wanted_c.end());
  std::ranges::sort(at_c);
  at_c.erase(std::unique(at_c.begin(), at_c.end()), at_c.end());
  Matrix factor(at_c.size(), std::vector<double>(at_c.size(), 0.0));
  for (std::size_t i = 0; i < at_c.size(); ++i) {
    for (std::size_t j = 0; j <= i; ++j) {
      double sum = process_covariance(at_c[i] - at_c[j]) + (i == j ? 1e-12 : 0.0);
      for (std::size_t k = 0; k < j; ++k) sum -= factor[i][k] * factor[j][k];
      factor[i][j] = i == j ? std::sqrt(sum) : sum / factor[j][j];
    }
  }
  constexpr int kDraws = 2000;
  std::mt19937_64 generator(20);
  std::normal_distribution<double> normal;
  double level_squares = 0.0;
  std::vector<double> shape_squares(wanted_c.size(), 0.0);
  for (int draw = 0; draw < kDraws; ++draw) {
    std::vector<double> standard(at_c.size());
    for (double& z : standard) z = normal(generator);
    const auto process_at = [&](double temp_c) {
      const auto i = static_cast<std::size_t>(std::ranges::find(at_c, temp_c) - at_c.begin());
      double value = 0.0;
      for (std::size_t k = 0; k <= i; ++k) value += factor[i][k] * standard[k];
      return value;
    };
    std::vector<double> offsets(6);
    for (double& offset : offsets) offset = 0.01 * normal(generator);
    std::vector<double> errors;
    for (const double temp_c : wanted_c) errors.push_back(-process_at(temp_c));
    for (std::size_t i = 0; i < rows.size(); ++i) {
      const double reading = process_at(rows[i].temp_c) + offsets[static_cast<std::size_t>(rows[i].power_on)] +
                             std::sqrt(row_variance) * normal(generator);
      for (std::size_t t = 0; t < wanted_c.size(); ++t) errors[t] += weights[i][t] * reading;
    }
    double mean = 0.0;
    for (const double error : errors) mean += error / static_cast<double>(errors.size());
    level_squares += mean * mean / kDraws;
    for (std::size_t t = 0; t < errors.size(); ++t) shape_squares[t] += std::pow(errors[t] - mean, 2) / kDraws;
  }
  // A standard deviation of 2000 draws is known to 1.6 %: four times that.
  EXPECT_NEAR(std::sqrt(level_squares) / band.level_sigma, 1.0, 0.064);
  for (std::size_t t = 0; t < wanted_c.size(); ++t) {
    EXPECT_NEAR(kNormal95 * std::sqrt(shape_squares[t]) / band.shape95[t], 1.0, 0.064) << wanted_c[t];
  }
}

}  // namespace
}  // namespace soak::calib
