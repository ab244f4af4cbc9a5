// SPDX-License-Identifier: Apache-2.0
#include "station/lab/power_cycle.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace soak::station {
namespace {

using std::chrono::steady_clock;

/// In-rush is over within milliseconds; the supply's own measurement may take tenths of a second.
constexpr std::chrono::seconds kBetweenLooks{1};
constexpr int kLooks = 2;

int output_of(const UnitChannel& unit) { return *unit.slot().power_output; }

}  // namespace

base::Result<bool> PowerCycle::poll(Lab& lab) {
  base::Result<Stage> next = stage_;
  switch (stage_) {
    case Stage::begin:
      next = begin(lab);
      break;
    case Stage::by_hand:
      if (lab.prompts.take_answer()) next = Stage::off;
      break;
    case Stage::off:
      next = switch_off(lab);
      break;
    case Stage::wait_off:
      if (was_off_long_enough(lab)) next = Stage::on;
      break;
    case Stage::on:
      next = switch_on(lab);
      break;
    case Stage::inrush:
      next = watch_inrush(lab);
      break;
    case Stage::done:
      break;
  }
  if (!next) return base::forward_error(next);
  if (*next != stage_) insistence_ = Insistence();
  stage_ = *next;
  return stage_ == Stage::done;
}

PowerCycle::Stage PowerCycle::begin(Lab& lab) {
  std::vector<std::string> by_hand;
  for (const auto& unit : lab.units) {
    if (lab.supply && unit->slot().power_output) {
      fed_.push_back(unit.get());
    } else {
      by_hand.push_back(unit->slot().name);
    }
  }
  if (by_hand.empty()) return Stage::off;
  const std::string which = fed_.empty() ? "units" : fmt::format("units in slots {}", fmt::join(by_hand, ", "));
  lab.prompts.ask(fmt::format("Switch the {} off for at least {:.0f} s, then on again, and confirm.", which, off_s_));
  return Stage::by_hand;
}

base::Result<PowerCycle::Stage> PowerCycle::switch_off(Lab& lab) {
  if (fed_.empty()) {
    on_since_ = steady_clock::now();
    return Stage::done;
  }
  std::vector<int> outputs;
  for (const UnitChannel* unit : fed_) outputs.push_back(output_of(*unit));
  const auto off = insistence_.attempt([&]() -> base::Status {
    if (auto known = lab.supply->read(outputs, lab.now_s()); !known) return known;
    for (const int output : outputs) {
      if (!lab.supply->reading(output).value_or(hal::OutputReading{}).on) continue;
      if (auto status = lab.supply->switch_off(output, lab.now_s()); !status) return status;
    }
    return {};
  });
  if (!off) return base::forward_error(off);
  return *off ? Stage::wait_off : Stage::off;
}

bool PowerCycle::was_off_long_enough(const Lab& lab) const {
  for (const UnitChannel* unit : fed_) {
    if (lab.supply->off_for_s(output_of(*unit), lab.now_s()).value_or(0.0) < off_s_) return false;
  }
  return true;
}

base::Result<PowerCycle::Stage> PowerCycle::switch_on(Lab& lab) {
  const auto on = insistence_.attempt([&]() -> base::Status {
    for (; next_ < fed_.size(); ++next_) {
      if (auto status = switch_on_next(lab); !status) return status;
    }
    return {};
  });
  if (!on) return base::forward_error(on);
  if (!*on) return Stage::on;
  on_since_ = steady_clock::now();
  return measured_outputs(lab).empty() ? Stage::done : Stage::inrush;
}

/// An output that goes off again while it is being switched on is the unit's fault, and must not be tried for half a
/// minute.
base::Status PowerCycle::switch_on_next(Lab& lab) {
  const UnitChannel& unit = *fed_[next_];
  const int output = output_of(unit);
  auto on = lab.supply->switch_on(output, unit.slot().supply, off_s_, lab.now_s());
  if (on || on.error().kind != base::ErrorKind::device) return on;
  if (!lab.supply->read({output}, lab.now_s())) return on;
  const bool settled = find_fault(lab, unit) || lab.supply->reading(output).value_or(hal::OutputReading{}).on;
  return settled ? base::Status{} : on;
}

std::vector<int> PowerCycle::measured_outputs(const Lab& lab) const {
  std::vector<int> outputs;
  for (const UnitChannel* unit : fed_) {
    const bool is_on = !faults_.contains(unit->serial());
    if (is_on && lab.supply->measures(output_of(*unit))) outputs.push_back(output_of(*unit));
  }
  return outputs;
}

PowerCycle::Stage PowerCycle::watch_inrush(Lab& lab) {
  if (steady_clock::now() - on_since_ < kBetweenLooks * (looks_ + 1)) return Stage::inrush;
  // A supply that cannot say how it is has still switched on: the units will show it.
  if (const auto outputs = measured_outputs(lab); !outputs.empty()) (void)lab.supply->read(outputs, lab.now_s());
  for (const UnitChannel* unit : fed_) {
    if (!faults_.contains(unit->serial())) find_fault(lab, *unit);
  }
  return ++looks_ < kLooks ? Stage::inrush : Stage::done;
}

bool PowerCycle::find_fault(Lab& lab, const UnitChannel& unit) {
  const auto trouble = lab.supply->trouble(output_of(unit));
  if (!trouble) return false;
  faults_[unit.serial()] = *trouble;
  lab.cut_off(unit);
  return true;
}

}  // namespace soak::station
