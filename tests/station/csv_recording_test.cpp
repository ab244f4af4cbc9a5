// SPDX-License-Identifier: Apache-2.0
#include "station/import/source_recording.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

namespace soak::station {
namespace {

using db::SampleType;

base::Result<SourceRecording> parse(const std::string& text, const CsvOptions& options = {}) {
  return parse_csv_recording(text, "folder/rec.csv", options);
}

CsvOptions skipping_bad() {
  CsvOptions options;
  options.skip_bad = true;
  return options;
}

CsvOptions with_map(const std::string& toml) {
  CsvOptions options;
  auto map = parse_columns_map(toml, "map");
  EXPECT_TRUE(map) << map.error().message;
  if (map) options.map = *std::move(map);
  return options;
}

/// Channel `name` of a run and its column.
std::pair<db::ChannelInfo, db::Column> channel(const SourceRun& run, std::string_view name) {
  for (std::size_t i = 0; i < run.channels.size(); ++i) {
    if (run.channels[i].name == name) return {run.channels[i], run.columns[i]};
  }
  ADD_FAILURE() << "no channel " << name;
  return {};
}

/// `named`: what the message quotes of the file, or names of columns.
void expect_refused(const base::Result<SourceRecording>& result, std::string_view where, std::string_view named = {}) {
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().kind, base::ErrorKind::bad_input);
  EXPECT_EQ(result.error().where, where);
  EXPECT_NE(result.error().message.find(named), std::string::npos) << result.error().message;
}

TEST(CsvRecording, TakesTheNarrowestTypeThatLosesNothing) {
  const auto recording = parse(
      "temp_c,t_s,gx_dps,gy_dps,gz_dps,ticks,ay_g,az_g\n"
      "25,0,1,-129,40000,3000000000,-0,1e3\n"
      "-3,0.5,127,5,1,0,2,2\n");
  ASSERT_TRUE(recording) << recording.error().message;
  const SourceRun& run = recording->runs.at(0);
  EXPECT_EQ(run.channels[0].name, "t_s");
  EXPECT_EQ(channel(run, "t_s").first.type, SampleType::f64);
  EXPECT_EQ(channel(run, "temp_c").first.type, SampleType::i8);
  EXPECT_EQ(channel(run, "gyro_x").first.type, SampleType::i8);
  EXPECT_EQ(channel(run, "gyro_y").first.type, SampleType::i16);
  EXPECT_EQ(channel(run, "gyro_z").first.type, SampleType::i32);
  EXPECT_EQ(channel(run, "ticks").first.type, SampleType::i64);
  EXPECT_EQ(channel(run, "accel_y").first.type, SampleType::f64);
  EXPECT_EQ(channel(run, "accel_z").first.type, SampleType::f64);
  EXPECT_EQ(channel(run, "gyro_y").second.raw, (base::Bytes{0x7F, 0xFF, 0x05, 0x00}));
}

TEST(CsvRecording, KeepsSourceNamesUnitsAndAbsentValues) {
  const auto recording = parse(
      "t_us,temp_k,gx_degph,az_mg,pressure,mode,temp_gx_f\n0,300,,1,9,idle,70\n5,,2,3,,busy,\n10,301,3,,8,idle,71\n");
  ASSERT_TRUE(recording) << recording.error().message;
  const SourceRun& run = recording->runs.at(0);
  EXPECT_EQ(run.label, "rec");
  EXPECT_EQ(channel(run, "t_s").first.source_name, "t_us");
  EXPECT_EQ(channel(run, "t_s").first.scale, 1e-6);
  EXPECT_EQ(channel(run, "temp_c").first.unit, "k");
  EXPECT_EQ(channel(run, "gyro_x").first.unit, "degph");
  EXPECT_EQ(channel(run, "accel_z").first.unit, "mg");
  EXPECT_EQ(channel(run, "temp_gx_c").first.unit, "f");
  EXPECT_EQ(channel(run, "gyro_x").second.present, (std::vector<std::uint8_t>{0, 1, 1}));
  EXPECT_TRUE(channel(run, "mode").second.present.empty());
  EXPECT_EQ(channel(run, "mode").first.labels, (std::vector<std::string>{"idle", "busy"}));
  EXPECT_EQ(channel(run, "mode").second.raw, (base::Bytes{0, 1, 0}));
  EXPECT_EQ(channel(run, "pressure").first.type, SampleType::i8);
}

TEST(CsvRecording, SplitsRunsByLabelAndLetsTimeRestart) {
  const auto recording = parse("t_s,run,temp_c,gx_dps\n0,a,1,1\n1,a,1,2\n0,\" b,\",1,0.5\n");
  ASSERT_TRUE(recording) << recording.error().message;
  ASSERT_EQ(recording->runs.size(), 2U);
  EXPECT_EQ(recording->runs[0].label, "a");
  EXPECT_EQ(recording->runs[1].label, " b,");
  EXPECT_EQ(recording->runs[0].rows(), 2U);
  EXPECT_EQ(channel(recording->runs[0], "gyro_x").first.type, SampleType::i8);
  EXPECT_EQ(channel(recording->runs[1], "gyro_x").first.type, SampleType::f64);
}

TEST(CsvRecording, ReadsByteOrderMarkCrLfAndQuotes) {
  const auto recording = parse("\xEF\xBB\xBFt_s, \"temp_c\" ,gx_dps\r\n0, 25 ,\"1.5\"\r\n");
  ASSERT_FALSE(recording) << "a quote after a blank does not open a cell";
  const auto tight = parse("\xEF\xBB\xBF\"t_s\", temp_c ,gx_dps\r\n0, 25 ,\"1.5\"\r\n");
  ASSERT_TRUE(tight) << tight.error().message;
  EXPECT_EQ(channel(tight->runs.at(0), "temp_c").first.type, SampleType::i8);
  EXPECT_TRUE(tight->warnings.empty());
}

TEST(CsvRecording, WarnsOfALastLineWithoutEnd) {
  const auto recording = parse("t_s,temp_c,gx_dps\n0,25,1\n1,25,2");
  ASSERT_TRUE(recording);
  EXPECT_EQ(recording->runs.at(0).rows(), 2U);
  ASSERT_EQ(recording->warnings.size(), 1U);
  EXPECT_NE(recording->warnings[0].find("line 3"), std::string::npos);
}

TEST(CsvRecording, RefusesBadHeaders) {
  const std::string place = "folder/rec.csv, line 1";
  expect_refused(parse("t_s,gx_dps\n0,1\n"), place, "temp_c");
  expect_refused(parse("t_s,temp_c\n0,1\n"), place);
  expect_refused(parse("temp_c,gx_dps\n0,1\n"), place, "t_s");
  expect_refused(parse("t_s,temp_c,gx_degs\n0,1,1\n"), place);
  expect_refused(parse("t_s,temp_c,gyro_x\n0,1,1\n"), place, "gx_dps");
  expect_refused(parse("t_s,temp_c,gx_dps,gx_rps\n0,1,1,1\n"), place);
  expect_refused(parse("t_s,t_ms,temp_c,gx_dps\n0,1,1,1\n"), place);
  expect_refused(parse("t_s,temp_c,gx_dps,x,x\n0,1,1,1,1\n"), place);
  expect_refused(parse("t_s,temp_c,gx_dps,\n0,1,1,1\n"), place);
  expect_refused(parse(""), "folder/rec.csv");
  expect_refused(parse("t_s,temp_c,gx_dps\n"), "folder/rec.csv");
}

TEST(CsvRecording, NamesLineAndColumnOfABadCell) {
  const std::string head = "t_s,temp_c,gx_dps\n0,25,1\n";
  expect_refused(parse(head + "1,25,nan\n"), "folder/rec.csv, line 3, column 'gx_dps'", "'nan'");
  expect_refused(parse(head + "1,-INF,1\n"), "folder/rec.csv, line 3, column 'temp_c'", "'-INF'");
  expect_refused(parse(head + "1,25,1;2\n"), "folder/rec.csv, line 3, column 'gx_dps'", "'1;2'");
  expect_refused(parse(head + ",25,1\n"), "folder/rec.csv, line 3, column 't_s'");
  expect_refused(parse(head + "1,25\n"), "folder/rec.csv, line 3");
  expect_refused(parse(head + "1,25,1,7\n"), "folder/rec.csv, line 3");
  expect_refused(parse("t_s,temp_c,gx_dps,aux\n0,25,1,7\n1,25,1,x\n"), "folder/rec.csv, line 3, column 'aux'", "'x'");
}

TEST(CsvRecording, LeavesBadRowsOutAndListsThem) {
  const auto recording = parse("t_s,temp_c,gx_dps\n0,25,1\n1,25,nan\n2,25\n,25,1\n3,25,2.5x\n4,25,2\n", skipping_bad());
  ASSERT_TRUE(recording) << recording.error().message;
  EXPECT_EQ(recording->runs.at(0).rows(), 2U);
  ASSERT_EQ(recording->bad_rows.size(), 4U);
  EXPECT_EQ(recording->bad_rows[0].line, 3U);
  EXPECT_EQ(recording->bad_rows[0].column, "gx_dps");
  EXPECT_EQ(recording->bad_rows[1].line, 4U);
  EXPECT_EQ(recording->bad_rows[1].column, "");
  // A bad row leaves no trace in the type of the sound ones.
  EXPECT_EQ(channel(recording->runs.at(0), "gyro_x").first.type, SampleType::i8);
}

TEST(CsvRecording, RefusesTimeThatDoesNotRiseWithinARunAlsoWhenSkippingBadRows) {
  for (const CsvOptions& options : {CsvOptions{}, skipping_bad()}) {
    expect_refused(parse("t_s,temp_c,gx_dps\n0,25,1\n2,25,1\n1,25,1\n", options),
                   "folder/rec.csv, line 4, column 't_s'");
    expect_refused(parse("t_s,run,temp_c,gx_dps\n0,a,25,1\n0,a,25,1\n", options),
                   "folder/rec.csv, line 3, column 't_s'");
  }
}

TEST(CsvRecording, RefusesARunThatGoesOnAfterAnother) {
  expect_refused(parse("t_s,run,temp_c,gx_dps\n0,a,25,1\n0,b,25,1\n1,a,25,1\n"), "folder/rec.csv, line 4, column 'run'",
                 "'a'");
}

TEST(CsvRecording, RefusesUnknownLabelsAndNamesTheKnownOnes) {
  const std::string head = "t_s,temp_c,gx_dps,phase,sweep,position\n0,25,1,soak,up,+X\n";
  expect_refused(parse(head + "1,25,1,dwell,up,+X\n", skipping_bad()), "folder/rec.csv, line 3, column 'phase'");
  expect_refused(parse(head + "1,25,1,soak,left,+X\n", skipping_bad()), "folder/rec.csv, line 3, column 'sweep'");
  expect_refused(parse(head + "1,25,1,soak,up,X+\n", skipping_bad()), "folder/rec.csv, line 3, column 'position'");
}

TEST(CsvRecording, RefusesARunWithoutTemperatureOrSensorValues) {
  expect_refused(parse("t_s,temp_c,gx_dps\n0,,1\n1,,1\n"), "folder/rec.csv, line 2, column 'temp_c'");
  expect_refused(parse("t_s,temp_c,gx_dps\n0,25,\n1,25,\n"), "folder/rec.csv, line 2");
}

TEST(CsvRecording, FollowsAColumnsMap) {
  const auto recording = parse("ticks;GX;Temp;att\n-7;0;0;\n100;-5;250;P1\n200;6;251;+z\n", with_map(R"(
separator = "semicolon"
skip_rows = 1
[columns]
ticks = { as = "t_ms", type = "u32", scale = 2, offset = -200 }
GX = { as = "gx_dps", type = "f32", scale = 0.5 }
Temp = { as = "temp_c", type = "i32", scale = 0.1 }
att = "position"
[constants]
phase = "ramp"
[positions]
P1 = [0, 0, 2]
P2 = [0, 1, 0]
)"));
  ASSERT_TRUE(recording) << recording.error().message;
  const SourceRun& run = recording->runs.at(0);
  ASSERT_EQ(run.rows(), 2U);
  const auto [time, ticks] = channel(run, "t_s");
  EXPECT_EQ(time.type, SampleType::u32);
  EXPECT_EQ(db::values_of(ticks, time.scale, time.offset), (std::vector<double>{0.0, 0.2}));
  const auto [gyro, counts] = channel(run, "gyro_x");
  EXPECT_EQ(gyro.type, SampleType::f32);
  float first = 0.0F;
  std::memcpy(&first, counts.raw.data(), sizeof first);
  EXPECT_EQ(first, -5.0F);
  EXPECT_EQ(channel(run, "position").first.labels, (std::vector<std::string>{"P1", "+z"}));
  ASSERT_EQ(run.positions.size(), 1U);
  EXPECT_EQ(run.positions[0].up, (calib::Vector3{0.0, 0.0, 1.0}));
  EXPECT_EQ(channel(run, "phase").first.labels, (std::vector<std::string>{"ramp"}));
}

/// Programs that know only floating point write counts as "-2052.0".
TEST(CsvRecording, AWholeTypeTakesWholeNumbersHoweverTheyAreSpelt) {
  const CsvOptions options = with_map("[columns]\ngx_dps = { type = \"i16\" }\n");
  const auto recording =
      parse("t_s,temp_c,gx_dps\n0,25,-2052.0\n1,25,7\n2,25,-0.0\n3,25,3.2767e4\n4,25,+12.\n", options);
  ASSERT_TRUE(recording) << recording.error().message;
  const auto [gyro, counts] = channel(recording->runs.at(0), "gyro_x");
  EXPECT_EQ(gyro.type, SampleType::i16);
  EXPECT_EQ(db::values_of(counts, 1.0, 0.0), (std::vector<double>{-2052.0, 7.0, 0.0, 32767.0, 12.0}));
  for (const char* cell : {"-2052.5", "32768.0", "-3.2769e4", "1e300", "nan"}) {
    expect_refused(parse(std::string("t_s,temp_c,gx_dps\n0,25,") + cell + "\n", options),
                   "folder/rec.csv, line 2, column 'gx_dps'");
  }
}

TEST(CsvRecording, RefusesWhatDoesNotFitTheTypeOfTheMap) {
  const CsvOptions options = with_map("[columns]\ngx_dps = { type = \"i8\" }\n");
  expect_refused(parse("t_s,temp_c,gx_dps\n0,25,128\n", options), "folder/rec.csv, line 2, column 'gx_dps'");
  expect_refused(parse("t_s,temp_c,gx_dps\n0,25,1.5\n", options), "folder/rec.csv, line 2, column 'gx_dps'");
}

TEST(CsvRecording, RefusesAMapThatNamesAColumnTheFileLacks) {
  expect_refused(parse("t_s,temp_c,gx_dps\n0,25,1\n", with_map("[columns]\nGX = \"gy_dps\"\n")),
                 "folder/rec.csv, line 1", "'GX'");
}

TEST(CsvRecording, StopsWhenTheCallerSaysSo) {
  std::string text = "t_s,temp_c,gx_dps\n";
  for (int i = 0; i < 50000; ++i) text += std::to_string(i) + ",25,1\n";
  CsvOptions options;
  options.progress = [](double share) { return share < 0.5; };
  const auto recording = parse(text, options);
  ASSERT_FALSE(recording);
  EXPECT_EQ(recording.error().kind, base::ErrorKind::internal);
}

}  // namespace
}  // namespace soak::station
