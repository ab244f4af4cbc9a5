// SPDX-License-Identifier: Apache-2.0
#include "calib/data_gate.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <limits>
#include <numbers>
#include <sstream>

#include "base/random.h"
#include "base/units.h"
#include "calib/segmentation.h"

namespace soak::calib {
namespace {

constexpr double kG = 9.80665;
constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

/// How a simulated unit at rest reads; noise is of single samples.
struct Still {
  double seconds = 60.0;
  double rate_hz = 100.0;
  std::string position = "+Z";
  double gyro_noise_rps = 1e-3;  ///< 0.06 deg/s
  double accel_noise_mps2 = 0.01;
  double gyro_lsb_rps = 0.0;  ///< 0 = not rounded
  double accel_lsb_mps2 = 0.0;
  double slow_share = 0.0;  ///< of the noise's standard deviation: Gauss-Markov with 20 s correlation time
  double temp_rate_kpmin = 0.01;
  double bias_per_k_rps = 1e-4;   ///< 0.006 deg/s per kelvin
  double bias_per_k_mps2 = 3e-3;  ///< 0.3 m/s² over 100 K
  double temp_noise_c = 0.01;
  double temp_lsb_c = 0.0;
};

double rounded(double value, double lsb) { return lsb > 0.0 ? std::round(value / lsb) * lsb : value; }

/// One segment at 25 °C.
Recording still(const Still& how, std::uint64_t seed) {
  base::Random random(seed);
  Recording r;
  r.run_id = "run";
  r.unit = "U";
  r.positions = {*position_named(how.position)};
  const auto rows = static_cast<std::size_t>(how.seconds * how.rate_hz);
  std::array<double, kSensorCount> slow{};
  const double step_s = 1.0 / how.rate_hz;
  const double keep = std::exp(-step_s / 20.0);
  for (std::size_t i = 0; i < rows; ++i) {
    const double t_s = static_cast<double>(i) * step_s;
    const double warming_k = how.temp_rate_kpmin * t_s / 60.0;
    r.t_s.push_back(t_s);
    r.temp_c.push_back(rounded(25.0 + warming_k + how.temp_noise_c * random.gaussian(), how.temp_lsb_c));
    r.plateau_c.push_back(25.0);
    r.position.push_back(0);
    for (const Sensor sensor : kSensors) {
      const std::size_t s = index_of(sensor);
      const bool gyro = is_gyro(sensor);
      const double noise = gyro ? how.gyro_noise_rps : how.accel_noise_mps2;
      slow[s] = keep * slow[s] + std::sqrt(1.0 - keep * keep) * how.slow_share * noise * random.gaussian();
      const double force = gyro ? 0.0 : kG * r.positions[0].up[axis_of(sensor)];
      const double bias = (gyro ? 0.01 : 0.1) + warming_k * (gyro ? how.bias_per_k_rps : how.bias_per_k_mps2);
      const double value = force + bias + slow[s] + noise * random.gaussian();
      r.sensor[s].push_back(rounded(value, gyro ? how.gyro_lsb_rps : how.accel_lsb_mps2));
    }
  }
  return r;
}

/// Findings of all segments of a recording, one after the other.
std::vector<Finding> findings_of(const Recording& r, const UnitType& type = {}) {
  const auto cut = segment(r);
  if (!cut || cut->segments.empty()) throw std::runtime_error("no segment");
  std::vector<Finding> all;
  for (const auto& found : examine(r, cut->segments, type)) all.insert(all.end(), found.begin(), found.end());
  return all;
}

std::string listed(const std::vector<Finding>& findings) {
  std::string text;
  for (const Finding& f : findings) text += f.code + " (" + std::string(name_of(f.severity)) + "): " + f.text + "\n";
  return text;
}

/// The only finding; a failure where there is none or another.
Finding only(const std::vector<Finding>& findings) {
  EXPECT_EQ(findings.size(), 1U) << listed(findings);
  return findings.empty() ? Finding{} : findings.front();
}

void expect_clean(const Recording& r, const UnitType& type = {}) {
  const auto findings = findings_of(r, type);
  EXPECT_TRUE(findings.empty()) << listed(findings);
}

std::vector<double>& sensor(Recording& r, Sensor which) { return r.sensor[index_of(which)]; }

/// Turns what the accelerometers read in rows [first, last) by an angle about the y axis.
void tilt(Recording& r, std::size_t first, std::size_t last, double angle_deg) {
  const double c = std::cos(angle_deg * base::kRadPerDeg);
  const double s = std::sin(angle_deg * base::kRadPerDeg);
  for (std::size_t i = first; i < last; ++i) {
    const double x = sensor(r, Sensor::accel_x)[i];
    const double z = sensor(r, Sensor::accel_z)[i];
    sensor(r, Sensor::accel_x)[i] = c * x + s * z;
    sensor(r, Sensor::accel_z)[i] = c * z - s * x;
  }
}

/// Appends another recording of the same unit as a later segment at the same plateau.
void append(Recording& r, const Recording& more) {
  const double offset_s = r.t_s.back() + 100.0;
  for (std::size_t i = 0; i < more.rows(); ++i) r.t_s.push_back(offset_s + more.t_s[i]);
  const auto join = [](auto& a, const auto& b) { a.insert(a.end(), b.begin(), b.end()); };
  join(r.temp_c, more.temp_c);
  join(r.plateau_c, more.plateau_c);
  join(r.position, more.position);
  for (std::size_t s = 0; s < kSensorCount; ++s) join(r.sensor[s], more.sensor[s]);
}

void remove_rows(Recording& r, std::size_t first, std::size_t last) {
  const auto cut = [&](auto& v) {
    v.erase(v.begin() + static_cast<std::ptrdiff_t>(first), v.begin() + static_cast<std::ptrdiff_t>(last));
  };
  cut(r.t_s);
  cut(r.temp_c);
  cut(r.plateau_c);
  cut(r.position);
  for (auto& values : r.sensor) cut(values);
}

TEST(DataGate, FindsNothingInThousandCleanSegments) {
  base::Random random(5);
  int findings = 0;
  std::string text;
  for (std::uint64_t seed = 0; seed < 1000; ++seed) {
    Still how;
    how.rate_hz = std::exp(random.uniform(std::log(1.0), std::log(100.0)));
    how.seconds = random.uniform(30.0, 90.0);
    how.position = kSixPositionLabels[seed % 6];
    how.gyro_noise_rps = std::exp(random.uniform(std::log(1e-5), std::log(5e-3)));
    how.accel_noise_mps2 = std::exp(random.uniform(std::log(1e-3), std::log(5e-2)));
    // From a hundredth of the noise up to three times it.
    how.gyro_lsb_rps = how.gyro_noise_rps * std::exp(random.uniform(std::log(0.01), std::log(3.0)));
    how.accel_lsb_mps2 = how.accel_noise_mps2 * std::exp(random.uniform(std::log(0.01), std::log(3.0)));
    how.slow_share = random.uniform(0.0, 1.0);
    how.temp_rate_kpmin = random.uniform(-0.3, 0.3);
    how.temp_lsb_c = seed % 2 == 0 ? 0.0 : random.uniform(0.003, 0.3);
    const auto found = findings_of(still(how, seed));
    findings += static_cast<int>(found.size());
    text += found.empty() ? "" : std::to_string(seed) + ": " + listed(found);
  }
  EXPECT_EQ(findings, 0) << text;
}

TEST(DataGate, FindsASmallTiltInMidSegment) {
  Recording r = still({}, 1);
  tilt(r, 3000, r.rows(), 0.5);
  const Finding finding = only(findings_of(r));
  EXPECT_EQ(finding.code, "moved");
  EXPECT_EQ(finding.severity, Severity::reject);
  EXPECT_FALSE(finding.sensor);
  EXPECT_NE(finding.text.find("by 0.5"), std::string::npos) << finding.text;
}

TEST(DataGate, FindsAUnitThatIsLiftedAndPutBack) {
  Recording r = still({}, 2);
  tilt(r, 2000, 3000, 30.0);
  EXPECT_EQ(only(findings_of(r)).code, "moved");
}

TEST(DataGate, FindsATurnAboutTheVerticalByTheGyroAlone) {
  Recording r = still({}, 3);
  // 5 degrees in 2 s; gravity sees nothing of it.
  for (std::size_t i = 2500; i < 2700; ++i) sensor(r, Sensor::gyro_z)[i] += 2.5 * base::kRadPerDeg;
  const Finding finding = only(findings_of(r));
  EXPECT_EQ(finding.code, "moved");
  EXPECT_NE(finding.text.find("gyro_z turns"), std::string::npos) << finding.text;
}

TEST(DataGate, TakesNoSlowThermalDriftForMotion) {
  Still how;
  how.seconds = 600.0;
  how.rate_hz = 10.0;
  how.temp_rate_kpmin = 3.0;    // 30 K in all, as on a ramp
  how.bias_per_k_mps2 = 7e-3;   // 0.21 m/s²: 1.2° of apparent tilt on each horizontal axis
  how.bias_per_k_rps = 1.7e-3;  // 0.1 deg/s per kelvin: 3 deg/s in all
  expect_clean(still(how, 4));
}

TEST(DataGate, TakesNoSmallTiltWithinNoiseForMotion) {
  Recording r = still({}, 5);
  tilt(r, 3000, r.rows(), 0.1);
  expect_clean(r);
}

TEST(DataGate, RejectsAKnockThatShiftsTheMeansAndWarnsOfOneThatDoesNot) {
  for (const double size_mps2 : {1.0, 10.0}) {
    Recording r = still({}, 6);
    for (std::size_t i = 1000; i < 1003; ++i) {
      for (const Sensor s : {Sensor::accel_x, Sensor::accel_y}) sensor(r, s)[i] += size_mps2;
    }
    const Finding finding = only(findings_of(r));
    EXPECT_EQ(finding.code, "knocked");
    // Three samples among 6000 of noise 0.01: 3 · size / (0.01 · √6000) standard errors, 3.9 and 39.
    EXPECT_EQ(finding.severity, Severity::reject) << finding.text;
    EXPECT_NE(finding.text.find("1 burst"), std::string::npos) << finding.text;
  }
  Recording r = still({}, 6);
  for (const Sensor s : {Sensor::accel_x, Sensor::accel_y}) sensor(r, s)[1000] += 1.0;  // 1.3 standard errors
  EXPECT_EQ(only(findings_of(r)).severity, Severity::warn);
}

TEST(DataGate, TakesNoOutlierOfOneSensorForAKnock) {
  Recording r = still({}, 7);
  sensor(r, Sensor::gyro_y)[1000] += 1.0;
  sensor(r, Sensor::accel_y)[4000] += 1.0;
  expect_clean(r);
}

TEST(DataGate, NamesThePositionThatAWrongLabelLooksLike) {
  Recording r = still({.position = "-Y"}, 8);
  r.positions = {*position_named("+Y")};
  const Finding finding = only(findings_of(r));
  EXPECT_EQ(finding.code, "wrong_position");
  EXPECT_EQ(finding.severity, Severity::reject);
  EXPECT_NE(finding.text.find("179 deg"), std::string::npos) << finding.text;
  EXPECT_NE(finding.text.find("looks like -Y"), std::string::npos) << finding.text;
  // With a type whose accelerometers read -g on the axis that points up, the label is right.
  UnitType type;
  type.sign_at_rest = -1;
  expect_clean(r, type);
}

TEST(DataGate, ToleratesAFixtureThatIsNotTrue) {
  Recording r = still({}, 9);
  tilt(r, 0, r.rows(), 15.0);
  expect_clean(r);
  tilt(r, 0, r.rows(), 10.0);  // 25 degrees: no other position is nearer
  EXPECT_EQ(only(findings_of(r)).code, "wrong_position");
  EXPECT_EQ(only(findings_of(r)).severity, Severity::warn);
  tilt(r, 0, r.rows(), 25.0);
  EXPECT_EQ(only(findings_of(r)).severity, Severity::reject);
}

/// A run of one visit with several positions in turn; `change` may alter each before it is appended.
template <class Change>
Recording positions_in_turn(const std::vector<std::string>& labels, const Still& how, const Change& change) {
  Recording all;
  for (std::size_t i = 0; i < labels.size(); ++i) {
    Still here = how;
    here.position = labels[i];
    Recording r = still(here, 100 + i);
    change(r, i);
    std::fill(r.position.begin(), r.position.end(), static_cast<std::int32_t>(i));
    if (i == 0) {
      all = std::move(r);
    } else {
      append(all, r);
      all.positions.push_back(r.positions[0]);
    }
  }
  return all;
}

const std::vector<std::string> kSix = {"+X", "-X", "+Y", "-Y", "+Z", "-Z"};

TEST(DataGate, TakesALargeBiasForNoWrongLabel) {
  const Still how{.seconds = 20.0};
  for (const Vector3& bias : {Vector3{3.0, -3.0, 2.0}, Vector3{2.5, 2.5, 0.0}}) {
    const auto add_bias = [&](Recording& r, std::size_t) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        for (double& value : r.sensor[3 + axis]) value += bias[axis];
      }
    };
    expect_clean(positions_in_turn(kSix, how, add_bias));
    // One position alone does not tell the bias; -Z is nearest all the same.
    for (const Finding& finding : findings_of(positions_in_turn({"-Z"}, how, add_bias))) {
      EXPECT_EQ(finding.code, "wrong_position");
      EXPECT_EQ(finding.severity, Severity::warn) << finding.text;
    }
  }
}

