// SPDX-License-Identifier: Apache-2.0
#include "station/lab/unit_supply.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace soak::station {
namespace {

using std::chrono::steady_clock;

constexpr std::chrono::milliseconds kSoonest{2};
constexpr double kAtLimit = 0.98;  ///< share of the current limit: what supplies set and measure differs by a per cent
constexpr int kStaysAtLimit = 2;

bool is_at_limit(const hal::OutputReading& reading) {
  return reading.on && reading.current_a && reading.limit_a && *reading.limit_a > 0.0 &&
         *reading.current_a >= kAtLimit * *reading.limit_a;
}

}  // namespace

void UnitSupply::take(int output, const hal::OutputReading& reading, double now_s) {
  readings_[output] = reading;
  at_limit_[output] = is_at_limit(reading) ? at_limit_[output] + 1 : 0;
  if (reading.on) {
    off_since_.erase(output);
  } else {
    note_off(output, now_s);
  }
}

/// Where nobody saw it go off it counts from now on.
void UnitSupply::note_off(int output, double now_s) { off_since_.try_emplace(output, now_s, steady_clock::now()); }

base::Status UnitSupply::read(const std::vector<int>& outputs, double now_s) {
  const auto readings = power_.read(outputs);
  if (!readings) {
    readings_.clear();
    fault_ = readings.error().message;
    return base::forward_error(readings);
  }
  fault_.clear();
  for (const auto& [output, reading] : *readings) take(output, reading, now_s);
  return {};
}

bool UnitSupply::poll(const std::vector<int>& outputs, double now_s) {
  const auto host_now = steady_clock::now();
  const bool due = !polled_s_ || now_s - *polled_s_ >= poll_s_;
  if (!due || host_now - polled_host_ < kSoonest) return false;
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
  fault_.clear();
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
  // It may be on although the answer does not come: from here on nobody knows it to be off.
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

std::optional<std::string> UnitSupply::trouble(int output) const {
  const auto found = readings_.find(output);
  if (found == readings_.end() || !switched_on_.contains(output)) return std::nullopt;
  const hal::OutputReading& reading = found->second;
  const std::string which = fmt::format("output {} of {}", output, description());
  if (reading.tripped) return fmt::format("a protection has switched off {}", which);
  if (!reading.on) return fmt::format("{} is off although it was switched on", which);
  const auto count = at_limit_.find(output);
  if (count == at_limit_.end() || count->second < kStaysAtLimit) return std::nullopt;
  return fmt::format("{} stays at its current limit of {:g} A", which, *reading.limit_a);
}

}  // namespace soak::station
