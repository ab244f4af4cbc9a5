// SPDX-License-Identifier: Apache-2.0
#include "station/runs/recording_reader.h"

#include <gtest/gtest.h>
#include <stdlib.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <string>

#include "station/import/import.h"

namespace soak::station {
namespace {

namespace fs = std::filesystem;

class RecordingReaderTest : public ::testing::Test {
 protected:
  void SetUp() override {
    std::string name = (fs::temp_directory_path() / "soak-reader-XXXXXX").string();
    ASSERT_NE(::mkdtemp(name.data()), nullptr);
    folder_ = name;
  }
  void TearDown() override { fs::remove_all(folder_); }

  /// Imports `csv` and reads it back.
  calib::Recording imported(const std::string& csv, const std::string& map = {}) {
    const fs::path path = folder_ / "rec.csv";
    std::ofstream(path) << csv;
    CsvOptions options;
    options.map = parse_columns_map(map, "map").value();
    auto catalog = db::Catalog::open(folder_ / "data");
    if (!catalog) throw std::runtime_error(catalog.error().message);
    ImportOptions import;
    import.unit = "SN1";
    const SourceRecording recording = read_csv_recording(path, options).value();
    const auto summary = store_recording(*catalog, recording, path, import);
    if (!summary) throw std::runtime_error(summary.error().where + ": " + summary.error().message);
    const auto runs = catalog->runs({.unit = "SN1", .campaign = {}, .run = summary->runs.at(0).run_id});
    const auto file = db::RunFileReader::open(catalog->run_file_path(runs->at(0)));
    return read_recording(*file, "SN1").value();
  }

  fs::path folder_;
};

TEST_F(RecordingReaderTest, ConvertsToSiAndNamesEverythingByItsPlace) {
  const calib::Recording recording = imported(
      "t_ms,temp_k,gx_dps,gz_degph,ax_g,az_mg,temp_az_f,chamber_c,mode,load\n"
      "0,293.15,180,1296000,1,500,32,21.5,idle,3\n"
      "500,294.15,-90,0,0,0,212,22,busy,4\n");
  EXPECT_EQ(recording.unit, "SN1");
  EXPECT_EQ(recording.t_s, (std::vector<double>{0.0, 0.5}));
  EXPECT_DOUBLE_EQ(recording.temp_c[0], 20.0);
  EXPECT_DOUBLE_EQ(recording.sensor[0][0], M_PI);
  EXPECT_DOUBLE_EQ(recording.sensor[2][0], 2.0 * M_PI);
  EXPECT_TRUE(recording.sensor[1].empty());
  EXPECT_DOUBLE_EQ(recording.sensor[3][0], 9.80665);
  EXPECT_DOUBLE_EQ(recording.sensor[5][0], 9.80665 / 2.0);
  EXPECT_DOUBLE_EQ(recording.sensor_temp_c[5][1], 100.0);
  EXPECT_TRUE(recording.phase.empty());
  EXPECT_TRUE(recording.position.empty());
  ASSERT_EQ(recording.auxiliary.size(), 2U);
  EXPECT_EQ(recording.auxiliary[0].name, "chamber_c");
  EXPECT_EQ(recording.auxiliary[1].values, (std::vector<double>{3.0, 4.0}));
}

TEST_F(RecordingReaderTest, ReadsPhasesSweepsAndPositionsWithTheirDefaults) {
  const calib::Recording recording = imported(
      "t_s,temp_c,gx_dps,phase,sweep,position\n0.5,25,1,,,tilt\n1,25,1,ramp,down,\n2,25,1,soak,up,+z\n3,25,1,soak,up,+"
      "Z\n",
      "[positions]\ntilt = [0, -3, 4]\n");
  using calib::Phase;
  using calib::Sweep;
  EXPECT_EQ(recording.phase, (std::vector<Phase>{Phase::soak, Phase::ramp, Phase::soak, Phase::soak}));
  EXPECT_EQ(recording.sweep, (std::vector<Sweep>{Sweep::unknown, Sweep::down, Sweep::up, Sweep::up}));
  EXPECT_EQ(recording.position, (std::vector<std::int32_t>{0, -1, 1, 1}));
  ASSERT_EQ(recording.positions.size(), 2U);
  EXPECT_EQ(recording.positions[0].up, (calib::Vector3{0.0, -0.6, 0.8}));
  EXPECT_EQ(recording.positions[1], *calib::position_named("+Z"));
}

TEST_F(RecordingReaderTest, HoldsSlowChannelsButNoSensorAndRunsPowerTimeOn) {
  const calib::Recording recording =
      imported("t_s,temp_c,gx_dps,plateau_c,t_since_power_s\n0,25,1,30,\n1,,,,11.5\n2,,3,,\n3,,4,,\n3.5,26,5,,14\n");
  EXPECT_EQ(recording.temp_c, (std::vector<double>{25, 25, 25, 25, 26}));  // own spacing 3.5 s: holds for 5.25 s
  EXPECT_EQ(recording.plateau_c[2], 30.0);
  EXPECT_TRUE(std::isnan(recording.plateau_c[3]));
  EXPECT_TRUE(std::isnan(recording.sensor[0][1]));
  EXPECT_EQ(recording.t_since_power_s, (std::vector<double>{10.5, 11.5, 12.5, 13.5, 14.0}));
}

}  // namespace
}  // namespace soak::station
