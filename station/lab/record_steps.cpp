// SPDX-License-Identifier: Apache-2.0
// Recording a segment, and the check of what the pre-flight recorded.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <vector>

#include "station/lab/steps.h"

namespace soak::station {
namespace {

constexpr double kRestLimit_s = 120.0;  ///< process time until all units rest in their position

/// Records one segment of every unit at once. A segment in which a unit's temperature moved too far is rejected and
/// recorded again, as often as the procedure allows; the last one is kept and marked.
class Record : public StepTask {
 public:
  Record(const Plan& plan, const Step& step)
      : step_(step),
        preflight_(plan.runs[static_cast<std::size_t>(step.run)].preflight),
        temperature_counts_(plan.procedure.kind == ProcedureKind::soak && !preflight_),
        limit_c_(plan.procedure.segment_change_c),
        attempts_(plan.procedure.segment_attempts) {}

  StepProgress poll(Station& station) override {
    if (settle_) {
      StepProgress progress = settle_->poll(station);
      if (progress.state != StepState::done) return progress;
      settle_.reset();
    }
    if (!recording_) return begin(station);
    const auto active = station.active_units();
    const auto ended = [](const UnitChannel* unit) {
      return !unit->capture || unit->capture->complete() || unit->capture->broken();
    };
    if (!std::all_of(active.begin(), active.end(), ended)) return StepProgress::running();
    return finish(station, active);
  }

 private:
  /// Hours may have passed since the units were turned: they confirm their position once more. At a rate the gyros
  /// have just confirmed it.
  StepProgress begin(Station& station) {
    const auto wrong = step_.rate_dps == 0.0 ? units_out_of_position(station) : std::vector<UnitChannel*>();
    if (wrong.empty()) {
      station.begin_segment(step_.seconds);
      recording_ = true;
      waiting_.reset();
      return StepProgress::running();
    }
    if (!waiting_) waiting_.emplace().start(station);
    if (!waiting_->overdue(station, kRestLimit_s)) return StepProgress::running();
    if (!preflight_ && wrong.size() < station.active_units().size()) {
      for (UnitChannel* unit : wrong) station.lose(*unit, attitudes_text({unit}));
      return StepProgress::running();
    }
    return StepProgress::device_failed(
        attitudes_text(wrong) + ": the position was right before; the fixture was turned or shaken since",
        "position " + step_.position);
  }

  StepProgress finish(Station& station, const std::vector<UnitChannel*>& active) {
    std::map<std::string, std::string> rejected;
    const bool last = ++attempt_ >= attempts_;
    std::string text;
    for (const UnitChannel* unit : active) {
      if (!unit->capture) continue;
      if (preflight_) station.preflight.push_back(record_of(*unit, station.procedure().rate_hz));
      const double change_c = unit->capture->temp_change_c();
      if (unit->capture->broken()) {
        rejected[unit->serial()] = "samples were missing";
      } else if (temperature_counts_ && shows_change(*unit) && std::abs(change_c) > limit_c_) {
        const std::string moved =
            fmt::format("the temperature moved by {:+.2f} °C (limit {:.2f} °C)", change_c, limit_c_);
        if (!last) rejected[unit->serial()] = moved;
        if (last) text += fmt::format("{}{}: kept although {}", text.empty() ? "" : "; ", unit->serial(), moved);
      }
    }
    station.end_segment(rejected);
    recording_ = false;
    if (rejected.empty()) return StepProgress::done(text);
    if (last) return StepProgress::done(fmt::format("{}{}no attempt left", text, text.empty() ? "" : "; "));
    settle_again(station);
    return StepProgress::running();
  }

  /// A thermometer whose step is above the limit would show a change where there is none.
  [[nodiscard]] bool shows_change(const UnitChannel& unit) const {
    return unit.type().temp_lsb_c.value_or(0.0) <= limit_c_;
  }

  void settle_again(Station& station) {
    for (UnitChannel* unit : station.active_units()) unit->disturb(station.procedure().stability.after_turn_s);
    Step settle = step_;
    settle.kind = StepKind::wait_stable;
    settle.after_turn = true;
    settle_ = make_task(station.campaign.plan, settle);
  }

  [[nodiscard]] PreflightRecord record_of(const UnitChannel& unit, double asked_rate_hz) const {
    PreflightRecord record;
    record.unit = unit.serial();
    record.position = step_.position;
    record.type = unit.type();
    record.samples = unit.capture->samples();
    record.clipped = unit.capture->clipped();
    record.asked_rate_hz = asked_rate_hz;
    record.rate_hz = static_cast<double>(record.samples) / step_.seconds;
    record.lost_packets = unit.imu().statistics().lost_packets;
    for (const calib::Sensor sensor : calib::kSensors) {
      record.spread[calib::index_of(sensor)] = unit.capture->spread(sensor);
    }
    return record;
  }

  Step step_;
  bool preflight_;
  bool temperature_counts_;
  double limit_c_;
  int attempts_;
  int attempt_ = 0;
  bool recording_ = false;
  std::optional<WaitTimer> waiting_;  ///< for units that are out of position
  std::unique_ptr<StepTask> settle_;
};

/// Judges what the pre-flight recorded: whatever would spoil the campaign ends it now.
class Check : public StepTask {
 public:
  StepProgress poll(Station& station) override {
    const auto findings = preflight_findings(station.preflight);
    station.preflight.clear();
    if (findings.empty()) return StepProgress::done("nothing found");
    std::string text;
    for (const PreflightFinding& finding : findings) {
      station.log.add("pre-flight", "", finding.text);
      text += (text.empty() ? "pre-flight: " : "; ") + finding.text;
    }
    return StepProgress::failed({base::ErrorKind::limits, std::move(text), "pre-flight"});
  }
};

}  // namespace

std::unique_ptr<StepTask> make_record_task(const Plan& plan, const Step& step) {
  if (step.kind == StepKind::check) return std::make_unique<Check>();
  return std::make_unique<Record>(plan, step);
}

}  // namespace soak::station