TEST(DataGate, FindsTwoSwappedLabelsUnderALargeBias) {
  Recording r = positions_in_turn(kSix, {.seconds = 20.0}, [](Recording& one, std::size_t) {
    for (double& value : sensor(one, Sensor::accel_x)) value += 3.0;
  });
  std::swap(r.positions[0], r.positions[3]);  // +X and -Y
  const auto findings = findings_of(r);
  ASSERT_EQ(findings.size(), 2U) << listed(findings);
  for (const Finding& finding : findings) EXPECT_EQ(finding.severity, Severity::reject) << finding.text;
  EXPECT_NE(findings[0].text.find("looks like +X"), std::string::npos) << findings[0].text;
  EXPECT_NE(findings[1].text.find("looks like -Y"), std::string::npos) << findings[1].text;
}

TEST(DataGate, NamesTheRemedyOnceWhereAUnitReadsMinusGUp) {
  const Recording r = positions_in_turn(kSix, {.seconds = 20.0}, [](Recording& one, std::size_t) {
    for (std::size_t s = 3; s < 6; ++s) {
      for (double& value : one.sensor[s]) value = -value;
    }
  });
  const auto findings = findings_of(r);
  ASSERT_EQ(findings.size(), 6U) << listed(findings);
  int named = 0;
  for (const Finding& finding : findings) {
    EXPECT_EQ(finding.severity, Severity::reject);
    named += finding.text.find("sign_at_rest = -1") != std::string::npos ? 1 : 0;
  }
  EXPECT_EQ(named, 1) << listed(findings);
  EXPECT_NE(findings[0].text.find("scale = -1"), std::string::npos) << findings[0].text;
  UnitType type;
  type.sign_at_rest = -1;
  expect_clean(r, type);
}

