// SPDX-License-Identifier: Apache-2.0
// What the calibration file says of one run and of temperatures that were visited one way only, and who passes it on.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "calib/deploy/calibration_file.h"
#include "calib/deploy/export.h"
#include "calib/judge/verification.h"
#include "calib/model/model_document.h"
#include "calib/runtime/soak_runtime.h"
#include "tests/calib/calibration_file_samples.h"
#include "tests/calib/six_position_samples.h"

namespace soak::calib {
namespace {

using namespace samples;
using nlohmann::json;

std::uint16_t minor_version(const base::Bytes& bytes) { return get<std::uint16_t>(bytes, 10); }

TEST(OneWayFile, SaysWhatItWasMadeFrom) {
  const Calibration written = golden_one_way();
  const auto read = decode(*encode(written));
  ASSERT_TRUE(read) << read.error().message;
  for (std::size_t i = 0; i < written.sensors.size(); ++i) {
    EXPECT_EQ(read->sensors[i].one_way, written.sensors[i].one_way);
    EXPECT_TRUE(read->sensors[i].bias_uncertainty.one_run);
  }
}

TEST(OneWayFile, IsOfVersion16WhereItSaysEitherAndElseOfTheOldOne) {
  EXPECT_EQ(minor_version(*encode(golden_fis())), 0);
  Calibration one_run = golden_fis();
  one_run.sensors[0].bias_uncertainty.one_run = true;
  EXPECT_EQ(minor_version(*encode(one_run)), 6);
  Calibration one_way = golden_fis();
  one_way.sensors[0].one_way = OneWay{{{-30.0, 70.0, Sweep::up}}, {}};
  EXPECT_EQ(minor_version(*encode(one_way)), 6);
}

TEST(OneWayFile, WhatTheFormatCannotCarryIsRefusedWithItsSensor) {
  const KnownHysteresis known{1e-4, HysteresisSource::type};
  const std::vector<OneWay> bad = {{{}, known},
                                   {{{10.0, -10.0, Sweep::up}}, known},
                                   {{{0.0, 20.0, Sweep::up}, {10.0, 30.0, Sweep::up}}, known},
                                   {{{0.0, 20.0, Sweep::unknown}}, known},
                                   {{{0.0, 2000.0, Sweep::up}}, known},
                                   {{{0.0, 20.0, Sweep::up}}, {NAN, HysteresisSource::type}},
                                   {{{0.0, 20.0, Sweep::up}}, {-1e-4, HysteresisSource::type}},
                                   {{{0.0, 20.0, Sweep::up}}, {1e-4, HysteresisSource::none}}};
  for (const OneWay& one_way : bad) {
    Calibration calibration = golden_fis();
    calibration.sensors[1].one_way = one_way;
    const auto bytes = encode(calibration);
    ASSERT_FALSE(bytes);
    EXPECT_EQ(bytes.error().kind, base::ErrorKind::bad_input);
    EXPECT_NE(bytes.error().where.find("gyro_y"), std::string::npos);
  }
}

TEST(OneWayFile, ADamagedSectionIsRefusedAndOneOfANewerLayoutPassedOver) {
  const base::Bytes whole = *encode(golden_one_way());
  const std::size_t at = payload_of(whole, 0x0015, 0, 1);  // gyro_x, source type
  ASSERT_NE(at, 0U);
  const auto refused = [&](auto change) {
    base::Bytes bytes = whole;
    change(bytes);
    seal(bytes);
    const auto read = decode(bytes);
    return !read && read.error().kind == base::ErrorKind::corrupt;
  };
  EXPECT_TRUE(refused([&](base::Bytes& bytes) { bytes[at] = 6; }));      // no such sensor
  EXPECT_TRUE(refused([&](base::Bytes& bytes) { bytes[at] = 5; }));      // accel_z comes later
  EXPECT_TRUE(refused([&](base::Bytes& bytes) { bytes[at + 1] = 3; }));  // no such source
  EXPECT_TRUE(refused([&](base::Bytes& bytes) { bytes[at + 2] = 3; }));  // more ranges than there are
  EXPECT_TRUE(refused([&](base::Bytes& bytes) { put(bytes, at + 4, NAN); }));
  EXPECT_TRUE(refused([&](base::Bytes& bytes) { put(bytes, at + 8, 18.0F); }));  // above its end
  EXPECT_TRUE(refused([&](base::Bytes& bytes) { bytes[at + 16] = 3; }));         // no such way
  base::Bytes newer = whole;
  newer[at - 6] = 2;
  seal(newer);
  const auto read = decode(newer);
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_FALSE(read->sensors[0].one_way);
  EXPECT_TRUE(read->sensors[4].one_way);
}

TEST(OneWayFile, TheRuntimeTellsOneRunAndTakesTheRestAsItComes) {
  const base::Bytes bytes = *encode(golden_one_way());
  const base::Bytes other = *encode(golden_fis());
  soak_cal cal;
  ASSERT_EQ(soak_load(&cal, bytes.data(), bytes.size()), SOAK_OK);
  EXPECT_EQ(soak_is_of_one_run(&cal, SOAK_GYRO_X), 1);
  float ci95 = 0.0F;
  float pi95 = 0.0F;
  EXPECT_EQ(soak_uncertainty(&cal, SOAK_GYRO_X, 20.0F, &ci95, &pi95), SOAK_OK);
  EXPECT_TRUE(std::isnan(pi95));
  ASSERT_EQ(soak_load(&cal, other.data(), other.size()), SOAK_OK);
  EXPECT_EQ(soak_is_of_one_run(&cal, SOAK_GYRO_X), 0);
  EXPECT_EQ(soak_is_of_one_run(&cal, -1), 0);
  EXPECT_EQ(soak_is_of_one_run(nullptr, 0), 0);
}

TEST(OneWayFile, TheJsonExportHasItToo) {
  const json sensors = json::parse(*export_json(golden_one_way()))["sensors"];
  EXPECT_TRUE(sensors["gyro_y"]["one_run"].get<bool>());
  EXPECT_TRUE(sensors["gyro_y"]["one_way"].is_null());
  const json gyro = sensors["gyro_x"]["one_way"];
  EXPECT_EQ(gyro["source"], "type");
  EXPECT_NEAR(gyro["half_gap"].get<double>(), 0x1p-12 * 180.0 / 3.14159265358979, 1e-12);
  EXPECT_EQ(gyro["ranges"][1], (json{{"low_c", 32.5}, {"high_c", 62.5}, {"sweep", "up"}}));
  EXPECT_TRUE(sensors["accel_z"]["one_way"]["half_gap"].is_null());
}

TEST(OneWayFile, TheCHeadersCommentHasALineForEachRange) {
  const std::string text = *export_c(golden_one_way());
  const std::string comment = text.substr(0, text.find("*/"));
  for (const char* words : {"32.5 to 62.5", "-30 to 20", "20 to 45"}) {
    EXPECT_NE(comment.find(words), std::string::npos) << words;
  }
  EXPECT_EQ(export_c(golden_fis())->find("only from"), std::string::npos);
}

UnitModel model_of(std::size_t runs, const OneWay& one_way) {
  UnitModel model;
  model.unit = "U";
  SensorFit fit;
  fit.bias.runs.assign(runs, "R");
  fit.bias.curve = TableCurve{-30.0, 50.0, {0.1, 0.2, 0.3}, {}};
  fit.bias.temp_min_c = -30.0;
  fit.bias.temp_max_c = 70.0;
  fit.bias.points = {{-30.0, 0.1, 0.01, {}}, {70.0, 0.3, 0.01, {}}};
  fit.bias.one_way = one_way;
  model.sensors[0] = fit;
  return model;
}

TEST(OneWayFile, AStoredModelKeepsItAndAnOlderDocumentHasNone) {
  const OneWay one_way{{{-30.0, 70.0, Sweep::down}}, {0.125, HysteresisSource::fleet}};
  const auto text = model_document(model_of(1, one_way));
  ASSERT_TRUE(text) << text.error().message;
  const auto read = calibration_of(*text);
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(read->sensors[0].one_way, one_way);
  EXPECT_TRUE(read->sensors[0].bias_uncertainty.one_run);
  json old = json::parse(*text);
  old["calibration"]["sensors"][0].erase("one_way");
  old["calibration"]["sensors"][0]["bias_uncertainty"].erase("one_run");
  const auto older = calibration_of(old.dump());
  ASSERT_TRUE(older) << older.error().message;
  EXPECT_FALSE(older->sensors[0].one_way);
  EXPECT_FALSE(older->sensors[0].bias_uncertainty.one_run);
  // A model that needs neither is stored as before.
  const json plain = json::parse(*model_document(model_of(3, {})))["calibration"]["sensors"][0];
  EXPECT_FALSE(plain.contains("one_way"));
  EXPECT_FALSE(plain["bias_uncertainty"].contains("one_run"));
  json wrong = json::parse(*text);
  wrong["calibration"]["sensors"][0]["one_way"]["source"] = "hearsay";
  EXPECT_EQ(calibration_of(wrong.dump()).error().kind, base::ErrorKind::corrupt);
}

// ---- verification ----

/// Fresh runs in six positions, all visits of the given way.
UnitInput fresh_runs(Sweep sweep) {
  test::Bench bench;
  bench.plateaus_c = {-25, -15, -5, 5, 15, 25, 35};
  UnitInput input;
  input.unit = "U";
  RunInput run;
  run.run_id = run.label = "V1";
  run.content_sha256 = "fresh";
  run.site = test::standard_site();
  run.segments = test::segments_of(bench);
  for (Segment& segment : run.segments) segment.sweep = sweep;
  input.runs.push_back(run);
  return input;
}

Calibration heated_only(bool one_run) {
  Calibration file;
  file.unit = "U";
  file.run_hashes = {"a"};
  for (const Sensor sensor : kSensors) {
    SensorCalibration stated;
    stated.sensor = sensor;
    stated.temp_min_c = -30.0;
    stated.temp_max_c = 40.0;
    stated.bias = TableCurve{-30.0, 70.0, {0.0, 0.0}, {}};
    stated.bias_uncertainty = {{-30.0, 40.0}, {1e-4, 1e-4}, {}, one_run};
    stated.one_way = OneWay{{{-30.0, 40.0, Sweep::up}}, {}};
    file.sensors.push_back(stated);
  }
  return file;
}

std::vector<std::string> texts_of(const Verification& verification, const std::string& code) {
  std::vector<std::string> texts;
  for (const Warning& warning : verification.warnings) {
    if (warning.code == code) texts.push_back(warning.text);
  }
  return texts;
}

TEST(OneWayFile, AVerificationSaysWhichWayTheFreshRunsWentAndOnceOnly) {
  const auto same = verify(heated_only(true), fresh_runs(Sweep::up), {});
  const auto other = verify(heated_only(false), fresh_runs(Sweep::down), {});
  ASSERT_TRUE(same && other);
  ASSERT_EQ(texts_of(*same, "one_way").size(), 1U);
  ASSERT_EQ(texts_of(*other, "one_way").size(), 1U);
  EXPECT_NE(texts_of(*same, "one_way"), texts_of(*other, "one_way"));
  EXPECT_NE(texts_of(*other, "one_way")[0].find("7 of 7"), std::string::npos);
  EXPECT_EQ(texts_of(*same, "one_run").size(), 1U);
  EXPECT_TRUE(texts_of(*other, "one_run").empty());
}

TEST(OneWayFile, AVerificationOfAFileThatWentBothWaysSaysNothing) {
  Calibration file = heated_only(false);
  for (SensorCalibration& sensor : file.sensors) sensor.one_way.reset();
  const auto verification = verify(file, fresh_runs(Sweep::up), {});
  ASSERT_TRUE(verification);
  EXPECT_TRUE(texts_of(*verification, "one_way").empty());
}

}  // namespace
}  // namespace soak::calib
