// SPDX-License-Identifier: Apache-2.0
#include "calib/gap/report/gap_report.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <optional>
#include <string_view>
#include <utility>

namespace soak::calib::gap {
namespace {

/// Why an effect is no term of a model, of what it was named in; nothing where it is one.
std::optional<std::string> why_no_term(const NamedEffect& named, JudgedOn judged_on) {
  const bool with_numbers = std::all_of(named.sensors.begin(), named.sensors.end(), [&](Sensor sensor) {
    const Meaning& meaning = named.meaning[index_of(sensor)];
    const auto count = static_cast<std::size_t>(named.parameters[index_of(sensor)].size());
    return meaning.estimated.size() == count && (count > 0 || !meaning.given.empty());
  });
  if (with_numbers) return std::nullopt;
  return judged_on == JudgedOn::runs
             ? "it is part of the curve over temperature, not an addition to it: the fitted curve follows it where "
               "plateaus are close enough"
             : "a recording without plateaus gives no parameters for a model; record plateaus in six positions";
}

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
  for (const Effect* rival : named.rivals) term.confusable_with.emplace_back(rival->name);
  for (std::size_t s = 0; s < kSensorCount; ++s) {
    if (const auto& gap = report.gap[s]) {
      term.gap[s] = {gap->before_rms, gap->after_rms, gap->floor_rms, gap->closed_fraction, gap->closed_ci95};
    }
  }
  return term;
}

void note_data(const LoggedCampaign& campaign, ModelTerm& term) {
  bool first = true;
  for (const LoggedRun& run : campaign.runs) {
    term.run_hashes.push_back(run.run.content_sha256);
    for (const Segment& segment : run.run.segments) {
      if (segment.phase != Phase::soak) continue;
      term.temp_min_c = first ? segment.temp_c : std::min(term.temp_min_c, segment.temp_c);
      term.temp_max_c = first ? segment.temp_c : std::max(term.temp_max_c, segment.temp_c);
      first = false;
    }
  }
}

bool wanted(const NamedEffect& named, const std::vector<std::string>& names) {
  return names.empty() || std::find(names.begin(), names.end(), named.effect->name) != names.end();
}

std::string named_list(const GapReport& report) {
  std::vector<std::string_view> names;
  for (const NamedEffect& named : report.effects) names.push_back(named.effect->name);
  return fmt::format("{}", fmt::join(names, ", "));
}

std::string in_words(const std::vector<NotAdded>& list) {
  std::vector<std::string> words;
  for (const NotAdded& entry : list) words.push_back(fmt::format("{}: {}", entry.name, entry.why));
  return fmt::format("{}", fmt::join(words, "; "));
}

}  // namespace

base::Result<Acceptance> accepted_terms(const LoggedCampaign& campaign, const GapReport& report,
                                        const std::vector<std::string>& names) {
  if (report.effects.empty()) {
    return base::bad_input(
        fmt::format("nothing to accept: the verdict is '{}', {}", name_of(report.conclusion), report.reason));
  }
  for (const std::string& name : names) {
    const bool known = std::any_of(report.effects.begin(), report.effects.end(),
                                   [&](const NamedEffect& named) { return named.effect->name == name; });
    if (!known)
      return base::bad_input(fmt::format("'{}' is not among the effects named: {}", name, named_list(report)));
  }
  Acceptance acceptance;
  for (const NamedEffect& named : report.effects) {
    if (!wanted(named, names)) continue;
    if (auto why = why_no_term(named, report.judged_on)) {
      acceptance.not_added.push_back({std::string(named.effect->name), *std::move(why)});
      continue;
    }
    acceptance.terms.push_back(term_of(named, report));
    note_data(campaign, acceptance.terms.back());
  }
  // Who asks for an effect by name wants that one, not the rest.
  if (acceptance.terms.empty() || (!names.empty() && !acceptance.not_added.empty())) {
    return base::bad_input("cannot be added to a model: " + in_words(acceptance.not_added));
  }
  return acceptance;
}

}  // namespace soak::calib::gap