TEST(DataGate, WarnsOfASteadyTurnAboutTheVertical) {
  const auto findings = findings_of(positions_in_turn(kSix, {.seconds = 20.0}, [](Recording& one, std::size_t i) {
    if (i != 4) return;
    for (double& value : sensor(one, Sensor::gyro_z)) value += 0.8 * base::kRadPerDeg;
  }));
  const Finding finding = only(findings);
  EXPECT_EQ(finding.code, "moved");
  EXPECT_EQ(finding.severity, Severity::warn);
  EXPECT_NE(finding.text.find("gyro_z reads 0.80 deg/s away"), std::string::npos) << finding.text;
}

TEST(DataGate, TakesABadSampleOrAKnockForNoMotion) {
  const Still how{.rate_hz = 50.0};
  Recording gyro = still(how, 40);
  sensor(gyro, Sensor::gyro_x)[1500] = 200.0 * base::kRadPerDeg;
  expect_clean(gyro);
  Recording accel = still(how, 41);
  sensor(accel, Sensor::accel_x)[1500] = 150.0;
  expect_clean(accel);
  Recording knock = still(how, 42);
  for (std::size_t i = 1500; i < 1510; ++i) {
    for (const Sensor s : kSensors) sensor(knock, s)[i] += i % 2 == 0 ? 20.0 : -15.0;
  }
  EXPECT_EQ(only(findings_of(knock)).code, "knocked");
}

