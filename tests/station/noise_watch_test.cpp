// SPDX-License-Identifier: Apache-2.0
#include "station/lab/noise_watch.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <thread>

#include "base/random.h"
#include "base/units.h"
#include "calib/signal/allan/allan.h"

namespace soak::station {
namespace {

using calib::signal::AllanKind;
using calib::signal::PhaseRecord;
using nlohmann::json;
using std::chrono::seconds;
using std::chrono::steady_clock;

constexpr double kRate_hz = 100.0;
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

hal::ImuSample sample_at(double t_s, float value) {
  hal::ImuSample sample;
  sample.t_s = t_s;
  sample.rate_rps = {value, 2.0F * value, 3.0F * value};
  sample.accel_mps2 = {4.0F * value, 5.0F * value, 6.0F * value};
  return sample;
}

/// Samples `kRate_hz` apart, one for each value; none where it is NaN.
std::vector<hal::ImuSample> recording(double start_s, const std::vector<double>& values) {
  std::vector<hal::ImuSample> samples;
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (std::isnan(values[i])) continue;
    samples.push_back(sample_at(start_s + static_cast<double>(i) / kRate_hz, static_cast<float>(values[i])));
  }
  return samples;
}

void record(NoiseWatch& watch, double start_s, const std::vector<double>& values) {
  watch.begin_recording();
  watch.add(recording(start_s, values));
}

std::vector<double> white(std::size_t count, double sigma, std::uint64_t seed) {
  base::Random random(seed);
  std::vector<double> values;
  // As a unit sends them: single precision.
  while (values.size() < count) values.push_back(static_cast<double>(static_cast<float>(sigma * random.gaussian())));
  return values;
}

json gyro_x(const NoiseWatch& watch) { return watch.document("SN1")["sensors"]["gyro_x"]; }

TEST(NoiseWatch, GivesTheDeviationsOfTheSamplesOfAllRecordings) {
  std::vector<double> first = white(700, 0.01, 1);
  std::vector<double> second = white(900, 0.01, 2);
  first[300] = kNan;                                            // one packet: bridged
  std::fill(second.begin() + 100, second.begin() + 120, kNan);  // a gap
  NoiseWatch watch(kRate_hz);
  record(watch, 50.0, first);
  record(watch, 4000.0, second);

  std::vector<double> both = first;
  both.insert(both.end(), 100, kNan);
  both.insert(both.end(), second.begin(), second.end());
  const auto reference = PhaseRecord::from_rate(both, kRate_hz);
  ASSERT_TRUE(reference);

  const json document = watch.document("SN1");
  EXPECT_EQ(document["unit"], "SN1");
  EXPECT_EQ(document["rate_hz"], kRate_hz);
  EXPECT_EQ(document["samples"], 699 + 880);
  const json& tau_s = document["tau_s"];
  // 700 samples carry 224, 256 would need 768; the 780 of the longest stretch carry 256.
  EXPECT_EQ(tau_s.back(), 2.56);
  const json& sensor = document["sensors"]["gyro_x"];
  EXPECT_EQ(sensor["unit"], "deg/s");
  ASSERT_EQ(sensor["oadev"].size(), tau_s.size());
  ASSERT_EQ(sensor["mdev"].size(), tau_s.size());
  for (std::size_t i = 0; i < tau_s.size(); ++i) {
    const auto multiple = static_cast<std::size_t>(std::lround(tau_s[i].get<double>() * kRate_hz));
    const auto expect = [&](AllanKind kind, const char* name) {
      const double value = allan_point(*reference, kind, multiple).deviation * base::kDegPerRad;
      EXPECT_DOUBLE_EQ(sensor[name][i].get<double>(), value) << name << " at " << multiple;
    };
    expect(AllanKind::overlapping, "oadev");
    expect(AllanKind::modified, "mdev");
  }
  // The accelerometer's samples are four times as large, and stay in m/s².
  EXPECT_EQ(document["sensors"]["accel_x"]["unit"], "m/s2");
  EXPECT_NEAR(document["sensors"]["accel_x"]["oadev"][5].get<double>() * base::kDegPerRad,
              4.0 * sensor["oadev"][5].get<double>(), 1e-9);
}

TEST(NoiseWatch, ARecordingCarriesAveragingTimesUpToAThirdOfItsLength) {
  NoiseWatch watch(kRate_hz);
  record(watch, 0.0, white(300, 0.01, 11));
  EXPECT_EQ(watch.document("SN1")["tau_s"].back(), 0.96);
  watch.begin_run();
  record(watch, 0.0, white(30000, 0.01, 11));  // of the longer averages the stream counts every second difference only
  EXPECT_EQ(watch.document("SN1")["tau_s"].back(), 81.92);
}

TEST(NoiseWatch, NoDifferenceReachesFromOneRecordingToTheNextOrAcrossAGap) {
  NoiseWatch watch(kRate_hz);
  record(watch, 0.0, std::vector<double>(500, 0.25));
  record(watch, 5.0, std::vector<double>(500, -0.5));  // the very next sample, after a turn
  std::vector<double> with_gap(1000, 1.0);
  std::fill(with_gap.begin() + 400, with_gap.begin() + 406, kNan);  // six: one more than are bridged
  std::fill(with_gap.begin() + 406, with_gap.end(), 2.0);
  record(watch, 100.0, with_gap);
  const json deviations = gyro_x(watch)["oadev"];
  ASSERT_GT(deviations.size(), 10U);
  for (const json& value : deviations) EXPECT_EQ(value, 0.0);
}

TEST(NoiseWatch, AnyStepInsideARecordingShows) {
  NoiseWatch watch(kRate_hz);
  std::vector<double> step(1000, 0.25);
  std::fill(step.begin() + 500, step.end(), -0.5);
  record(watch, 0.0, step);
  const json deviations = gyro_x(watch)["oadev"];
  ASSERT_FALSE(deviations.empty());
  for (const json& value : deviations) EXPECT_GT(value, 0.0);
}

// A rate that rises evenly has its deviation from the slope alone. Were the missing samples left out without a trace,
// the rate would jump there.
TEST(NoiseWatch, EachLostPacketIsOneMissingSample) {
  std::vector<double> ramp;
  for (int i = 0; i < 1000; ++i) ramp.push_back(i / 1024.0);
  NoiseWatch whole(kRate_hz);
  record(whole, 0.0, ramp);
  for (const int lost : {1, 2, 3, 4, 5}) ramp[static_cast<std::size_t>(100 * lost)] = kNan;
  ramp[501] = ramp[502] = ramp[503] = ramp[504] = kNan;  // five in a row
  NoiseWatch with_losses(kRate_hz);
  record(with_losses, 0.0, ramp);
  const json expected = gyro_x(whole)["oadev"];
  const json found = gyro_x(with_losses)["oadev"];
  ASSERT_EQ(found.size(), expected.size());
  for (std::size_t i = 0; i < found.size(); ++i) EXPECT_NEAR(found[i], expected[i], 1e-9 * expected[i].get<double>());
}

TEST(NoiseWatch, HowTheSamplesArriveChangesNothing) {
  const auto samples = recording(0.0, white(5000, 0.01, 3));
  NoiseWatch at_once(kRate_hz);
  NoiseWatch in_pieces(kRate_hz);
  at_once.begin_recording();
  in_pieces.begin_recording();
  at_once.add(samples);
  for (std::size_t i = 0; i < samples.size(); i += 7) {
    in_pieces.add(std::span(samples).subspan(i, std::min<std::size_t>(7, samples.size() - i)));
  }
  EXPECT_EQ(at_once.document("SN1"), in_pieces.document("SN1"));
}

TEST(NoiseWatch, FiguresNeedThirtyDifferencesThatDoNotOverlap) {
  // 10 Hz, averages of 10 samples: of n samples in one stretch n + 1 - 2 * 10 differences exist, every tenth of which
  // begins where no other one of them does.
  NoiseWatch watch(10.0);
  const auto now = steady_clock::now();
  watch.begin_recording();
  std::vector<hal::ImuSample> samples;
  for (int i = 0; i < 319; ++i) samples.push_back(sample_at(0.1 * i, i % 2 == 0 ? 0.5F : -0.5F));
  watch.add(std::span(samples).first(318));
  watch.refresh(now);
  EXPECT_EQ(watch.figures().tau_s, 1.0);
  EXPECT_FALSE(watch.figures().gyro_dps);
  EXPECT_FALSE(watch.figures().accel_mps2);
  watch.add(std::span(samples).last(1));
  watch.refresh(now + seconds(3));
  EXPECT_TRUE(watch.figures().gyro_dps);
  EXPECT_TRUE(watch.figures().accel_mps2);
}

TEST(NoiseWatch, FiguresAreTheWhiteNoiseOfEachSensor) {
  constexpr std::size_t kSamples = 20000;
  NoiseWatch watch(kRate_hz);
  record(watch, 0.0, white(kSamples, 0.01, 4));
  watch.refresh(steady_clock::now());
  const NoiseFigures& figures = watch.figures();
  EXPECT_EQ(figures.tau_s, 0.96);
  ASSERT_TRUE(figures.gyro_dps && figures.accel_mps2);
  // White noise of sigma per sample: sigma / sqrt(m) at m samples. 20000 / 96 = 208 averages have 1.5 * 208 - 2 = 310
  // degrees of freedom [NIST SP 1065, table 5]: 1 / sqrt(2 * 310) = 4 %, taken five times.
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double unit = 0.01 / std::sqrt(96.0);
    const double gyro_dps = unit * static_cast<double>(axis + 1) * base::kDegPerRad;
    const double accel_mps2 = unit * static_cast<double>(axis + 4);
    EXPECT_NEAR((*figures.gyro_dps)[axis], gyro_dps, 0.2 * gyro_dps);
    EXPECT_NEAR((*figures.accel_mps2)[axis], accel_mps2, 0.2 * accel_mps2);
  }
}

