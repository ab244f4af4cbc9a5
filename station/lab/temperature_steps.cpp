// SPDX-License-Identifier: Apache-2.0
// Steps that drive the chamber and wait for the units to follow.
#include <fmt/format.h>

#include <cmath>
#include <optional>

#include "station/lab/dew_safe_warm_up.h"
#include "station/lab/steps.h"

namespace soak::station {
namespace {

constexpr double kAirArrived_c = 1.0;
constexpr double kAirLeft_c = 3.0;
constexpr double kRampGrace_s = 7200.0;       ///< process time beyond three times the estimate
constexpr double kRampHostLimit_s = 30.0;     ///< beside it
constexpr double kStabilityInterval_s = 2.0;  ///< process time between two judgements, which cost some

calib::StabilityCriterion criterion_of(const StabilitySettings& settings, const std::optional<double>& step_c) {
  return {settings.slope_kpmin, settings.confidence, settings.window_s, settings.min_window_s, step_c};
}

/// Gives a set point and waits until the air is there.
class SetTemperature : public StepTask {
 public:
  SetTemperature(const Plan& plan, const Step& step)
      : step_(step),
        is_ramp_(plan.procedure.kind == ProcedureKind::ramp),
        rate_kpmin_(plan.procedure.ramp_rate_kpmin) {}

  StepProgress poll(Station& station) override {
    if (!commanded_) return is_purged(station) ? command(station) : StepProgress::running();
    const auto& reading = station.chamber.reading();
    if (reading && std::abs(reading->air_c - step_.temp_c) <= kAirArrived_c) return StepProgress::done();
    if (!timer_.overdue(station, 3.0 * step_.estimate_s + kRampGrace_s, kRampHostLimit_s)) {
      return StepProgress::running();
    }
    return StepProgress::device_failed(fmt::format("the chamber does not reach {:+.1f} °C (air: {})", step_.temp_c,
                                                   reading ? fmt::format("{:+.1f} °C", reading->air_c) : "unknown"),
                                       station.chamber.chamber().description());
  }

 private:
  /// Whether dry air flows where the station wants it before this set point: asked of the operator once a campaign.
  bool is_purged(Station& station) {
    const auto& below_c = station.config.purge_below_c;
    if (!below_c || step_.temp_c >= *below_c || station.campaign.purge_confirmed) return true;
    if (!asked_for_purge_) {
      station.prompts.ask(
          {fmt::format("Switch the dry-air purge on, then confirm: the next set point is {:+.1f} °C.", step_.temp_c),
           "dry_air",
           {{"temp_c", step_.temp_c}}});
      asked_for_purge_ = true;
    }
    if (!station.prompts.take_answer()) return false;
    station.log.add("chamber", "purge", "confirmed: dry air flows");
    return station.campaign.purge_confirmed = true;
  }

  StepProgress command(Station& station) {
    hal::Chamber& chamber = station.chamber.chamber();
    const auto sent = retry_.attempt([&]() -> base::Status {
      if (chamber.can_ramp()) {
        if (auto status = chamber.set_ramp_rate(rate_kpmin_); !status) return status;
      }
      if (auto status = chamber.set_temperature(step_.temp_c); !status) return status;
      return chamber.start();
    });
    if (!sent) return StepProgress::failed(sent.error());
    if (!*sent) return StepProgress::running();
    commanded_ = true;
    station.chamber.expect(step_.temp_c);
    timer_.start(station);
    station.set_plateau(is_ramp_ ? std::nullopt : std::optional(step_.temp_c), step_.sweep, step_.visit);
    for (const auto& unit : station.units) unit->disturb();
    return StepProgress::running();
  }

  Step step_;
  bool is_ramp_;
  std::optional<double> rate_kpmin_;
  CommandRetry retry_;
  bool asked_for_purge_ = false;
  bool commanded_ = false;
  WaitTimer timer_;
};

/// Waits until every unit's own thermometer reads steadily.
class WaitStable : public StepTask {
 public:
  WaitStable(const Plan& plan, const Step& step) : step_(step), settings_(plan.procedure.stability) {}