/// 80 K in 80 minutes in one attitude, without plateaus; accelerometers drift by 1.2 mg/K, and not in a straight line.
Recording ramp(double curvature) {
  Still how;
  how.seconds = 4800.0;
  how.rate_hz = 5.0;
  how.temp_rate_kpmin = 1.0;
  how.bias_per_k_mps2 = 1.2e-3 * kG;
  Recording r = still(how, 43);
  for (std::size_t i = 0; i < r.rows(); ++i) {
    const double share = static_cast<double>(i) / static_cast<double>(r.rows());
    for (std::size_t s = 3; s < 6; ++s) r.sensor[s][i] += curvature * kG * share * share;
  }
  return r;
}

TEST(DataGate, TakesAPoorUnitOnALongRampForUnmoved) {
  expect_clean(ramp(0.0));
  expect_clean(ramp(0.02));
}

TEST(DataGate, FindsAMoveOnALongRamp) {
  for (const double share : {0.2, 0.5, 0.8}) {
    Recording r = ramp(0.0);
    tilt(r, static_cast<std::size_t>(share * static_cast<double>(r.rows())), r.rows(), 1.0);
    EXPECT_EQ(only(findings_of(r)).code, "moved") << share;
  }
}

TEST(DataGate, FindsMotionWithoutAllThreeAccelerometers) {
  for (const bool with_x : {false, true}) {
    Recording r = still({}, 44);
    tilt(r, 3000, r.rows(), 60.0);
    sensor(r, Sensor::accel_y).clear();
    if (!with_x) sensor(r, Sensor::accel_x).clear();
    const auto found = findings_of(r);  // and a warning of the mean direction where two of them see it
    ASSERT_FALSE(found.empty()) << with_x;
    EXPECT_EQ(found.front().code, "moved") << with_x;
    Recording rest = still({}, 45);
    sensor(rest, Sensor::accel_y).clear();
    if (!with_x) sensor(rest, Sensor::accel_x).clear();
    expect_clean(rest);
  }
}

