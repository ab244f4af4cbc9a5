// SPDX-License-Identifier: Apache-2.0
// A run that is reduced sensor by sensor, against plain arithmetic on whole columns.
#include <gtest/gtest.h>
#include <stdlib.h>

#include <array>
#include <bit>
#include <cmath>
#include <filesystem>
#include <numeric>
#include <optional>
#include <string>
#include <vector>

#include "calib/segments/data_gate.h"
#include "calib/segments/segmentation.h"
#include "calib/segments/statistics.h"
#include "calib/signal/noise/mean_error.h"
#include "station/import/channel.h"
#include "station/import/slow_channel.h"
#include "station/runs/recording_reader.h"
#include "tests/station/tricky_run.h"

namespace soak::station {
namespace {

namespace fs = std::filesystem;
constexpr std::uint64_t kSeeds = 12;

class RunReductionTest : public ::testing::TestWithParam<std::uint64_t> {
 protected:
  void SetUp() override {
    std::string name = (fs::temp_directory_path() / "soak-reduction-XXXXXX").string();
    ASSERT_NE(::mkdtemp(name.data()), nullptr);
    folder_ = name;
    testing::write_tricky_run(folder_ / "run.soakrun", GetParam());
    file_.emplace(db::RunFileReader::open(folder_ / "run.soakrun").value());
  }
  void TearDown() override {
    file_.reset();
    fs::remove_all(folder_);
  }

  /// A sensor's channel as a whole, number by number; nothing where it was not recorded.
  std::vector<double> whole_column(calib::Sensor sensor) const {
    const auto& channels = file_->streams()[0].channels;
    for (std::size_t i = 0; i < channels.size(); ++i) {
      if (channels[i].name != calib::name_of(sensor)) continue;
      std::vector<double> values = db::values_of(file_->read(0, i).value(), channels[i].scale, channels[i].offset);
      for (double& value : values) value = conversion_to_si(channels[i].unit)(value);
      return values;
    }
    return {};
  }

  fs::path folder_;
  std::optional<db::RunFileReader> file_;
};

bool same_bits(const std::vector<double>& a, const std::vector<double>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](double x, double y) {
    return std::bit_cast<std::uint64_t>(x) == std::bit_cast<std::uint64_t>(y) || (std::isnan(x) && std::isnan(y));
  });
}

/// Sum in the order that stored statistics were made in since the first version: eight sums in turn.
template <class Term>
double sum_in_turn(const std::vector<double>& x, const Term& term) {
  std::array<double, 8> sums{};
  for (std::size_t i = 0; i < x.size(); ++i) sums[i % 8] += term(x[i]);
  return std::accumulate(sums.begin(), sums.end(), 0.0);
}

void expect_statistics(const calib::SensorStatistics& s, const std::vector<double>& x, double step) {
  ASSERT_EQ(s.count, x.size());
  if (x.size() < 2) return;
  const auto n = static_cast<double>(x.size());
  const double mean = x[0] + sum_in_turn(x, [&](double v) { return v - x[0]; }) / n;
  if (!std::isfinite(mean)) return;
  EXPECT_EQ(s.mean, mean);
  const double variance = sum_in_turn(x, [&](double v) { return (v - mean) * (v - mean); }) / (n - 1.0);
  EXPECT_EQ(s.variance, variance);
  const double rounding = calib::rounding_error(std::max(step, 0x1p-23 * std::abs(mean)), variance);
  EXPECT_EQ(s.standard_error, std::hypot(calib::signal::standard_error_of_mean(x).standard_error, rounding));
}

TEST_P(RunReductionTest, ReadsTheSamplesOfOneSensorAsThoseOfAll) {
  const auto recording = read_recording(*file_, "SN1").value();
  std::vector<double> samples(7, 1.0);
  for (const calib::Sensor sensor : calib::kSensors) {
    ASSERT_TRUE(read_sensor(*file_, "SN1", sensor, samples));
    EXPECT_TRUE(same_bits(samples, whole_column(sensor))) << calib::name_of(sensor);
    EXPECT_TRUE(same_bits(samples, recording.sensor[calib::index_of(sensor)])) << calib::name_of(sensor);
  }
  EXPECT_FALSE(read_sensor(*file_, "SN2", calib::Sensor::gyro_x, samples));
}