  StepProgress poll(Station& station) override {
    if (!begun_) begin(station);
    const bool late = station.now_s() - begun_s_ > settings_.timeout_s;
    if (air_is_away(station)) return late ? timed_out("the air is not at the set point") : StepProgress::running();
    if (station.now_s() - since_s_ < shortest_s()) return StepProgress::running();
    if (station.now_s() - judged_s_ < kStabilityInterval_s) return StepProgress::running();
    judged_s_ = station.now_s();
    std::string unsettled;
    for (UnitChannel* unit : station.active_units()) {
      if (!is_settled(station, *unit)) unsettled += unsettled.empty() ? unit->serial() : ", " + unit->serial();
    }
    if (unsettled.empty()) return StepProgress::done();
    return late ? timed_out(unsettled) : StepProgress::running();
  }

 private:
  void begin(Station& station) {
    begun_ = true;
    begun_s_ = since_s_ = judged_s_ = station.now_s();
    if (step_.after_turn) return;
    for (UnitChannel* unit : station.active_units()) unit->judge_by(criterion_of(settings_, unit->type().temp_lsb_c));
    station.chamber.judge_air(criterion_of(settings_, std::nullopt));
  }

  /// After nothing but a turn the short check is enough.
  [[nodiscard]] double shortest_s() const {
    return step_.after_turn && !air_has_left_ ? settings_.after_turn_s : settings_.minimum_soak_s;
  }

  /// An opened door: whatever was judged before does not count.
  bool air_is_away(Station& station) {
    const auto& reading = station.chamber.reading();
    if (!reading || step_.visit < 0 || std::abs(reading->air_c - step_.temp_c) <= kAirLeft_c) return false;
    for (UnitChannel* unit : station.active_units()) unit->disturb();
    since_s_ = station.now_s();
    if (!air_has_left_) {
      station.log.add(
          "device", "chamber",
          fmt::format("the air left the set point (air {:+.1f} °C, set point {:+.1f} °C): was the door opened?",
                      reading->air_c, step_.temp_c));
    }
    air_has_left_ = true;
    return true;
  }

  [[nodiscard]] static bool is_settled(const Station& station, const UnitChannel& unit) {
    const calib::StabilityVerdict verdict = unit.stability();
    if (verdict.stable) return true;
    // A thermometer too coarse to show a slope: that its reading does not change, the minimum time and the chamber's
    // air count instead.
    return verdict.quantised && verdict.standing && station.chamber.air_is_stable();
  }

  [[nodiscard]] StepProgress timed_out(const std::string& unsettled) const {
    const std::string text = fmt::format("not stable after {:.0f} s: {}", settings_.timeout_s, unsettled);
    switch (settings_.on_timeout) {
      case TimeoutOutcome::skip_plateau:
        return {StepState::skip_visit, text, {}};
      case TimeoutOutcome::record:
        return StepProgress::done(text);
      case TimeoutOutcome::abort:
        break;
    }
    return StepProgress::device_failed(text, "stability");
  }

  Step step_;
  StabilitySettings settings_;
  bool begun_ = false;
  double begun_s_ = 0.0;
  double since_s_ = 0.0;  ///< when the air was there (again)
  double judged_s_ = 0.0;
  bool air_has_left_ = false;
};

/// Drives to room temperature or above until no unit can gather dew, then switches the chamber off.
class WarmEnd : public StepTask {
 public:
  explicit WarmEnd(const Step& step) : temp_c_(step.temp_c) {}

  StepProgress poll(Station& station) override {
    if (!warm_up_) {
      warm_up_.emplace(temp_c_);
      station.chamber.expect(std::nullopt);
      station.set_plateau(std::nullopt, calib::Sweep::unknown, -1);
    }
    return warm_up_->poll(station) ? StepProgress::done() : StepProgress::running();
  }

  std::string trouble() const override {
    if (!warm_up_ || !warm_up_->off().is_alarm()) return {};
    return fmt::format("heating and cooling cannot be switched off ({}): go to the chamber and switch them off by hand",
                       warm_up_->off().trouble());
  }

 private:
  double temp_c_;
  std::optional<DewSafeWarmUp> warm_up_;
};

}  // namespace

std::unique_ptr<StepTask> make_temperature_task(const Plan& plan, const Step& step) {
  if (step.kind == StepKind::set_temperature) return std::make_unique<SetTemperature>(plan, step);
  if (step.kind == StepKind::wait_stable) return std::make_unique<WaitStable>(plan, step);
  return std::make_unique<WarmEnd>(step);
}

}  // namespace soak::station
