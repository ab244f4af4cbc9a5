// SPDX-License-Identifier: Apache-2.0
// Power-on at the beginning of a run and power-off at its end.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>
#include <vector>

#include "station/lab/steps.h"

namespace soak::station {
namespace {

using std::chrono::steady_clock;

/// In-rush is over within milliseconds; the supply's own measurement may take tenths of a second.
constexpr std::chrono::seconds kInrushCheckInterval{1};
constexpr int kInrushChecks = 2;

constexpr std::chrono::seconds kSealInterval{1};
constexpr double kSealAtPlateau_s =
    600.0;  ///< process time that a run may take to be sealed while the chamber is driven
constexpr double kShortestOff_s = 1.0;
constexpr double kClockAfterPowerOn_s = 60.0;  ///< largest that the clock of a unit that was just switched on may show
constexpr double kLag_s = 0.02;  ///< host time that a laboratory whose clock runs at another rate may be behind
// Host time after the units were switched on.
constexpr double kPowerOnTimeout_s = 60.0;  ///< for all units to send
constexpr double kRestart_s = 10.0;         ///< a unit that still sends by then was never off
constexpr double kIdentify_s = 20.0;        ///< for the others to say who they are where one is not who it should be
constexpr double kSilent_s = 2.0;           ///< without a sample: the unit has stopped sending

int output_of(const UnitChannel& unit) { return *unit.slot().power_output; }

/// Takes the supply from all units and gives it back: by the outputs of their slots, by hand where a slot has none.
class PowerCycle {
 public:
  /// `off_s`: process time that an output is off at least, whoever switched it off.
  explicit PowerCycle(double off_s) : off_s_(off_s) {}

  /// True once all have their supply, but for those of faults(). An error: the switch does not answer.
  [[nodiscard]] base::Result<bool> poll(Station& station) {
    const auto next = next_stage(station);
    if (!next) return base::forward_error(next);
    if (*next != stage_) retry_ = CommandRetry();
    stage_ = *next;
    return stage_ == Stage::done;
  }

  /// When the last one was switched on.
  [[nodiscard]] steady_clock::time_point on_since() const { return on_since_; }
  /// When a unit was switched on at the earliest: its clock did not run before.
  [[nodiscard]] steady_clock::time_point on_since(const UnitChannel& unit) const {
    const auto own = on_since_of_.find(&unit);
    return own == on_since_of_.end() ? on_since_ : own->second;
  }
  /// Why a unit has no supply, and that its output is off: it went off by itself or stayed at its current limit.
  [[nodiscard]] const std::map<std::string, std::string>& faults() const { return faults_; }
  [[nodiscard]] bool is_faulty(const UnitChannel& unit) const { return faults_.contains(unit.serial()); }

 private:
  enum class Stage : std::uint8_t { begin, by_hand, off, wait_off, on, inrush, done };

  base::Result<Stage> next_stage(Station& station) {
    switch (stage_) {
      case Stage::begin:
        return begin(station);
      case Stage::by_hand:
        return station.prompts.take_answer() ? Stage::off : stage_;
      case Stage::off:
        return switch_off(station);
      case Stage::wait_off:
        return was_off_long_enough(station) ? Stage::on : stage_;
      case Stage::on:
        return switch_on(station);
      case Stage::inrush:
        return check_inrush(station);
      case Stage::done:
        break;
    }
    return stage_;
  }

  Stage begin(Station& station) {
    std::vector<std::string> by_hand;
    for (const auto& unit : station.units) {
      if (station.supply && unit->slot().power_output) {
        switched_.push_back(unit.get());
      } else {
        by_hand.push_back(unit->slot().name);
      }
    }
    if (by_hand.empty()) return Stage::off;
    const std::string which = switched_.empty() ? "units" : fmt::format("units in slots {}", fmt::join(by_hand, ", "));
    station.prompts.ask(
        {fmt::format("Switch the {} off for at least {:.0f} s, then on again, and confirm.", which, off_s_),
         "power",
         {{"off_s", off_s_}, {"slots", by_hand}}});
    return Stage::by_hand;
  }

