// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/lab/simulated_chamber.h"

#include <algorithm>
#include <initializer_list>
#include <string_view>
#include <utility>
#include <vector>

#include "base/random.h"
#include "hal/sim/unit/draws.h"

namespace soak::hal::sim {
namespace {

// Enumeration values of the controller.
constexpr int kBoth = 13;
constexpr int kCelsius = 15;
constexpr int kError = 28;
constexpr int kFail = 32;
constexpr int kHigh = 37;
constexpr int kRampPerHour = 39;
constexpr int kRampPerMinute = 57;
constexpr int kNone = 61;
constexpr int kOff = 62;
constexpr int kOn = 63;
constexpr int kAuto = 10;
constexpr int kProcessAlarm = 76;
constexpr int kAtSetPoint = 85;
constexpr int kAtStart = 88;
constexpr int kOk = 138;

// Registers of data map 1, loop 1 and alarm 1.
constexpr int kPartNumber = 16;
constexpr int kDeviceStatus = 90;
constexpr int kAlarmType = 1330;
constexpr int kAlarmSides = 1332;
constexpr int kAlarmHighSetPoint = 1334;
constexpr int kAlarmLowSetPoint = 1336;
constexpr int kAlarmState = 1356;
constexpr int kAlarmCount = 6;  // alarms 2 to 6 are not set up
constexpr int kRegistersPerAlarm = 100;
constexpr int kControlModeRequest = 2730;
constexpr int kSetPointLow = 2774;
constexpr int kSetPointHigh = 2776;
constexpr int kSetPoint = 2782;
constexpr int kRampAction = 2794;
constexpr int kRampScale = 2796;
constexpr int kRampRate = 2798;
constexpr int kOutputPower = 2808;
constexpr int kWorkingSetPoint = 2810;
constexpr int kControlModeActual = 2814;
constexpr int kProcessValue = 2820;
constexpr int kCommsUnits = 6730;
constexpr int kSerialUnits = 14080;
constexpr int kLimitError = 11250;
constexpr int kLimitStatus = 11264;
constexpr int kLimitState = 11288;
constexpr int kEvents1To4 = 16594;
constexpr int kEvents5To8 = 16822;

constexpr std::string_view kPartNumberText = "F4T1L1EAA1B1AAA";
constexpr double kSensorLow_c = -100.0;  // what the controller's sensor input covers
constexpr double kSensorHigh_c = 250.0;

RegisterTable::NumberWriter one_of(std::initializer_list<int> codes, std::function<void(int)> store) {
  return {[codes = std::vector<int>(codes)](int code) {
            return std::find(codes.begin(), codes.end(), code) != codes.end();
          },
          std::move(store)};
}

RegisterTable::ValueWriter between(std::function<double()> low, std::function<double()> high,
                                   std::function<void(double)> store) {
  return {[low = std::move(low), high = std::move(high)](double value) { return value >= low() && value <= high(); },
          std::move(store)};
}

RegisterTable::ValueWriter within_sensor_range(std::function<void(double)> store) {
  return between([] { return kSensorLow_c; }, [] { return kSensorHigh_c; }, std::move(store));
}

}  // namespace

SimulatedChamber::SimulatedChamber(const LabMagnitudes& magnitudes, std::uint64_t seed)
    : magnitudes_(magnitudes.controller),
      seed_(seed),
      plant_(magnitudes.plant),
      controller_(magnitudes.controller, magnitudes.plant.room_c),
      alarm_(magnitudes.controller.alarm_high_c),
      limit_(magnitudes.controller.limit_high_c),
      set_point_low_c_(magnitudes.controller.set_point_low_c),
      set_point_high_c_(magnitudes.controller.set_point_high_c),
      alarm_low_c_(magnitudes.controller.alarm_low_c),
      ramp_action_(kOff),
      ramp_scale_(kRampPerMinute) {
  events_.fill(kOff);
  add_loop_registers();
  add_ramp_registers();
  add_alarm_registers();
  add_identity_registers();
}

void SimulatedChamber::step(double dt_s) {
  ++step_;
  controller_.step(dt_s, plant_.air_c());
  plant_.step(dt_s, applied_output());
  alarm_.check(controller_.sensed_c(), controller_.is_on());
  limit_.check(plant_.air_c(), controller_.is_on());
}

double SimulatedChamber::applied_output() const {
  return limit_.tripped() ? std::min(controller_.output(), 0.0) : controller_.output();
}

double SimulatedChamber::process_value_c() const {
  const double noise = base::hashed_gaussian(seed_, stream_of(Purpose::lab_chamber_sensor), step_);
  return controller_.sensed_c() + magnitudes_.sensor_noise_sigma_c * noise;
}

void SimulatedChamber::apply_ramp() {
  RampSettings ramp;
  ramp.at_start = ramp_action_ == kAtStart || ramp_action_ == kBoth;
  ramp.at_set_point = ramp_action_ == kAtSetPoint || ramp_action_ == kBoth;
  ramp.rate_kps = ramp_rate_ / (ramp_scale_ == kRampPerHour ? 3600.0 : 60.0);
  controller_.set_ramp(ramp);
}

void SimulatedChamber::add_loop_registers() {
  const auto mode = [this] { return controller_.is_on() ? kAuto : kOff; };
  registers_.add_number(kControlModeRequest, 2, mode,
                        one_of({kOff, kAuto}, [this](int code) { controller_.switch_control(code == kAuto); }));
  registers_.add_number(kControlModeActual, 2, mode);
  registers_.add_value(kProcessValue, [this] { return process_value_c(); });
  registers_.add_value(kWorkingSetPoint, [this] { return controller_.working_set_point_c(); });
  registers_.add_value(kOutputPower, [this] { return 100.0 * applied_output(); });
  registers_.add_value(kSetPoint, [this] { return controller_.set_point_c(); },
                       {[this](double value) { return takes_set_point(value); },
                        [this](double value) { controller_.set_set_point_c(value); }});
  registers_.add_value(
      kSetPointLow, [this] { return set_point_low_c_; },
      between([] { return kSensorLow_c; }, [this] { return set_point_high_c_; },
              [this](double value) { set_point_low_c_ = value; }));
  registers_.add_value(
      kSetPointHigh, [this] { return set_point_high_c_; },
      between([this] { return set_point_low_c_; }, [] { return kSensorHigh_c; },
              [this](double value) { set_point_high_c_ = value; }));
}

void SimulatedChamber::add_ramp_registers() {
  const auto setting = [this](int& target) {
    return [this, &target](int code) {
      target = code;
      apply_ramp();
    };
  };
  registers_.add_number(
      kRampAction, 2, [this] { return ramp_action_; },
      one_of({kOff, kAtStart, kAtSetPoint, kBoth}, setting(ramp_action_)));
  registers_.add_number(
      kRampScale, 2, [this] { return ramp_scale_; }, one_of({kRampPerMinute, kRampPerHour}, setting(ramp_scale_)));
  registers_.add_value(
      kRampRate, [this] { return ramp_rate_; },
      between([] { return 0.0; }, [] { return 9999.0; },
              [this](double rate) {
                ramp_rate_ = rate;
                apply_ramp();
              }));
}

void SimulatedChamber::add_alarm_registers() {
  registers_.add_number(kAlarmType, 2, [] { return kProcessAlarm; });
  registers_.add_number(kAlarmSides, 2, [] { return kHigh; });
  registers_.add_value(
      kAlarmHighSetPoint, [this] { return alarm_.high_c(); },
      within_sensor_range([this](double value) { alarm_.set_high_c(value); }));
  registers_.add_value(
      kAlarmLowSetPoint, [this] { return alarm_low_c_; },
      within_sensor_range([this](double value) { alarm_low_c_ = value; }));
  registers_.add_number(kAlarmState, 2, [this] { return alarm_.tripped() ? kHigh : kNone; });
  for (int other = 1; other < kAlarmCount; ++other) {
    registers_.add_number(kAlarmState + other * kRegistersPerAlarm, 2, [] { return kNone; });
  }
  registers_.add_number(kLimitError, 2, [this] { return limit_.tripped() ? kError : kNone; });
  registers_.add_number(kLimitStatus, 2, [this] { return limit_.tripped() ? kFail : kOk; });
  registers_.add_number(kLimitState, 2, [this] { return limit_.tripped() ? kError : kNone; });
}

void SimulatedChamber::add_identity_registers() {
  for (std::size_t i = 0; i < kPartNumberText.size(); ++i) {
    registers_.add_number(kPartNumber + static_cast<int>(i), 1, [i] { return static_cast<int>(kPartNumberText[i]); });
  }
  registers_.add_number(kDeviceStatus, 2, [] { return kOk; });
  registers_.add_number(kCommsUnits, 2, [] { return kCelsius; });
  registers_.add_number(kSerialUnits, 2, [] { return kCelsius; });
  for (std::size_t i = 0; i < events_.size(); ++i) {
    const int place = static_cast<int>(i);
    const int address = place < 4 ? kEvents1To4 + 2 * place : kEvents5To8 + 2 * (place - 4);
    registers_.add_number(
        address, 2, [this, i] { return events_[i]; }, one_of({kOff, kOn}, [this, i](int code) { events_[i] = code; }));
  }
}

}  // namespace soak::hal::sim
