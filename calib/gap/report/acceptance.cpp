// SPDX-License-Identifier: Apache-2.0
#include "calib/gap/report/gap_report.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <iterator>
#include <string_view>
#include <utility>

namespace soak::calib::gap {
namespace {

/// Parameters and covariance of one sensor in the units that their meaning states.
TermPart part_of(const NamedEffect& named, Sensor sensor) {
  const std::size_t s = index_of(sensor);
  const Meaning& meaning = named.meaning[s];
  const auto count = static_cast<std::size_t>(named.parameters[s].size());
  TermPart part;
  part.sensors = {sensor};
  for (std::size_t i = 0; i < count; ++i) {
    const auto& [name, unit, per_parameter] = meaning.estimated[i];
    part.parameters.push_back({name, named.parameters[s](static_cast<Eigen::Index>(i)) * per_parameter, unit});
    for (std::size_t j = 0; j < count; ++j) {
      part.covariance.push_back(named.covariance[s](static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) *
                                per_parameter * meaning.estimated[j].per_parameter);
    }
  }
  part.parameters.insert(part.parameters.end(), meaning.given.begin(), meaning.given.end());
  return part;
}

std::vector<TermPart> parts_of(const NamedEffect& named) {
  std::vector<TermPart> parts;
  for (const Sensor sensor : named.sensors) {
    if (named.candidate.shared && !parts.empty()) {
      parts.front().sensors.push_back(sensor);
    } else {
      parts.push_back(part_of(named, sensor));
    }
  }
  return parts;
}

ModelTerm term_of(const NamedEffect& named, const GapReport& report) {
  ModelTerm term;
  term.name = named.effect->name;
  term.library = kLibraryVersion;
  term.parent_version = report.model;
  term.lab_only = named.effect->lab_only;
  term.parts = parts_of(named);
  term.p_adjusted = named.p_adjusted;
  term.delta_bic = named.delta_bic;
  term.heldout_gain = named.heldout_gain;
  term.verdict = name_of(report.conclusion);
  for (const Rival& rival : named.rivals) {
    if (has_chance(rival)) term.confusable_with.emplace_back(rival.effect->name);
  }
  for (std::size_t s = 0; s < kSensorCount; ++s) {
    if (const auto& gap = report.gap[s]) {
      term.gap[s] = {gap->before_rms, gap->after_rms, gap->floor_rms, gap->closed_fraction, gap->closed_ci95};
    }
  }
  return term;
}

/// Temperatures of a segment: of its blocks where it lies at no plateau.
std::vector<double> temperatures_of(const Segment& segment) {
  if (segment.plateau_c) return {segment.temp_c};
  std::vector<double> temps_c;
  for (const Block& block : segment.blocks) temps_c.push_back(block.temp_c);
  return temps_c;
}

void note_data(const LoggedCampaign& campaign, ModelTerm& term) {
  const bool with_plateaus = has_plateaus(campaign);
  std::vector<double> temps_c;
  for (const LoggedRun& run : campaign.runs) {
    term.run_hashes.push_back(run.run.content_sha256);
    for (const Segment& segment : run.run.segments) {
      if (with_plateaus && !(segment.phase == Phase::soak && segment.plateau_c)) continue;
      std::ranges::copy(temperatures_of(segment), std::back_inserter(temps_c));
    }
  }
  if (temps_c.empty()) return;
  const auto [low, high] = std::ranges::minmax(temps_c);
  term.temp_min_c = low;
  term.temp_max_c = high;
}

bool wanted(const NamedEffect& named, const std::vector<std::string>& names) {
  return names.empty() || std::find(names.begin(), names.end(), named.effect->name) != names.end();
}

std::string list_of_names(const std::vector<NamedEffect>& effects) {
  std::vector<std::string_view> names;
  for (const NamedEffect& named : effects) names.push_back(named.effect->name);
  return fmt::format("{}", fmt::join(names, ", "));
}

/// Whether the parameters of an effect mean something: those of a drift that only forbids names do not.
bool has_meaning(const NamedEffect& named) {
  return std::ranges::all_of(named.sensors, [&](Sensor sensor) {
    const std::size_t s = index_of(sensor);
    return named.meaning[s].estimated.size() == static_cast<std::size_t>(named.parameters[s].size());
  });
}

/// What a report without named effects leaves to do.
std::string suspects_text(const GapReport& report) {
  std::vector<NamedEffect> suspects;
  std::ranges::copy_if(report.suspects, std::back_inserter(suspects), has_meaning);
  if (suspects.empty()) return {};
  return fmt::format("; suspected is {}, which '--suspect --effect NAME' takes all the same", list_of_names(suspects));
}

/// A sensor has its own shape on ramps, and then an entry of its own: they are parts of one term.
void add_term(ModelTerm term, std::vector<ModelTerm>& terms) {
  const auto same = std::ranges::find(terms, term.name, &ModelTerm::name);
  if (same == terms.end()) return terms.push_back(std::move(term));
  std::ranges::move(term.parts, std::back_inserter(same->parts));
  same->p_adjusted = std::max(same->p_adjusted, term.p_adjusted);
  same->delta_bic += term.delta_bic;
  same->heldout_gain = std::min(same->heldout_gain, term.heldout_gain);
}

}  // namespace

base::Result<std::vector<ModelTerm>> accepted_terms(const LoggedCampaign& campaign, const GapReport& report,
                                                    const std::vector<std::string>& names, Accepted accepted) {
  std::vector<NamedEffect> effects = report.effects;
  if (accepted == Accepted::suspected) std::ranges::copy_if(report.suspects, std::back_inserter(effects), has_meaning);
  if (effects.empty()) {
    return base::bad_input(fmt::format("nothing to accept: the verdict is '{}', {}{}", name_of(report.conclusion),
                                       report.reason, suspects_text(report)));
  }
  for (const std::string& name : names) {
    const bool known = std::any_of(effects.begin(), effects.end(),
                                   [&](const NamedEffect& named) { return named.effect->name == name; });
    if (!known) {
      return base::bad_input(fmt::format("'{}' is not among the effects {}: {}", name,
                                         accepted == Accepted::named ? "named" : "named or suspected",
                                         list_of_names(effects)));
    }
  }
  std::vector<ModelTerm> terms;
  for (const NamedEffect& named : effects) {
    if (!wanted(named, names)) continue;
    ModelTerm term = term_of(named, report);
    note_data(campaign, term);
    add_term(std::move(term), terms);
  }
  return terms;
}

}  // namespace soak::calib::gap
