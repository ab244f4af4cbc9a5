// SPDX-License-Identifier: Apache-2.0
#include "station/report/unit_overview.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <tuple>
#include <utility>
#include <vector>

#include "calib/judge/warning_list.h"
#include "calib/model/model_document.h"
#include "station/nav/free_inertial.h"
#include "station/records/calibration_reader.h"
#include "station/report/model_versions.h"
#include "station/report/runs_of_model.h"
#include "station/report/term_text.h"

namespace soak::station {
namespace {

using nlohmann::json;

/// What a page shows of a sensor's part of `soak fit --json`. An older document may lack some of it.
constexpr auto kOfSensor = {
    "deployed",         "scale_deployed", "rules", "train_rmse", "check_rmse", "check_rmse_shape",
    "run_to_run_sigma", "relative",       "runs",  "temp_min_c", "temp_max_c", "curve"};

/// Events that are looked through for new runs.
constexpr std::size_t kMostAdded = 100'000;

bool counts(const db::RunRow& run) { return !run.voided && run.purpose != "diagnosis"; }

bool can_be_fitted(const db::RunRow& run, const db::UnitRow& unit) {
  return run.sealed && !run.voided && run.purpose == "calibration" && run.epoch == unit.epoch;
}

/// Runs that count, and the newest of them.
json run_counts(const std::vector<db::RunRow>& runs, const db::UnitRow& unit) {
  std::size_t number = 0;
  std::size_t to_fit = 0;
  double newest_utc_s = 0.0;
  for (const db::RunRow& run : runs) {
    if (run.unit != unit.serial || !counts(run)) continue;
    ++number;
    if (can_be_fitted(run, unit)) ++to_fit;
    newest_utc_s = std::max(newest_utc_s, run.created_utc_s);
  }
  return {{"runs", number}, {"to_fit", to_fit}, {"newest_run_utc_s", newest_utc_s > 0.0 ? json(newest_utc_s) : json()}};
}

/// Campaigns with runs that the next fit takes, by name: [{"campaign", "runs"}].
json fit_campaigns(const std::vector<db::RunRow>& runs, const db::UnitRow& unit) {
  std::map<std::string, std::size_t> number;
  for (const db::RunRow& run : runs) {
    if (run.unit == unit.serial && can_be_fitted(run, unit)) ++number[run.campaign];
  }
  json list = json::array();
  for (const auto& [campaign, count] : number) list.push_back({{"campaign", campaign}, {"runs", count}});
  return list;
}

/// Campaigns with runs for a verification, the newest first: [{"campaign", "units"}]. Only units that can be verified
/// count: `epochs` of those whose newest model is of the epoch that they are in.
json check_campaigns(const std::vector<db::RunRow>& runs, const std::map<std::string, std::int32_t>& epochs) {
  struct Found {
    double newest_utc_s = 0.0;
    std::set<std::string> units;
  };
  std::map<std::string, Found> by_name;
  for (const db::RunRow& run : runs) {
    if (!run.sealed || run.voided || run.purpose != "verification") continue;
    if (const auto unit = epochs.find(run.unit); unit == epochs.end() || unit->second != run.epoch) continue;
    Found& found = by_name[run.campaign];
    found.newest_utc_s = std::max(found.newest_utc_s, run.created_utc_s);
    found.units.insert(run.unit);
  }
  std::vector<std::pair<std::string, Found>> sorted(by_name.begin(), by_name.end());
  std::ranges::stable_sort(sorted,
                           [](const auto& a, const auto& b) { return a.second.newest_utc_s > b.second.newest_utc_s; });
  json list = json::array();
  for (const auto& [name, found] : sorted) list.push_back({{"campaign", name}, {"units", found.units.size()}});
  return list;
}

json model_head(const db::ModelRow& model) {
  return {{"version", model.version}, {"epoch", model.epoch}, {"created_utc_s", model.created_utc_s}};
}

/// "fitted", "verified", "released" or "withdrawn".
base::Result<std::string> state_of(const db::Catalog& catalog, const db::ModelRow& model) {
  const auto heads = catalog.models(model.unit);
  if (!heads) return base::forward_error(heads);
  return std::ranges::find(*heads, model.version, &db::ModelHead::version)->state;
}

/// Why, by whom and when a model was withdrawn; null where it was not.
base::Result<json> withdrawn_part(const db::Catalog& catalog, const db::ModelRow& model) {
  const auto history = catalog.model_history(model.unit, model.version);
  if (!history) return base::forward_error(history);
  const auto row = std::ranges::find(*history, "withdrawn", &db::ModelStateRow::state);
  if (row == history->end()) return json();
  return json{{"reason", row->reason}, {"user", row->user}, {"utc_s", row->utc_s}};
}

/// The accepted effects of a model, with their sizes in words.
base::Result<json> terms_part(const db::Catalog& catalog, const db::ModelRow& model) {
  const auto terms = calib::model_terms_of(model.document);
  if (!terms) return base::forward_error(terms);
  json list = json::array();
  for (const calib::ModelTerm& term : *terms) {
    auto sizes = size_lines(catalog, model.unit, term);
    if (!sizes) return base::forward_error(sizes);
    list.push_back({{"name", term.name}, {"lab_only", term.lab_only}, {"sizes", *std::move(sizes)}});
  }
  return list;
}

/// What the runs of a campaign are to a model.
struct CampaignOfModel {
  std::string name;
  std::size_t runs = 0;       ///< that are sealed and count
  double newest_utc_s = 0.0;  ///< of them
  bool verifies = false;      ///< one of them is of a verification
  bool fitted = false;        ///< one of them is in the model
};

/// Those for verification first, then the newest first.
std::vector<CampaignOfModel> campaigns_of(const RunsOfModel& found) {
  std::map<std::string, CampaignOfModel> by_name;
  for (const UsedRun& used : found.runs) {
    if (used.use != RunUse::fitted && used.use != RunUse::fresh && used.use != RunUse::not_used) continue;
    CampaignOfModel& campaign = by_name[used.run.campaign];
    campaign.name = used.run.campaign;
    ++campaign.runs;
    campaign.newest_utc_s = std::max(campaign.newest_utc_s, used.run.created_utc_s);
    campaign.verifies |= used.use == RunUse::fresh;
    campaign.fitted |= used.use == RunUse::fitted;
  }
  std::vector<CampaignOfModel> campaigns;
  for (auto& [name, campaign] : by_name) campaigns.push_back(std::move(campaign));
  std::ranges::stable_sort(campaigns, [](const CampaignOfModel& a, const CampaignOfModel& b) {
    return std::tie(a.verifies, a.newest_utc_s) > std::tie(b.verifies, b.newest_utc_s);
  });
  return campaigns;
}

/// `verify_with`, the campaigns that can judge a model, none of whose runs it has seen; and those that it was fitted
/// to.
void add_campaigns(const RunsOfModel& found, json& overview) {
  for (const CampaignOfModel& campaign : campaigns_of(found)) {
    json entry = {{"campaign", campaign.name}, {"runs", campaign.runs}};
    if (!campaign.fitted) entry["purpose"] = campaign.verifies ? "verification" : "calibration";
    overview[campaign.fitted ? "fitted_to" : "verify_with"].push_back(std::move(entry));
  }
}

json sensor_part(const std::string& name, const json& sensor) {
  json part = {{"unit", name.starts_with("gyro") ? "deg/s" : "m/s2"}};
  for (const char* key : kOfSensor) part[key] = sensor.value(key, json());
  return part;
}

base::Result<json> model_part(const db::Catalog& catalog, const db::ModelRow& model,
                              const calib::Calibration& calibration, const json& fit) {
  json part = model_head(model);
  auto terms = terms_part(catalog, model);
  if (!terms) return base::forward_error(terms);
  part["terms"] = *std::move(terms);
  const auto state = state_of(catalog, model);
  if (!state) return base::forward_error(state);
  part["state"] = *state;
  auto withdrawn = withdrawn_part(catalog, model);
  if (!withdrawn) return withdrawn;
  part["withdrawn"] = *std::move(withdrawn);
  part["simulated"] = calibration.simulated;
  part["impact"] = impact_json(calibration);
  part["sensors"] = json::object();
  for (const auto& [name, sensor] : fit.at("sensors").items()) part["sensors"][name] = sensor_part(name, sensor);
  return part;
}

json fit_of(const db::ModelRow& model) { return json::parse(model.document, nullptr, false)["fit"]; }

base::Status add_model(const db::Catalog& catalog, const db::ModelRow& model, json& overview) {
  const auto calibration = calib::calibration_of(model.document);
  if (!calibration) return base::forward_error(calibration);
  const auto runs = runs_of_model(catalog, *calibration);
  if (!runs) return base::forward_error(runs);
  const json fit = fit_of(model);
  auto part = model_part(catalog, model, *calibration, fit);
  if (!part) return base::forward_error(part);
  calib::WarningList warnings;
  if (calibration->simulated) {
    warnings.add({"simulated", "the model comes from SIMULATED data: it is not of a real unit"});
  }
  for (const calib::Warning& warning : runs->warnings) warnings.add(warning);
  warnings.add_fit(fit);
  overview["model"] = *std::move(part);
  overview["warnings"] = warnings.take();
  add_campaigns(*runs, overview);
  return {};
}

base::Result<db::UnitRow> known_unit(const db::Catalog& catalog, const std::string& serial) {
  auto unit = catalog.unit(serial);
  if (!unit) return base::forward_error(unit);
  if (!*unit) return base::bad_input("there is no such unit; /api/v1/units lists those that there are", "unit");
  return **std::move(unit);
}

/// Refuses a version, and says which there are instead: they count from 1.
tl::unexpected<base::Error> no_such_model(const db::Catalog& catalog, const std::string& serial, std::int32_t version) {
  const auto newest = catalog.model(serial);
  if (!newest) return base::forward_error(newest);
  const std::string there =
      *newest ? fmt::format("its newest is {}", (*newest)->version) : std::string("it has none yet");
  return base::bad_input(fmt::format("unit {} has no model {}: {}", serial, version, there), "version");
}

}  // namespace

base::Result<json> units_overview(const db::Catalog& catalog) {
  const auto units = catalog.units();
  if (!units) return base::forward_error(units);
  const auto runs = catalog.runs({.unit = {}, .campaign = {}, .run = {}});
  if (!runs) return base::forward_error(runs);
  std::map<std::string, std::vector<db::RunRow>> of_unit;
  for (const db::RunRow& run : *runs) of_unit[run.unit].push_back(run);
  const auto heads = catalog.models();
  if (!heads) return base::forward_error(heads);
  std::map<std::string, std::string> states;  // of the newest version
  for (const db::ModelHead& head : *heads) states[head.unit] = head.state;
  std::map<std::string, std::int32_t> with_model;
  std::vector<json> list;
  for (const db::UnitRow& unit : *units) {
    json entry = {
        {"unit", unit.serial}, {"type", unit.type}, {"epoch", unit.epoch}, {"model", nullptr}, {"trouble", nullptr}};
    entry.update(run_counts(of_unit[unit.serial], unit));
    const auto model = catalog.model(unit.serial);
    // One that is damaged must not keep the others from being seen.
    if (!model)
      entry["trouble"] = model.error().message;
    else if (*model) {
      entry["model"] = model_head(**model);
      entry["model"]["state"] = states[unit.serial];
      if ((*model)->epoch == unit.epoch) with_model[unit.serial] = unit.epoch;
    }
    list.push_back(std::move(entry));
  }
  const auto newest = [](const json& entry) {
    return entry["newest_run_utc_s"].is_null() ? 0.0 : entry["newest_run_utc_s"].get<double>();
  };
  std::ranges::stable_sort(list, [&](const json& a, const json& b) { return newest(a) > newest(b); });
  return json{{"units", std::move(list)}, {"check_campaigns", check_campaigns(*runs, with_model)}};
}

base::Result<json> unit_overview(const db::Catalog& catalog, const std::string& serial) {
  const auto unit = known_unit(catalog, serial);
  if (!unit) return base::forward_error(unit);
  const auto runs = catalog.runs({.unit = serial, .campaign = {}, .run = {}});
  if (!runs) return base::forward_error(runs);
  const auto model = catalog.model(serial);
  if (!model) return base::forward_error(model);
  json overview = {{"unit", serial},
                   {"type", unit->type},
                   {"epoch", unit->epoch},
                   {"model", nullptr},
                   {"warnings", json::array()},
                   {"verify_with", json::array()},
                   {"fitted_to", json::array()}};
  overview.update(run_counts(*runs, *unit));
  overview["fit_campaigns"] = fit_campaigns(*runs, *unit);
  const auto versions = model_versions(catalog, *unit);
  if (!versions) return base::forward_error(versions);
  overview.update(*versions);
  if (*model) {
    if (auto added = add_model(catalog, **model, overview); !added) return base::forward_error(added);
  }
  return overview;
}

base::Result<json> model_overview(const db::Catalog& catalog, const std::string& serial, std::int32_t version) {
  const auto unit = known_unit(catalog, serial);
  if (!unit) return base::forward_error(unit);
  const auto model = catalog.model(serial, version);
  if (!model) return base::forward_error(model);
  if (!*model) return no_such_model(catalog, serial, version);
  const auto calibration = calib::calibration_of((*model)->document);
  if (!calibration) return base::forward_error(calibration);
  auto part = model_part(catalog, **model, *calibration, fit_of(**model));
  if (!part) return part;
  return json{{"unit", serial}, {"model", *std::move(part)}};
}

base::Result<ModelCalibration> calibration_of_model(const db::Catalog& catalog, const std::string& serial,
                                                    std::optional<std::int32_t> version) {
  const auto unit = known_unit(catalog, serial);
  if (!unit) return base::forward_error(unit);
  const auto model = catalog.model(serial, version);
  if (!model) return base::forward_error(model);
  if (!*model && version) return no_such_model(catalog, serial, *version);
  if (!*model) {
    return base::bad_input(fmt::format("unit {} has no model yet: fit it first", serial), "unit");
  }
  auto calibration = calib::calibration_of((*model)->document);
  if (!calibration) return base::forward_error(calibration);
  return ModelCalibration{(*model)->version, *std::move(calibration)};
}

base::Result<std::string> doubt_of(const db::Catalog& catalog, const calib::Calibration& calibration) {
  const auto withdrawn = withdrawn_since(catalog, calibration);
  if (!withdrawn) return base::forward_error(withdrawn);
  const auto found = std::ranges::find_if(*withdrawn, [](const calib::Warning& warning) {
    return warning.code == "voided_since" || warning.code == "reference_withdrawn";
  });
  return found == withdrawn->end() ? std::string() : found->text;
}

base::Result<std::string> doubt_of_model(const db::Catalog& catalog, const std::string& serial) {
  const auto model = catalog.model(serial);
  if (!model) return base::forward_error(model);
  if (!*model) return std::string();
  const auto calibration = calib::calibration_of((*model)->document);
  if (!calibration) return base::forward_error(calibration);
  return doubt_of(catalog, *calibration);
}

base::Result<bool> withdrawn_since_start(const db::Catalog& catalog, const std::string& unit,
                                         const std::optional<std::string>& campaign, double utc_s) {
  const auto runs = catalog.runs({.unit = unit, .campaign = campaign, .run = {}});
  if (!runs) return base::forward_error(runs);
  for (const db::RunRow& run : *runs) {
    const auto voids = catalog.voids(run.run_id);
    if (!voids) return base::forward_error(voids);
    const auto later = [&](const db::VoidRecord& record) { return record.unit == unit && record.utc_s >= utc_s; };
    if (std::ranges::any_of(*voids, later)) return true;
  }
  return false;
}

base::Result<bool> recorded_since(const db::Catalog& catalog, const std::string& unit, double utc_s, bool only_fitted) {
  const auto runs = catalog.runs({.unit = unit, .campaign = {}, .run = {}});
  if (!runs) return base::forward_error(runs);
  // When a run was entered only its event knows: the run itself names its beginning.
  const auto added = catalog.find_events({.kind = "run_added",
                                          .subject = {},
                                          .user = {},
                                          .from_utc_s = utc_s,
                                          .to_utc_s = {},
                                          .before = {},
                                          .most = kMostAdded});
  if (!added) return base::forward_error(added);
  return std::ranges::any_of(*added, [&](const db::EventRow& event) {
    return std::ranges::any_of(*runs, [&](const db::RunRow& run) {
      return run.run_id == event.subject && counts(run) && (!only_fitted || run.purpose == "calibration");
    });
  });
}

}  // namespace soak::station