TEST_P(RunReductionTest, DescribesEachSegmentAsPlainArithmeticOnItsRowsDoes) {
  const auto axes = read_axes(*file_, "SN1").value();
  auto segmenter = calib::Segmenter::begin(axes).value();
  std::vector<double> samples;
  for (const calib::Sensor sensor : calib::kSensors) {
    ASSERT_TRUE(read_sensor(*file_, "SN1", sensor, samples));
    if (!samples.empty()) segmenter.describe(sensor, samples);
  }
  ASSERT_GT(segmenter.result().segments.size(), 3U);
  for (const calib::Sensor sensor : calib::kSensors) {
    const std::size_t s = calib::index_of(sensor);
    const std::vector<double> column = whole_column(sensor);
    if (column.empty()) continue;
    const double coarsest = calib::is_gyro(sensor) ? 5.0 / calib::printed_per_si(sensor) : 0.5;
    const double step = calib::output_step(column);
    const auto& temp_c = axes.sensor_temp_c[s].empty() ? axes.temp_c : axes.sensor_temp_c[s];
    for (const calib::Segment& segment : segmenter.result().segments) {
      std::vector<double> rows;
      for (std::size_t i = 0; i < axes.rows(); ++i) {
        const bool inside = axes.t_s[i] >= segment.t_start_s && axes.t_s[i] <= segment.t_end_s;
        if (inside && !std::isnan(column[i]) && !std::isnan(temp_c[i])) rows.push_back(column[i]);
      }
      const double plausible = step <= coarsest ? step : 0.0;
      const auto spikes = calib::find_spikes(rows, plausible);
      for (auto row = spikes.rbegin(); row != spikes.rend(); ++row) {
        rows.erase(rows.begin() + static_cast<std::ptrdiff_t>(*row));
      }
      expect_statistics(segment.sensor[s], rows, plausible);
    }
  }
}

TEST_P(RunReductionTest, FindsTheSameInWhateverOrderSensorsCome) {
  const auto recording = read_recording(*file_, "SN1").value();
  const auto segmentation = calib::segment(recording).value();
  const auto expected = calib::examine(recording, segmentation.segments, {});
  const auto axes = read_axes(*file_, "SN1").value();
  auto segmenter = calib::Segmenter::begin(axes).value();
  calib::Examination examination(axes, segmenter.result().segments, {});
  std::vector<double> samples;
  for (std::size_t i = calib::kSensorCount; i-- > 0;) {
    ASSERT_TRUE(read_sensor(*file_, "SN1", calib::kSensors[i], samples));
    if (samples.empty()) continue;
    segmenter.describe(calib::kSensors[i], samples);
    examination.add(calib::kSensors[i], samples);
  }
  EXPECT_EQ(examination.findings(), expected);
  EXPECT_EQ(segmenter.result().warnings, segmentation.warnings);
  ASSERT_EQ(segmenter.result().segments.size(), segmentation.segments.size());
  for (std::size_t i = 0; i < segmentation.segments.size(); ++i) {
    EXPECT_EQ(segmenter.result().segments[i].key, segmentation.segments[i].key);
    EXPECT_EQ(segmenter.result().segments[i].blocks.size(), segmentation.segments[i].blocks.size());
  }
}

INSTANTIATE_TEST_SUITE_P(Seeds, RunReductionTest, ::testing::Range<std::uint64_t>(0, kSeeds));

TEST(HoldSlowChannel, HoldsForTheMedianOfUnevenDistances) {
  // Distances 1, 4, 4, 1, 6 s: their median is 4 s, so that a value holds for 6 s.
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const std::vector<double> t_s = {0, 1, 2, 5, 8, 9, 10, 11, 16, 22.5};
  std::vector<double> values = {1, 2, nan, 3, nan, 4, 5, nan, 6, nan};
  hold_slow_channel(t_s, values);
  EXPECT_EQ(values[2], 2.0);
  EXPECT_EQ(values[4], 3.0);
  EXPECT_EQ(values[7], 5.0);
  EXPECT_TRUE(std::isnan(values[9]));  // 6.5 s later
}

}  // namespace
}  // namespace soak::station