TEST(DataGate, FindsAStuckSensorWhoseNoiseIsBelowItsStep) {
  Recording r = still({.seconds = 15.0, .accel_noise_mps2 = 0.008, .accel_lsb_mps2 = 0.01}, 46);
  std::fill(sensor(r, Sensor::accel_y).begin() + 500, sensor(r, Sensor::accel_y).begin() + 1100, 0.1);
  const Finding finding = only(findings_of(r));
  EXPECT_EQ(finding.code, "stuck");
  EXPECT_EQ(finding.severity, Severity::reject);
}

TEST(DataGate, FindsASensorThatIsFrozenInHalfOfTheSegments) {
  for (const double noise_steps : {0.5, 2.0, 20.0}) {
    const Still how{.seconds = 20.0, .gyro_noise_rps = 1e-3, .gyro_lsb_rps = 1e-3 / noise_steps};
    const auto findings = findings_of(positions_in_turn(kSix, how, [](Recording& one, std::size_t i) {
      if (i >= 3) std::fill(sensor(one, Sensor::gyro_y).begin(), sensor(one, Sensor::gyro_y).end(), 0.01);
    }));
    EXPECT_EQ(findings.size(), 3U) << noise_steps << listed(findings);
    for (const Finding& finding : findings) {
      EXPECT_EQ(finding.code, "stuck");
      EXPECT_EQ(finding.severity, Severity::reject);
    }
  }
}

TEST(DataGate, FindsAQuietCoarseAccelerometerThatIsFrozen) {
  // Noise of a tenth of a step: one number per segment is usual, the same at +g and -g is not.
  const Still how{.seconds = 20.0, .accel_noise_mps2 = 0.001, .accel_lsb_mps2 = 0.01};
  expect_clean(positions_in_turn(kSix, how, [](Recording&, std::size_t) {}));
  const auto findings = findings_of(positions_in_turn(kSix, how, [](Recording& one, std::size_t i) {
    if (i >= 3) std::fill(sensor(one, Sensor::accel_z).begin(), sensor(one, Sensor::accel_z).end(), 0.13);
  }));
  const auto stuck = std::count_if(findings.begin(), findings.end(), [](const Finding& finding) {
    return finding.code == "stuck" && finding.severity == Severity::reject && finding.sensor == Sensor::accel_z;
  });
  EXPECT_EQ(stuck, 3) << listed(findings);
}

TEST(DataGate, JudgesAPositionByTheAccelerometersThatWereRecorded) {
  Recording r = still({.position = "-Z"}, 10);
  r.positions = {*position_named("+Z")};
  sensor(r, Sensor::accel_x).clear();
  sensor(r, Sensor::accel_y).clear();
  EXPECT_EQ(only(findings_of(r)).code, "wrong_position");
  Recording blind = r;
  sensor(blind, Sensor::accel_x) = sensor(r, Sensor::gyro_x);
  sensor(blind, Sensor::accel_z).clear();
  expect_clean(blind);
}

TEST(DataGate, RejectsASensorAtTheEndOfItsRange) {
  UnitType type;
  type.accel_range_mps2 = 9.85;  // a 1 g sensor with a bias of 0.1 in a field of 1 g
  Recording r = still({}, 11);
  for (double& value : sensor(r, Sensor::accel_z)) value = std::min(value, 9.85);
  const Finding finding = only(findings_of(r, type));
  EXPECT_EQ(finding.code, "saturated");
  EXPECT_EQ(finding.severity, Severity::reject);
  EXPECT_EQ(finding.sensor, Sensor::accel_z);
  EXPECT_NE(finding.text.find("9.85 m/s2"), std::string::npos) << finding.text;
}

TEST(DataGate, FindsSaturationWithoutKnowingTheRange) {
  Recording r = still({.accel_lsb_mps2 = 0.001}, 12);
  // Cut off one standard deviation above the mean: 16 % of the samples.
  for (double& value : sensor(r, Sensor::accel_z)) value = std::min(value, kG + 0.11);
  const Finding finding = only(findings_of(r));
  EXPECT_EQ(finding.code, "saturated");
  EXPECT_EQ(finding.severity, Severity::reject);
  EXPECT_NE(finding.text.find("9.91665"), std::string::npos) << finding.text;
}

