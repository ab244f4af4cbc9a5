// SPDX-License-Identifier: Apache-2.0
#include "calib/gap/experiment/detail/proposed_run.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

#include "base/statistics.h"

namespace soak::calib::gap {
namespace {

constexpr double kShortestWay_c = 2.0;
constexpr double kTailBegins = 0.15;  ///< part of the way that is left where the air must have arrived
constexpr double kLeastRamp = 0.5;    ///< of the time constant: a shorter ramp is not seen
constexpr std::size_t kLeastTail = 10;
constexpr double kShortestTau_s = 10.0;
constexpr int kTaus = 60;

std::vector<TemplateVisit> visits_of(const LoggedRun& run) {
  std::vector<const Segment*> segments;
  for (const Segment& segment : run.run.segments) {
    if (segment.phase == Phase::soak && segment.plateau_c && !segment.blocks.empty()) segments.push_back(&segment);
  }
  std::sort(segments.begin(), segments.end(),
            [](const Segment* a, const Segment* b) { return a->t_start_s < b->t_start_s; });
  std::vector<TemplateVisit> visits;
  for (const Segment* segment : segments) {
    if (visits.empty() || visits.back().segments.front()->key.visit != segment->key.visit) {
      TemplateVisit& fresh = visits.emplace_back();
      fresh.start_s = segment->t_start_s;
      fresh.plateau_c = *segment->plateau_c;
      fresh.sweep = segment->sweep;
    }
    TemplateVisit& visit = visits.back();
    visit.segments.push_back(segment);
    visit.end_s = segment->t_end_s;
    double temp_c = 0.0;
    for (const Block& block : segment->blocks) temp_c += block.temp_c / static_cast<double>(segment->blocks.size());
    visit.rest_c += (temp_c - visit.rest_c) / static_cast<double>(visit.segments.size());
  }
  return visits;
}

/// What a run's log says of the way from one plateau to the next, and of the stay there.
struct Way {
  std::vector<double> t_s;  ///< from its begin
  std::vector<double> temp_c;
};

Way way_between(const RunLog& log, double begin_s, double end_s) {
  Way way;
  for (std::size_t k = 0; k < log.t_s.size(); ++k) {
    if (log.t_s[k] < begin_s || log.t_s[k] > end_s || !std::isfinite(log.temp_c[k])) continue;
    way.t_s.push_back(log.t_s[k] - begin_s);
    way.temp_c.push_back(log.temp_c[k]);
  }
  return way;
}

/// How a way ends: a + b e^{-t/tau}.
struct Tail {
  double tau_s = 0.0;
  double rest_c = 0.0;  ///< a
  double squares = std::numeric_limits<double>::infinity();
};

/// Least squares of a and b over the rows from `first`.
Tail tail_with(const Way& way, std::size_t first, double tau_s) {
  double e = 0.0;
  double c = 0.0;
  double n = 0.0;
  std::vector<double> decay;
  for (std::size_t k = first; k < way.t_s.size(); ++k) {
    decay.push_back(std::exp(-(way.t_s[k] - way.t_s[first]) / tau_s));
    n += 1.0;
    e += (decay.back() - e) / n;
    c += (way.temp_c[k] - c) / n;
  }
  double ee = 0.0;
  double ec = 0.0;
  double cc = 0.0;
  for (std::size_t k = 0; k < decay.size(); ++k) {
    const double off_e = decay[k] - e;
    const double off_c = way.temp_c[first + k] - c;
    ee += off_e * off_e;
    ec += off_e * off_c;
    cc += off_c * off_c;
  }
  return ee > 0.0 ? Tail{tau_s, c - ec / ee * e, cc - ec * ec / ee} : Tail{};
}

/// The best tail, of time constants up to the length of the way; nothing where too little of the way is one.
std::optional<Tail> tail_of(const Way& way) {
  if (way.t_s.size() < kLeastTail) return std::nullopt;
  const double whole_c = way.temp_c.back() - way.temp_c.front();
  if (std::abs(whole_c) < kShortestWay_c) return std::nullopt;
  std::size_t first = 0;
  while ((way.temp_c.back() - way.temp_c[first]) / whole_c > kTailBegins) ++first;
  if (first + kLeastTail > way.t_s.size()) return std::nullopt;
  const double longest = std::log(std::max(kShortestTau_s, way.t_s.back()) / kShortestTau_s);
  Tail best;
  for (int k = 0; k < kTaus; ++k) {
    const Tail tail = tail_with(way, first, kShortestTau_s * std::exp(longest * k / (kTaus - 1)));
    if (tail.squares < best.squares) best = tail;
  }
  return best;
}

/// Length of the ramp that, before a lag of tau, leaves such an area below what is still to go.
double ramp_s(const Way& way, const Tail& tail) {
  const auto left = [&](std::size_t k) { return (way.temp_c[k] - tail.rest_c) / (way.temp_c.front() - tail.rest_c); };
  double area_s = left(way.t_s.size() - 1) * tail.tau_s + way.t_s.front();
  for (std::size_t k = 1; k < way.t_s.size(); ++k) {
    area_s += 0.5 * (left(k) + left(k - 1)) * (way.t_s[k] - way.t_s[k - 1]);
  }
  return std::max(0.0, 2.0 * (area_s - tail.tau_s));
}

/// Settling on the ways of one run; its visits are told where they would come to rest.
Settling settling_of(const RunLog& log, std::vector<TemplateVisit>& visits) {
  std::vector<double> per_kelvin_s;
  std::vector<double> taus_s;
  std::vector<double> ramps_s;
  for (std::size_t k = 1; k < visits.size(); ++k) {
    const Way way = way_between(log, visits[k - 1].end_s, visits[k].end_s);
    const auto tail = tail_of(way);
    if (!tail) continue;
    const double way_c = std::abs(tail->rest_c - way.temp_c.front());
    visits[k].rest_c = tail->rest_c;
    taus_s.push_back(tail->tau_s);
    ramps_s.push_back(ramp_s(way, *tail));
    per_kelvin_s.push_back(ramps_s.back() / way_c);
  }
  Settling settling;
  if (taus_s.empty()) return settling;
  settling.tau_s = base::median(taus_s);
  if (base::median(ramps_s) > kLeastRamp * settling.tau_s) settling.rate_kps = 1.0 / base::median(per_kelvin_s);
  return settling;
}

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
  Simulation(const RunTemplate& source, const ProposedRun& plan)
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
      const ProposedVisit& visit = plan_.visits[v];
      target_c_ = visit.temp_c;
      advance(plan_.settling.drive_s(target_c_ - air_c_) + visit.soak_s, std::nullopt);
      record(visit, static_cast<std::int32_t>(v));
    }
    return std::move(run_);
  }

 private:
  void record(const ProposedVisit& visit, std::int32_t number) {
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
  const ProposedRun& plan_;
  Copied compressor_;
  Copied supply_;
  LoggedRun run_;
  double t_s_ = 0.0;
  double target_c_ = 0.0;
  double air_c_;
  double unit_c_;
};

}  // namespace