TEST(NoiseWatch, FiguresAreRefreshedEveryTwoSecondsAtMost) {
  NoiseWatch watch(kRate_hz);
  const auto now = steady_clock::now();
  record(watch, 0.0, white(4000, 0.01, 5));
  watch.refresh(now);
  const double before = watch.figures().gyro_dps.value()[0];
  record(watch, 100.0, white(4000, 1.0, 6));
  watch.refresh(now + std::chrono::milliseconds(1900));
  EXPECT_EQ(watch.figures().gyro_dps.value()[0], before);
  watch.refresh(now + std::chrono::milliseconds(2000));
  EXPECT_GT(watch.figures().gyro_dps.value()[0], 10.0 * before);
}

TEST(NoiseWatch, ANewRunBeginsWithNothing) {
  NoiseWatch watch(kRate_hz);
  record(watch, 0.0, white(4000, 0.01, 7));
  watch.refresh(steady_clock::now());
  ASSERT_TRUE(watch.figures().gyro_dps);
  watch.begin_run();
  EXPECT_FALSE(watch.figures().gyro_dps);
  EXPECT_EQ(watch.figures().tau_s, 0.96);
  const json document = watch.document("SN1");
  EXPECT_EQ(document["samples"], 0);
  EXPECT_TRUE(document["tau_s"].empty());
  EXPECT_TRUE(document["sensors"]["accel_z"]["mdev"].empty());
  NoiseWatch fresh(kRate_hz);
  record(watch, 0.0, white(500, 0.02, 8));
  record(fresh, 0.0, white(500, 0.02, 8));
  EXPECT_EQ(watch.document("SN1"), fresh.document("SN1"));
}

