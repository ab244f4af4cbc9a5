// SPDX-License-Identifier: Apache-2.0
// A run from its recorder to the catalog: samples, purposes, refusals.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <map>

#include "db/catalog/catalog.h"
#include "station/fit/fit_unit.h"
#include "station/io/host.h"
#include "station/lab/run_recorder.h"
#include "station/runs/csv_export.h"
#include "station/runs/run_streams.h"
#include "tests/station/run_recorder_bench.h"

namespace soak::station {
namespace {

using namespace recorder_bench;

constexpr double kQuietNan = std::numeric_limits<double>::quiet_NaN();

TEST_F(RunRecorderTest, KeepsTheAzimuthsOfThePositionsThatOccur) {
  const auto at = [](std::string_view label, double azimuth_deg) {
    calib::Position position = *calib::position_named(label);
    position.azimuth_deg = azimuth_deg;
    return position;
  };
  RecordedUnit turned{"SN1", "mti-300"};
  turned.positions = {at("+X", 10.0), at("-X", 20.0), at("-Z", 30.0)};
  RunRecorder recorder = begin(info(), {turned, {"SN2", "mti-300"}});
  Unit units[] = {Unit(1), Unit(2)};
  for (const char* label : {"-Z", "", "+X", "", "-Z"}) {
    for (std::size_t unit = 0; unit < 2; ++unit) {
      ASSERT_TRUE(recorder.add(unit, units[unit].samples(30, 25.0F), soak(25.0, label)));
    }
  }
  const auto runs = recorder.finish();
  ASSERT_TRUE(runs) << runs.error().message;
  for (const db::RunRow& run : *runs) {
    const auto segments = catalog_->segments(run.run_id, run.unit, false);
    ASSERT_TRUE(segments);
    ASSERT_EQ(segments->size(), 3U);
    const bool known = run.unit == "SN1";
    EXPECT_EQ((*segments)[0].position->azimuth_deg, known ? std::optional(30.0) : std::nullopt);
    EXPECT_EQ((*segments)[1].position->azimuth_deg, known ? std::optional(10.0) : std::nullopt);
    EXPECT_EQ((*segments)[1].position->label, "+X");
    const auto file = db::RunFileReader::open(catalog_->run_file_path(run));
    ASSERT_TRUE(file);
    EXPECT_EQ(read_positions(*file, run.unit)->size(), known ? 2U : 0U);
    const auto native = native_csv(*file, run.unit);
    ASSERT_TRUE(native) << native.error().message;
    EXPECT_EQ(native->columns_map->find("\"-Z\" = 30.0") != std::string::npos, known);
  }
}

TEST_F(RunRecorderTest, GivesBackEveryNumberThatWentIn) {
  RunRecorder recorder = begin(info());
  std::vector<hal::ImuSample> sent;
  std::vector<RowLabels> labels;
  Unit unit(1);
  const auto add = [&](std::size_t count, const RowLabels& label) {
    const auto samples = unit.samples(count, 25.0F);
    const auto added = recorder.add(1, samples, label);
    ASSERT_TRUE(added) << added.error().message;
    sent.insert(sent.end(), samples.begin(), samples.end());
    labels.insert(labels.end(), count, label);
  };
  add(40, ramp(Sweep::unknown));
  hal::ChamberReading reading;
  reading.air_c = 25.1;
  ASSERT_TRUE(recorder.add_chamber(4.0, reading));
  add(30, soak(25.0, "+X"));
  ASSERT_TRUE(recorder.flush());
  add(1, soak(25.0, ""));
  reading.air_c = 25.2;
  ASSERT_TRUE(recorder.add_chamber(7.1, reading));
  reading.air_c = 25.3;
  ASSERT_TRUE(recorder.add_chamber(7.2, reading));
  add(30, soak(25.0, "-Z", Sweep::down));
  EXPECT_EQ(recorder.rows(0), 0U);
  EXPECT_EQ(recorder.rows(1), sent.size());
  const auto runs = recorder.finish();
  ASSERT_TRUE(runs) << runs.error().message;

  ASSERT_EQ(runs->size(), 1U);
  const calib::Recording r = recording_of(runs->front());
  ASSERT_EQ(r.rows(), sent.size());
  std::map<std::string, std::vector<double>> auxiliary;
  for (const auto& channel : r.auxiliary) auxiliary[channel.name] = channel.values;
  double temp_c = kQuietNan;
  for (std::size_t i = 0; i < sent.size(); ++i) {
    EXPECT_EQ(r.t_s[i], sent[i].t_s);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      EXPECT_EQ(r.sensor[axis][i], static_cast<double>(sent[i].rate_rps[axis]));
      EXPECT_EQ(r.sensor[3 + axis][i], static_cast<double>(sent[i].accel_mps2[axis]));
    }
    if (sent[i].temp_c) temp_c = static_cast<double>(*sent[i].temp_c);
    if (i > 0) {
      EXPECT_EQ(r.temp_c[i], temp_c);
    }
    EXPECT_EQ(auxiliary["packet"][i], sent[i].packet);
    EXPECT_EQ(auxiliary["status"][i], sent[i].status);
    EXPECT_EQ(r.phase[i], labels[i].phase);
    EXPECT_EQ(r.sweep[i], labels[i].sweep);
    if (labels[i].plateau_c) {
      EXPECT_EQ(r.plateau_c[i], *labels[i].plateau_c);
    }
    if (labels[i].position.empty()) {
      EXPECT_EQ(r.position[i], -1);
    } else {
      EXPECT_EQ(r.positions[static_cast<std::size_t>(r.position[i])], *calib::position_named(labels[i].position));
    }
  }
  EXPECT_TRUE(std::isnan(r.temp_c[0]));
  EXPECT_TRUE(std::isnan(r.plateau_c[0]));
  EXPECT_TRUE(std::isnan(auxiliary["chamber_c"][39]));
  EXPECT_EQ(auxiliary["chamber_c"][40], 25.1);
  EXPECT_EQ(auxiliary["chamber_c"][71], 25.3);
}

TEST_F(RunRecorderTest, KeepsVoltsAndAmpsInTheNextRowOfTheUnitThatTheyFeed) {
  RunRecorder recorder = begin(info(), {{"SN1", "mti-300", {}, {}, true}, {"SN2", "mti-300"}});
  std::vector<Unit> units = {Unit(1), Unit(2)};
  const auto add = [&](std::size_t count) {
    for (std::size_t u = 0; u < units.size(); ++u) {
      ASSERT_TRUE(recorder.add(u, units[u].samples(count, 20.0F), soak(20.0, "+X")));
    }
  };
  add(20);
  recorder.add_supply(0, {.on = true, .voltage_v = 12.01, .current_a = 0.24});
  add(10);
  recorder.add_supply(0, {.on = true, .voltage_v = 11.98});
  add(10);
  const auto runs = recorder.finish();
  ASSERT_TRUE(runs) << runs.error().message;
  const auto channel_of = [](const calib::Recording& recording, std::string_view name) {
    for (const auto& channel : recording.auxiliary) {
      if (channel.name == name) return channel.values;
    }
    return std::vector<double>();
  };
  const calib::Recording measured = recording_of((*runs)[0]);
  const auto volts = channel_of(measured, "supply_v");
  ASSERT_EQ(volts.size(), 40U);
  EXPECT_TRUE(std::isnan(volts[19]));
  EXPECT_EQ(volts[20], 12.01);
  EXPECT_EQ(volts[29], 12.01) << "held until the next reading";
  EXPECT_EQ(volts[30], 11.98);
  EXPECT_EQ(channel_of(measured, "supply_a")[20], 0.24);
  EXPECT_TRUE(channel_of(recording_of((*runs)[1]), "supply_v").empty());
}

TEST_F(RunRecorderTest, KeepsTheChambersLogAndEvents) {
  RunRecorder recorder = begin(info());
  Unit unit(1);
  ASSERT_TRUE(recorder.add(0, unit.samples(20, 20.0F), soak(20.0, "+X")));
  hal::ChamberReading reading;
  reading.air_c = 21.5;
  reading.set_point_c = 22.0;
  reading.output_percent = -40.0;
  reading.air_rh_percent = 7.5;
  ASSERT_TRUE(recorder.add_chamber(1.0, reading));
  reading.working_set_point_c = 21.9;
  ASSERT_TRUE(recorder.add_chamber(0.5, reading)) << "another unit's clock is a little behind";
  ASSERT_TRUE(recorder.add_event(1.5, "door", "opened"));
  const auto runs = recorder.finish();
  ASSERT_TRUE(runs) << runs.error().message;
  const auto file = db::RunFileReader::open(catalog_->run_file_path(runs->front()));
  const auto stream = find_stream(*file, "chamber", "");
  ASSERT_TRUE(stream);
  const auto values = [&](std::string_view name) {
    const auto channel = find_channel(file->streams()[*stream].channels, name);
    return db::values_of(file->read(*stream, *channel).value(), 1.0, 0.0);
  };
  EXPECT_EQ(values("t_s"), (std::vector<double>{1.0, 1.0}));
  EXPECT_EQ(values("chamber_c"), (std::vector<double>{21.5, 21.5}));
  EXPECT_EQ(values("set_point_c"), (std::vector<double>{22.0, 22.0}));
  EXPECT_TRUE(std::isnan(values("working_set_point_c")[0]));
  EXPECT_EQ(values("working_set_point_c")[1], 21.9);
  EXPECT_EQ(values("output_percent")[0], -40.0);
  EXPECT_EQ(values("chamber_rh")[0], 7.5);
  const auto events = file->events();
  ASSERT_EQ(events->size(), 4U);
  EXPECT_EQ((*events)[0].kind, "epochs");
  EXPECT_EQ((*events)[1].text, "opened");
  EXPECT_EQ((*events)[2].kind, "no_samples");
  EXPECT_NE((*events)[2].text.find("SN2"), std::string::npos);
  EXPECT_EQ((*events)[3].kind, "ended");
  EXPECT_TRUE(file->verify());
}

TEST_F(RunRecorderTest, ARunKeepsTheEpochInWhichItBeganThoughTheUnitIsRepairedMeanwhile) {
  RunRecorder recorder = begin(info());
  record_up_and_down(recorder);
  ASSERT_TRUE(catalog_->begin_epoch("SN1", "gyro replaced", "ann"));
  const auto runs = recorder.finish();
  ASSERT_TRUE(runs) << runs.error().message;
  for (const db::RunRow& run : *runs) EXPECT_EQ(run.epoch, 0) << run.unit;
  EXPECT_EQ((*catalog_->unit("SN1"))->epoch, 1);
  RunRecorder next = begin(info("R02"));
  record_up_and_down(next);
  const auto after = next.finish();
  ASSERT_TRUE(after) << after.error().message;
  for (const db::RunRow& run : *after) EXPECT_EQ(run.epoch, run.unit == "SN1" ? 1 : 0) << run.unit;
}

TEST_F(RunRecorderTest, EntersARunThatAFitFinds) {
  const db::RunInfo stated = info();
  RunRecorder recorder = begin(stated);
  record_up_and_down(recorder);
  const auto entered = recorder.finish();
  ASSERT_TRUE(entered) << entered.error().message;
  const auto runs = catalog_->runs({});
  ASSERT_EQ(runs->size(), 2U);
  for (std::size_t i = 0; i < 2; ++i) {
    const db::RunRow& run = (*runs)[i];
    EXPECT_EQ(run.run_id, stated.run_id);
    EXPECT_EQ(run.unit, i == 0 ? "SN1" : "SN2");
    EXPECT_EQ(run.campaign, "c1");
    EXPECT_EQ(run.label, "R01");
    EXPECT_EQ(run.procedure, "soak");
    EXPECT_EQ(run.purpose, "calibration");
    EXPECT_EQ(run.created_utc_s, 1700000000.5);
    EXPECT_FALSE(run.simulated);
    EXPECT_TRUE(run.sealed);
    EXPECT_EQ(run.file_name, stated.run_id + ".soakrun");
    EXPECT_EQ(run.site, stated.site);
    EXPECT_EQ(run.rows, 1126U);
    EXPECT_NEAR(run.duration_s, 112.5, 1e-9);
    EXPECT_EQ((*entered)[i].file_sha256, run.file_sha256);
    const auto file = db::RunFileReader::open(catalog_->run_file_path(run));
    EXPECT_TRUE(file->sealed());
    EXPECT_EQ(*file->content_hash(), run.content_sha256);
    EXPECT_TRUE(file->verify());
    std::vector<calib::Warning> warnings;
    EXPECT_EQ(load_unit(*catalog_, run.unit, {}, warnings)->runs.size(), 1U);
    EXPECT_TRUE(warnings.empty());
  }
  EXPECT_EQ((*catalog_->unit("SN1"))->type, "mti-300");
  EXPECT_TRUE(orphan_run_files(*catalog_)->empty());
}

TEST_F(RunRecorderTest, ExportsItsSamplesBitForBit) {
  RunRecorder recorder = begin(info());
  record_up_and_down(recorder);
  const auto runs = recorder.finish();
  const auto file = db::RunFileReader::open(catalog_->run_file_path(runs->front()));
  // native_csv() imports what it has written and compares all numbers.
  const auto native = native_csv(*file, "SN1");
  EXPECT_TRUE(native) << native.error().message;
}

TEST_F(RunRecorderTest, CountsAnotherClockRateAsSimulated) {
  db::RunInfo fast = info();
  fast.clock_rate = 20.0;
  RunRecorder recorder = begin(fast, {{"SN1", "mti-300"}});
  Unit unit(1);
  ASSERT_TRUE(recorder.add(0, unit.samples(100, 20.0F), soak(20.0, "+X")));
  const auto runs = recorder.finish();
  ASSERT_TRUE(runs) << runs.error().message;
  EXPECT_TRUE(runs->front().simulated);
  EXPECT_TRUE(db::RunFileReader::open(catalog_->run_file_path(runs->front()))->info().simulated);
}

TEST_F(RunRecorderTest, KeepsThePurposeAndOffersRunsForCalibrationOnlyToAFit) {
  for (const char* purpose : {"verification", "diagnosis"}) {
    const db::RunInfo stated = info(purpose);
    auto recorder = RunRecorder::begin(*catalog_, stated, purpose, {{"SN1", "mti-300"}});
    ASSERT_TRUE(recorder);
    Unit unit(1);
    ASSERT_TRUE(recorder->add(0, unit.samples(100, 20.0F), soak(20.0, "+X")));
    const auto runs = recorder->finish();
    ASSERT_TRUE(runs) << runs.error().message;
    EXPECT_EQ(runs->front().purpose, purpose);
    EXPECT_EQ(db::RunFileReader::open(catalog_->run_file_path(runs->front()))->info().purpose, purpose);
    std::vector<calib::Warning> warnings;
    const auto unfit = load_unit(*catalog_, "SN1", {}, warnings);
    ASSERT_FALSE(unfit);
    EXPECT_NE(unfit.error().message.find(std::string("1 ") + purpose + " runs"), std::string::npos)
        << unfit.error().message;
  }
}

TEST_F(RunRecorderTest, RefusesWhatCouldNotBeEnteredLater) {
  Unit unit(1);
  RunRecorder recorder = begin(info());
  ASSERT_TRUE(recorder.add(0, unit.samples(100, 20.0F), soak(20.0, "+X")));
  ASSERT_TRUE(recorder.finish());
  const auto refused = [&](const db::RunInfo& info, std::string purpose, std::vector<RecordedUnit> units) {
    const auto begun = RunRecorder::begin(*catalog_, info, std::move(purpose), std::move(units));
    return !begun && begun.error().kind == base::ErrorKind::bad_input;
  };
  EXPECT_TRUE(refused(info("R01"), "calibration", {{"SN1", "mti-300"}})) << "the label is taken";
  EXPECT_TRUE(refused(info("R02"), "holiday", {{"SN1", "mti-300"}}));
  EXPECT_TRUE(refused(info("R02"), "calibration", {}));
  EXPECT_TRUE(refused(info("R02"), "calibration", {{"SN1", "mti-300"}, {"SN1", "mti-300"}}));
  EXPECT_TRUE(orphan_run_files(*catalog_)->empty());
}

TEST_F(RunRecorderTest, TakesAllRowsOfACallOrNone) {
  Unit unit(1);
  RunRecorder recorder = begin(info(), {{"SN1", "mti-300"}});
  auto samples = unit.samples(10, 20.0F);
  EXPECT_FALSE(recorder.add(0, samples, soak(20.0, "tilted")));
  EXPECT_FALSE(recorder.add(1, samples, soak(20.0, "+X")));
  std::swap(samples[8], samples[9]);
  EXPECT_FALSE(recorder.add(0, samples, soak(20.0, "+X"))) << "time falls";
  std::swap(samples[8], samples[9]);
  EXPECT_EQ(recorder.rows(0), 0U);
  EXPECT_TRUE(recorder.add(0, samples, soak(20.0, "+X")));
  EXPECT_FALSE(recorder.add(0, samples, soak(20.0, "+X"))) << "the unit has restarted";
  EXPECT_EQ(recorder.rows(0), 10U);
  EXPECT_EQ(recorder.finish()->front().rows, 10U);
}

TEST_F(RunRecorderTest, EntersNoRunIfOneIsRefused) {
  RunRecorder recorder = begin(info());
  record_up_and_down(recorder);
  // Meanwhile somebody else imports a run of the second unit with this label.
  ASSERT_TRUE(catalog_->ensure_campaign("c1", "soak"));
  db::RunRow other;
  other.run_id = new_run_id();
  other.file_name = other.run_id + ".soakrun";
  other.unit = "SN2";
  other.campaign = "c1";
  other.label = "R01";
  ASSERT_TRUE(catalog_->add_run(other, {}));
  EXPECT_FALSE(recorder.finish());
  EXPECT_EQ(catalog_->runs({})->size(), 1U);
}

}  // namespace
}  // namespace soak::station
