// SPDX-License-Identifier: Apache-2.0
#include "calib/estimate/unit_input.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "base/random.h"
#include "tests/errors.h"

// Samples that were filed twice, seen through labels, serial numbers and void records.
namespace soak::calib {
namespace {

constexpr int kSamples = 90;

/// What `kSamples` readings with steps of `step` give in a minute from `t_s`.
Segment segment(base::Random& random, double t_s, double step = 0.0) {
  Segment made;
  made.key = {"run", "SN1", static_cast<std::int32_t>(t_s / 600.0), "+Z", 0};
  made.t_start_s = t_s;
  made.t_end_s = t_s + 60.0;
  made.temp_c = 20.0 + 0.01 * random.gaussian();
  for (SensorStatistics& sensor : made.sensor) {
    std::vector<double> readings;
    for (int i = 0; i < kSamples; ++i) {
      const double reading = random.gaussian();
      readings.push_back(step > 0.0 ? step * std::round(reading / step) : reading);
    }
    sensor.count = readings.size();
    for (const double x : readings) sensor.mean += x / kSamples;
    for (const double x : readings) sensor.variance += (x - sensor.mean) * (x - sensor.mean) / (kSamples - 1);
  }
  return made;
}

std::vector<Segment> segments(std::uint64_t seed, double step = 0.0) {
  base::Random random(seed);
  std::vector<Segment> made;
  for (int i = 0; i < 12; ++i) made.push_back(segment(random, 100.0 * i, step));
  return made;
}

RunInput run(const std::string& campaign, const std::string& label, std::uint64_t seed) {
  RunInput made;
  made.campaign = campaign;
  made.label = label;
  made.content_sha256 = "content of " + campaign + "/" + label;
  made.segments = segments(seed);
  return made;
}

std::vector<std::string> names_of(const std::vector<RunInput>& runs) {
  std::vector<std::string> names;
  for (const RunInput& one : runs) names.push_back(one.campaign + "/" + one.label);
  return names;
}

TEST(RunCopies, AreSeenWhateverTheirSerialNumberAndLabels) {
  const auto original = segments(1);
  auto copy = original;
  for (Segment& one : copy) one.key = {"other run", "SN2", 7, "unknown", 3};
  EXPECT_TRUE(same_samples(original, copy));
  EXPECT_FALSE(same_samples(original, segments(2)));
}

TEST(RunCopies, AreSeenWherePartsOfEachWereWithdrawn) {
  auto original = segments(1);
  auto copy = original;
  original.erase(original.begin() + 2, original.begin() + 5);
  copy.erase(copy.begin() + 8);
  EXPECT_TRUE(same_samples(original, copy));
  copy.resize(2);
  original.erase(original.begin(), original.begin() + 2);
  EXPECT_FALSE(same_samples(original, copy)) << "nothing is left that both have";
}

TEST(RunCopies, OneOtherNumberMakesAnotherRecording) {
  const auto original = segments(1);
  auto other = original;
  other[5].sensor[3].mean = std::nextafter(other[5].sensor[3].mean, 1e9);
  EXPECT_FALSE(same_samples(original, other));
  other = original;
  --other[5].sensor[3].count;
  EXPECT_FALSE(same_samples(original, other));
}

TEST(RunCopies, ASensorThatWasNotRecordedIsThatInBoth) {
  auto original = segments(1);
  for (Segment& one : original) {
    one.sensor[2] = {0, std::numeric_limits<double>::quiet_NaN(), 0.0, 0.0};
    one.temp_c = std::numeric_limits<double>::quiet_NaN();
  }
  auto copy = original;
  for (Segment& one : copy) one.sensor[2].mean = 0.0;
  EXPECT_TRUE(same_samples(original, copy));
}

TEST(RunCopies, CoarseRecordingsOfOneUnitAreNotTakenForEachOther) {
  // Steps of twice the noise: most readings are one of three numbers, and means fall on a grid of a 45th.
  for (std::uint64_t seed = 10; seed < 60; ++seed) {
    EXPECT_FALSE(same_samples(segments(1, 2.0), segments(seed, 2.0))) << seed;
  }
  // Nothing but zeros says nothing.
  EXPECT_FALSE(same_samples(segments(1, 1000.0), segments(1, 1000.0)));
}

TEST(RunCopies, CountOnceByTheFirst) {
  std::vector<RunInput> runs = {run("a", "r1", 1), run("a", "r2", 2), run("b", "r1", 1), run("c", "x1", 1)};
  runs.push_back(run("d", "void in parts", 9));
  runs.back().segments.clear();
  runs.back().content_sha256 = runs[1].content_sha256;
  std::vector<Warning> warnings;
  leave_out_copies(runs, warnings);
  EXPECT_EQ(names_of(runs), (std::vector<std::string>{"a/r1", "a/r2"}));
  EXPECT_EQ(runs[0].segments.size(), 12U);
  ASSERT_EQ(warnings.size(), 2U);
  EXPECT_EQ(warnings[0].code, "copied_runs");
  EXPECT_TRUE(base::mentions(warnings[0].text, {"b/r1, c/x1", "a/r1"}));
  EXPECT_TRUE(base::mentions(warnings[1].text, {"d/void in parts"}));
}

TEST(RunCopies, RunsOfTheirOwnStayAsTheyAre) {
  std::vector<RunInput> runs = {run("a", "r1", 1), run("a", "r2", 2), run("b", "r1", 3)};
  for (RunInput& one : runs) one.content_sha256.clear();  // not known: no reason to call them the same
  std::vector<Warning> warnings;
  leave_out_copies(runs, warnings);
  EXPECT_EQ(runs.size(), 3U);
  EXPECT_TRUE(warnings.empty());
}

}  // namespace
}  // namespace soak::calib
