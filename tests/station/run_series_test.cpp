// SPDX-License-Identifier: Apache-2.0
// What a page draws of a run, against the numbers that were written.
#include "station/runs/run_series.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <nlohmann/json.hpp>

#include "tests/errors.h"
#include "tests/station/stored_runs.h"

namespace soak::station {
namespace {

using nlohmann::json;
using testing::kSlowEvery;
using testing::kStoredRows;

class RunSeries : public ::testing::Test {
 protected:
  /// The answer as a client reads it.
  json series(const std::string& channel, std::optional<double> from_s, std::optional<double> to_s,
              std::size_t points) {
    const auto made = series_json(file_, {0, {channel}, from_s, to_s, points});
    EXPECT_TRUE(made) << made.error().message;
    return made ? json::parse(made->dump()) : json();
  }

  db::testing::TempFolder folder_;
  db::Catalog catalog_ = db::Catalog::open(folder_.path()).value();
  testing::StoredNumbers numbers_;
  db::RunRow row_ = testing::stored_run(catalog_, numbers_);
  db::RunFileReader file_ = db::RunFileReader::open(catalog_.run_file_path(row_)).value();
};

TEST_F(RunSeries, AWindowWithNoMoreRowsThanPointsGivesTheSamplesBitForBit) {
  const json answer = series("gyro_x", 500.0, 507.5, 1000);
  ASSERT_EQ(answer["kind"], "samples");
  const std::size_t first = 50'000;
  ASSERT_EQ(answer["rows"], 751);
  ASSERT_EQ(answer["t_s"].size(), 751);
  ASSERT_EQ(answer["channels"][0]["values"].size(), 751);
  for (std::size_t i = 0; i < 751; ++i) {
    EXPECT_EQ(answer["t_s"][i].get<double>(), numbers_.t_s[first + i]);
    const auto value = answer["channels"][0]["values"][i].get<double>();
    EXPECT_EQ(std::bit_cast<std::uint64_t>(value), std::bit_cast<std::uint64_t>(double{numbers_.gyro_x[first + i]}));
  }
}

TEST_F(RunSeries, OneRowMoreThanPointsMakesBuckets) {
  EXPECT_EQ(series("gyro_x", 500.0, 507.5, 751)["kind"], "samples");
  EXPECT_EQ(series("gyro_x", 500.0, 507.5, 750)["kind"], "buckets");
}

TEST_F(RunSeries, ValuesAreInTheUnitOfTheChannel) {
  const json answer = series("accel_x", 0.0, 1.0, 200);
  EXPECT_EQ(answer["channels"][0]["unit"], "g");
  EXPECT_EQ(answer["channels"][0]["values"][7].get<double>(), 0.001 * numbers_.accel_x[7]);
}

TEST_F(RunSeries, RowsWithoutAValueOfASlowChannelAreNull) {
  const json values = series("temp_c", 0.0, 9.995, 1000)["channels"][0]["values"];
  ASSERT_EQ(values.size(), 1000);
  for (std::size_t i = 0; i < values.size(); ++i) EXPECT_EQ(values[i].is_null(), i % kSlowEvery != 0) << i;
}

/// Checks that the buckets follow each other over rows first ... end - 1, each with the numbers of its rows.
void expect_buckets(const json& channel, const testing::StoredNumbers& numbers, std::size_t first, std::size_t end) {
  std::size_t next = first;
  for (std::size_t i = 0; i < channel["count"].size(); ++i) {
    const auto count = channel["count"][i].get<std::size_t>();
    ASSERT_LE(next + count, end);
    const auto begin = numbers.gyro_x.begin() + static_cast<std::ptrdiff_t>(next);
    const auto [low, high] = std::minmax_element(begin, begin + static_cast<std::ptrdiff_t>(count));
    double sum = 0.0;
    for (std::size_t row = next; row < next + count; ++row) sum += double{numbers.gyro_x[row]};
    EXPECT_EQ(channel["t_first_s"][i], numbers.t_s[next]);
    EXPECT_EQ(channel["t_last_s"][i], numbers.t_s[next + count - 1]);
    EXPECT_EQ(channel["minimum"][i].get<double>(), double{*low});
    EXPECT_EQ(channel["maximum"][i].get<double>(), double{*high});
    // n additions of numbers up to 5: under n · 5 · 2^-53 for a hundred thousand of them.
    EXPECT_NEAR(channel["mean"][i].get<double>(), sum / static_cast<double>(count), 1e-10);
    next += count;
  }
  EXPECT_EQ(next, end);
}

TEST_F(RunSeries, BucketsOfTheWholeRunHoldEveryRowOnce) {
  for (const std::size_t points : {1UL, 7UL, 50UL, 195UL, 200UL, 1000UL, 2000UL}) {
    const json answer = series("gyro_x", std::nullopt, std::nullopt, points);
    ASSERT_EQ(answer["kind"], "buckets");
    EXPECT_EQ(answer["rows"], kStoredRows);
    EXPECT_EQ(answer["from_s"], 0.0);
    EXPECT_EQ(answer["to_s"], numbers_.t_s.back());
    EXPECT_LE(answer["channels"][0]["count"].size(), points + 2);
    expect_buckets(answer["channels"][0], numbers_, 0, kStoredRows);
  }
}

TEST_F(RunSeries, BucketsOfSamplesKeepToTheWindow) {
  const json answer = series("gyro_x", 123.455, 323.455, 400);  // rows 12346 to 32345
  ASSERT_EQ(answer["kind"], "buckets");
  EXPECT_EQ(answer["rows"], 20'000);
  expect_buckets(answer["channels"][0], numbers_, 12'346, 32'346);
}

TEST_F(RunSeries, AWindowBesideTheRunIsEmpty) {
  for (const auto& [from_s, to_s] : {std::pair(-20.0, -1.0), std::pair(5000.0, 6000.0), std::pair(1.001, 1.009)}) {
    const json answer = series("gyro_x", from_s, to_s, 100);
    EXPECT_EQ(answer["rows"], 0);
    EXPECT_EQ(answer["kind"], "samples");
    EXPECT_TRUE(answer["t_s"].empty());
  }
}

TEST_F(RunSeries, RowsBetweenTimesAreThoseOfALinearSearch) {
  for (const double from_s : {-1.0, 0.0, 0.005, 5.11, 5.12, 5.121, 163.84, 999.98, 999.99, 1e9}) {
    for (const double length_s : {0.0, 0.004, 0.01, 5.12, 10.24, 700.0, 1e9}) {
      const double to_s = from_s + length_s;
      const auto inside = std::ranges::count_if(numbers_.t_s, [&](double t) { return from_s <= t && t <= to_s; });
      const auto before = std::ranges::count_if(numbers_.t_s, [&](double t) { return t < from_s; });
      const auto rows = file_.rows_between(0, from_s, to_s);
      ASSERT_TRUE(rows);
      EXPECT_EQ(rows->count, static_cast<std::uint64_t>(inside)) << from_s << " " << to_s;
      if (inside > 0) {
        EXPECT_EQ(rows->first, static_cast<std::uint64_t>(before));
      }
    }
  }
}

TEST_F(RunSeries, AnAnswerIsBoundedHoweverLongTheRunIs) {
  const std::vector<std::string> channels(12, "gyro_x");
  for (const std::optional<double> to_s : {std::optional<double>(), std::optional(600.0), std::optional(20.0)}) {
    const auto answer = series_json(file_, {0, channels, 0.0, to_s, 2000});
    ASSERT_TRUE(answer);
    EXPECT_LT(answer->dump().size(), 4U << 20) << to_s.value_or(-1.0);
  }
}

TEST_F(RunSeries, WhatTheRunDoesNotHaveIsRefusedWithWhatItHas) {
  const auto channel = series_json(file_, {0, {"gyro_x", "nosuch"}, {}, {}, 10});
  ASSERT_TRUE(base::is_bad_input(channel, {"nosuch", "gyro_x", "accel_x", "temp_c"}));
  EXPECT_EQ(channel.error().where, "channel");
  const auto stream = stream_named(file_, "positions", "SN1");
  ASSERT_TRUE(base::is_bad_input(stream, {"imu", "chamber"}));
  EXPECT_EQ(stream.error().where, "stream");
  EXPECT_TRUE(base::is_bad_input(stream_named(file_, "imu", "SN2")));
  const auto span = series_json(file_, {0, {"gyro_x"}, 5.0, 4.0, 10});
  ASSERT_TRUE(base::is_bad_input(span));
  EXPECT_EQ(span.error().where, "to_s");
}

TEST_F(RunSeries, StreamsAreThoseOfTheUnitAndOfTheChamber) {
  const json streams = streams_json(file_, "SN1").value();
  ASSERT_EQ(streams.size(), 2);
  EXPECT_EQ(streams[0]["name"], "imu");
  EXPECT_EQ(streams[0]["rows"], kStoredRows);
  EXPECT_EQ(streams[0]["last_s"], numbers_.t_s.back());
  EXPECT_EQ(streams[0]["channels"][1]["values"], kStoredRows);
  EXPECT_NEAR(streams[0]["channels"][1]["rate_hz"].get<double>(), 100.0, 1e-6);
  EXPECT_EQ(streams[0]["channels"][3]["values"], kStoredRows / kSlowEvery);
  EXPECT_NEAR(streams[0]["channels"][3]["rate_hz"].get<double>(), 2.0, 0.01);
  EXPECT_EQ(streams[1]["name"], "chamber");
}

TEST_F(RunSeries, TheChamberIsNotShownBesideAUnitWhoseClockIsAnother) {
  EXPECT_EQ(streams_json(file_, "SN2").value(), json::array());
  EXPECT_TRUE(base::is_bad_input(stream_named(file_, "chamber", "SN2")));
}

}  // namespace
}  // namespace soak::station