TEST(DataGate, TakesNoNoiseThatPeaksAtItsExtremeStepForSaturation) {
  // Noise of half a step whose mean lies near one of them: most samples stand on the second highest or highest step.
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    expect_clean(still({.accel_noise_mps2 = 0.005 + 0.0003 * static_cast<double>(seed), .accel_lsb_mps2 = 0.01}, seed));
  }
}

TEST(DataGate, TakesNoDriftThatEndsOnOneStepForSaturation) {
  Recording r = still({}, 13);
  // Rises through ten steps in the first half second and stays on the last, flickering to the one below now and then.
  for (std::size_t i = 0; i < r.rows(); ++i) {
    const double level = std::round(10.0 * std::min(1.0, static_cast<double>(i) / 50.0));
    sensor(r, Sensor::gyro_x)[i] = 1e-4 * (level == 10.0 && i % 12 == 0 ? 9.0 : level);
  }
  expect_clean(r);
}

TEST(DataGate, RejectsASensorThatSticksWhileItLivesElsewhere) {
  Recording r = still({.gyro_lsb_rps = 2e-4}, 14);
  std::fill(sensor(r, Sensor::gyro_y).begin() + 4000, sensor(r, Sensor::gyro_y).end(), 0.0102);
  const Finding finding = only(findings_of(r));
  EXPECT_EQ(finding.code, "stuck");
  EXPECT_EQ(finding.severity, Severity::reject);
  EXPECT_EQ(finding.sensor, Sensor::gyro_y);
  EXPECT_NE(finding.text.find("2000"), std::string::npos) << finding.text;
}

TEST(DataGate, KnowsAStuckSegmentByTheNoiseOfTheOthers) {
  Recording r = still({}, 15);
  Recording dead = still({}, 16);
  std::fill(sensor(dead, Sensor::accel_y).begin(), sensor(dead, Sensor::accel_y).end(), 0.123);
  append(r, dead);
  const auto cut = segment(r);
  ASSERT_EQ(cut->segments.size(), 2U);
  const auto findings = examine(r, cut->segments, {});
  EXPECT_TRUE(findings[0].empty()) << listed(findings[0]);
  EXPECT_EQ(only(findings[1]).code, "stuck");
}

TEST(DataGate, RejectsASensorThatGivesOneNumberThroughoutAndWarnsWhereResolutionMayExplainIt) {
  Recording r = still({}, 17);
  Recording later = still({}, 18);
  std::fill(later.plateau_c.begin(), later.plateau_c.end(), 30.0);
  for (double& temp_c : later.temp_c) temp_c += 5.0;
  std::fill(sensor(r, Sensor::accel_x).begin(), sensor(r, Sensor::accel_x).end(), 0.25);
  EXPECT_EQ(only(findings_of(r)).severity, Severity::warn);
  std::fill(sensor(later, Sensor::accel_x).begin(), sensor(later, Sensor::accel_x).end(), 0.25);
  append(r, later);
  const auto both = findings_of(r);
  ASSERT_EQ(both.size(), 2U) << listed(both);
  EXPECT_EQ(both[0].code, "stuck");
  EXPECT_EQ(both[0].severity, Severity::reject);
  EXPECT_NE(both[0].text.find("throughout"), std::string::npos) << both[0].text;
}

TEST(DataGate, TakesNoQuietSensorOnCoarseStepsForStuck) {
  // Noise of a tenth of a step: for seconds on end there is one number, then another.
  expect_clean(still({.gyro_noise_rps = 1e-5, .gyro_lsb_rps = 1e-4, .temp_rate_kpmin = 1.0}, 18));
}

TEST(DataGate, TakesAQuietCoarseGyroThatShowsOneNumberInAllPositionsAsItIs) {
  // Gravity does not turn a gyro; at one temperature its one code may explain the one number.
  const Still how{.seconds = 20.0, .gyro_noise_rps = 1e-4, .gyro_lsb_rps = 2e-3};
  const auto findings = findings_of(positions_in_turn(kSix, how, [](Recording&, std::size_t) {}));
  ASSERT_FALSE(findings.empty());
  for (const Finding& finding : findings) EXPECT_EQ(finding.severity, Severity::warn) << finding.text;
}

TEST(DataGate, TakesACodeOfACoarseGyroForNoTurn) {
  // One code is 0.5 deg/s, 5 degrees in ten seconds.
  Recording r = still({.gyro_noise_rps = 1e-4}, 47);
  for (std::size_t i = 0; i < r.rows(); ++i) {
    sensor(r, Sensor::gyro_z)[i] = (i < 2200 || i >= 3300 ? 0.5 : 1.0) * base::kRadPerDeg;
  }
  expect_clean(r);
}

