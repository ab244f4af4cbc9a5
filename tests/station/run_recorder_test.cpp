// SPDX-License-Identifier: Apache-2.0
#include "station/lab/run_recorder.h"

#include <gtest/gtest.h>
#include <stdlib.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <filesystem>
#include <limits>
#include <map>

#include "base/random.h"
#include "db/orphans.h"
#include "station/csv_export.h"
#include "station/fit_unit.h"
#include "station/identity.h"
#include "station/lab/event_log.h"
#include "station/lab/lost_runs.h"
#include "station/lab/run_source.h"
#include "station/recording_reader.h"
#include "station/run_streams.h"

namespace soak::station {
namespace {

namespace fs = std::filesystem;
using calib::Phase;
using calib::Sweep;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

/// Makes samples at 10 Hz whose every number differs from every other, with a new temperature in every other one.
class Unit {
 public:
  explicit Unit(std::uint64_t seed) : random_(seed) {}

  std::vector<hal::ImuSample> samples(std::size_t count, float temp_c) {
    std::vector<hal::ImuSample> result;
    for (std::size_t i = 0; i < count; ++i) {
      hal::ImuSample sample;
      sample.t_s = 0.1 * static_cast<double>(++row_);
      sample.packet = 0xFFFFFFF0U + row_;  // wraps
      for (float& rate : sample.rate_rps) rate = static_cast<float>(random_.gaussian() * 1e-3);
      for (float& accel : sample.accel_mps2) accel = static_cast<float>(9.8 + random_.gaussian() * 1e-2);
      if (row_ % 2 == 0) sample.temp_c = temp_c + static_cast<float>(random_.gaussian() * 1e-3);
      sample.status = row_ * 3;
      result.push_back(sample);
    }
    return result;
  }

 private:
  base::Random random_;
  std::uint32_t row_ = 0;
};

class RunRecorderTest : public ::testing::Test {
 protected:
  void SetUp() override {
    std::string name = (fs::temp_directory_path() / "soak-recorder-XXXXXX").string();
    ASSERT_NE(::mkdtemp(name.data()), nullptr);
    folder_ = name;
    auto catalog = db::Catalog::open(folder_);
    ASSERT_TRUE(catalog);
    catalog_ = std::make_unique<db::Catalog>(*std::move(catalog));
  }
  void TearDown() override { fs::remove_all(folder_); }

  static db::RunInfo info(std::string label = "R01") {
    db::RunInfo info;
    info.run_id = new_run_id();
    info.label = std::move(label);
    info.campaign = "c1";
    info.procedure = "soak";
    info.created_utc_s = 1700000000.5;
    info.source = "imu at tcp://127.0.0.1:5000";
    info.site.latitude_deg = 48.0;
    return info;
  }

  RunRecorder begin(const db::RunInfo& info, std::vector<RecordedUnit> units = {{"SN1", "mti"}, {"SN2", "mti"}}) {
    auto recorder = RunRecorder::begin(*catalog_, info, "calibration", std::move(units));
    if (!recorder) throw std::runtime_error(recorder.error().message);
    return *std::move(recorder);
  }

  calib::Recording recording_of(const db::RunRow& run) const {
    const auto file = db::RunFileReader::open(catalog_->run_file_path(run));
    return read_recording(*file, run.unit).value();
  }

