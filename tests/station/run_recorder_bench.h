// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <stdlib.h>
#include <algorithm>
#include <filesystem>
#include <map>

#include "base/random.h"
#include "station/io/host.h"
#include "station/lab/run_recorder.h"
#include "station/runs/recording_reader.h"

// A data folder, a recorder and units that feed it.
namespace soak::station::recorder_bench {

namespace fs = std::filesystem;
using calib::Phase;
using calib::Sweep;

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

  RunRecorder begin(const db::RunInfo& info,
                    std::vector<RecordedUnit> units = {{"SN1", "mti-300"}, {"SN2", "mti-300"}}) {
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

inline RowLabels soak(double plateau_c, std::string position, Sweep sweep = Sweep::up) {
  return {Phase::soak, sweep, plateau_c, std::move(position)};
}

inline RowLabels ramp(Sweep sweep) { return {Phase::ramp, sweep, {}, ""}; }

/// Records both units through 65, 70 and 65 °C again, with +X twice at 70 °C.
/// `reject`: unit, stretch (from 0, in the order of time) → reason.
inline void record_up_and_down(RunRecorder& recorder,
                               const std::map<std::pair<std::size_t, int>, std::string>& reject = {}) {
  int stretch = 0;
  std::vector<Unit> units = {Unit(1), Unit(2)};
  const auto add = [&](std::size_t count, float temp_c, const RowLabels& labels) {
    for (std::size_t u = 0; u < units.size(); ++u) {
      // In small pieces, as they come.
      for (std::size_t done = 0; done < count; done += 50) {
        const auto added = recorder.add(u, units[u].samples(std::min<std::size_t>(50, count - done), temp_c), labels);
        ASSERT_TRUE(added) << added.error().message;
      }
      const auto why = labels.phase == Phase::soak ? reject.find({u, stretch}) : reject.end();
      if (why != reject.end() && !labels.position.empty()) recorder.reject(u, why->second);
    }
    if (labels.phase == Phase::soak && !labels.position.empty()) ++stretch;
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

}  // namespace soak::station::recorder_bench
