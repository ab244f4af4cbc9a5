// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "station/lab/step_task.h"
#include "station/lab/warmth.h"

namespace soak::station {
namespace {

constexpr double kAirIsThere_c = 1.0;
constexpr double kGrace_s = 7200.0;       ///< process time beyond three times the estimate
constexpr double kHostPatience_s = 30.0;  ///< beside it

using std::chrono::steady_clock;

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

  StepProgress poll(Lab& lab) override {
    if (!commanded_) return is_purged(lab) ? command(lab) : StepProgress::running();
    const auto& reading = lab.chamber.reading();
    if (reading && std::abs(reading->air_c - step_.temp_c) <= kAirIsThere_c) return StepProgress::done();
    const bool late = lab.now_s() - since_s_ > 3.0 * step_.estimate_s + kGrace_s &&
                      std::chrono::duration<double>(steady_clock::now() - since_host_).count() > kHostPatience_s;
    if (!late) return StepProgress::running();
    return StepProgress::failed({base::ErrorKind::device,
                                 fmt::format("the chamber does not reach {:+.1f} °C (air {})", step_.temp_c,
                                             reading ? fmt::format("{:+.1f} °C", reading->air_c) : "unknown"),
                                 lab.chamber.chamber().description()});
  }

 private:
  /// Whether dry air flows where the station wants it before this set point: asked of the operator once a campaign.
  bool is_purged(Lab& lab) {
    const auto& below_c = lab.config.purge_below_c;
    if (!below_c || step_.temp_c >= *below_c || lab.campaign.purge_confirmed) return true;
    if (!asked_for_purge_) {
      lab.prompts.ask(
          fmt::format("Switch the dry-air purge on and confirm: the chamber goes to {:+.1f} °C.", step_.temp_c));
      asked_for_purge_ = true;
    }
    if (!lab.prompts.take_answer()) return false;
    lab.log.add("chamber", "purge", "confirmed: dry air flows");
    return lab.campaign.purge_confirmed = true;
  }

  StepProgress command(Lab& lab) {
    hal::Chamber& chamber = lab.chamber.chamber();
    const auto sent = insistence_.attempt([&]() -> base::Status {
      if (chamber.can_ramp()) {
        if (auto status = chamber.set_ramp_rate(rate_kpmin_); !status) return status;
      }
      if (auto status = chamber.set_temperature(step_.temp_c); !status) return status;
      return chamber.start();
    });
    if (!sent) return StepProgress::failed(sent.error());
    if (!*sent) return StepProgress::running();
    commanded_ = true;
    lab.chamber.expect(step_.temp_c);
    since_s_ = lab.now_s();
    since_host_ = steady_clock::now();
    lab.set_plateau(is_ramp_ ? std::nullopt : std::optional(step_.temp_c), step_.sweep, step_.visit);
    for (const auto& unit : lab.units) unit->disturb();
    return StepProgress::running();
  }

  Step step_;
  bool is_ramp_;
  std::optional<double> rate_kpmin_;
  Insistence insistence_;
  bool asked_for_purge_ = false;
  bool commanded_ = false;
  double since_s_ = 0.0;
  steady_clock::time_point since_host_{};
};

/// Waits until every unit's own thermometer stands still.
class WaitStable : public StepTask {
 public:
  WaitStable(const Plan& plan, const Step& step) : step_(step), settings_(plan.procedure.stability) {}

  StepProgress poll(Lab& lab) override {
    if (!begun_) begin(lab);
    const bool late = lab.now_s() - begun_s_ > settings_.timeout_s;
    if (air_is_away(lab)) return late ? timed_out("the air is not at the set point") : StepProgress::running();
    const double waited_s = lab.now_s() - since_s_;
    if (waited_s < shortest_s()) return StepProgress::running();
    // A verdict is worth its cost only now and then.
    if (lab.now_s() - judged_s_ < kJudgeEvery_s) return StepProgress::running();
    judged_s_ = lab.now_s();
    std::string unsettled;
    for (UnitChannel* unit : lab.active_units()) {
      if (!is_settled(lab, *unit)) unsettled += unsettled.empty() ? unit->serial() : ", " + unit->serial();
    }
    if (unsettled.empty()) return StepProgress::done();
    return late ? timed_out(unsettled) : StepProgress::running();
  }

 private:
  static constexpr double kJudgeEvery_s = 2.0;
  static constexpr double kAirLeft_c = 3.0;

  void begin(Lab& lab) {
    begun_ = true;
    begun_s_ = since_s_ = judged_s_ = lab.now_s();
    for (UnitChannel* unit : lab.active_units()) {
      if (!step_.after_turn) unit->judge_by(criterion_of(settings_, unit->type().temp_lsb_c));
    }
    if (!step_.after_turn) lab.chamber.judge_air(criterion_of(settings_, std::nullopt));
  }

  /// After a mere turn the short check will do.
  [[nodiscard]] double shortest_s() const {
    return step_.after_turn && !air_has_left_ ? settings_.after_turn_s : settings_.minimum_soak_s;
  }

  /// An opened door: whatever was judged before does not count.
  bool air_is_away(Lab& lab) {
    const auto& reading = lab.chamber.reading();
    if (!reading || step_.visit < 0 || std::abs(reading->air_c - step_.temp_c) <= kAirLeft_c) return false;
    for (UnitChannel* unit : lab.active_units()) unit->disturb();
    since_s_ = lab.now_s();
    if (!air_has_left_)
      lab.log.add("device", "chamber",
                  fmt::format("the air left the set point ({:+.1f} °C at {:+.1f} °C): was the door opened?",
                              reading->air_c, step_.temp_c));
    air_has_left_ = true;
    return true;
  }

  [[nodiscard]] static bool is_settled(const Lab& lab, const UnitChannel& unit) {
    const calib::StabilityVerdict verdict = unit.stability();
    if (verdict.stable) return true;
    // A thermometer that cannot show a slope: its standstill, the minimum time and the chamber's air stand in for it.
    return verdict.quantised && verdict.standing && lab.chamber.air_is_stable();
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
    return StepProgress::failed({base::ErrorKind::device, text, "stability"});
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

  StepProgress poll(Lab& lab) override {
    if (!warmth_) {
      warmth_.emplace(temp_c_);
      lab.chamber.expect(std::nullopt);
      lab.set_plateau(std::nullopt, calib::Sweep::unknown, -1);
    }
    return warmth_->poll(lab) ? StepProgress::done() : StepProgress::running();
  }

 private:
  double temp_c_;
  std::optional<Warmth> warmth_;
};

}  // namespace

std::unique_ptr<StepTask> make_set_temperature(const Plan& plan, const Step& step) {
  return std::make_unique<SetTemperature>(plan, step);
}

std::unique_ptr<StepTask> make_wait_stable(const Plan& plan, const Step& step) {
  return std::make_unique<WaitStable>(plan, step);
}

std::unique_ptr<StepTask> make_warm_end(const Step& step) { return std::make_unique<WarmEnd>(step); }

}  // namespace soak::station