  fs::path folder_;
  std::unique_ptr<db::Catalog> catalog_;
};

RowLabels soak(double plateau_c, std::string position, Sweep sweep = Sweep::up) {
  return {Phase::soak, sweep, plateau_c, std::move(position)};
}

RowLabels ramp(Sweep sweep) { return {Phase::ramp, sweep, {}, ""}; }

/// Position, visit and attempt of segments, in the order of time.
std::vector<std::string> names_of(const std::vector<calib::Segment>& segments) {
  std::vector<std::string> names;
  for (const calib::Segment& segment : segments) {
    names.push_back(std::to_string(segment.key.visit) + segment.key.position + std::to_string(segment.key.attempt));
  }
  return names;
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
  const auto runs = recorder.finish({});
  ASSERT_TRUE(runs) << runs.error().message;

  ASSERT_EQ(runs->size(), 1U);
  const calib::Recording r = recording_of(runs->front());
  ASSERT_EQ(r.rows(), sent.size());
  std::map<std::string, std::vector<double>> auxiliary;
  for (const auto& channel : r.auxiliary) auxiliary[channel.name] = channel.values;
  double temp_c = kNan;
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

TEST_F(RunRecorderTest, KeepsTheChambersLogAndEvents) {
  RunRecorder recorder = begin(info());
  Unit unit(1);
  ASSERT_TRUE(recorder.add(0, unit.samples(20, 20.0F), soak(20.0, "+X")));
  hal::ChamberReading reading;
  reading.air_c = 21.5;
  reading.set_point_c = 22.0;
  reading.output_percent = -40.0;
  ASSERT_TRUE(recorder.add_chamber(1.0, reading));
  reading.working_set_point_c = 21.9;
  ASSERT_TRUE(recorder.add_chamber(0.5, reading)) << "another unit's clock is a little behind";
  ASSERT_TRUE(recorder.add_event(1.5, "door", "opened"));
  const auto runs = recorder.finish({});
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
  const auto events = file->events();
  ASSERT_EQ(events->size(), 2U);
  EXPECT_EQ((*events)[0].text, "opened");
  EXPECT_EQ((*events)[1].kind, "no_samples");
  EXPECT_NE((*events)[1].text.find("SN2"), std::string::npos);
  EXPECT_TRUE(file->verify());
}

/// Records both units through 65, 70 and 65 °C again, with +X twice at 70 °C.
void record_up_and_down(RunRecorder& recorder) {
  std::vector<Unit> units = {Unit(1), Unit(2)};
  const auto add = [&](std::size_t count, float temp_c, const RowLabels& labels) {
    for (std::size_t u = 0; u < units.size(); ++u) {
      // In small pieces, as they come.
      for (std::size_t done = 0; done < count; done += 50) {
        const auto added = recorder.add(u, units[u].samples(std::min<std::size_t>(50, count - done), temp_c), labels);
        ASSERT_TRUE(added) << added.error().message;
      }
    }
  };
  // A row before the thermometer's first value would not count.
  add(20, 60.0F, ramp(Sweep::up));
  add(100, 65.0F, soak(65.0, "+X"));
  add(3, 65.0F, soak(65.0, ""));
  add(100, 65.0F, soak(65.0, "-X"));
  add(200, 67.5F, ramp(Sweep::up));
  add(100, 70.0F, soak(70.0, "+X"));
  add(1, 70.0F, soak(70.0, ""));
  add(100, 70.0F, soak(70.0, "+X"));
  add(1, 70.0F, soak(70.0, ""));
  add(100, 70.0F, soak(70.0, "-X"));
  add(200, 67.5F, ramp(Sweep::down));
  add(100, 65.0F, soak(65.0, "-X", Sweep::down));
  add(1, 65.0F, soak(65.0, "", Sweep::down));
  add(100, 65.0F, soak(65.0, "+X", Sweep::down));
}

TEST_F(RunRecorderTest, NumbersVisitsAndAttemptsAsThePlanDoes) {
  RunRecorder recorder = begin(info());
  record_up_and_down(recorder);
  const auto runs = recorder.finish({});
  ASSERT_TRUE(runs) << runs.error().message;
  ASSERT_EQ(runs->size(), 2U);
  for (const db::RunRow& run : *runs) {
    const auto segments = catalog_->segments(run.run_id, run.unit, true);
    EXPECT_EQ(names_of(*segments), (std::vector<std::string>{"0+X0", "0-X0", "1+X0", "1+X1", "1-X0", "2-X0", "2+X0"}));
    EXPECT_EQ((*segments)[1].plateau_c, 65.0);
    EXPECT_EQ((*segments)[1].sweep, Sweep::up);
    EXPECT_EQ((*segments)[3].plateau_c, 70.0);
    EXPECT_EQ((*segments)[5].plateau_c, 65.0);
    EXPECT_EQ((*segments)[5].sweep, Sweep::down);
    for (const auto& segment : *segments) {
      EXPECT_EQ(segment.sensor[0].count, 100U);
      EXPECT_NEAR(segment.t_end_s - segment.t_start_s, 9.9, 1e-9);
    }
  }
}

TEST_F(RunRecorderTest, WithdrawsRejectedSegmentsOfTheirUnitOnly) {
  RunRecorder recorder = begin(info());
  record_up_and_down(recorder);
  const auto runs = recorder.finish({{"SN1", 1, "+X", 0, "temperature moved 0.2 K"},
                                     {"SN1", 2, "-X", 0, "unit was silent"},
                                     {"SN2", 7, "+X", 0, "never recorded"}});
  ASSERT_TRUE(runs) << runs.error().message;
  const std::string& run_id = runs->front().run_id;
  EXPECT_EQ(names_of(*catalog_->segments(run_id, "SN1", false)),
            (std::vector<std::string>{"0+X0", "0-X0", "1+X1", "1-X0", "2+X0"}));
  EXPECT_EQ(catalog_->segments(run_id, "SN2", false)->size(), 7U);
  const auto voids = catalog_->voids(run_id);
  ASSERT_EQ(voids->size(), 2U);
  EXPECT_EQ(voids->front().reason, "temperature moved 0.2 K");
  EXPECT_EQ(voids->front().user, "soakd");
  const auto events = catalog_->events();
  const auto logged =
      std::find_if(events->begin(), events->end(), [](const auto& e) { return e.kind == "nothing_to_void"; });
  ASSERT_NE(logged, events->end());
  EXPECT_NE(logged->text.find("never recorded"), std::string::npos);
}

TEST_F(RunRecorderTest, WithdrawsThePartOfOneUnitOnly) {
  RunRecorder recorder = begin(info());
  record_up_and_down(recorder);
  const auto entered = recorder.finish({}, {}, {{"SN1", "the unit restarted"}, {"SN9", "is not in this run"}});
  ASSERT_TRUE(entered) << entered.error().message;
  const auto runs = catalog_->runs({});
  ASSERT_EQ(runs->size(), 2U);
  for (const db::RunRow& run : *runs) EXPECT_EQ(run.voided, run.unit == "SN1") << run.unit;
  const std::string& run_id = runs->front().run_id;
  EXPECT_TRUE(catalog_->segments(run_id, "SN1", false)->empty());
  EXPECT_EQ(catalog_->segments(run_id, "SN2", false)->size(), 7U);
  const auto voids = catalog_->voids(run_id);
  ASSERT_EQ(voids->size(), 1U);
  EXPECT_EQ(voids->front().unit, "SN1");
  EXPECT_FALSE(voids->front().visit);
  EXPECT_EQ(voids->front().reason, "the unit restarted");
  EXPECT_EQ(voids->front().user, "soakd");
  EXPECT_TRUE(load_unit(*catalog_, "SN2", {}));
  EXPECT_FALSE(load_unit(*catalog_, "SN1", {})) << "nothing is left to fit";
}

TEST_F(RunRecorderTest, TheReasonOfTheWholeRunIsThatOfEachUnit) {
  RunRecorder recorder = begin(info());
  record_up_and_down(recorder);
  const auto entered = recorder.finish({}, "the campaign was aborted", {{"SN1", "the unit restarted"}});
  ASSERT_TRUE(entered) << entered.error().message;
  const auto voids = catalog_->voids(entered->front().run_id);
  ASSERT_EQ(voids->size(), 2U);
  for (const db::VoidRecord& record : *voids) EXPECT_EQ(record.reason, "the campaign was aborted");
  const auto runs = catalog_->runs({});
  for (const db::RunRow& run : *runs) EXPECT_TRUE(run.voided) << run.unit;
}

/// Starts of segments, s.
std::vector<double> starts_of(const std::vector<calib::Segment>& segments) {
  std::vector<double> starts;
  for (const calib::Segment& segment : segments) starts.push_back(segment.t_start_s);
  return starts;
}

TEST_F(RunRecorderTest, OneRampRowInTheSamePositionSeparatesTwoAttempts) {
  RunRecorder recorder = begin(info(), {{"SN1", "mti"}});
  Unit unit(6);
  // As the lab labels its rows: set point, visit and position stay while it waits for the units to settle.
  RowLabels waiting{Phase::ramp, Sweep::up, 30.0, "+Y", 4};
  RowLabels recording = waiting;
  recording.phase = Phase::soak;
  ASSERT_TRUE(recorder.add(0, unit.samples(40, 30.0F), waiting));  // from 0.1 s
  for (int attempt = 0; attempt < 3; ++attempt) {
    ASSERT_TRUE(recorder.add(0, unit.samples(1, 30.0F), waiting));
    // Two calls that follow each other are one attempt.
    ASSERT_TRUE(recorder.add(0, unit.samples(60, 30.0F), recording));
    ASSERT_TRUE(recorder.add(0, unit.samples(39, 30.0F), recording));
  }
  const auto runs = recorder.finish({{"SN1", 4, "+Y", 1, "the temperature moved"}});
  ASSERT_TRUE(runs) << runs.error().message;
  const std::string& run_id = runs->front().run_id;
  const auto left = catalog_->segments(run_id, "SN1", false);
  EXPECT_EQ(names_of(*left), (std::vector<std::string>{"4+Y0", "4+Y2"}));
  const auto starts = starts_of(*left);
  ASSERT_EQ(starts.size(), 2U);
  EXPECT_NEAR(starts[0], 4.2, 1e-9);
  EXPECT_NEAR(starts[1], 24.2, 1e-9);
  for (const calib::Segment& segment : *left) EXPECT_EQ(segment.sensor[0].count, 99U);
  EXPECT_EQ(catalog_->voids(run_id)->size(), 1U);
}

TEST_F(RunRecorderTest, WithdrawsAttemptsOfARunWithoutPlateaus) {
  RunRecorder recorder = begin(info(), {{"SN1", "mti"}});
  Unit unit(7);
  const RowLabels standing{Phase::soak, Sweep::unknown, {}, "+X", -1};
  RowLabels turned = standing;
  turned.position = "-X";
  ASSERT_TRUE(recorder.add(0, unit.samples(400, 22.0F), standing));
  ASSERT_TRUE(recorder.add(0, unit.samples(1, 22.0F), ramp(Sweep::unknown)));
  ASSERT_TRUE(recorder.add(0, unit.samples(400, 22.0F), turned));
  const auto runs = recorder.finish({{"SN1", -1, "+X", 0, "samples were missing"}});
  ASSERT_TRUE(runs) << runs.error().message;
  const auto left = catalog_->segments(runs->front().run_id, "SN1", false);
  ASSERT_FALSE(left->empty());
  for (const calib::Segment& segment : *left) EXPECT_EQ(segment.key.position, "-X");
}

TEST_F(RunRecorderTest, KeepsThePlansVisitsWhereAPlateauWasSkipped) {
  RunRecorder recorder = begin(info(), {{"SN1", "mti"}});
  Unit unit(3);
  RowLabels labels = soak(10.0, "+X");
  labels.visit = 0;
  ASSERT_TRUE(recorder.add(0, unit.samples(100, 10.0F), labels));
  labels = ramp(Sweep::up);
  labels.visit = 1;  // 20 °C, which gave up
  ASSERT_TRUE(recorder.add(0, unit.samples(100, 20.0F), labels));
  labels = soak(10.0, "+X", Sweep::down);
  labels.visit = 2;
  ASSERT_TRUE(recorder.add(0, unit.samples(100, 10.0F), labels));
  labels.position = "";
  ASSERT_TRUE(recorder.add(0, unit.samples(1, 10.0F), labels));
  labels = soak(10.0, "+X", Sweep::down);
  labels.visit = 3;  // the same set point twice in a row: no excursion tells the two apart
  ASSERT_TRUE(recorder.add(0, unit.samples(100, 10.0F), labels));
  const auto runs = recorder.finish({{"SN1", 2, "+X", 0, "wrong"}});
  ASSERT_TRUE(runs) << runs.error().message;
  EXPECT_EQ(names_of(*catalog_->segments(runs->front().run_id, "SN1", false)),
            (std::vector<std::string>{"0+X0", "3+X0"}));
}

TEST_F(RunRecorderTest, WithdrawsAllPartsOfASegmentThatAGapHasCut) {
  RunRecorder recorder = begin(info(), {{"SN1", "mti"}});
  Unit unit(4);
  ASSERT_TRUE(recorder.add(0, unit.samples(100, 10.0F), soak(10.0, "+X")));
  static_cast<void>(unit.samples(150, 10.0F));  // 15 s that were lost
  ASSERT_TRUE(recorder.add(0, unit.samples(100, 10.0F), soak(10.0, "+X")));
  ASSERT_TRUE(recorder.add(0, unit.samples(1, 10.0F), soak(10.0, "")));
  ASSERT_TRUE(recorder.add(0, unit.samples(100, 10.0F), soak(10.0, "+X")));
  const auto runs = recorder.finish({{"SN1", 0, "+X", 0, "15 s are missing"}});
  ASSERT_TRUE(runs) << runs.error().message;
  EXPECT_EQ(catalog_->voids(runs->front().run_id)->size(), 2U);
  const auto left = catalog_->segments(runs->front().run_id, "SN1", false);
  ASSERT_EQ(left->size(), 1U);
  EXPECT_NEAR(left->front().t_start_s, 35.2, 1e-9);
}

TEST_F(RunRecorderTest, EntersARunThatAFitFinds) {
  const db::RunInfo stated = info();
  RunRecorder recorder = begin(stated);
  record_up_and_down(recorder);
  const auto entered = recorder.finish({});
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
    EXPECT_EQ(load_unit(*catalog_, run.unit, {})->runs.size(), 1U);
  }
  EXPECT_EQ((*catalog_->unit("SN1"))->type, "mti");
  EXPECT_TRUE(orphan_run_files(*catalog_)->empty());
}

TEST_F(RunRecorderTest, ExportsItsSamplesBitForBit) {
  RunRecorder recorder = begin(info());
  record_up_and_down(recorder);
  const auto runs = recorder.finish({});
  const auto file = db::RunFileReader::open(catalog_->run_file_path(runs->front()));
  // native_csv() imports what it has written and compares all numbers.
  const auto native = native_csv(*file, "SN1");
  EXPECT_TRUE(native) << native.error().message;
}

TEST_F(RunRecorderTest, CountsAnotherClockRateAsSimulated) {
  db::RunInfo fast = info();
  fast.clock_rate = 20.0;
  RunRecorder recorder = begin(fast, {{"SN1", "mti"}});
  Unit unit(1);
  ASSERT_TRUE(recorder.add(0, unit.samples(100, 20.0F), soak(20.0, "+X")));
  const auto runs = recorder.finish({});
  ASSERT_TRUE(runs) << runs.error().message;
  EXPECT_TRUE(runs->front().simulated);
  EXPECT_TRUE(db::RunFileReader::open(catalog_->run_file_path(runs->front()))->info().simulated);
}

TEST_F(RunRecorderTest, KeepsThePurposeAndOffersRunsForCalibrationOnlyToAFit) {
  for (const char* purpose : {"verification", "diagnosis"}) {
    const db::RunInfo stated = info(purpose);
    auto recorder = RunRecorder::begin(*catalog_, stated, purpose, {{"SN1", "mti"}});
    ASSERT_TRUE(recorder);
    Unit unit(1);
    ASSERT_TRUE(recorder->add(0, unit.samples(100, 20.0F), soak(20.0, "+X")));
    const auto runs = recorder->finish({});
    ASSERT_TRUE(runs) << runs.error().message;
    EXPECT_EQ(runs->front().purpose, purpose);
    EXPECT_EQ(db::RunFileReader::open(catalog_->run_file_path(runs->front()))->info().purpose, purpose);
    const auto unfit = load_unit(*catalog_, "SN1", {});
    ASSERT_FALSE(unfit);
    EXPECT_NE(unfit.error().message.find(std::string("1 ") + purpose + " runs"), std::string::npos)
        << unfit.error().message;
  }
}

TEST_F(RunRecorderTest, RefusesWhatCouldNotBeEnteredLater) {
  Unit unit(1);
  RunRecorder recorder = begin(info());
  ASSERT_TRUE(recorder.add(0, unit.samples(100, 20.0F), soak(20.0, "+X")));
  ASSERT_TRUE(recorder.finish({}));
  const auto refused = [&](const db::RunInfo& info, std::string purpose, std::vector<RecordedUnit> units) {
    const auto begun = RunRecorder::begin(*catalog_, info, std::move(purpose), std::move(units));
    return !begun && begun.error().kind == base::ErrorKind::bad_input;
  };
  EXPECT_TRUE(refused(info("R01"), "calibration", {{"SN1", "mti"}})) << "the label is taken";
  EXPECT_TRUE(refused(info("R02"), "holiday", {{"SN1", "mti"}}));
  EXPECT_TRUE(refused(info("R02"), "calibration", {}));
  EXPECT_TRUE(refused(info("R02"), "calibration", {{"SN1", "mti"}, {"SN1", "mti"}}));
  EXPECT_TRUE(orphan_run_files(*catalog_)->empty());
}

TEST_F(RunRecorderTest, TakesAllRowsOfACallOrNone) {
  Unit unit(1);
  RunRecorder recorder = begin(info(), {{"SN1", "mti"}});
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
  EXPECT_EQ(recorder.finish({})->front().rows, 10U);
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
  EXPECT_FALSE(recorder.finish({}));
  EXPECT_EQ(catalog_->runs({})->size(), 1U);
}

using LostRuns = RunRecorderTest;

/// What the log says of runs.
std::vector<std::string> told_of_runs(const db::Catalog& catalog) {
  std::vector<std::string> texts;
  const auto events = catalog.events();
  for (const db::EventRow& event : *events) {
    if (event.kind == "run") texts.push_back(event.text);
  }
  return texts;
}

/// Records as soakd does in a process of its own, which is killed: `rows` rows of SN1 are flushed, some more are not.
void record_and_die(const fs::path& data_folder, const db::RunInfo& info, std::size_t rows) {
  const pid_t child = ::fork();
  if (child == 0) {
    auto catalog = db::Catalog::open(data_folder);
    auto recorder = RunRecorder::begin(*catalog, info, "verification", {{"SN1", "mti"}, {"SN2", "mti"}});
    Unit unit(1);
    // Nothing of this is checked here: a failure shows as rows that are missing.
    static_cast<void>(recorder->add(0, unit.samples(rows, 20.0F), soak(20.0, "+X")));
    static_cast<void>(recorder->flush());
    static_cast<void>(recorder->add(0, unit.samples(50, 20.0F), soak(20.0, "+X")));
    ::raise(SIGKILL);
  }
  int status = 0;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  ASSERT_TRUE(WIFSIGNALED(status));
}

TEST_F(LostRuns, AreEnteredVoidedWithEveryRowThatWasFlushed) {
  db::RunInfo lost = info();
  lost.source = kRunSource;
  record_and_die(folder_, lost, 20'000);
  ASSERT_FALSE(db::orphan_run_files(*catalog_)->empty());
  EventLog log(*catalog_);
  ASSERT_TRUE(enter_lost_runs(*catalog_, log));
  const auto runs = catalog_->runs({});
  ASSERT_EQ(runs->size(), 1U) << "SN2 gave no row";
  const db::RunRow& run = runs->front();
  EXPECT_EQ(run.run_id, lost.run_id);
  EXPECT_EQ(run.rows, 20'000U);
  EXPECT_EQ(run.purpose, "verification");
  EXPECT_TRUE(run.sealed);
  EXPECT_TRUE(run.voided);
  EXPECT_EQ((*catalog_->unit("SN1"))->type, "mti") << "known since the run began";
  const auto file = db::RunFileReader::open(catalog_->run_file_path(run));
  EXPECT_TRUE(file->sealed());
  EXPECT_TRUE(file->verify());
  EXPECT_EQ(file->events()->back().kind, "interrupted");
  EXPECT_TRUE(db::orphan_run_files(*catalog_)->empty());
  ASSERT_EQ(told_of_runs(*catalog_).size(), 1U);
  EXPECT_NE(told_of_runs(*catalog_).front().find("voided"), std::string::npos);
}

TEST_F(LostRuns, WithoutSamplesAreToldOfOnce) {
  db::RunInfo lost = info();
  lost.source = kRunSource;
  record_and_die(folder_, lost, 0);
  EventLog log(*catalog_);
  ASSERT_TRUE(enter_lost_runs(*catalog_, log));
  ASSERT_TRUE(enter_lost_runs(*catalog_, log));
  EXPECT_TRUE(catalog_->runs({})->empty());
  EXPECT_TRUE(db::orphan_run_files(*catalog_)->front().sealed);
  EXPECT_EQ(told_of_runs(*catalog_).size(), 1U);
}

TEST_F(LostRuns, LeavesTheFilesOfOthersAlone) {
  record_and_die(folder_, info(), 100);  // says that it is no file of soakd's
  EventLog log(*catalog_);
  ASSERT_TRUE(enter_lost_runs(*catalog_, log));
  EXPECT_FALSE(db::orphan_run_files(*catalog_)->front().sealed);
  EXPECT_TRUE(told_of_runs(*catalog_).empty());
}

}  // namespace
}  // namespace soak::station
