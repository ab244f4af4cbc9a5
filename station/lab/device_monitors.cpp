// SPDX-License-Identifier: Apache-2.0
#include "station/lab/device_monitors.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace soak::station {
namespace {

using std::chrono::steady_clock;

constexpr std::chrono::milliseconds kShortestPoll{2};

constexpr std::chrono::seconds kStale{10};
constexpr int kFailuresUntilStale = 3;
constexpr int kMismatchesUntilLost = 3;
constexpr int kReadingsOfAlarm = 2;
constexpr double kSetPointTolerance_c = 0.5;
constexpr double kLeap_c = 5.0;               ///< ripple of the air, a door that opens
constexpr double kFastest_kps = 20.0 / 60.0;  ///< of the air: twice what the quickest chambers for units do

constexpr double kAtLimitShare = 0.98;  ///< of the current limit: what supplies set and measure differs by a per cent
constexpr int kReadingsAtLimit = 2;

}  // namespace

// --- ChamberMonitor ---------------------------------------------------------------------------------------------

bool ChamberMonitor::poll(double now_s) {
  const auto host_now = steady_clock::now();
  // By the host's clock too: a unit whose clock does not move must not leave the chamber unwatched.
  const bool due = !polled_s_ || now_s - *polled_s_ >= poll_s_ ||
                   std::chrono::duration<double>(host_now - polled_host_).count() >= poll_s_;
  if (!due || host_now - polled_host_ < kShortestPoll) return false;
  polled_s_ = now_s;
  auto reading = chamber_.read();
  polled_host_ = steady_clock::now();
  if (!reading) {
    note_failure(reading.error().message);
    return false;
  }
  const bool taken = take(*std::move(reading), now_s);
  if (!taken || alarmed_ == 1) polled_s_.reset();
  return taken;
}

void ChamberMonitor::note_failure(std::string why) {
  trouble_ = std::move(why);
  if (++failures_ >= kFailuresUntilStale || polled_host_ - heard_host_ > kStale) reading_.reset();
}

bool ChamberMonitor::take(hal::ChamberReading reading, double now_s) {
  alarmed_ = reading.alarms.empty() ? 0 : alarmed_ + 1;
  const double room_c = kLeap_c + kFastest_kps * (now_s - reading_s_);
  const auto is_near = [&](double before_c) { return std::abs(reading.air_c - before_c) <= room_c; };
  if (reading_ && !is_near(reading_->air_c) && !(leap_c_ && is_near(*leap_c_))) {
    leap_c_ = reading.air_c;
    reading_->alarms = std::move(reading.alarms);
    note_failure(fmt::format("its temperature leaps from {:+.1f} to {:+.1f} °C", reading_->air_c, *leap_c_));
    return false;
  }
  leap_c_.reset();
  failures_ = 0;
  trouble_.clear();
  heard_host_ = polled_host_;
  reading_ = std::move(reading);
  reading_s_ = now_s;
  air_.add(now_s, reading_->air_c);
  const bool as_expected =
      !expected_c_ || (reading_->running && std::abs(reading_->set_point_c - *expected_c_) <= kSetPointTolerance_c);
  mismatches_ = as_expected ? 0 : mismatches_ + 1;
  return true;
}

bool ChamberMonitor::lost_set_point() const { return mismatches_ >= kMismatchesUntilLost; }

std::vector<hal::ChamberAlarm> ChamberMonitor::alarms() const {
  return reading_ && alarmed_ >= kReadingsOfAlarm ? reading_->alarms : std::vector<hal::ChamberAlarm>{};
}

std::optional<double> ChamberMonitor::age_s() const {
  if (heard_host_ == steady_clock::time_point{}) return std::nullopt;
  return std::chrono::duration<double>(steady_clock::now() - heard_host_).count();
}

// --- UnitSupply -------------------------------------------------------------------------------------------------

bool is_at_limit(const hal::OutputReading& reading) {
  return reading.on && reading.current_a && reading.limit_a && *reading.limit_a > 0.0 &&
         *reading.current_a >= kAtLimitShare * *reading.limit_a;
}

base::Status UnitSupply::read(const std::vector<int>& outputs, double now_s) {
  const auto readings = power_.read(outputs);
  if (!readings) {
    readings_.clear();
    trouble_ = readings.error().message;
    return base::forward_error(readings);
  }
  trouble_.clear();
  for (const auto& [output, reading] : *readings) {
    readings_[output] = reading;
    at_limit_[output] = is_at_limit(reading) ? at_limit_[output] + 1 : 0;
    if (reading.on) off_since_.erase(output);
    if (!reading.on) note_off(output, now_s);
  }
  return {};
}

/// Where nobody saw it go off it counts from now on.
void UnitSupply::note_off(int output, double now_s) { off_since_.try_emplace(output, now_s, steady_clock::now()); }

bool UnitSupply::poll(const std::vector<int>& outputs, double now_s) {
  const bool due = !polled_s_ || now_s - *polled_s_ >= poll_s_;
  if (!due || steady_clock::now() - polled_host_ < kShortestPoll) return false;
  polled_s_ = now_s;
  const bool answered = read(outputs, now_s).has_value();
  polled_host_ = steady_clock::now();
  return answered;
}

std::optional<hal::OutputReading> UnitSupply::reading(int output) const {
  const auto found = readings_.find(output);
  return found == readings_.end() ? std::nullopt : std::optional(found->second);
}

void UnitSupply::forget() {
  readings_.clear();
  at_limit_.clear();
  polled_s_.reset();
  trouble_.clear();
}

base::Status UnitSupply::switch_off(int output, double now_s) {
  if (auto off = power_.set(output, false); !off) return off;
  note_off(output, now_s);
  switched_on_.erase(output);
  return {};
}

base::Status UnitSupply::switch_on(int output, const hal::SupplySettings& settings, double min_off_s, double now_s) {
  const auto off_s = off_for_s(output, now_s);
  if (!off_s || *off_s < min_off_s) {
    return base::fail(base::ErrorKind::internal, fmt::format("output {} was not off for {} s", output, min_off_s));
  }
  if (auto prepared = power_.prepare(output, settings); !prepared) return prepared;
  // It may be on although the answer does not come: from here on it is not known to be off.
  switched_on_.insert(output);
  at_limit_.erase(output);
  auto on = power_.set(output, true);
  if (on) off_since_.erase(output);
  return on;
}

std::optional<double> UnitSupply::off_for_s(int output, double now_s) const {
  const auto found = off_since_.find(output);
  if (found == off_since_.end()) return std::nullopt;
  const std::chrono::duration<double> host = steady_clock::now() - found->second.host;
  return std::min(now_s - found->second.process_s, host.count() * clock_rate_);
}

std::optional<std::string> UnitSupply::fault_of(int output) const {
  const auto found = readings_.find(output);
  if (found == readings_.end() || !switched_on_.contains(output)) return std::nullopt;
  const hal::OutputReading& reading = found->second;
  const std::string which = fmt::format("output {} of {}", output, description());
  if (reading.tripped) return fmt::format("a protection has switched off {}", which);
  if (!reading.on) return fmt::format("{} is off although it was switched on", which);
  const auto count = at_limit_.find(output);
  if (count == at_limit_.end() || count->second < kReadingsAtLimit) return std::nullopt;
  return fmt::format("{} stays at its current limit of {:g} A", which, *reading.limit_a);
}

}  // namespace soak::station