  base::Result<Stage> switch_off(Station& station) {
    if (switched_.empty()) {
      on_since_ = steady_clock::now();
      return Stage::done;
    }
    std::vector<int> outputs;
    for (const UnitChannel* unit : switched_) outputs.push_back(output_of(*unit));
    const auto off = retry_.attempt([&]() -> base::Status {
      if (auto read = station.supply->read(outputs, station.now_s()); !read) return read;
      for (const int output : outputs) {
        if (!station.supply->is_on(output)) continue;
        if (auto status = station.supply->switch_off(output, station.now_s()); !status) return status;
      }
      return {};
    });
    if (!off) return base::forward_error(off);
    return *off ? Stage::wait_off : Stage::off;
  }

  [[nodiscard]] bool was_off_long_enough(const Station& station) const {
    return std::all_of(switched_.begin(), switched_.end(), [&](const UnitChannel* unit) {
      return station.supply->off_for_s(output_of(*unit), station.now_s()).value_or(0.0) >= off_s_;
    });
  }

  base::Result<Stage> switch_on(Station& station) {
    const auto on = retry_.attempt([&]() -> base::Status {
      for (; next_ < switched_.size(); ++next_) {
        if (auto status = switch_on_unit(station, *switched_[next_]); !status) return status;
      }
      return {};
    });
    if (!on) return base::forward_error(on);
    if (!*on) return Stage::on;
    on_since_ = steady_clock::now();
    return measured_outputs(station).empty() ? Stage::done : Stage::inrush;
  }

  /// An output that goes off again while it is being switched on shows a fault of the unit and must not be tried again
  /// and again.
  base::Status switch_on_unit(Station& station, const UnitChannel& unit) {
    const int output = output_of(unit);
    on_since_of_.try_emplace(&unit, steady_clock::now());
    auto on = station.supply->switch_on(output, unit.slot().supply, off_s_, station.now_s());
    if (on || on.error().kind != base::ErrorKind::device) return on;
    if (!station.supply->read({output}, station.now_s())) return on;
    return find_fault(station, unit) || station.supply->is_on(output) ? base::Status{} : on;
  }

  [[nodiscard]] std::vector<int> measured_outputs(const Station& station) const {
    std::vector<int> outputs;
    for (const UnitChannel* unit : switched_) {
      if (!is_faulty(*unit) && station.supply->measures(output_of(*unit))) outputs.push_back(output_of(*unit));
    }
    return outputs;
  }

  Stage check_inrush(Station& station) {
    if (steady_clock::now() - on_since_ < kInrushCheckInterval * (checks_ + 1)) return Stage::inrush;
    // A supply that cannot be read has still switched on: the units will show it.
    if (const auto outputs = measured_outputs(station); !outputs.empty()) {
      (void)station.supply->read(outputs, station.now_s());
    }
    for (const UnitChannel* unit : switched_) {
      if (!is_faulty(*unit)) find_fault(station, *unit);
    }
    return ++checks_ < kInrushChecks ? Stage::inrush : Stage::done;
  }

  bool find_fault(Station& station, const UnitChannel& unit) {
    const auto fault = station.supply->fault_of(output_of(unit));
    if (!fault) return false;
    faults_[unit.serial()] = *fault;
    station.cut_off(unit);
    return true;
  }

  double off_s_;
  Stage stage_ = Stage::begin;
  std::vector<const UnitChannel*> switched_;  ///< the units whose slot has an output
  std::size_t next_ = 0;                      ///< of switched_, the next one to be switched on
  CommandRetry retry_;
  steady_clock::time_point on_since_{};
  std::map<const UnitChannel*, steady_clock::time_point> on_since_of_;
  int checks_ = 0;  ///< of the in-rush
  std::map<std::string, std::string> faults_;
};

/// Takes the units' supply away and gives it back, waits until each has identified itself and proved that it
/// restarted, opens the run file, lets the units warm up. Where slots hold other units than was said it asks for the
/// right ones and begins again. A unit without proof is reported and left out; in the pre-flight, and where none is
/// left, it ends the campaign.
class PowerOn : public StepTask {
 public:
  PowerOn(const Plan& plan, const Step& step)
      : run_(plan.runs[static_cast<std::size_t>(step.run)]),
        warm_up_s_(plan.procedure.warm_up_s),
        off_s_(std::max(plan.procedure.power_off_s, kShortestOff_s)),
        cycle_(off_s_) {}

