// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "station/lab/steps/step_task.h"

namespace soak::station {
namespace {

constexpr double kShortestOff_s = 1.0;
constexpr double kYoung_s = 60.0;     ///< what the clock of a unit that was just switched on may show too much
constexpr double kPatience_s = 60.0;  ///< host time for all units to come up

using std::chrono::steady_clock;

/// Switches the units off and on, waits until each has said who it is and proved that it restarted, opens the run file,
/// lets the units warm up.
class PowerOn : public StepTask {
 public:
  PowerOn(const Plan& plan, const Step& step)
      : run_(plan.runs[static_cast<std::size_t>(step.run)]),
        warm_up_s_(plan.procedure.warm_up_s),
        off_s_(std::max(plan.procedure.power_off_s, kShortestOff_s)) {}

  StepProgress poll(Lab& lab) override {
    switch (stage_) {
      case Stage::begin:
        return begin(lab);
      case Stage::switch_off:
        return switch_off(lab);
      case Stage::wait_off:
        return wait_off(lab);
      case Stage::switch_on:
        return switch_on(lab);
      case Stage::by_hand:
        return by_hand(lab);
      case Stage::wait_up:
        return wait_up(lab);
      case Stage::warm_up:
        return warm_up(lab);
    }
    return StepProgress::running();
  }

 private:
  enum class Stage { begin, switch_off, wait_off, switch_on, by_hand, wait_up, warm_up };

  StepProgress begin(Lab& lab) {
    for (const auto& unit : lab.units) {
      unit->begin_run();
      before_[unit->serial()] = {unit->latest().has_value(), unit->power_on()};
      warm_up_s_ = std::max(warm_up_s_, unit->type().warm_up_s.value_or(0.0));
    }
    lab.expect_run();
    if (lab.power) {
      stage_ = Stage::switch_off;
    } else {
      lab.prompts.ask(fmt::format("Switch the units off for at least {:.0f} s, then on again, and confirm.", off_s_));
      stage_ = Stage::by_hand;
    }
    return StepProgress::running();
  }

  /// Does `command` with the relay output of each unit that has one.
  template <class Command>
  base::Result<bool> with_outputs(Lab& lab, Command command) {
    return insistence_.attempt([&]() -> base::Status {
      for (const auto& unit : lab.units) {
        if (!unit->slot().power_output) continue;
        if (auto status = command(*unit->slot().power_output); !status) return status;
      }
      return {};
    });
  }

  StepProgress switch_off(Lab& lab) {
    bool any_on = false;
    const auto off = with_outputs(lab, [&](int output) -> base::Status {
      const auto on = lab.power->is_on(output);
      if (!on) return base::forward_error(on);
      any_on = any_on || *on;
      return *on ? lab.power->set(output, false) : base::Status{};
    });
    if (!off) return StepProgress::failed(off.error());
    if (!*off) return StepProgress::running();
    off_at_s_ = lab.now_s();
    // Units that were off already have been so since the last run.
    if (!any_on) off_s_ = 0.0;
    stage_ = Stage::wait_off;
    return StepProgress::running();
  }

  StepProgress wait_off(Lab& lab) {
    if (lab.now_s() - off_at_s_ < off_s_) return StepProgress::running();
    insistence_ = Insistence();
    stage_ = Stage::switch_on;
    return StepProgress::running();
  }

  StepProgress switch_on(Lab& lab) {
    const auto on = with_outputs(lab, [&](int output) { return lab.power->set(output, true); });
    if (!on) return StepProgress::failed(on.error());
    if (*on) wait_from_now();
    return StepProgress::running();
  }

  StepProgress by_hand(Lab& lab) {
    if (lab.prompts.take_answer()) wait_from_now();
    return StepProgress::running();
  }

  void wait_from_now() {
    since_ = steady_clock::now();
    stage_ = Stage::wait_up;
  }

  StepProgress wait_up(Lab& lab) {
    std::string missing;
    for (const auto& unit : lab.units) {
      if (unit->streaming() && unit->imu().identity()) {
        if (auto wrong = wrong_identity(lab, *unit)) return StepProgress::failed(*std::move(wrong));
      }
      if (!is_up(lab, *unit)) missing += missing.empty() ? unit->serial() : ", " + unit->serial();
    }
    if (missing.empty()) return open_run(lab);
    if (std::chrono::duration<double>(steady_clock::now() - since_).count() < kPatience_s)
      return StepProgress::running();
    if (!run_.preflight && leave_out_missing(lab)) return open_run(lab);
    return StepProgress::failed({base::ErrorKind::device,
                                 fmt::format("no proof within {:.0f} s that these units were switched on: {}{}",
                                             kPatience_s, missing, troubles(lab)),
                                 "power"});
  }

  /// Goes on without the units that do not come up; false where that would be all of them.
  bool leave_out_missing(Lab& lab) {
    const auto up = [&](const auto& unit) { return is_up(lab, *unit); };
    if (std::none_of(lab.units.begin(), lab.units.end(), up)) return false;
    for (const auto& unit : lab.units) {
      if (is_up(lab, *unit)) continue;
      lab.log.add("unit", unit->serial(),
                  fmt::format("left out of {}: no proof within {:.0f} s that it was switched on; {}", run_.label,
                              kPatience_s, unit->trouble()));
      lab.campaign.losses.push_back(fmt::format("{} in {}", unit->serial(), run_.label));
      unit->give_up();
    }
    return true;
  }

  /// A unit has proved that it restarted if its own count of power-ons rose, or if it was never heard before and its
  /// clock cannot have begun long before it was switched on.
  [[nodiscard]] bool is_up(const Lab& lab, const UnitChannel& unit) const {
    if (!unit.streaming() || !unit.first_sample_s()) return false;
    const Before& before = before_.at(unit.serial());
    if (unit.power_on() != before.power_on) return true;
    const std::chrono::duration<double> on = unit.first_heard() - since_;
    const double since_switch_s = std::max(on.count(), 0.0) * lab.config.clock_rate;
    return !before.heard && *unit.first_sample_s() < since_switch_s + kYoung_s;
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

  static std::string troubles(const Lab& lab) {
    std::string text;
    for (const auto& unit : lab.units) {
      if (!unit->trouble().empty()) text += fmt::format("; {}: {}", unit->serial(), unit->trouble());
    }
    return text;
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
  double off_s_;
  Stage stage_ = Stage::begin;
  Insistence insistence_;
  double off_at_s_ = 0.0;
  steady_clock::time_point since_{};
  std::map<std::string, Before> before_;
};

}  // namespace

std::unique_ptr<StepTask> make_power_on(const Plan& plan, const Step& step) {
  return std::make_unique<PowerOn>(plan, step);
}

}  // namespace soak::station