double Settling::drive_s(double way_c) const { return rate_kps ? std::abs(way_c) / *rate_kps : 0.0; }

std::optional<RunTemplate> run_template(const LoggedCampaign& campaign) {
  RunTemplate result;
  std::size_t most = 0;
  for (const LoggedRun& run : campaign.runs) {
    auto visits = visits_of(run);
    std::size_t segments = 0;
    for (const TemplateVisit& visit : visits) segments += visit.segments.size();
    const auto& temp_c = run.log.temp_c;
    const auto first = std::find_if(temp_c.begin(), temp_c.end(), [](double c) { return std::isfinite(c); });
    if (segments == 0 || segments < most || first == temp_c.end()) continue;
    most = segments;
    result.run = &run;
    result.visits = std::move(visits);
    result.start_c = *first;
  }
  if (result.run == nullptr) return std::nullopt;
  result.settling = settling_of(result.run->log, result.visits);
  double before_s = result.run->log.t_s.front();
  double before_c = result.start_c;
  for (TemplateVisit& visit : result.visits) {
    visit.soak_s = std::max(0.0, visit.start_s - before_s - result.settling.drive_s(visit.rest_c - before_c));
    before_s = visit.end_s;
    before_c = visit.rest_c;
  }
  return result;
}

LoggedRun simulate(const RunTemplate& source, const ProposedRun& plan, const std::string& label) {
  return Simulation(source, plan).run(label);
}

double hours_of(const LoggedRun& run) {
  constexpr double kHour_s = 3600.0;
  return run.log.t_s.empty() ? 0.0 : (run.log.t_s.back() - run.log.t_s.front()) / kHour_s;
}

}  // namespace soak::calib::gap
