// SPDX-License-Identifier: Apache-2.0
#include "calib/gap/experiment/detail/planned_run.h"

#include <algorithm>
#include <cmath>

namespace soak::calib::gap {
namespace {

constexpr double kStep_s = 10.0;
constexpr double kDay_s = 86400.0;

/// Channels that the plan does not say: values of the template.
class Copied {
 public:
  Copied(const RunLog& log, const std::vector<double>& channel) : t_s_(log.t_s), values_(channel) {
    double count = 0.0;
    for (const double value : values_) {
      if (std::isfinite(value)) mean_ += (value - mean_) / ++count;
    }
  }

  /// Appends what the template has at its time `at_s`, or its mean where it has nothing there.
  void append(std::vector<double>& target, double at_s) const {
    if (values_.empty()) return;
    const auto next = std::lower_bound(t_s_.begin(), t_s_.end(), at_s);
    const auto k = std::min<std::size_t>(static_cast<std::size_t>(next - t_s_.begin()), values_.size() - 1);
    target.push_back(std::abs(t_s_[k] - at_s) <= kStep_s && std::isfinite(values_[k]) ? values_[k] : mean_);
  }

  void append_mean(std::vector<double>& target) const {
    if (!values_.empty()) target.push_back(mean_);
  }

 private:
  const std::vector<double>& t_s_;
  const std::vector<double>& values_;
  double mean_ = 0.0;
};

class Simulation {
 public:
  Simulation(const RunTemplate& source, const PlannedRun& plan)
      : source_(source),
        plan_(plan),
        compressor_(source.run->log, source.run->log.compressor),
        supply_(source.run->log, source.run->log.supply_v),
        air_c_(plan.start_c),
        unit_c_(plan.start_c) {}

  LoggedRun run(const std::string& label) {
    run_.run.run_id = run_.run.label = label;
    run_.run.site = source_.run->run.site;
    if (source_.run->start_utc_s) run_.start_utc_s = *source_.run->start_utc_s + kDay_s;
    append();
    for (std::size_t v = 0; v < plan_.visits.size(); ++v) {
      const PlannedVisit& visit = plan_.visits[v];
      target_c_ = visit.temp_c;
      advance(plan_.settling.drive_s(target_c_ - air_c_) + visit.soak_s, std::nullopt);
      record(visit, static_cast<std::int32_t>(v));
    }
    return std::move(run_);
  }

 private:
  void record(const PlannedVisit& visit, std::int32_t number) {
    const TemplateVisit& copied = source_.visits[visit.copy_of];
    const double later_s = t_s_ - copied.start_s;
    advance(copied.end_s - copied.start_s, later_s);
    for (const Segment* original : copied.segments) {
      Segment segment = *original;
      segment.key.run_id = run_.run.run_id;
      segment.key.visit = number;
      segment.plateau_c = visit.plateau_c;
      segment.sweep = visit.sweep;
      segment.findings.clear();
      segment.t_start_s += later_s;
      segment.t_end_s += later_s;
      if (segment.position && segment.position->azimuth_deg) *segment.position->azimuth_deg += plan_.turn_deg;
      for (Block& block : segment.blocks) place(block, later_s);
      run_.run.segments.push_back(std::move(segment));
    }
  }

  /// Moves a block of the template by `later_s` and gives it the temperature of this run.
  void place(Block& block, double later_s) const {
    block.t_s += later_s;
    const double temp_c = temperature_at(block.t_s);
    for (double& sensor_c : block.sensor_temp_c) sensor_c += temp_c - block.temp_c;
    block.temp_c = temp_c;
    block.sensor.fill({.count = 1, .mean = 0.0});
  }

  [[nodiscard]] double temperature_at(double at_s) const {
    const std::vector<double>& t_s = run_.log.t_s;
    const std::vector<double>& temp_c = run_.log.temp_c;
    const auto next = std::upper_bound(t_s.begin(), t_s.end(), at_s);
    if (next == t_s.begin() || next == t_s.end()) return next == t_s.end() ? temp_c.back() : temp_c.front();
    const auto k = static_cast<std::size_t>(next - t_s.begin());
    return temp_c[k - 1] + (at_s - t_s[k - 1]) / (t_s[k] - t_s[k - 1]) * (temp_c[k] - temp_c[k - 1]);
  }

  /// `later_s`: by how much the template's visit is shifted; absent on the way between visits.
  void advance(double seconds, std::optional<double> later_s) {
    while (seconds > 0.0) {
      const double dt = std::min(kStep_s, seconds);
      seconds -= dt;
      const double way_c = target_c_ - air_c_;
      const double most_c = plan_.settling.rate_kps.value_or(std::abs(way_c)) * dt;
      air_c_ += plan_.settling.rate_kps ? std::clamp(way_c, -most_c, most_c) : way_c;
      unit_c_ += (air_c_ - unit_c_) * (plan_.settling.tau_s > 0.0 ? -std::expm1(-dt / plan_.settling.tau_s) : 1.0);
      t_s_ += dt;
      append(later_s);
    }
  }

  void append(std::optional<double> later_s = {}) {
    RunLog& log = run_.log;
    const RunLog& copied = source_.run->log;
    log.t_s.push_back(t_s_);
    log.temp_c.push_back(unit_c_);
    if (!copied.t_since_power_s.empty()) log.t_since_power_s.push_back(copied.t_since_power_s.front() + t_s_);
    if (!copied.chamber_c.empty()) log.chamber_c.push_back(air_c_);
    if (later_s) {
      compressor_.append(log.compressor, t_s_ - *later_s);
      supply_.append(log.supply_v, t_s_ - *later_s);
    } else {
      compressor_.append_mean(log.compressor);
      supply_.append_mean(log.supply_v);
    }
  }

  const RunTemplate& source_;
  const PlannedRun& plan_;
  Copied compressor_;
  Copied supply_;
  LoggedRun run_;
  double t_s_ = 0.0;
  double target_c_ = 0.0;
  double air_c_;
  double unit_c_;
};

}  // namespace

LoggedRun simulate(const RunTemplate& source, const PlannedRun& plan, const std::string& label) {
  return Simulation(source, plan).run(label);
}

double hours_of(const LoggedRun& run) {
  constexpr double kHour_s = 3600.0;
  return run.log.t_s.empty() ? 0.0 : (run.log.t_s.back() - run.log.t_s.front()) / kHour_s;
}

}  // namespace soak::calib::gap
