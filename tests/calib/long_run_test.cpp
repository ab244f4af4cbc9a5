// SPDX-License-Identifier: Apache-2.0
// A run that is read segment by segment gives what segment() and examine() give for the whole of it, to the last bit.
#include "calib/segments/long_run.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "base/random.h"
#include "calib/segments/data_gate.h"
#include "calib/segments/segmentation.h"
#include "tests/calib/same_segment.h"

namespace soak::calib {
namespace {

constexpr double kQuietNaN = std::numeric_limits<double>::quiet_NaN();

/// Rows of a recording in memory; counts how many were asked for at once.
class MemoryRows : public RunRows {
 public:
  explicit MemoryRows(const Recording& recording) : r_(recording) {}
  std::size_t rows() const override { return r_.rows(); }
  base::Result<Recording> axes(std::size_t first, std::size_t last) override {
    most = std::max(most, last - first);
    const auto cut = [&](const auto& v) {
      auto part = v;
      if (!v.empty())
        part.assign(v.begin() + static_cast<std::ptrdiff_t>(first), v.begin() + static_cast<std::ptrdiff_t>(last));
      return part;
    };
    Recording part;
    part.run_id = r_.run_id;
    part.unit = r_.unit;
    part.t_s = cut(r_.t_s);
    part.temp_c = cut(r_.temp_c);
    part.phase = cut(r_.phase);
    part.sweep = cut(r_.sweep);
    part.plateau_c = cut(r_.plateau_c);
    // Positions in the order in which they occur there.
    for (const std::int32_t number : cut(r_.position)) {
      part.position.push_back(-1);
      if (number < 0) continue;
      const Position& position = r_.positions[static_cast<std::size_t>(number)];
      const auto known = std::ranges::find(part.positions, position);
      part.position.back() = static_cast<std::int32_t>(known - part.positions.begin());
      if (known == part.positions.end()) part.positions.push_back(position);
    }
    for (const AuxiliaryChannel& channel : r_.auxiliary) part.auxiliary.push_back({channel.name, cut(channel.values)});
    return part;
  }
  bool has(Sensor sensor) const override { return !r_.sensor[index_of(sensor)].empty(); }
  base::Status samples(Sensor sensor, std::size_t first, std::size_t last, std::vector<double>& values) override {
    most = std::max(most, last - first);
    const auto& all = r_.sensor[index_of(sensor)];
    values.assign(all.begin() + static_cast<std::ptrdiff_t>(first), all.begin() + static_cast<std::ptrdiff_t>(last));
    return {};
  }

  std::size_t most = 0;

 private:
  const Recording& r_;
};

/// Makes a run stretch by stretch, at 20 Hz, with everything that the data gate looks for now and then.
class RunMaker {
 public:
  explicit RunMaker(std::uint64_t seed) : random_(seed) {
    run.run_id = "run";
    run.unit = "SN1";
    for (const std::string_view label : kSixPositionLabels) run.positions.push_back(*position_named(label));
    run.auxiliary.push_back({"visit", {}});
  }

  void stretch(double seconds, double to_c, std::optional<double> plateau_c, int position, Sweep sweep, double visit) {
    const auto rows = static_cast<std::size_t>(20.0 * seconds);
    const double from_c = temp_c_;
    const std::size_t begin = run.rows();
    for (std::size_t i = 0; i < rows; ++i) {
      temp_c_ = from_c + (to_c - from_c) * static_cast<double>(i + 1) / static_cast<double>(rows);
      row(plateau_c, position, sweep, visit);
    }
    spoil(begin, run.rows());
  }
  /// Nothing for a while.
  void gap(double seconds) { t_s_ += seconds; }

  Recording run;

 private:
  void row(std::optional<double> plateau_c, int position, Sweep sweep, double visit) {
    run.t_s.push_back(t_s_ += 0.05);
    run.temp_c.push_back(random_.uniform(0.0, 1.0) < 1e-4
                             ? kQuietNaN
                             : std::round(100.0 * (temp_c_ + 0.01 * random_.gaussian())) / 100.0);
    run.phase.push_back(plateau_c ? Phase::soak : Phase::ramp);
    run.sweep.push_back(sweep);
    run.plateau_c.push_back(plateau_c.value_or(kQuietNaN));
    run.position.push_back(position);
    run.auxiliary.front().values.push_back(visit);
    for (const Sensor sensor : kSensors) {
      const auto up = position < 0 ? Vector3{} : run.positions[static_cast<std::size_t>(position)].up;
      const double level = is_gyro(sensor) ? 1e-3 + 1e-5 * temp_c_ : 9.8 * up[axis_of(sensor)] + 1e-3 * temp_c_;
      const double noise = is_gyro(sensor) ? 1e-4 : 1e-3;
      run.sensor[index_of(sensor)].push_back(static_cast<float>(level + noise * random_.gaussian()));
    }
  }