  StepProgress poll(Station& station) override {
    switch (stage_) {
      case Stage::begin:
        return begin(station);
      case Stage::cycle:
        return cycle(station);
      case Stage::identify:
        return identify(station);
      case Stage::wrong_units:
        return wait_for_right_units(station);
      case Stage::warm_up:
        return warm_up(station);
    }
    return StepProgress::running();
  }

 private:
  enum class Stage { begin, cycle, identify, wrong_units, warm_up };

  StepProgress begin(Station& station) {
    cycle_ = PowerCycle(off_s_);
    for (const auto& unit : station.units) {
      unit->begin_run();
      before_[unit->serial()] = {unit->latest().has_value(), unit->power_on()};
      warm_up_s_ = std::max(warm_up_s_, unit->type().warm_up_s.value_or(0.0));
    }
    station.expect_run();
    stage_ = Stage::cycle;
    return StepProgress::running();
  }

  StepProgress cycle(Station& station) {
    const auto done = cycle_.poll(station);
    if (!done) return StepProgress::failed(done.error());
    if (*done) stage_ = Stage::identify;
    return StepProgress::running();
  }

  /// Host time since the units were switched on.
  [[nodiscard]] double on_for_s() const {
    return std::chrono::duration<double>(steady_clock::now() - cycle_.on_since()).count();
  }

  StepProgress identify(Station& station) {
    std::vector<UnitChannel*> missing;
    bool worth_waiting = false;
    if (const auto wrong = wrong_identities(station); !wrong.empty()) {
      // One question for all slots: those that are slower to say who they are have their time.
      const bool all_are_known = std::ranges::all_of(station.units, [](const auto& unit) { return is_known(*unit); });
      return all_are_known || on_for_s() >= kIdentify_s ? ask_for_right_units(station, wrong) : StepProgress::running();
    }
    for (const auto& unit : station.units) {
      if (has_restarted(station, *unit)) continue;
      missing.push_back(unit.get());
      worth_waiting = worth_waiting || may_restart(station, *unit);
    }
    if (missing.empty()) return open_run(station);
    if (worth_waiting && on_for_s() < kPowerOnTimeout_s) return StepProgress::running();
    if (!run_.preflight && missing.size() < station.units.size()) {
      for (UnitChannel* unit : missing) leave_out(station, *unit);
      return open_run(station);
    }
    std::vector<std::string> findings;
    for (const UnitChannel* unit : missing) findings.push_back(finding(station, *unit));
    return StepProgress::device_failed(fmt::format("{}", fmt::join(findings, "; ")), "power");
  }

  void leave_out(Station& station, UnitChannel& unit) const {
    const std::string why = finding(station, unit);
    station.log.add("unit", unit.serial(), fmt::format("left out of {}: {}", run_.label, why));
    station.campaign.missing_units.push_back(fmt::format("{} in {}", unit.serial(), run_.label));
    unit.drop(why);
  }

  /// A unit has proved that it restarted if its own count of power-ons rose, or if it was never heard before and its
  /// clock cannot have begun long before it was switched on.
  [[nodiscard]] bool has_restarted(const Station& station, const UnitChannel& unit) const {
    if (cycle_.is_faulty(unit) || !unit.streaming() || !unit.first_sample_s()) return false;
    const Before& before = before_.at(unit.serial());
    if (unit.power_on() != before.power_on) return true;
    const std::chrono::duration<double> on = unit.first_heard() - cycle_.on_since(unit);
    const double since_switch_s = (std::max(on.count(), 0.0) + kLag_s) * station.config.clock_rate;
    return !before.heard && *unit.first_sample_s() < since_switch_s + kClockAfterPowerOn_s;
  }

