// SPDX-License-Identifier: Apache-2.0
#include "calib/gap/experiment/detail/run_template.h"

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

}  // namespace soak::calib::gap
