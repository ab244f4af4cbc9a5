// SPDX-License-Identifier: Apache-2.0
#include "calib/segments/standstill.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <vector>

#include "base/random.h"
#include "calib/estimate/attitude_fit.h"
#include "calib/estimate/multi_position.h"
#include "calib/segments/segmentation.h"

namespace soak::calib {
namespace {

namespace fs = std::filesystem;

struct Piece {
  double length_s;
  bool moves;
  double rate_rps = 0.0;  ///< of the z gyro
};

/// 100 rows per second: white noise of 0.02 about (0, 0, 10), swings added while it moves; gyros with noise of 0.002.
Recording recording(const std::vector<Piece>& pieces, bool with_gyros = true) {
  base::Random random(5);
  Recording r;
  for (const Piece& piece : pieces) {
    const auto rows = static_cast<std::size_t>(std::lround(100.0 * piece.length_s));
    for (std::size_t n = 0; n < rows; ++n) {
      const double swing = piece.moves ? 2.0 * std::sin(0.05 * static_cast<double>(n)) : 0.0;
      r.t_s.push_back(0.01 * static_cast<double>(r.t_s.size()));
      r.temp_c.push_back(25.0);
      const Vector3 force = {swing, 0.0, 10.0 - swing};
      for (std::size_t i = 0; i < 3; ++i) r.sensor[3 + i].push_back(force[i] + 0.02 * random.gaussian());
      for (std::size_t i = 0; i < 3 && with_gyros; ++i) {
        r.sensor[i].push_back((i == 2 ? piece.rate_rps : 0.0) + 0.002 * random.gaussian());
      }
    }
  }
  return r;
}

std::vector<Standstill> standstills(const Recording& r) {
  StandstillFinder finder(r.t_s);
  for (const Sensor sensor : kSensors) {
    if (!r.sensor[index_of(sensor)].empty()) finder.add(sensor, r.sensor[index_of(sensor)]);
  }
  return finder.find();
}

TEST(Standstill, FindsTheRestsBetweenTheMoves) {
  for (const bool with_gyros : {true, false}) {
    const Recording r = recording({{6, false}, {3, true}, {5, false}, {4, true}, {9, false}}, with_gyros);
    const auto found = standstills(r);
    ASSERT_EQ(found.size(), 3U);
    // Half a window of 1 s is lost at each end, and a hop of 0.1 s; the gentle start of a swing comes along.
    const std::array<std::array<double, 2>, 3> truth_s = {{{0, 6}, {9, 14}, {18, 27}}};
    for (std::size_t i = 0; i < 3; ++i) {
      EXPECT_NEAR(r.t_s[found[i].first], truth_s[i][0] + 0.5, 0.21);
      EXPECT_NEAR(r.t_s[found[i].last - 1], truth_s[i][1] - 0.5, 0.21);
      EXPECT_NEAR(found[i].force[2], 10.0, 0.02);
    }
  }
}

TEST(Standstill, PassesOverRestsThatAreTooShort) {
  EXPECT_EQ(standstills(recording({{6, false}, {3, true}, {1.5, false}, {4, true}})).size(), 1U);
}

// Accelerometers feel nothing of a slow turn about the vertical.
TEST(Standstill, ATurnAboutTheVerticalIsNoRest) {
  const auto found = standstills(recording({{6, false}, {8, false, 0.1}, {6, false}}));
  ASSERT_EQ(found.size(), 2U);
}

TEST(Standstill, SamplesThatNeverChangeAreRest) {
  Recording r = recording({{10, false}});
  for (auto& values : r.sensor) std::fill(values.begin(), values.end(), 1.0);
  EXPECT_EQ(standstills(r).size(), 1U);
}

TEST(Standstill, NothingIsFoundWithoutThreeAccelerometersOrInAFewRows) {
  Recording r = recording({{10, false}});
  r.sensor[4].clear();
  EXPECT_TRUE(standstills(r).empty());
  EXPECT_TRUE(standstills(recording({{0.05, false}})).empty());
}

TEST(Standstill, AGapInTimeEndsARest) {
  Recording r = recording({{10, false}});
  for (std::size_t i = 500; i < r.rows(); ++i) r.t_s[i] += 30.0;
  EXPECT_EQ(standstills(r).size(), 2U);
}

TEST(Standstill, OneAttitudeIsNoSession) {
  const auto found = standstills(recording({{6, false}, {3, true}, {5, false}, {4, true}, {9, false}}));
  EXPECT_FALSE(show_attitudes(found));
}

/// The recording of the Xsens MTi in counts, made into m/s² and rad/s by its nominal range: 5 g and 5.24 rad/s over
/// 2^15, roughly. Empty where it is not here.
Recording xsens_recording() {
  constexpr double kNominalForce = 1.0 / 415.0;
  constexpr double kNominalRate = 1.0 / 4778.0;
  const char* given = std::getenv("SOAK_TEST_DATA");
  const fs::path data = given != nullptr ? fs::path(given) : fs::path(SOAK_TEST_FOLDER) / ".." / ".." / "shared/data";
  Recording r;
  r.unit = "MTi";
  r.run_id = "session";
  for (const char* name : {"xsens_acc.mat", "xsens_gyro.mat"}) {
    std::ifstream file(data / "multi_position_xsens" / name);
    const bool accels = name[6] == 'a';
    double t_s = 0.0;
    Vector3 counts{};
    while (file >> t_s >> counts[0] >> counts[1] >> counts[2]) {
      if (accels) r.t_s.push_back(t_s);
      for (std::size_t i = 0; i < 3; ++i) {
        const double value = (counts[i] - 32768.0) * (accels ? kNominalForce : kNominalRate);
        r.sensor[(accels ? 3 : 0) + i].push_back(value);
      }
    }
  }
  r.temp_c.assign(r.t_s.size(), 25.0);
  return r;
}

class Xsens : public ::testing::Test {
 protected:
  static constexpr double kGravity_mps2 = 9.81744;  ///< of the place, as the authors of the recording state it
  void SetUp() override {
    recording = xsens_recording();
    if (recording.t_s.empty()) GTEST_SKIP() << "skipped: the Xsens recording is not here (SOAK_TEST_DATA)";
  }
  [[nodiscard]] std::vector<Segment> segments() const { return segment(recording).value().segments; }
  Recording recording;
};

TEST_F(Xsens, EveryAttitudeIsFoundWithoutBeingToldOfTheFirstRest) {
  const auto segments = this->segments();
  EXPECT_EQ(segments.size(), 38U);
  for (const Segment& rest : segments) EXPECT_TRUE(is_found_rest(rest));
}

TEST_F(Xsens, ConstantsAgreeWithTheFactory) {
  const auto segments = this->segments();
  const Place place =
      place_of(segments, {.latitude_deg = {}, .height_m = {}, .azimuth_deg = {}, .gravity_mps2 = kGravity_mps2});
  auto estimate = estimate_attitudes(segments, place, {});
  ASSERT_TRUE(estimate) << estimate.error().message;
  const auto moves = moves_between(recording, segments, {});
  EXPECT_EQ(moves.size(), 37U);
  const auto added = add_gains(segments, moves, {}, *estimate);
  ASSERT_TRUE(added) << added.error().message;
  // The maker's calibration of this unit, counts: shared/data/multi_position_xsens/PROVENANCE.md.
  constexpr Vector3 kAccelOffset = {33123.0, 33276.0, 32360.0};
  constexpr Vector3 kAccelScale = {415.0, 413.0, 415.0};
  constexpr Vector3 kGyroScale = {4778.0, 4758.0, 4766.0};
  // Its gain matrices, to two digits, are A = [1 0 -.01; .01 1 .01; .02 .01 1] of the accelerometers and G = [1 -.01
  // -.02; 0 1 .04; -.01 .01 1] of the gyros, in axes of its housing (imu_tk_matlab, calibrate.m). Turned by the W for
  // which A·(1 + W) is upper triangular (w_xy = .01, w_xz = .02, w_yz = .01), the axes used here, G·(1 + W) is:
  constexpr std::array<Vector3, 3> kGyroGain = {{{1.0, 0.0, 0.0}, {-0.01, 1.0, 0.05}, {-0.03, 0.0, 1.0}}};
  for (std::size_t i = 0; i < 3; ++i) {
    const PlateauEstimate& accel = estimate->sensor[3 + i].plateaus.at(0);
    EXPECT_NEAR(32768.0 + 415.0 * accel.bias, kAccelOffset[i], 5.0);
    EXPECT_NEAR(415.0 * (1.0 + 1e-6 * *accel.scale_ppm) / kAccelScale[i], 1.0, 0.003);
    const PlateauEstimate& gyro = estimate->sensor[i].plateaus.at(0);
    ASSERT_TRUE(gyro.scale_ppm);
    const double scale = 4778.0 * (1.0 + 1e-6 * *gyro.scale_ppm);
    std::printf(
        "axis %zu: accelerometer %.2f +- %.2f counts (factory %.0f), %.3f +- %.3f counts/(m/s2) (%.0f); gyro "
        "%.2f +- %.2f counts/(rad/s) (%.0f)\n",
        i, 32768.0 + 415.0 * accel.bias, 2.0 * 415.0 * accel.bias_se, kAccelOffset[i],
        415.0 * (1.0 + 1e-6 * *accel.scale_ppm), 2.0 * 415e-6 * *accel.scale_se_ppm, kAccelScale[i], scale,
        2.0 * 4778e-6 * *gyro.scale_se_ppm, kGyroScale[i]);
    // The factory's own values of the accelerometers differ from these by 0.24 %; the gyros' are held to 0.3 % too.
    EXPECT_NEAR(scale / kGyroScale[i], 1.0, 0.003);
    ASSERT_TRUE(estimate->sensor[i].rate_coupling);
    for (std::size_t j = 0; j < 3; ++j) {
      const Estimate& entry = (*estimate->sensor[i].rate_coupling)[j];
      // Two numbers rounded to 0.01 add up to each of these.
      if (i != j) {
        EXPECT_NEAR(entry.value, kGyroGain[i][j], 0.01 + 2.0 * entry.standard_error);
      }
      std::printf("   gyro misalignment %zu%zu %.5f +- %.5f (%.1f freedoms)\n", i, j, entry.value,
                  2.0 * entry.standard_error, entry.freedoms);
    }
  }
}

TEST_F(Xsens, HalfOfTheAttitudesPredictTheOtherHalf) {
  std::vector<AttitudeMean> half;
  std::vector<Vector3> other;
  for (const Segment& rest : segments()) {
    const Vector3 mean = {rest.sensor[3].mean, rest.sensor[4].mean, rest.sensor[5].mean};
    AttitudeMean attitude{mean, {}};
    for (std::size_t i = 0; i < 3; ++i) attitude.standard_error[i] = rest.sensor[3 + i].standard_error;
    if (half.size() <= other.size()) {
      half.push_back(attitude);
    } else {
      other.push_back(mean);
    }
  }
  const auto fit = calibrate_triad(half, kGravity_mps2);
  ASSERT_TRUE(fit) << fit.error().message;
  double squares = 0.0;
  for (const Vector3& mean : other) {
    const Vector3 f = fit->specific_force(mean);
    squares += std::pow(std::hypot(f[0], f[1], f[2]) - kGravity_mps2, 2) / static_cast<double>(other.size());
  }
  std::printf("19 attitudes that the fit has not seen: RMS %.5f m/s2\n", std::sqrt(squares));
  // Residuals of 0.001 plus nine parameters' errors from 19 attitudes: twice that at most.
  EXPECT_LT(std::sqrt(squares), 0.0022);
}

}  // namespace
}  // namespace soak::calib