  [[nodiscard]] static bool is_switched(const Station& station, const UnitChannel& unit) {
    return station.supply && unit.slot().power_output;
  }

  [[nodiscard]] static bool still_sends(const UnitChannel& unit) {
    return unit.streaming() && unit.silent_s() < kSilent_s;
  }

  /// Whether a unit that has not restarted is worth waiting for. People who switch by hand may be early.
  [[nodiscard]] bool may_restart(const Station& station, const UnitChannel& unit) const {
    if (cycle_.is_faulty(unit)) return false;
    return !(is_switched(station, unit) && on_for_s() >= kRestart_s && still_sends(unit));
  }

  /// Why a unit has not restarted, with its slot.
  [[nodiscard]] std::string finding(const Station& station, const UnitChannel& unit) const {
    const std::string who = fmt::format("unit {} in slot {}", unit.serial(), unit.slot().name);
    if (cycle_.is_faulty(unit)) return fmt::format("{}: {}; switched off", who, cycle_.faults().at(unit.serial()));
    if (still_sends(unit)) {
      const std::string what =
          is_switched(station, unit) ? fmt::format("output {} was", output_of(unit)) : std::string("the units were");
      return fmt::format("{} did not restart: its clock kept running while {} off; is it powered by another supply?",
                         who, what);
    }
    return fmt::format("{} gave no sign of power within {:.0f} s{}{}", who, kPowerOnTimeout_s,
                       unit.trouble().empty() ? "" : ": ", unit.trouble());
  }

  /// What a slot holds instead of its unit; nothing where that is the right one or not known yet.
  static std::optional<std::string> wrong_identity(const Station& station, const UnitChannel& unit) {
    if (!is_known(unit)) return std::nullopt;
    const hal::ImuIdentity& found = *unit.imu().identity();
    if (found.serial == unit.serial()) return std::nullopt;
    const auto other = std::find_if(station.units.begin(), station.units.end(),
                                    [&](const auto& u) { return u->serial() == found.serial; });
    const std::string hint = other == station.units.end()
                                 ? ""
                                 : fmt::format(" ({} belongs in slot {})", found.serial, (*other)->slot().name);
    return fmt::format("slot {} holds unit {} ({}), not {}{}", unit.slot().name, found.serial, product_text(found),
                       unit.serial(), hint);
  }

  static std::vector<std::string> wrong_identities(const Station& station) {
    std::vector<std::string> wrong;
    for (const auto& unit : station.units) {
      if (auto found = wrong_identity(station, *unit)) wrong.push_back(*std::move(found));
    }
    return wrong;
  }

  static std::map<std::string, Prompts::Detail> wrong_slots(const Station& station) {
    std::vector<std::string> slots;
    std::vector<std::string> expected;
    std::vector<std::string> found;
    for (const auto& unit : station.units) {
      if (!wrong_identity(station, *unit)) continue;
      slots.push_back(unit->slot().name);
      expected.push_back(unit->serial());
      found.push_back(unit->imu().identity()->serial);
    }
    return {{"slots", slots}, {"expected", expected}, {"found", found}};
  }

  static bool is_known(const UnitChannel& unit) { return unit.streaming() && unit.imu().identity(); }

  StepProgress ask_for_right_units(Station& station, const std::vector<std::string>& wrong) {
    std::vector<std::string> options;
    for (const auto& unit : station.units) {
      options.push_back(fmt::format("--unit {}={}", unit->slot().name,
                                    is_known(*unit) ? unit->imu().identity()->serial : unit->serial()));
    }
    // Whoever changes units finds them without supply, as far as that is ours.
    for (const auto& unit : station.units) {
      if (is_switched(station, *unit)) station.cut_off(*unit);
    }
    station.log.add("unit", station.campaign.name, fmt::format("{}: asked for the right ones", fmt::join(wrong, "; ")));
    station.prompts.ask(
        {fmt::format("In {}. Put the right units there, or their cables, and confirm. If the serial numbers of the "
                     "campaign are wrong, abort it and start it with {}.",
                     fmt::join(wrong, "; "), fmt::join(options, " ")),
         "units", wrong_slots(station)});
    station.expect_no_run();
    stage_ = Stage::wrong_units;
    return StepProgress::running();
  }

