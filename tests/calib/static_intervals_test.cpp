// SPDX-License-Identifier: Apache-2.0
#include "calib/estimate/multi_position.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <vector>

#include "base/random.h"

namespace soak::calib {
namespace {

namespace fs = std::filesystem;

struct Piece {
  std::size_t samples;
  bool moves;
};

/// White noise of 1 about (0, 0, 10) at rest; swings of 20 added while it moves.
std::vector<Vector3> recording(const std::vector<Piece>& pieces) {
  base::Random random(5);
  std::vector<Vector3> samples;
  for (const Piece& piece : pieces) {
    for (std::size_t n = 0; n < piece.samples; ++n) {
      const double swing = piece.moves ? 20.0 * std::sin(0.05 * static_cast<double>(n)) : 0.0;
      samples.push_back({random.gaussian() + swing, random.gaussian(), 10.0 + random.gaussian() - swing});
    }
  }
  return samples;
}

TEST(StaticIntervals, FindsTheRestsBetweenTheMoves) {
  const auto found =
      find_static_intervals(recording({{1500, false}, {300, true}, {600, false}, {400, true}, {900, false}}), {});
  ASSERT_TRUE(found) << found.error().message;
  ASSERT_EQ(found->size(), 3U);
  // Half a window of 100 is lost at each end, and the start of a swing comes along, a ramp of 1 per sample in two axes:
  // m samples of it add (2 m³/3 − m⁴/200)/100 to a variance of 3, which goes beyond 27 at m = 18.
  const std::array<StaticInterval, 3> truth = {{{0, 1500}, {1800, 2400}, {2800, 3700}}};
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(static_cast<double>((*found)[i].first), static_cast<double>(truth[i].first) + 50.0, 20.0);
    EXPECT_NEAR(static_cast<double>((*found)[i].last), static_cast<double>(truth[i].last) - 50.0, 20.0);
  }
}

TEST(StaticIntervals, PassesOverRestsThatAreTooShort) {
  const auto found = find_static_intervals(recording({{1500, false}, {300, true}, {250, false}, {400, true}}), {});
  ASSERT_TRUE(found);
  EXPECT_EQ(found->size(), 1U);
}

TEST(StaticIntervals, MeansCarryTheStandardErrorOfWhiteNoise) {
  const auto samples = recording({{4000, false}});
  const auto means = attitude_means(samples, std::array{StaticInterval{0, 4000}});
  ASSERT_EQ(means.size(), 1U);
  for (std::size_t i = 0; i < 3; ++i) {
    // 1/√4000 = 0.0158; the estimate never goes below white noise, and correlation by chance adds some tens of percent.
    EXPECT_NEAR(means[0].standard_error[i], 0.0158, 0.006);
    EXPECT_NEAR(means[0].mean[i], i == 2 ? 10.0 : 0.0, 4.0 * 0.0158);
  }
}

TEST(StaticIntervals, RefusesWhatGivesNoThreshold) {
  EXPECT_FALSE(find_static_intervals(recording({{500, false}}), {}));
  EXPECT_FALSE(find_static_intervals(std::vector<Vector3>(2000, Vector3{1.0, 2.0, 3.0}), {}));
  auto samples = recording({{2000, false}});
  EXPECT_FALSE(find_static_intervals(samples, {.factor = 1.0}));
  EXPECT_FALSE(find_static_intervals(samples, {.window = 1}));
  EXPECT_FALSE(find_static_intervals(samples, {.initial = 50}));
  samples[700][2] = std::nan("");
  const auto found = find_static_intervals(samples, {});
  ASSERT_FALSE(found);
  EXPECT_EQ(found.error().where, "sample 701");
}

/// Samples of the Xsens MTi, counts: text of four columns (time, x, y, z). Empty where the recording is not here.
std::vector<Vector3> xsens_samples() {
  const char* given = std::getenv("SOAK_TEST_DATA");
  const fs::path data = given != nullptr ? fs::path(given) : fs::path(SOAK_TEST_FOLDER) / ".." / ".." / "shared/data";
  std::ifstream file(data / "multi_position_xsens" / "xsens_acc.mat");
  std::vector<Vector3> samples;
  double t_s = 0.0;
  Vector3 counts{};
  while (file >> t_s >> counts[0] >> counts[1] >> counts[2]) samples.push_back(counts);
  return samples;
}

class Xsens : public ::testing::Test {
 protected:
  static constexpr double kGravity_mps2 = 9.81744;  ///< of the place, as the authors of the recording state it
  void SetUp() override {
    samples = xsens_samples();
    if (samples.empty()) GTEST_SKIP() << "skipped: the Xsens recording is not here (SOAK_TEST_DATA)";
  }
  /// 51.5 s at rest first, 100 samples per second.
  [[nodiscard]] std::vector<AttitudeMean> attitudes() const {
    return attitude_means(samples, find_static_intervals(samples, {.initial = 5000}).value());
  }
  std::vector<Vector3> samples;
};

TEST_F(Xsens, NineParametersAgreeWithTheFactory) {
  const auto attitudes = this->attitudes();
  EXPECT_EQ(attitudes.size(), 38U);
  const auto fit = calibrate_triad(attitudes, kGravity_mps2);
  ASSERT_TRUE(fit) << fit.error().message;
  // The maker's calibration of this unit: shared/data/multi_position_xsens/PROVENANCE.md.
  constexpr Vector3 kFactoryBias = {33123.0, 33276.0, 32360.0};
  constexpr Vector3 kFactoryScale = {415.0, 413.0, 415.0};
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(fit->value[i], kFactoryBias[i], 5.0);
    EXPECT_NEAR(fit->value[3 + i] / kFactoryScale[i], 1.0, 0.003);
    std::printf("axis %zu: bias %.2f +- %.2f (factory %.0f), scale %.3f +- %.3f (factory %.0f), misalignment %.5f\n", i,
                fit->value[i], fit->ci95[i], kFactoryBias[i], fit->value[3 + i], fit->ci95[3 + i], kFactoryScale[i],
                fit->value[6 + i]);
  }
  EXPECT_LE(fit->residual_rms_mps2, 0.0011);
  std::printf("|f| - g: RMS %.5f m/s2, lack of fit %.5f m/s2, condition %.1f\n", fit->residual_rms_mps2,
              fit->lack_of_fit_mps2, fit->condition);
}

TEST_F(Xsens, HalfOfTheAttitudesPredictTheOtherHalf) {
  const auto all = attitudes();
  std::vector<AttitudeMean> half;
  for (std::size_t n = 0; n < all.size(); n += 2) half.push_back(all[n]);
  const auto fit = calibrate_triad(half, kGravity_mps2);
  ASSERT_TRUE(fit) << fit.error().message;
  double squares = 0.0;
  for (std::size_t n = 1; n < all.size(); n += 2) {
    const Vector3 f = fit->specific_force(all[n].mean);
    squares += std::pow(std::hypot(f[0], f[1], f[2]) - kGravity_mps2, 2) / 19.0;
  }
  std::printf("19 attitudes that the fit has not seen: RMS %.5f m/s2\n", std::sqrt(squares));
  // Residuals of 0.001 plus nine parameters' errors from 19 attitudes: twice that at most.
  EXPECT_LT(std::sqrt(squares), 0.0022);
}

}  // namespace
}  // namespace soak::calib
