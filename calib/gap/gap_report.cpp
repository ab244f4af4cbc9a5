// SPDX-License-Identifier: Apache-2.0
#include "calib/gap/gap_report.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include "base/statistics.h"

namespace soak::calib::gap {
namespace {

constexpr int kLeastRuns = 2;
/// Share of the strongest named merit from which a leftover forbids names.
constexpr double kStrange = 0.25;
/// Sets of sensors among which a term may be named: all, gyros, accelerometers, each alone.
constexpr double kSets = 9.0;

/// F of one and the given degrees of freedom whose upper tail is `p`.
double f_quantile(double p, double dof) {
  double low = 0.0;
  double high = 1.0;
  while (base::f_upper_tail(high, 1.0, dof) > p) high *= 2.0;
  for (int i = 0; i < 100; ++i) {
    const double middle = 0.5 * (low + high);
    (base::f_upper_tail(middle, 1.0, dof) > p ? low : high) = middle;
  }
  return high;
}

std::optional<double> detection_limit(const CampaignModel& model, std::size_t s, const SearchResult& found) {
  const Observations& observations = model.circumstances().observations;
  if (!model.residuals().sensor[s] || found.candidates == 0) return std::nullopt;
  double visits = 0.0;
  double placements = 0.0;
  for (std::size_t i = 0; i < observations.rows.size(); ++i) {
    const auto& row = observations.rows[i];
    if (i > 0 && row.placement == observations.rows[i - 1].placement) continue;
    placements += 1.0;
    if (i == 0 || row.visit != observations.rows[i - 1].visit || row.run != observations.rows[i - 1].run) visits += 1.0;
  }
  const NoiseComponents& noise = model.residuals().noise[s];
  const double blocks = static_cast<double>(observations.rows.size()) / placements;
  const double of_visit =
      noise.visit * noise.visit +
      (noise.placement * noise.placement + noise.block * noise.block / blocks) / (placements / visits);
  const double p = kGate / (static_cast<double>(found.candidates) * kSets);
  const double f = f_quantile(p, kPriorDof + observations.run_count() - 1);
  return std::sqrt(f * std::max(1.0, found.typical_heterogeneity) * of_visit / visits);
}

std::string list_of(const std::vector<NamedEffect>& effects) {
  std::vector<std::string_view> names;
  for (const NamedEffect& effect : effects) names.push_back(effect.effect->name);
  return fmt::format("{}", fmt::join(names, ", "));
}

/// `beside`: effects that the means do not show; they are named whatever else is there.
void decide(SearchResult found, std::vector<NamedEffect> beside, GapReport& report) {
  double merit = 0.0;
  for (const NamedEffect& effect : found.effects) merit = std::max(merit, effect.merit);
  report.leftover = std::move(found.leftover);
  if (report.leftover && report.leftover->merit >= kStrange * merit) {
    report.verdict = Verdict::unknown;
    report.suspects = std::move(found.effects);
    report.reason =
        fmt::format("readings change with {}, in a way that no effect of the library explains", report.leftover->axis);
    return;
  }
  std::stable_sort(found.effects.begin(), found.effects.end(),
                   [](const auto& a, const auto& b) { return a.merit > b.merit; });
  report.effects = std::move(found.effects);
  std::move(beside.begin(), beside.end(), std::back_inserter(report.effects));
  report.verdict = report.effects.empty() ? Verdict::none : Verdict::named;
  report.reason = report.effects.empty() ? "nothing beyond the scatter between runs and the detection limit"
                                         : fmt::format("explained by {}", list_of(report.effects));
}

}  // namespace

GapReport find_gap(const LoggedCampaign& campaign, std::int32_t model_version) {
  GapReport report;
  report.unit = campaign.unit;
  report.model = model_version;
  const Observations observations = observe(campaign);
  if (observations.rows.empty() || observations.run_count() < kLeastRuns) {
    report.verdict = Verdict::cannot_judge;
    report.reason = observations.rows.empty()
                        ? "no run has a plateau with readings of one-minute blocks"
                        : "one run only: what an effect repeats and what runs scatter cannot be told apart; record a "
                          "second run of the same procedure";
    return report;
  }
  const Courses courses(campaign, observations);
  CampaignModel model(observations, courses);
  for (const Effect& effect : library()) {
    if (auto why = effect.missing(model.circumstances())) {
      report.not_testable.push_back({std::string(effect.name), *std::move(why)});
    }
  }
  SearchResult found = search(model);
  for (std::size_t s = 0; s < kSensorCount; ++s) report.detection_limit[s] = detection_limit(model, s, found);
  BesideTheMean beside = look_beside_the_mean(campaign, model);
  std::move(beside.not_testable.begin(), beside.not_testable.end(), std::back_inserter(report.not_testable));
  report.not_testable.push_back(
      {"narrow_bump",
       "the base is free at every plateau and takes up a feature of one; look at the fit's residuals, or "
       "record a grid of 5 K about it"});
  decide(std::move(found), std::move(beside.effects), report);
  report.gap = held_out_gap(observations, courses, report.effects);
  return report;
}

}  // namespace soak::calib::gap
