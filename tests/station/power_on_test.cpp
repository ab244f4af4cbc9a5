// SPDX-License-Identifier: Apache-2.0
// Which unit has proved that it was off: judged by its own clock, which in a simulated laboratory runs fast.
#include <gtest/gtest.h>

#include <map>

#include "station/lab/steps.h"
#include "tests/station/lab_bench.h"

namespace soak::station {
namespace {

using namespace lab_bench;
using std::chrono::steady_clock;

constexpr double kRate = 20000.0;
constexpr std::chrono::milliseconds kSwitching{20};  ///< until the supply has answered; the unit starts at once

/// Outputs that are on since some moment; its answers take their time.
class SlowPower final : public hal::UnitPower {
 public:
  base::Status connect() override { return {}; }
  [[nodiscard]] base::Status check(int, const hal::SupplySettings&) const override { return {}; }
  base::Status prepare(int, const hal::SupplySettings&) override { return {}; }
  base::Status set(int output, bool on) override {
    if (on)
      on_since.try_emplace(output, steady_clock::now());
    else
      on_since.erase(output);
    std::this_thread::sleep_for(kSwitching);
    return {};
  }
  base::Result<std::map<int, hal::OutputReading>> read(const std::vector<int>& asked) override {
    std::map<int, hal::OutputReading> readings;
    for (const int output : asked) readings[output].on = on_since.contains(output);
    return readings;
  }
  [[nodiscard]] bool measures(int) const override { return false; }
  [[nodiscard]] std::string description() const override { return "slow"; }

  std::map<int, steady_clock::time_point> on_since;
};

/// Sends its clock, which started with its supply.
class ClockImu final : public hal::Imu {
 public:
  ClockImu(const SlowPower& power, int output, std::string serial)
      : power_(power), output_(output), identity_(hal::ImuIdentity{std::move(serial), "", "", true}) {}
  base::Status open(const Settings&) override { return {}; }
  void close() override {}
  base::Status poll(std::vector<hal::ImuSample>& samples) override {
    const auto since = power_.on_since.find(output_);
    if (since == power_.on_since.end()) return {};
    const std::chrono::duration<double> on = steady_clock::now() - since->second;
    hal::ImuSample sample;
    sample.packet = ++packet_;
    sample.t_s = kRate * on.count();
    sample.temp_c = 20.0F;
    samples.push_back(sample);
    return {};
  }
  hal::ImuState state() const override {
    return power_.on_since.contains(output_) ? hal::ImuState::streaming : hal::ImuState::silent;
  }
  const std::optional<hal::ImuIdentity>& identity() const override { return identity_; }
  const hal::ImuStatistics& statistics() const override { return statistics_; }
  int wait_fd() const override { return 0; }
  std::string description() const override { return "clock"; }

 private:
  const SlowPower& power_;
  int output_;
  std::uint32_t packet_ = 0;
  std::optional<hal::ImuIdentity> identity_;
  hal::ImuStatistics statistics_;
};

class PowerOnTest : public LabBench {
 protected:
  void SetUp() override {
    LabBench::SetUp();
    config_.clock_rate = kRate;
    station_ = std::make_unique<Station>(config_, *catalog_, *log_, chamber_, nullptr, &power_);
    station_->campaign.name = "c1";
    plan_.runs.resize(1);
    plan_.runs.front().label = "R01";
    plan_.runs.front().preflight = true;
  }

  void add_unit(const std::string& serial, int output) {
    Slot slot;
    slot.name = std::to_string(output);
    slot.power_output = output;
    station_->units.push_back(std::make_unique<UnitChannel>(
        slot, serial, calib::UnitType{}, std::make_unique<ClockImu>(power_, output, serial), hal::Imu::Settings{}));
  }

  StepProgress power_on() {
    Step step;
    step.kind = StepKind::power_on;
    const auto task = make_power_task(plan_, step);
    StepProgress progress = StepProgress::running();
    turns_until([&] {
      progress = task->poll(*station_);
      return progress.state != StepState::running;
    });
    return progress;
  }

  SlowPower power_;
  Plan plan_;
};

TEST_F(PowerOnTest, UnitsThatStartBeforeTheLastOneIsSwitchedOnHaveRestarted) {
  for (const int output : {1, 2, 3}) add_unit("SN" + std::to_string(output), output);
  const StepProgress progress = power_on();
  EXPECT_EQ(progress.state, StepState::done) << progress.error.message;
}

}  // namespace
}  // namespace soak::station
