// SPDX-License-Identifier: Apache-2.0
#include "station/gap/gap_search.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "base/statistics.h"
#include "calib/curve/curve_fit.h"
#include "calib/estimate/certificates.h"
#include "calib/estimate/site.h"
#include "calib/forward/simulation.h"
#include "calib/gap/campaign/campaign.h"
#include "calib/gap/campaign/fine_temperature.h"
#include "calib/model/model_document.h"
#include "db/run/run_file.h"
#include "station/fit/fit_unit.h"
#include "station/lab/run_recorder.h"
#include "station/runs/recording_reader.h"
#include "station/runs/still_segment.h"

namespace soak::station {
namespace {

/// Unix time of device time 0: the median over all rows that have both.
std::optional<double> start_utc_s(const calib::Recording& recording) {
  std::vector<double> starts;
  for (const calib::AuxiliaryChannel& channel : recording.auxiliary) {
    if (channel.name != "utc_s") continue;
    for (std::size_t i = 0; i < recording.t_s.size(); ++i) {
      if (std::isfinite(channel.values[i])) starts.push_back(channel.values[i] - recording.t_s[i]);
    }
  }
  if (starts.empty()) return std::nullopt;
  return base::median(starts);
}

/// The runs that have no time of their own begin when the station says.
void add_times_of_the_station(calib::gap::LoggedCampaign& logged, const std::vector<db::RunInfo>& infos) {
  const auto begun = begun_utc_s(infos);
  for (std::size_t i = 0; i < logged.runs.size(); ++i) {
    if (!logged.runs[i].start_utc_s) logged.runs[i].start_utc_s = begun[i];
  }
}

base::Status look_at_samples(const db::RunFileReader& file, const std::string& unit,
                             std::array<calib::gap::SampleFacts, calib::kSensorCount>& facts) {
  std::vector<double> values;
  for (const calib::Sensor sensor : calib::kSensors) {
    if (const auto read = read_sensor(file, unit, sensor, values); !read) return read;
    facts[calib::index_of(sensor)].add(calib::gap::sample_facts(values));
  }
  return {};
}

/// The newest model of the unit, if it is one of the unit as it is now.
base::Result<db::ModelRow> present_model(const db::Catalog& catalog, const std::string& serial) {
  const auto unit = catalog.unit(serial);
  if (!unit) return base::forward_error(unit);
  if (!*unit) {
    return base::bad_input(fmt::format("no unit '{}' in this data folder; 'soak unit list' shows them", serial));
  }
  const auto model = catalog.model(serial);
  if (!model) return base::forward_error(model);
  if (!*model) {
    return base::bad_input(fmt::format("unit {} has no model yet; 'soak fit --unit {}' makes one", serial, serial));
  }
  if ((*model)->epoch != (*unit)->epoch) {
    return base::bad_input(fmt::format(
        "model {} of unit {} belongs to epoch {}, but the unit is now in epoch {}: run 'soak fit --unit {}'",
        (*model)->version, serial, (*model)->epoch, (*unit)->epoch, serial));
  }
  return **model;
}

/// Refuses a model of constants: effects are looked for in what a curve over temperature leaves.
base::Status check_curves(const db::ModelRow& model) {
  const auto calibration = calib::calibration_of(model.document);
  if (!calibration) return base::forward_error(calibration);
  const auto is_constant = [](const calib::SensorCalibration& sensor) {
    return sensor.model == calib::name_of(calib::Family::constant);
  };
  if (!std::ranges::all_of(calibration->sensors, is_constant)) return {};
  return base::bad_input(
      fmt::format("model {} of unit {} holds constants, measured at one temperature: what a thermal model lacks shows "
                  "only in campaigns of three temperatures or more",
                  model.version, model.unit));
}

/// What the Allan document of a sensor says of its bias instability; nothing where its curve does not show it.
std::optional<calib::gap::InstabilityAtRest> instability_of(const nlohmann::json& allan, calib::Sensor sensor,
                                                            const StillSegment& still) {
  if (!allan.contains("coefficients") || !allan["coefficients"].contains("bias_instability")) return std::nullopt;
  const nlohmann::json& found = allan["coefficients"]["bias_instability"];
  const nlohmann::json& ci95 = found["ci95"];
  if (!found.value("found", false) || !ci95[0].is_number() || !ci95[1].is_number()) return std::nullopt;
  const double factor = calib::printed_per_si(sensor);
  return calib::gap::InstabilityAtRest{.value = found["value"].get<double>() / factor,
                                       .low = ci95[0].get<double>() / factor,
                                       .high = ci95[1].get<double>() / factor,
                                       .tau_s = allan["bias_instability_tau_s"].get<double>(),
                                       .campaign = still.run.campaign,
                                       .run = still.run.label,
                                       .duration_s = allan["samples"].get<double>() / allan["rate_hz"].get<double>()};
}

}  // namespace

std::vector<std::optional<double>> begun_utc_s(const std::vector<db::RunInfo>& runs) {
  std::map<double, std::vector<std::size_t>> by_rate;  // those that the station recorded
  for (std::size_t i = 0; i < runs.size(); ++i) {
    if (runs[i].source == kRunSource) by_rate[runs[i].clock_rate].push_back(i);
  }
  std::vector<std::optional<double>> begun(runs.size());
  if (by_rate.empty()) return begun;
  const auto& [rate, most] =
      *std::ranges::max_element(by_rate, {}, [](const auto& entry) { return entry.second.size(); });
  const double first_s = runs[most.front()].created_utc_s;
  for (const std::size_t i : most) begun[i] = first_s + (runs[i].created_utc_s - first_s) * rate;
  return begun;
}

base::Result<calib::gap::LoggedCampaign> with_logs(const db::Catalog& catalog, calib::UnitInput input,
                                                   bool with_samples) {
  calib::gap::LoggedCampaign logged;
  logged.unit = input.unit;
  logged.type = input.type;
  std::vector<db::RunInfo> infos;
  const auto rows = catalog.runs({.unit = input.unit, .campaign = {}, .run = {}});
  if (!rows) return base::forward_error(rows);
  for (calib::RunInput& run : input.runs) {
    const auto row =
        std::find_if(rows->begin(), rows->end(), [&](const db::RunRow& r) { return r.run_id == run.run_id; });
    if (row == rows->end()) continue;
    const auto file = catalog.open_run_file(*row);
    if (!file) return base::forward_error(file);
    const auto recording = read_axes(*file, input.unit);
    if (!recording) return base::forward_error(recording);
    calib::gap::LoggedRun entry;
    entry.log = calib::gap::make_run_log(*recording);
    calib::correct_supply(entry.log.supply_v, input.references, run.campaign);
    logged.thermometer.add(calib::gap::sample_facts(recording->temp_c));
    entry.start_utc_s = start_utc_s(*recording);
    if (with_samples) {
      if (auto looked = look_at_samples(*file, input.unit, logged.samples); !looked) return base::forward_error(looked);
    }
    entry.run = std::move(run);
    entry.run.site = calib::with_reference_gravity(entry.run.site, input.references);
    logged.runs.push_back(std::move(entry));
    infos.push_back(file->info());
  }
  add_times_of_the_station(logged, infos);
  calib::gap::refine_logs(logged);
  return logged;
}

base::Result<calib::gap::LoggedCampaign> load_logged_campaign(const db::Catalog& catalog, const std::string& unit,
                                                              const std::optional<std::string>& campaign) {
  std::vector<calib::Warning> told_by_the_fit;
  auto input = load_unit(catalog, unit, campaign, told_by_the_fit);
  if (!input) return base::forward_error(input);
  auto logged = with_logs(catalog, *std::move(input), true);
  if (logged) calib::gap::refine_blocks(*logged);
  return logged;
}

base::Result<GapSearch> search_gap(const db::Catalog& catalog, const std::string& unit,
                                   const std::optional<std::string>& campaign,
                                   const std::function<void(std::string_view)>& begin) {
  begin("reading");
  auto model = present_model(catalog, unit);
  if (!model) return base::forward_error(model);
  if (const auto curves = check_curves(*model); !curves) return base::forward_error(curves);
  auto terms = calib::model_terms_of(model->document);
  if (!terms) return base::forward_error(terms);
  auto logged = load_logged_campaign(catalog, unit, campaign);
  if (!logged) return base::forward_error(logged);
  GapSearch search;
  search.model = *std::move(model);
  search.terms = *std::move(terms);
  search.campaign = *std::move(logged);
  search.warnings = calib::forward::subtract_terms(search.terms, search.campaign);
  begin("searching");
  search.report = calib::gap::find_gap(search.campaign, search.model.version);
  return search;
}

base::Status set_beside_rest(const db::Catalog& catalog, GapSearch& search) {
  std::vector<calib::gap::SensorWander>& wanders = search.report.slow_noise;
  if (wanders.empty()) return {};
  const auto longest = longest_still_segment(catalog, search.model.unit, search.model.epoch);
  if (!longest) return base::forward_error(longest);
  if (!*longest || length_s((*longest)->segment) < 0.99 * calib::kKalibrLeastStill_s) return {};
  for (calib::gap::SensorWander& wander : wanders) {
    if ((*longest)->segment.sensor[calib::index_of(wander.sensor)].count == 0) continue;
    const auto allan = allan_at_rest(catalog, **longest, wander.sensor);
    if (!allan) {
      search.warnings.push_back(
          fmt::format("run '{}' of campaign '{}', the unit's longest rest, cannot be read, so that no bias instability "
                      "stands beside slow noise: {}",
                      (*longest)->run.label, (*longest)->run.campaign, allan.error().message));
      return {};
    }
    wander.at_rest = instability_of(*allan, wander.sensor, **longest);
  }
  return {};
}

base::Status set_beside_rest_as_found(const db::Catalog& catalog, GapSearch& search) {
  if (search.report.slow_noise.empty()) return {};
  const auto reports = catalog.gap_reports(search.model.unit);
  if (!reports) return base::forward_error(reports);
  const auto of_this_model = [&](const db::GapReportRow& row) { return row.model_version == search.model.version; };
  const auto newest = std::find_if(reports->rbegin(), reports->rend(), of_this_model);
  if (newest == reports->rend()) return {};
  const auto document = nlohmann::json::parse(newest->document, nullptr, false);
  if (!document.is_object()) return {};
  for (const calib::gap::SensorWander& known : calib::gap::slow_noise_of(document)) {
    for (calib::gap::SensorWander& wander : search.report.slow_noise) {
      if (wander.sensor == known.sensor) wander.at_rest = known.at_rest;
    }
  }
  return {};
}

}  // namespace soak::station
