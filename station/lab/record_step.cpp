// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "station/lab/step_task.h"

namespace soak::station {
namespace {

constexpr double kLongestRest_s = 120.0;  ///< process time until all units rest as they should
constexpr double kHostPatience_s = 20.0;  ///< beside it: a fast clock gives a slow host no chance otherwise

/// Records one segment of every unit at once. A segment in which a unit's temperature moved too far is rejected and
/// recorded again, as often as the procedure allows; the last one is kept and marked.
class Record : public StepTask {
 public:
  Record(const Plan& plan, const Step& step)
      : step_(step),
        seconds_(step.seconds),
        position_(step.position),
        preflight_(plan.runs[static_cast<std::size_t>(step.run)].preflight),
        judged_(plan.procedure.kind == ProcedureKind::soak && !preflight_),
        limit_c_(plan.procedure.segment_change_c),
        attempts_(plan.procedure.segment_attempts) {}

  StepProgress poll(Lab& lab) override {
    if (settle_) {
      StepProgress progress = settle_->poll(lab);
      if (progress.state != StepState::done) return progress;
      settle_.reset();
    }
    if (!recording_) return begin(lab);
    const auto active = lab.active_units();
    const auto ended = [](const UnitChannel* unit) {
      return !unit->capture || unit->capture->complete() || unit->capture->broken();
    };
    if (!std::all_of(active.begin(), active.end(), ended)) return StepProgress::running();
    return finish(lab, active);
  }

 private:
  /// Hours may have gone by since the units were turned: they say once more that they stand so. At a rate the gyros
  /// have just said it.
  StepProgress begin(Lab& lab) {
    const std::vector<UnitChannel*> wrong =
        step_.rate_dps == 0.0 ? units_out_of_position(lab) : std::vector<UnitChannel*>();
    if (wrong.empty()) {
      lab.begin_segment(seconds_);
      recording_ = true;
      waits_since_.reset();
      return StepProgress::running();
    }
    if (!waits_since_) waits_since_ = {lab.now_s(), std::chrono::steady_clock::now()};
    const std::chrono::duration<double> host = std::chrono::steady_clock::now() - waits_since_->second;
    if (lab.now_s() - waits_since_->first <= kLongestRest_s || host.count() <= kHostPatience_s) {
      return StepProgress::running();
    }
    if (!preflight_ && wrong.size() < lab.active_units().size()) {
      for (UnitChannel* unit : wrong) lab.lose(*unit, attitudes_text({unit}));
      return StepProgress::running();
    }
    return StepProgress::failed({base::ErrorKind::device,
                                 attitudes_text(wrong) + ": they stood right before, and were turned or shaken since",
                                 "position " + position_});
  }

  StepProgress finish(Lab& lab, const std::vector<UnitChannel*>& active) {
    std::map<std::string, std::string> rejected;
    const bool last = ++attempt_ >= attempts_;
    std::string text;
    for (const UnitChannel* unit : active) {
      if (!unit->capture) continue;
      if (preflight_) lab.preflight.push_back(record_of(*unit, lab.procedure().rate_hz));
      const double change_c = unit->capture->temp_change_c();
      if (unit->capture->broken()) {
        rejected[unit->serial()] = "samples were missing";
      } else if (judged_ && shows_change(*unit) && std::abs(change_c) > limit_c_) {
        const std::string moved =
            fmt::format("the temperature moved by {:+.2f} °C (limit {:.2f} °C)", change_c, limit_c_);
        if (!last) rejected[unit->serial()] = moved;
        if (last) text += fmt::format("{}{}: kept although {}", text.empty() ? "" : "; ", unit->serial(), moved);
      }
    }
    lab.end_segment(rejected);
    recording_ = false;
    if (rejected.empty()) return StepProgress::done(text);
    if (last) return StepProgress::done(fmt::format("{}{}no attempt left", text, text.empty() ? "" : "; "));
    settle_again(lab);
    return StepProgress::running();
  }

  /// A thermometer whose step is above the limit would show a change where there is none.
  [[nodiscard]] bool shows_change(const UnitChannel& unit) const {
    return unit.type().temp_lsb_c.value_or(0.0) <= limit_c_;
  }

  void settle_again(Lab& lab) {
    for (UnitChannel* unit : lab.active_units()) unit->disturb(lab.procedure().stability.after_turn_s);
    Step settle = step_;
    settle.after_turn = true;
    settle_ = make_wait_stable(lab.campaign.plan, settle);
  }

  [[nodiscard]] PreflightRecord record_of(const UnitChannel& unit, double asked_rate_hz) const {
    PreflightRecord record;
    record.unit = unit.serial();
    record.position = position_;
    record.type = unit.type();
    record.samples = unit.capture->samples();
    record.clipped = unit.capture->clipped();
    record.asked_rate_hz = asked_rate_hz;
    record.rate_hz = static_cast<double>(record.samples) / seconds_;
    record.lost_packets = unit.imu().statistics().lost_packets;
    for (const calib::Sensor sensor : calib::kSensors) {
      record.spread[calib::index_of(sensor)] = unit.capture->spread(sensor);
    }
    return record;
  }

  Step step_;
  double seconds_;
  std::string position_;
  bool preflight_;
  bool judged_;
  double limit_c_;
  int attempts_;
  int attempt_ = 0;
  bool recording_ = false;
  std::optional<std::pair<double, std::chrono::steady_clock::time_point>> waits_since_;  ///< process and host time
  std::unique_ptr<StepTask> settle_;
};

}  // namespace

std::unique_ptr<StepTask> make_record(const Plan& plan, const Step& step) {
  return std::make_unique<Record>(plan, step);
}

}  // namespace soak::station
