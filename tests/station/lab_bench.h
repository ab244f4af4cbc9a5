// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <stdlib.h>
#include <array>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "db/catalog/catalog.h"
#include "station/lab/station.h"

// A station with a chamber that obeys and one unit, without a wire.
namespace soak::station::lab_bench {

namespace fs = std::filesystem;

/// Obeys at once, and counts.
class ObedientChamber : public hal::Chamber {
 public:
  base::Status connect() override { return {}; }
  base::Result<hal::ChamberReading> read() override {
    ++reads;
    if (unreadable) return base::fail(base::ErrorKind::device, "does not answer", description());
    hal::ChamberReading reading;
    reading.air_c = reading.set_point_c = set_point_c;
    reading.running = running;
    return reading;
  }
  base::Status set_temperature(double temp_c) override {
    ++commands;
    if (refuses_set_points) return base::fail(base::ErrorKind::device, "illegal data value", description());
    if (takes_set_points) set_point_c = temp_c;
    return {};
  }
  base::Status set_ramp_rate(std::optional<double>) override { return {}; }
  base::Status start() override {
    running = true;
    return {};
  }
  base::Status stop() override {
    ++stops;
    if (silent) return base::fail(base::ErrorKind::device, "does not answer", description());
    if (refuses_stops) return base::fail(base::ErrorKind::device, "illegal data value", description());
    if (deaf_stops > 0)
      --deaf_stops;
    else
      running = false;
    return {};
  }
  std::optional<double> min_set_point_c() const override { return std::nullopt; }
  std::optional<double> max_set_point_c() const override { return std::nullopt; }
  bool can_ramp() const override { return false; }
  bool answers() const override { return !silent; }
  std::string description() const override { return "obedient"; }

  double set_point_c = 60.0;
  bool running = true;
  bool takes_set_points = true;  ///< else it acknowledges them, and goes on
  int reads = 0;
  int commands = 0;
  int stops = 0;
  bool refuses_set_points = false;
  bool refuses_stops = false;
  bool unreadable = false;
  bool silent = false;  ///< to a command to stop
  int deaf_stops = 0;   ///< so many commands to stop are acknowledged, and it goes on
};

/// What a unit shows.
struct Stream {
  std::size_t rows_per_poll = 0;
  std::array<float, 3> accel_mps2 = {9.80665F, 0.0F, 0.0F};  ///< but for a few digits
};

/// Streams rows of 100 Hz with each poll.
class RushingImu : public hal::Imu {
 public:
  explicit RushingImu(const Stream& stream) : stream_(stream) {}
  base::Status open(const Settings&) override { return {}; }
  void close() override {}
  base::Status poll(std::vector<hal::ImuSample>& samples) override {
    for (std::size_t i = 0; i < stream_.rows_per_poll; ++i) {
      hal::ImuSample sample;
      sample.packet = ++row_;
      sample.t_s = 0.01 * static_cast<double>(row_);
      sample.rate_rps = {1e-3F * static_cast<float>(row_ % 7), 0.0F, 0.0F};
      sample.accel_mps2 = stream_.accel_mps2;
      sample.accel_mps2[0] += 1e-3F * static_cast<float>(row_ % 5);
      sample.temp_c = 60.0F;
      samples.push_back(sample);
    }
    return {};
  }
  hal::ImuState state() const override { return hal::ImuState::streaming; }
  const std::optional<hal::ImuIdentity>& identity() const override { return identity_; }
  const hal::ImuStatistics& statistics() const override { return statistics_; }
  int wait_fd() const override { return 0; }
  std::string description() const override { return "rushing"; }

 private:
  const Stream& stream_;
  std::uint32_t row_ = 0;
  std::optional<hal::ImuIdentity> identity_ = hal::ImuIdentity{"SN1", "", "", true};
  hal::ImuStatistics statistics_;
};

class LabBench : public ::testing::Test {
 protected:
  void SetUp() override {
    std::string name = (fs::temp_directory_path() / "soak-lab-XXXXXX").string();
    ASSERT_NE(::mkdtemp(name.data()), nullptr);
    folder_ = name;
    auto catalog = db::Catalog::open(folder_);
    ASSERT_TRUE(catalog);
    catalog_ = std::make_unique<db::Catalog>(*std::move(catalog));
    config_.dew_point_c = 10.0;
    config_.dew_point_assumed = false;
    config_.chamber.link.poll_s = 1e-3;
    log_ = std::make_unique<EventLog>(*catalog_);
    station_ = std::make_unique<Station>(config_, *catalog_, *log_, chamber_, nullptr, nullptr);
    station_->campaign.name = "c1";
    station_->campaign.plan.procedure.name = "soak";
    station_->units.push_back(std::make_unique<UnitChannel>(
        Slot{}, "SN1", calib::UnitType{}, std::make_unique<RushingImu>(stream_), hal::Imu::Settings{}));
    station_->units.front()->begin_run();
  }
  void TearDown() override {
    station_.reset();
    fs::remove_all(folder_);
  }

  /// Turns of a loop as the engine's until `work` says true.
  template <class Work>
  int turns_until(Work work) {
    int turns = 0;
    for (; !work(); ++turns) {
      EXPECT_TRUE(station_->poll());
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    return turns;
  }

  fs::path folder_;
  std::unique_ptr<db::Catalog> catalog_;
  StationConfig config_;
  ObedientChamber chamber_;
  Stream stream_;
  std::unique_ptr<EventLog> log_;
  std::unique_ptr<Station> station_;
};

}  // namespace soak::station::lab_bench