TEST(DataGate, TakesASimulationWithoutNoiseAsItIs) {
  Recording r = still({.gyro_noise_rps = 0.0, .accel_noise_mps2 = 0.0, .temp_rate_kpmin = 0.0}, 19);
  Recording other = still({.gyro_noise_rps = 0.0, .accel_noise_mps2 = 0.0, .temp_rate_kpmin = 0.0}, 20);
  for (auto& values : other.sensor) {
    for (double& value : values) value += 0.001;
  }
  append(r, other);
  expect_clean(r);
}

TEST(DataGate, TakesADeviceThatRepeatsItsValuesAsItIs) {
  // A sensor of 20 Hz in packets of 100 Hz.
  Recording r = still({}, 21);
  for (auto& values : r.sensor) {
    for (std::size_t i = 0; i < values.size(); ++i) values[i] = values[i - i % 5];
  }
  expect_clean(r);
}

TEST(DataGate, WarnsOfDropoutsAndRejectsWhereMuchIsMissing) {
  Recording r = still({}, 22);
  remove_rows(r, 1000, 1300);  // 3 s of 60: 5 %
  const auto found = findings_of(r);
  ASSERT_EQ(found.size(), 6U) << listed(found);
  EXPECT_EQ(found.front().code, "dropouts");
  EXPECT_EQ(found.front().severity, Severity::warn);
  EXPECT_NE(found.front().text.find("5.0 %"), std::string::npos) << found.front().text;

  Recording holes = still({}, 23);
  for (std::size_t i = 0; i < holes.rows(); i += 3) sensor(holes, Sensor::gyro_x)[i] = kNone;
  const Finding third = only(findings_of(holes));
  EXPECT_EQ(third.code, "dropouts");
  EXPECT_EQ(third.severity, Severity::reject);
  EXPECT_EQ(third.sensor, Sensor::gyro_x);
}

TEST(DataGate, TakesASlowerChannelAndASingleLostPacketAsTheyAre) {
  Recording r = still({}, 24);
  for (std::size_t i = 0; i < r.rows(); ++i) {
    if (i % 4 != 0) sensor(r, Sensor::accel_x)[i] = kNone;  // 25 Hz beside 100 Hz
  }
  remove_rows(r, 3001, 3002);
  // Gravity has no direction in rows without the x axis, but means of stretches do.
  expect_clean(r);
}

TEST(DataGate, WarnsOfIrregularSampling) {
  Recording r = still({}, 25);
  for (std::size_t i = 0; i < r.rows(); ++i) {
    r.t_s[i] = 0.04 * static_cast<double>(i / 4) + 0.001 * static_cast<double>(i % 4);  // in bursts of four
  }
  const Finding finding = only(findings_of(r));
  EXPECT_EQ(finding.code, "irregular_sampling");
  EXPECT_EQ(finding.severity, Severity::warn);

  Recording jitter = still({}, 26);
  base::Random random(27);
  for (double& t_s : jitter.t_s) t_s += random.uniform(-0.002, 0.002);  // a fifth of the interval
  expect_clean(jitter);
}

TEST(DataGate, WarnsOfAThermometerInWholeDegrees) {
  Still how;
  how.temp_rate_kpmin = 5.0;
  how.temp_noise_c = 0.05;
  how.temp_lsb_c = 1.0;
  const Finding finding = only(findings_of(still(how, 28)));
  EXPECT_EQ(finding.code, "coarse_thermometer");
  EXPECT_EQ(finding.severity, Severity::warn);
  EXPECT_NE(finding.text.find("steps of 1 K"), std::string::npos) << finding.text;
  how.temp_lsb_c = 0.25;
  expect_clean(still(how, 28));
  // One that stands on a whole degree throughout shows no step; the type may state it.
  UnitType type;
  type.temp_lsb_c = 1.0;
  EXPECT_EQ(only(findings_of(still({.temp_lsb_c = 1.0}, 29), type)).code, "coarse_thermometer");
}