  StepProgress wait_for_right_units(Station& station) {
    if (station.prompts.take_answer()) stage_ = Stage::begin;
    return StepProgress::running();
  }

  StepProgress open_run(Station& station) {
    for (const UnitChannel* unit : station.active_units()) {
      const auto& identity = unit->imu().identity();
      if (!identity) continue;
      station.log.add("unit", unit->serial(),
                      fmt::format("in slot {}: {}", unit->slot().name, product_text(*identity)));
    }
    if (const auto begun = station.begin_run(run_); !begun) return StepProgress::failed(begun.error());
    stage_ = Stage::warm_up;
    return StepProgress::running();
  }

  StepProgress warm_up(Station& station) {
    const auto active = station.active_units();
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
  PowerCycle cycle_;
  Stage stage_ = Stage::begin;
  std::map<std::string, Before> before_;
};

/// Ends the run: its file is sealed and entered into the catalog, and the units are off for a while. Sealing goes on
/// beside both.
class PowerOff : public StepTask {
 public:
  explicit PowerOff(const Step& step) : seconds_(step.seconds) {}

  StepProgress poll(Station& station) override {
    if (!sealed_) {
      const auto sealed = seal(station);
      if (!sealed) return StepProgress::failed(sealed.error());
      sealed_ = *sealed;
    }
    if (!off_at_s_) {
      const auto off = station.supply ? retry_.attempt([&] { return switch_off(station); }) : base::Result<bool>(true);
      if (!off) return StepProgress::failed(off.error());
      if (*off) off_at_s_ = station.now_s();
      return StepProgress::running();
    }
    return sealed_ && station.now_s() - *off_at_s_ >= seconds_ ? StepProgress::done() : StepProgress::running();
  }

 private:
  /// What the world does not let happen now (a locked catalog) is tried again: the run is complete, and nothing is lost
  /// by waiting. For some minutes only where the chamber holds a plateau meanwhile (power.cycle_at_visit).
  base::Result<bool> seal(Station& station) {
    if (steady_clock::now() < next_seal_) return false;
    const auto ended = station.end_run(std::nullopt);
    if (ended) return *ended;
    if (!sealing_since_s_) {
      sealing_since_s_ = station.now_s();
      station.log.add("run", station.run_id(), "cannot be entered yet: " + ended.error().message);
    }
    const double give_up_s = 3600.0 * station.procedure().give_up_h;
    const double limit_s = station.chamber.expected_c() ? std::min(kSealAtPlateau_s, give_up_s) : give_up_s;
    if (ended.error().kind != base::ErrorKind::internal || station.now_s() - *sealing_since_s_ > limit_s) {
      return base::forward_error(ended);
    }
    next_seal_ = steady_clock::now() + kSealInterval;
    return false;
  }

  static base::Status switch_off(Station& station) {
    for (const auto& unit : station.units) {
      if (!unit->slot().power_output) continue;
      if (auto status = station.supply->switch_off(output_of(*unit), station.now_s()); !status) return status;
    }
    return {};
  }

  double seconds_;
  bool sealed_ = false;
  std::optional<double> sealing_since_s_;  ///< without success
  steady_clock::time_point next_seal_{};
  std::optional<double> off_at_s_;
  CommandRetry retry_;
};

}  // namespace

std::unique_ptr<StepTask> make_power_task(const Plan& plan, const Step& step) {
  if (step.kind == StepKind::power_off) return std::make_unique<PowerOff>(step);
  return std::make_unique<PowerOn>(plan, step);
}

}  // namespace soak::station
