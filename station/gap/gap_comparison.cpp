// SPDX-License-Identifier: Apache-2.0
#include "station/gap/gap_comparison.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <ranges>
#include <string_view>
#include <utility>

#include "calib/model/document_parts.h"
#include "calib/model/model_document.h"
#include "station/fit/fit_unit.h"
#include "station/fit/reference_rule.h"
#include "station/gap/gap_search.h"

namespace soak::station {
namespace {

using calib::forward::SimulatedCampaign;
using calib::forward::SimulatedModel;

/// What one run alone must read above the floor for its gap to be more than its own scatter.
constexpr double kLeastOverFloor = 1.1;

/// Growth of an RMS that is more than the chance of other rows.
constexpr double kWorse = 1.05;

/// What to know of an accepted effect beside the figures; empty where they say it all.
std::string remark_on(const calib::ModelTerm& term) {
  if (!moves_blocks(term.name)) {
    return fmt::format("{} does not change what is compared here (blocks about each run's own mean)", term.name);
  }
  if (shown_by_fresh_runs(term.name) == ShownPart::nothing) {
    return fmt::format("{} is another in each mounting: nothing of it can be foreseen in a fresh run", term.name);
  }
  if (shown_by_fresh_runs(term.name) == ShownPart::within_a_run) {
    return fmt::format(
        "the unit itself does not correct {}; of it only what changes within a run shows here (blocks "
        "about each run's own mean)",
        term.name);
  }
  if (term.name == "scale_nonlinearity") {
    return "the unit itself does not correct scale_nonlinearity: the calibration file states it as even-order term";
  }
  if (!term.lab_only) return {};
  return fmt::format("the unit itself does not correct {}: 'soak verify' shows all of it", term.name);
}

base::Result<db::ModelRow> model_row(const db::Catalog& catalog, const std::string& unit,
                                     std::optional<std::int32_t> version) {
  const auto known = catalog.unit(unit);
  if (!known) return base::forward_error(known);
  if (!*known)
    return base::bad_input(fmt::format("no unit '{}' in this data folder; 'soak unit list' shows them", unit));
  const auto row = catalog.model(unit, version);
  if (!row) return base::forward_error(row);
  if (*row) return **row;
  return base::bad_input(version ? fmt::format("unit {} has no model version {}", unit, *version)
                                 : fmt::format("unit {} has no model yet; 'soak fit --unit {}' makes one", unit, unit));
}

base::Result<SimulatedModel> simulated_model(const db::ModelRow& row) {
  auto calibration = calib::calibration_of(row.document);
  if (!calibration) return base::forward_error(calibration);
  auto terms = calib::model_terms_of(row.document);
  if (!terms) return base::forward_error(terms);
  return SimulatedModel{*std::move(calibration), *std::move(terms)};
}

/// The newest version before a model that carries no term at all, of the same epoch: with others the difference would
/// not be that of its own. The model itself where it carries none.
base::Result<db::ModelRow> model_before(const db::Catalog& catalog, const db::ModelRow& row,
                                        const SimulatedModel& model) {
  if (model.terms.empty()) return row;
  for (std::int32_t version = row.version - 1; version > 0; --version) {
    auto earlier = model_row(catalog, row.unit, version);
    if (!earlier) return earlier;
    const auto terms = calib::model_terms_of(earlier->document);
    if (!terms) return base::forward_error(terms);
    if (earlier->epoch == row.epoch && terms->empty()) return earlier;
  }
  return base::bad_input(
      fmt::format("no version of unit {} before {} is without accepted effects", row.unit, row.version));
}

base::Result<calib::UnitInput> runs_to_compare(const db::Catalog& catalog, const calib::Calibration& calibration,
                                               const std::optional<std::string>& campaign) {
  auto input = unit_of(calibration);
  if (!input) return base::forward_error(input);
  const auto rows = catalog.runs({.unit = calibration.unit, .campaign = campaign, .run = {}});
  if (!rows) return base::forward_error(rows);
  for (const db::RunRow& row : *rows) {
    if (!row.sealed || row.voided || row.epoch != calibration.epoch || row.purpose == "diagnosis") continue;
    auto run = load_run(catalog, row, input->type);
    if (!run) return base::forward_error(run);
    input->runs.push_back(*std::move(run));
  }
  std::vector<std::string> campaigns;
  for (const calib::RunInput& run : input->runs) campaigns.push_back(run.campaign);
  auto references = references_of_campaigns(catalog, campaigns);
  if (!references) return base::forward_error(references);
  input->references = *std::move(references);
  if (!input->runs.empty()) return input;
  return base::bad_input(fmt::format("unit {} has no run to compare{}", calibration.unit,
                                     campaign ? fmt::format(" in campaign '{}'", *campaign) : ""));
}

/// Whether a term was estimated from a run.
bool rests_on(const std::vector<calib::ModelTerm>& terms, const std::string& hash) {
  return std::any_of(terms.begin(), terms.end(), [&](const calib::ModelTerm& term) {
    return std::find(term.run_hashes.begin(), term.run_hashes.end(), hash) != term.run_hashes.end();
  });
}

bool lists(const calib::Calibration& calibration, const std::string& hash) {
  return std::find(calibration.run_hashes.begin(), calibration.run_hashes.end(), hash) != calibration.run_hashes.end();
}

/// Only blocks of runs that were fitted, or of those that were not.
SimulatedCampaign part_of(const SimulatedCampaign& whole, const std::vector<ComparedRun>& runs, bool fitted) {
  SimulatedCampaign part;
  for (const auto& block : whole.blocks) {
    if (runs[static_cast<std::size_t>(block.run)].fitted == fitted) part.blocks.push_back(block);
  }
  return part;
}

/// (before − after)/(before − floor) over runs; nothing where before − floor is under two standard errors.
std::optional<double> closed_fraction(const std::vector<double>& before, const std::vector<double>& after,
                                      double floor) {
  double open = 0.0;
  double closed = 0.0;
  double squares = 0.0;
  double runs = 0.0;
  for (std::size_t r = 0; r < before.size(); ++r) {
    if (!std::isfinite(before[r]) || !std::isfinite(after[r])) continue;
    runs += 1.0;
    open += before[r] - floor;
    closed += before[r] - after[r];
    squares += (before[r] - floor) * (before[r] - floor);
  }
  const double mean = open / runs;
  const double least = runs > 1.0 ? 2.0 * std::sqrt(std::max(0.0, squares / runs - mean * mean) / (runs - 1.0))
                                  : (kLeastOverFloor - 1.0) * floor;
  if (runs == 0.0 || mean <= 0.0 || mean < least) return std::nullopt;
  return closed / open;
}

std::array<std::optional<SensorComparison>, calib::kSensorCount> figures(const GapComparison& comparison, bool fitted) {
  const auto before = calib::forward::compare(part_of(comparison.simulated_before, comparison.runs, fitted));
  const auto after = calib::forward::compare(part_of(comparison.simulated_after, comparison.runs, fitted));
  std::array<std::optional<SensorComparison>, calib::kSensorCount> result;
  for (std::size_t s = 0; s < calib::kSensorCount; ++s) {
    if (!before[s] || !after[s]) continue;
    SensorComparison sensor{before[s]->rms, after[s]->rms, after[s]->noise_rms, {}, {}};
    if (!comparison.terms.empty() && comparison.terms.back().gap[s]) {
      sensor.floor_rms = comparison.terms.back().gap[s]->floor_rms;
      // The floor is that of runs that were left out: fitted runs lie below it by what the fit took of their noise.
      if (!fitted) sensor.closed_fraction = closed_fraction(before[s]->runs, after[s]->runs, *sensor.floor_rms);
    }
    result[s] = sensor;
  }
  return result;
}

/// What the newest search in one of the two models has found of slow noise; nothing where there was none.
base::Result<std::vector<calib::gap::SensorWander>> slow_noise_found(const db::Catalog& catalog,
                                                                     const GapComparison& comparison) {
  const auto reports = catalog.gap_reports(comparison.unit);
  if (!reports) return base::forward_error(reports);
  for (const db::GapReportRow& report : std::views::reverse(*reports)) {
    if (report.model_version != comparison.model && report.model_version != comparison.before) continue;
    const auto document = nlohmann::json::parse(report.document, nullptr, false);
    if (document.is_object()) return calib::gap::slow_noise_of(document);
  }
  return std::vector<calib::gap::SensorWander>{};
}

nlohmann::json sensor_json(const std::optional<SensorComparison>& figures, double factor) {
  if (!figures) return nullptr;
  const auto optional = [](const std::optional<double>& value, double by) {
    return value ? nlohmann::json(*value * by) : nlohmann::json();
  };
  return {{"before_rms", figures->before_rms * factor},
          {"after_rms", figures->after_rms * factor},
          {"noise_rms", figures->noise_rms * factor},
          {"floor_rms", optional(figures->floor_rms, factor)},
          {"closed_fraction", optional(figures->closed_fraction, 1.0)}};
}

}  // namespace

base::Result<GapComparison> compare_gap(const db::Catalog& catalog, const std::string& unit,
                                        std::optional<std::int32_t> model, const std::optional<std::string>& campaign) {
  const auto row = model_row(catalog, unit, model);
  if (!row) return base::forward_error(row);
  const auto after = simulated_model(*row);
  if (!after) return base::forward_error(after);
  const auto row_before = model_before(catalog, *row, *after);
  if (!row_before) return base::forward_error(row_before);
  const auto before = simulated_model(*row_before);
  if (!before) return base::forward_error(before);
  auto input = runs_to_compare(catalog, after->calibration, campaign);
  if (!input) return base::forward_error(input);

  GapComparison comparison;
  comparison.unit = unit;
  comparison.simulated = after->calibration.simulated;
  comparison.model = row->version;
  comparison.before = row_before->version;
  comparison.terms = after->terms;
  for (const calib::RunInput& run : input->runs) {
    comparison.runs.push_back({run.label, run.run_id,
                               rests_on(after->terms, run.content_sha256) ||
                                   lists(after->calibration, run.content_sha256) ||
                                   lists(before->calibration, run.content_sha256)});
  }
  const auto logged = with_logs(catalog, *std::move(input), false);
  if (!logged) return base::forward_error(logged);
  comparison.at_plateaus = std::ranges::any_of(logged->runs, [](const calib::gap::LoggedRun& run) {
    return std::ranges::any_of(run.run.segments, [](const auto& segment) { return segment.plateau_c.has_value(); });
  });
  comparison.simulated_before = calib::forward::simulate(*before, *logged);
  comparison.simulated_after = calib::forward::simulate(*after, *logged);
  comparison.fitted = figures(comparison, true);
  comparison.fresh = figures(comparison, false);
  auto slow_noise = slow_noise_found(catalog, comparison);
  if (!slow_noise) return base::forward_error(slow_noise);
  comparison.slow_noise = *std::move(slow_noise);
  return comparison;
}

bool moves_blocks(std::string_view effect) {
  constexpr std::array<std::string_view, 3> kOthers = {"noise_vs_temperature", "quantization", "saturation"};
  return std::find(kOthers.begin(), kOthers.end(), effect) == kOthers.end();
}

ShownPart shown_by_fresh_runs(std::string_view effect) {
  if (!moves_blocks(effect) || effect == "fixture_tilt") return ShownPart::nothing;
  return effect == "aging_drift" ? ShownPart::within_a_run : ShownPart::all;
}

bool is_worse(const SensorComparison& figures) { return figures.after_rms > kWorse * figures.before_rms; }

bool is_better(const SensorComparison& figures) {
  return figures.closed_fraction && figures.before_rms > kWorse * figures.after_rms;
}

std::vector<std::string> remarks(const GapComparison& comparison) {
  std::vector<std::string> sentences;
  if (!comparison.terms.empty() && std::ranges::all_of(comparison.runs, &ComparedRun::fitted)) {
    sentences.emplace_back(
        "no run is fresh: only one that neither model was fitted to shows whether the gap has closed. Record one with "
        "a procedure whose purpose is verification, or import one with '--procedure verification'");
  }
  for (const calib::ModelTerm& term : comparison.terms) {
    if (std::string remark = remark_on(term); !remark.empty()) sentences.push_back(std::move(remark));
  }
  for (const calib::Sensor sensor : calib::kSensors) {
    const auto& fresh = comparison.fresh[calib::index_of(sensor)];
    if (!fresh || !is_worse(*fresh)) continue;
    sentences.push_back(
        fmt::format("{}: model {} agrees less well with the fresh runs than model {}: look at its curve in 'soak "
                    "report' before deploying it",
                    calib::name_of(sensor), comparison.model, comparison.before));
  }
  return sentences;
}

nlohmann::json comparison_json(const GapComparison& comparison) {
  nlohmann::json runs = nlohmann::json::array();
  for (const ComparedRun& run : comparison.runs) {
    runs.push_back({{"label", run.label}, {"run_id", run.run_id}, {"use", run.fitted ? "fitted" : "fresh"}});
  }
  nlohmann::json sensors = nlohmann::json::object();
  for (const calib::Sensor sensor : calib::kSensors) {
    const std::size_t s = calib::index_of(sensor);
    if (!comparison.fitted[s] && !comparison.fresh[s]) continue;
    const double factor = calib::printed_per_si(sensor);
    sensors[std::string(calib::name_of(sensor))] = {{"unit", calib::printed_unit(sensor)},
                                                    {"fitted", sensor_json(comparison.fitted[s], factor)},
                                                    {"fresh", sensor_json(comparison.fresh[s], factor)}};
  }
  return {{"unit", comparison.unit},
          {"simulated", comparison.simulated},
          {"model", comparison.model},
          {"before", comparison.before},
          {"terms", calib::terms_json(comparison.terms)},
          {"runs", std::move(runs)},
          {"sensors", std::move(sensors)},
          {"slow_noise", calib::gap::slow_noise_json(comparison.slow_noise)},
          {"not_evaluated", comparison.simulated_after.not_evaluated},
          {"remarks", remarks(comparison)}};
}

}  // namespace soak::station