  void spoil(std::size_t begin, std::size_t end) {
    if (end - begin < 400) return;
    auto& values = run.sensor[static_cast<std::size_t>(random_.uniform(0.0, 5.99))];
    const std::size_t at = begin + static_cast<std::size_t>(random_.uniform(10.0, 300.0));
    switch (static_cast<int>(random_.uniform(0.0, 6.0))) {
      case 0:
        values[at] = 1e6;
        break;
      case 1:
        std::fill_n(values.begin() + static_cast<std::ptrdiff_t>(at), 60, values[at]);
        break;
      case 2:
        std::fill_n(values.begin() + static_cast<std::ptrdiff_t>(at), 60, kQuietNaN);
        break;
      case 3:
        for (auto& other : run.sensor) other[at] += 0.1;
        break;
      default:
        break;
    }
  }

  base::Random random_;
  double t_s_ = 10.0;
  double temp_c_ = 20.0;
};

Recording made_run(std::uint64_t seed, double segment_s = 70.0) {
  RunMaker maker(seed);
  int visit = 0;
  for (const double plateau_c : {20.0, 40.0, 60.0, 40.0, 40.0, 20.0}) {
    const Sweep sweep = visit < 3 ? Sweep::up : Sweep::down;
    // The second 40 in a row: after an excursion to 50.
    if (visit == 4) maker.stretch(30.0, 50.0, {}, -1, sweep, kQuietNaN);
    maker.stretch(60.0, plateau_c, {}, -1, sweep, kQuietNaN);
    for (const int position : {0, 1, 4, 4}) {
      maker.stretch(2.0, plateau_c, plateau_c, -1, sweep, visit);
      maker.stretch(segment_s, plateau_c + 0.05, plateau_c, position, sweep, visit);
    }
    if (visit == 2) maker.gap(30.0);
    ++visit;
  }
  return std::move(maker.run);
}

class LongRun_ : public ::testing::TestWithParam<std::uint64_t> {};

TEST_P(LongRun_, GivesTheSameBitsAsTheWholeRunInMemory) {
  const Recording run = made_run(GetParam());
  const UnitType type;
  auto whole = segment(run);
  ASSERT_TRUE(whole);
  auto findings = examine(run, whole->segments, type);
  for (std::size_t i = 0; i < findings.size(); ++i) whole->segments[i].findings = std::move(findings[i]);
  MemoryRows rows(run);
  const auto parts = describe_long_run(rows, type, "");
  ASSERT_TRUE(parts && *parts);
  EXPECT_EQ((*parts)->segmentation.warnings, whole->warnings);
  EXPECT_EQ((*parts)->duration_s, run.t_s.back() - run.t_s.front());
  ASSERT_EQ((*parts)->segmentation.segments.size(), whole->segments.size());
  EXPECT_EQ(whole->segments.size(), 24U);
  for (std::size_t i = 0; i < whole->segments.size(); ++i) {
    SCOPED_TRACE(i);
    expect_same((*parts)->segmentation.segments[i], whole->segments[i]);
  }
}

INSTANTIATE_TEST_SUITE_P(Seeds, LongRun_, ::testing::Range<std::uint64_t>(0, 8));

TEST(LongRunMemory, HoldsOneSegmentOrOneBlockOfRowsHoweverLongTheRunIs) {
  const Recording run = made_run(1, 200.0);
  ASSERT_GT(run.rows(), 90'000U);
  MemoryRows rows(run);
  const auto parts = describe_long_run(rows, {}, "visit");
  ASSERT_TRUE(parts && *parts);
  EXPECT_LE(rows.most, 65536U);
}

TEST(LongRunMemory, LeavesRunsWithoutSetPointsOrPositionsToTheOtherWay) {
  Recording run = made_run(2);
  std::ranges::fill(run.plateau_c, kQuietNaN);
  MemoryRows without_set_points(run);
  EXPECT_FALSE(describe_long_run(without_set_points, {}, "")->has_value());
  run = made_run(2);
  std::ranges::fill(run.position, -1);
  MemoryRows moving(run);
  EXPECT_FALSE(describe_long_run(moving, {}, "")->has_value());
}

TEST(LongRunMemory, AnErrorOfTheRowsComesBack) {
  class FailingRows : public MemoryRows {
   public:
    using MemoryRows::MemoryRows;
    base::Status samples(Sensor, std::size_t, std::size_t, std::vector<double>&) override {
      return base::corrupt("a chunk is damaged", "run");
    }
  };
  const Recording run = made_run(3);
  FailingRows rows(run);
  const auto described = describe_long_run(rows, {}, "");
  ASSERT_FALSE(described);
  EXPECT_EQ(described.error().kind, base::ErrorKind::corrupt);
}

}  // namespace
}  // namespace soak::calib
