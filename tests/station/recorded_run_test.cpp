// SPDX-License-Identifier: Apache-2.0
// How a recorded run is described: read in parts or whole, and what lost packets leave behind.
#include <gtest/gtest.h>

#include <bit>

#include "calib/segments/segmentation.h"
#include "station/runs/long_run_rows.h"
#include "station/runs/run_records.h"
#include "tests/station/run_recorder_bench.h"

namespace soak::station {
namespace {

using namespace recorder_bench;
using RecordedRun = RunRecorderTest;

/// Every number of the sensors' statistics, as bits.
std::vector<std::uint64_t> numbers_of(const std::vector<calib::Segment>& segments) {
  std::vector<std::uint64_t> bits;
  const auto add = [&](double number) { bits.push_back(std::bit_cast<std::uint64_t>(number)); };
  const auto add_statistics = [&](const auto& sensors) {
    for (const calib::SensorStatistics& s : sensors) {
      add(static_cast<double>(s.count));
      add(s.mean);
      add(s.variance);
      add(s.standard_error);
    }
  };
  for (const calib::Segment& segment : segments) {
    for (const double number : {segment.t_start_s, segment.t_end_s, segment.temp_c, segment.temp_rate_kpmin})
      add(number);
    add_statistics(segment.sensor);
    for (const calib::Block& block : segment.blocks) {
      for (const double number : {block.t_s, block.duration_s, block.temp_c, block.temp_rate_kpmin}) add(number);
      add_statistics(block.sensor);
    }
  }
  return bits;
}

void expect_the_same_in_parts(const fs::path& path, const std::string& unit) {
  const auto file = db::RunFileReader::open(path);
  ASSERT_TRUE(file);
  ASSERT_NE(LongRunRows::open(*file, unit).value(), nullptr);
  const auto parts = describe_recorded_run(*file, unit, {}, true);
  const auto whole = describe_recorded_run(*file, unit, {}, false);
  ASSERT_TRUE(parts && whole);
  EXPECT_EQ(parts->row.rows, whole->row.rows);
  EXPECT_EQ(parts->row.duration_s, whole->row.duration_s);
  EXPECT_EQ(parts->warnings, whole->warnings);
  ASSERT_EQ(parts->segments.size(), whole->segments.size());
  for (std::size_t i = 0; i < parts->segments.size(); ++i) {
    EXPECT_EQ(parts->segments[i].key, whole->segments[i].key);
    EXPECT_EQ(parts->segments[i].sweep, whole->segments[i].sweep);
    EXPECT_EQ(parts->segments[i].findings, whole->segments[i].findings);
    EXPECT_EQ(parts->segments[i].position, whole->segments[i].position);
  }
  EXPECT_EQ(numbers_of(parts->segments), numbers_of(whole->segments));
}

TEST_F(RecordedRun, IsDescribedInPartsAsItIsAsAWhole) {
  RunRecorder recorder = begin(info());
  record_up_and_down(recorder);
  const auto runs = recorder.finish();
  ASSERT_TRUE(runs);
  for (const db::RunRow& run : *runs) expect_the_same_in_parts(catalog_->run_file_path(run), run.unit);
}

TEST_F(RecordedRun, OfMoreRowsThanAreReadAtOnceIsTheSameInParts) {
  RunRecorder recorder = begin(info(), {{"SN1", "mti-300"}});
  Unit unit(3);
  for (const double plateau_c : {20.0, 30.0, 40.0, 40.0}) {
    const auto temp_c = static_cast<float>(plateau_c);
    ASSERT_TRUE(recorder.add(0, unit.samples(500, temp_c - 5.0F), ramp(Sweep::up)));
    for (const char* position : {"+X", "-X", "+Y"}) {
      ASSERT_TRUE(recorder.add(0, unit.samples(3, temp_c), soak(plateau_c, "")));
      ASSERT_TRUE(recorder.add(0, unit.samples(6000, temp_c), soak(plateau_c, position)));
    }
  }
  const auto runs = recorder.finish();
  ASSERT_TRUE(runs);
  ASSERT_GT(runs->front().rows, 65536U);
  expect_the_same_in_parts(catalog_->run_file_path(runs->front()), "SN1");
}

TEST_F(RecordedRun, LostPacketsAreAnEventAndMarkTheirSegmentOnly) {
  RunRecorder recorder = begin(info(), {{"SN1", "mti-300"}});
  Unit unit(4);
  const auto add = [&](std::size_t count, const RowLabels& labels, const std::map<std::size_t, std::uint32_t>& lost) {
    auto samples = unit.samples(count, 20.0F);
    for (const auto& [row, packets] : lost) samples[row].lost = packets;
    ASSERT_TRUE(recorder.add(0, samples, labels));
  };
  add(20, ramp(Sweep::up), {{10, 7}});
  add(200, soak(20.0, "+X"), {});
  add(3, soak(20.0, ""), {{1, 5}});
  add(200, soak(20.0, "-X"), {{50, 1}, {120, 2}});
  add(3, soak(20.0, ""), {});
  add(200, soak(20.0, "+Y"), {});
  const auto runs = recorder.finish();
  ASSERT_TRUE(runs);
  const auto segments = catalog_->segments(runs->front().run_id, "SN1", false);
  ASSERT_EQ(segments->size(), 3U);
  for (const calib::Segment& segment : *segments) {
    const bool marked = std::ranges::any_of(segment.findings, [](const calib::Finding& finding) {
      return finding.code == "lost_packets" && finding.severity == calib::Severity::warn;
    });
    EXPECT_EQ(marked, segment.key.position == "-X") << segment.key.position;
  }
  const auto file = db::RunFileReader::open(catalog_->run_file_path(runs->front()));
  const auto events = file->events();
  EXPECT_EQ(std::ranges::count(*events, kLostPacketsEvent, &db::RunEvent::kind), 3);
}

}  // namespace
}  // namespace soak::station