TEST(DataGate, AcceptsWhatIsNotRejected) {
  Segment whole;
  whole.sensor.fill({10, 1.0, 1.0, 1.0});
  whole.blocks.resize(2);
  for (Block& block : whole.blocks) block.sensor = whole.sensor;
  whole.findings = {{"dropouts", Severity::warn, Sensor::gyro_x, "few"}};
  Segment part = whole;
  part.findings.push_back({"stuck", Severity::reject, Sensor::accel_x, "0.25"});
  Segment none = whole;
  none.findings.push_back({"moved", Severity::reject, std::nullopt, "by 3 deg"});
  EXPECT_FALSE(is_rejected(part));
  EXPECT_TRUE(is_rejected(part, Sensor::accel_x));
  EXPECT_TRUE(is_rejected(none));
  EXPECT_TRUE(is_rejected(none, Sensor::gyro_z));

  const std::vector<Segment> all = {whole, part, none};
  const auto kept = accepted(all);
  ASSERT_EQ(kept.size(), 2U);
  EXPECT_EQ(kept[0].sensor[3].count, 10U);
  EXPECT_EQ(kept[1].sensor[3].count, 0U);
  EXPECT_EQ(kept[1].blocks[1].sensor[3].count, 0U);
  EXPECT_EQ(kept[1].sensor[0].count, 10U);

  const auto warnings = summarise(all);
  ASSERT_EQ(warnings.size(), 3U);
  EXPECT_EQ(warnings[0].code, "dropouts");
  EXPECT_EQ(warnings[0].text, "has 3 of 3 segments; the first, visit 0: few");
  EXPECT_EQ(warnings[2].text, "loses 1 of 3 segments; the first, visit 0: by 3 deg");
}

/// Rows of numbers of a text file, without its header line.
std::vector<std::vector<double>> table_of(const std::filesystem::path& path, bool header) {
  std::ifstream file(path);
  std::string line;
  if (header) std::getline(file, line);
  std::vector<std::vector<double>> rows;
  while (std::getline(file, line)) {
    std::istringstream words(line);
    std::vector<double> row;
    for (double value = 0.0; words >> value;) row.push_back(value);
    if (!row.empty()) rows.push_back(std::move(row));
  }
  return rows;
}

std::filesystem::path shared_data(const char* folder) {
  const char* const base = std::getenv("SOAK_TEST_DATA");
  const auto shared = std::filesystem::path(SOAK_TEST_FOLDER) / ".." / ".." / "shared" / "data";
  return (base != nullptr ? std::filesystem::path(base) : shared) / folder;
}

TEST(DataGate, FindsNoMotionInTheChamberRecording) {
  const auto path = shared_data("thermal_chamber_cycle") / "imu_raw_data.csv";
  if (!std::filesystem::exists(path)) GTEST_SKIP() << "the chamber recording is not here (SOAK_TEST_DATA)";
  Recording r;
  for (const auto& row : table_of(path, true)) {
    r.t_s.push_back(row[0] * 1e-6);
    for (std::size_t s = 0; s < kSensorCount; ++s) r.sensor[s].push_back(row[1 + s]);
    r.temp_c.push_back(row[8]);
  }
  // 92 K of thermal drift, 3 deg/s of it on gyro y, in one attitude; only the first row is an outlier (PROVENANCE.md).
  const Finding finding = only(findings_of(r));
  EXPECT_EQ(finding.code, "knocked");
  EXPECT_EQ(finding.severity, Severity::warn);
  EXPECT_NE(finding.text.find("1 burst"), std::string::npos) << finding.text;
}

TEST(DataGate, TellsTheRestOfAHandHeldRecordingFromItsTurns) {
  const auto folder = shared_data("multi_position_xsens");
  if (!std::filesystem::exists(folder / "xsens_acc.mat")) {
    GTEST_SKIP() << "the multi-position recording is not here (SOAK_TEST_DATA)";
  }
  const auto accel = table_of(folder / "xsens_acc.mat", false);
  const auto gyro = table_of(folder / "xsens_gyro.mat", false);
  ASSERT_EQ(accel.size(), gyro.size());
  // Factory offset and scale in counts, PROVENANCE.md.
  constexpr std::array kAccelOffset = {33123.0, 33276.0, 32360.0};
  constexpr std::array kGyroOffset = {32768.0, 32466.0, 32485.0};
  Recording all;
  for (std::size_t i = 0; i < accel.size(); ++i) {
    all.t_s.push_back(accel[i][0]);
    all.temp_c.push_back(25.0);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      all.sensor[axis].push_back((gyro[i][1 + axis] - kGyroOffset[axis]) / 4766.0);
      all.sensor[3 + axis].push_back((accel[i][1 + axis] - kAccelOffset[axis]) / 414.5);
    }
  }
  EXPECT_EQ(only(findings_of(all)).code, "moved");
  // The first 50 s lie still (38 positions follow).
  Recording rest = all;
  const auto end = std::lower_bound(rest.t_s.begin(), rest.t_s.end(), rest.t_s.front() + 45.0) - rest.t_s.begin();
  const auto keep = [&](std::vector<double>& values) { values.resize(static_cast<std::size_t>(end)); };
  keep(rest.t_s);
  keep(rest.temp_c);
  for (auto& values : rest.sensor) keep(values);
  expect_clean(rest);
}

}  // namespace
}  // namespace soak::calib
