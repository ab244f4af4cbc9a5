// SPDX-License-Identifier: Apache-2.0
#include "station/gap_comparison.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

#include "calib/model_document.h"
#include "calib/model_term_json.h"
#include "station/fit_unit.h"
#include "station/logged_campaign.h"

namespace soak::station {
namespace {

using calib::forward::SimulatedCampaign;
using calib::forward::SimulatedModel;

/// A gap less than this above the floor says nothing of how much of it was closed.
constexpr double kLeastOverFloor = 1.1;

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

/// The version that the first of the terms was found missing in.
std::int32_t version_before(const SimulatedModel& model) {
  std::int32_t version = model.calibration.model_version;
  for (const calib::ModelTerm& term : model.terms) version = std::min(version, term.parent_version);
  return version;
}

base::Result<calib::UnitInput> runs_to_compare(const db::Catalog& catalog, const calib::Calibration& calibration,
                                               const std::optional<std::string>& campaign) {
  auto input = unit_of(calibration);
  if (!input) return base::forward_error(input);
  const auto rows = catalog.runs({.unit = calibration.unit, .campaign = campaign, .run = {}});
  if (!rows) return base::forward_error(rows);
  for (const db::RunRow& row : *rows) {
    if (!row.sealed || row.voided || row.epoch != calibration.epoch || row.purpose == "diagnosis") continue;
    auto run = load_run(catalog, row);
    if (!run) return base::forward_error(run);
    input->runs.push_back(*std::move(run));
  }
  if (!input->runs.empty()) return input;
  return base::bad_input(fmt::format("unit {} has no run to compare{}", calibration.unit,
                                     campaign ? fmt::format(" in campaign '{}'", *campaign) : ""));
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

std::array<std::optional<SensorComparison>, calib::kSensorCount> figures(const GapComparison& comparison, bool fitted) {
  const auto before = calib::forward::compare(part_of(comparison.simulated_before, comparison.runs, fitted));
  const auto after = calib::forward::compare(part_of(comparison.simulated_after, comparison.runs, fitted));
  std::array<std::optional<SensorComparison>, calib::kSensorCount> result;
  for (std::size_t s = 0; s < calib::kSensorCount; ++s) {
    if (!before[s] || !after[s]) continue;
    SensorComparison sensor{before[s]->rms, after[s]->rms, after[s]->noise_rms, {}, {}};
    if (!comparison.terms.empty() && comparison.terms.back().gap[s]) {
      sensor.floor_rms = comparison.terms.back().gap[s]->floor_rms;
      if (sensor.before_rms > kLeastOverFloor * *sensor.floor_rms) {
        sensor.closed_fraction = (sensor.before_rms - sensor.after_rms) / (sensor.before_rms - *sensor.floor_rms);
      }
    }
    result[s] = sensor;
  }
  return result;
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
  const auto row_before = model_row(catalog, unit, version_before(*after));
  if (!row_before) return base::forward_error(row_before);
  const auto before = simulated_model(*row_before);
  if (!before) return base::forward_error(before);
  auto input = runs_to_compare(catalog, after->calibration, campaign);
  if (!input) return base::forward_error(input);

  GapComparison comparison;
  comparison.unit = unit;
  comparison.model = row->version;
  comparison.before = row_before->version;
  comparison.terms = after->terms;
  for (const calib::RunInput& run : input->runs) {
    comparison.runs.push_back(
        {run.label, run.run_id,
         lists(after->calibration, run.content_sha256) || lists(before->calibration, run.content_sha256)});
  }
  const auto logged = with_logs(catalog, *std::move(input), false);
  if (!logged) return base::forward_error(logged);
  comparison.simulated_before = calib::forward::simulate(*before, *logged);
  comparison.simulated_after = calib::forward::simulate(*after, *logged);
  comparison.fitted = figures(comparison, true);
  comparison.fresh = figures(comparison, false);
  return comparison;
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
          {"model", comparison.model},
          {"before", comparison.before},
          {"terms", calib::terms_json(comparison.terms)},
          {"runs", std::move(runs)},
          {"sensors", std::move(sensors)},
          {"not_evaluated", comparison.simulated_after.left_out}};
}

}  // namespace soak::station