TEST(NoiseWatch, TheAveragingTimeIsTheNearestToOneSecondThatThereIs) {
  std::vector<std::size_t> multiples = {1, 2, 3};
  for (std::size_t power = 1; power <= 4096; power *= 2) {
    for (std::size_t m = 4; m < 8; ++m) multiples.push_back(m * power);
  }
  for (const double rate_hz : {0.1, 0.7, 1.0, 2.4, 7.0, 8.4, 10.0, 11.2, 100.0, 200.0, 400.0, 833.0, 1000.0, 10000.0}) {
    double nearest = 1e9;
    for (const std::size_t m : multiples) {
      const double tau_s = static_cast<double>(m) / rate_hz;
      if (std::abs(tau_s - 1.0) < std::abs(nearest - 1.0)) nearest = tau_s;
    }
    EXPECT_DOUBLE_EQ(NoiseWatch(rate_hz).figures().tau_s, nearest) << rate_hz;
  }
}

TEST(NoiseWatch, AReadingThatIsNotFiniteIsMissing) {
  auto samples = recording(0.0, white(1000, 0.01, 9));
  NoiseWatch watch(kRate_hz);
  NoiseWatch clean(kRate_hz);
  clean.begin_recording();
  clean.add(samples);
  samples[500].rate_rps[0] = std::numeric_limits<float>::infinity();
  for (std::size_t i = 700; i < 1000; ++i) samples[i].rate_rps[1] = std::numeric_limits<float>::quiet_NaN();
  watch.begin_recording();
  watch.add(samples);
  const json sensors = watch.document("SN1")["sensors"];
  EXPECT_EQ(sensors["gyro_z"], clean.document("SN1")["sensors"]["gyro_z"]);
  // One reading of a thousand, bridged: it bears on two differences of neighbours, a share of 1e-3 each.
  EXPECT_NEAR(sensors["gyro_x"]["oadev"][0], clean.document("SN1")["sensors"]["gyro_x"]["oadev"][0], 1e-2);
  // The lists are of one length; what a sensor lacks is null.
  ASSERT_EQ(sensors["gyro_y"]["oadev"].size(), sensors["gyro_z"]["oadev"].size());
  EXPECT_TRUE(sensors["gyro_y"]["oadev"].back().is_null());
  EXPECT_TRUE(sensors["gyro_z"]["oadev"].back().is_number());
}

TEST(NoiseWatch, AnyThreadMayAskWhileSamplesCome) {
  NoiseWatch watch(kRate_hz);
  const auto samples = recording(0.0, white(4000, 0.01, 10));
  watch.begin_recording();
  watch.add(std::span(samples).first(100));
  std::thread asking([&] {
    for (int i = 0; i < 20; ++i) EXPECT_GE(watch.document("SN1")["samples"], 100);
  });
  for (std::size_t i = 100; i < samples.size(); i += 100) watch.add(std::span(samples).subspan(i, 100));
  asking.join();
  EXPECT_EQ(watch.document("SN1")["samples"], 4000);
}

}  // namespace
}  // namespace soak::station
