// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>
#include <vector>

#include "station/lab/power_cycle.h"
#include "station/lab/step_task.h"

namespace soak::station {
namespace {

constexpr double kShortestOff_s = 1.0;
constexpr double kYoung_s = 60.0;     ///< what the clock of a unit that was just switched on may show too much
constexpr double kPatience_s = 60.0;  ///< host time for all units to come up
constexpr double kRestart_s = 10.0;   ///< a unit that still streams so long (host time) after it was switched on ran on
constexpr double kSilent_s = 2.0;     ///< host time: it streams no more

using std::chrono::steady_clock;

/// Takes the units' supply away and gives it back, waits until each has said who it is and proved that it restarted,
/// opens the run file, lets the units warm up. A unit without proof is told and left out; in the pre-flight, and where
/// none is left, it ends the campaign.
class PowerOn : public StepTask {
 public:
  PowerOn(const Plan& plan, const Step& step)
      : run_(plan.runs[static_cast<std::size_t>(step.run)]),
        warm_up_s_(plan.procedure.warm_up_s),
        cycle_(std::max(plan.procedure.power_off_s, kShortestOff_s)) {}

  StepProgress poll(Lab& lab) override {
    switch (stage_) {
      case Stage::begin:
        return begin(lab);
      case Stage::cycle:
        return cycle(lab);
      case Stage::wait_up:
        return wait_up(lab);
      case Stage::warm_up:
        return warm_up(lab);
    }
    return StepProgress::running();
  }

 private:
  enum class Stage { begin, cycle, wait_up, warm_up };

  StepProgress begin(Lab& lab) {
    for (const auto& unit : lab.units) {
      unit->begin_run();
      before_[unit->serial()] = {unit->latest().has_value(), unit->power_on()};
      warm_up_s_ = std::max(warm_up_s_, unit->type().warm_up_s.value_or(0.0));
    }
    lab.expect_run();
    stage_ = Stage::cycle;
    return StepProgress::running();
  }

  StepProgress cycle(Lab& lab) {
    const auto done = cycle_.poll(lab);
    if (!done) return StepProgress::failed(done.error());
    if (*done) stage_ = Stage::wait_up;
    return StepProgress::running();
  }

  /// Host time since the units were switched on.
  [[nodiscard]] double on_for_s() const {
    return std::chrono::duration<double>(steady_clock::now() - cycle_.on_since()).count();
  }

  StepProgress wait_up(Lab& lab) {
    std::vector<UnitChannel*> missing;
    bool hope = false;
    for (const auto& unit : lab.units) {
      if (unit->streaming() && unit->imu().identity()) {
        if (auto wrong = wrong_identity(lab, *unit)) return StepProgress::failed(*std::move(wrong));
      }
      if (is_up(lab, *unit)) continue;
      missing.push_back(unit.get());
      hope = hope || may_come_up(lab, *unit);
    }
    if (missing.empty()) return open_run(lab);
    if (hope && on_for_s() < kPatience_s) return StepProgress::running();
    if (!run_.preflight && missing.size() < lab.units.size()) {
      for (UnitChannel* unit : missing) leave_out(lab, *unit);
      return open_run(lab);
    }
    std::vector<std::string> findings;
    for (const UnitChannel* unit : missing) findings.push_back(finding(lab, *unit));
    return StepProgress::failed({base::ErrorKind::device, fmt::format("{}", fmt::join(findings, "; ")), "power"});
  }

  void leave_out(Lab& lab, UnitChannel& unit) const {
    lab.log.add("unit", unit.serial(), fmt::format("left out of {}: {}", run_.label, finding(lab, unit)));
    lab.campaign.losses.push_back(fmt::format("{} in {}", unit.serial(), run_.label));
    unit.give_up();
  }

  /// A unit has proved that it restarted if its own count of power-ons rose, or if it was never heard before and its
  /// clock cannot have begun long before it was switched on.
  [[nodiscard]] bool is_up(const Lab& lab, const UnitChannel& unit) const {
    if (cycle_.faults().contains(unit.serial())) return false;
    if (!unit.streaming() || !unit.first_sample_s()) return false;
    const Before& before = before_.at(unit.serial());
    if (unit.power_on() != before.power_on) return true;
    const std::chrono::duration<double> on = unit.first_heard() - cycle_.on_since();
    const double since_switch_s = std::max(on.count(), 0.0) * lab.config.clock_rate;
    return !before.heard && *unit.first_sample_s() < since_switch_s + kYoung_s;
  }

  [[nodiscard]] static bool still_streams(const UnitChannel& unit) {
    return unit.streaming() && unit.silent_s() < kSilent_s;
  }

  /// Whether it makes sense to wait for a unit that is not up. People who switch by hand may be early.
  [[nodiscard]] bool may_come_up(const Lab& lab, const UnitChannel& unit) const {
    if (cycle_.faults().contains(unit.serial())) return false;
    const bool switched = lab.supply && unit.slot().power_output;
    return !(switched && on_for_s() >= kRestart_s && still_streams(unit));
  }

  /// Why a unit is not up, with its slot.
  [[nodiscard]] std::string finding(const Lab& lab, const UnitChannel& unit) const {
    const std::string who = fmt::format("unit {} in slot {}", unit.serial(), unit.slot().name);
    const auto fault = cycle_.faults().find(unit.serial());
    if (fault != cycle_.faults().end()) return fmt::format("{}: {}; switched off", who, fault->second);
    if (still_streams(unit)) {
      const std::string what = lab.supply && unit.slot().power_output
                                   ? fmt::format("output {} was", *unit.slot().power_output)
                                   : std::string("the units were");
      return fmt::format("{} did not restart: its own time ran on while {} off; another supply feeds it", who, what);
    }
    return fmt::format("{}: no proof within {:.0f} s that it was switched on{}{}", who, kPatience_s,
                       unit.trouble().empty() ? "" : "; ", unit.trouble());
  }

  static std::optional<base::Error> wrong_identity(const Lab& lab, const UnitChannel& unit) {
    const std::string& found = unit.imu().identity()->serial;
    if (found == unit.serial()) return std::nullopt;
    const auto other =
        std::find_if(lab.units.begin(), lab.units.end(), [&](const auto& u) { return u->serial() == found; });
    const std::string hint = other == lab.units.end()
                                 ? "correct the campaign's --unit or the wiring"
                                 : fmt::format("that one belongs into slot {}", (*other)->slot().name);
    return base::Error{base::ErrorKind::bad_input,
                       fmt::format("slot {} holds unit {}, not {}: {}", unit.slot().name, found, unit.serial(), hint),
                       "slot " + unit.slot().name};
  }

  StepProgress open_run(Lab& lab) {
    if (const auto begun = lab.begin_run(run_); !begun) return StepProgress::failed(begun.error());
    stage_ = Stage::warm_up;
    return StepProgress::running();
  }

  StepProgress warm_up(Lab& lab) {
    const auto active = lab.active_units();
    const bool warm = std::all_of(active.begin(), active.end(), [&](const UnitChannel* unit) {
      return unit->latest() && unit->latest()->t_s >= warm_up_s_;
    });
    return warm ? StepProgress::done() : StepProgress::running();
  }

  struct Before {
    bool heard = false;
    std::uint32_t power_on = 0;
  };

  PlannedRun run_;
  double warm_up_s_;
  PowerCycle cycle_;
  Stage stage_ = Stage::begin;
  std::map<std::string, Before> before_;
};

}  // namespace

std::unique_ptr<StepTask> make_power_on(const Plan& plan, const Step& step) {
  return std::make_unique<PowerOn>(plan, step);
}

}  // namespace soak::station
