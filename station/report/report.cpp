// SPDX-License-Identifier: Apache-2.0
#include "station/report/report.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <utility>

#include "calib/model_document.h"
#include "calib/report_json.h"
#include "station/report/noise.h"
#include "station/report/provenance.h"
#include "station/report/runs_of_model.h"
#include "station/unit_type_file.h"

namespace soak::station {
namespace {

using nlohmann::json;

base::Result<db::UnitRow> find_unit(const db::Catalog& catalog, const std::string& serial) {
  const auto unit = catalog.unit(serial);
  if (!unit) return base::forward_error(unit);
  if (*unit) return **unit;
  return base::bad_input(fmt::format("no unit '{}' in this data folder; 'soak unit list' shows them", serial));
}

base::Result<db::ModelRow> find_model(const db::Catalog& catalog, const ReportRequest& request) {
  const auto row = catalog.model(request.unit, request.model);
  if (!row) return base::forward_error(row);
  if (*row) return **row;
  return base::bad_input(request.model ? fmt::format("unit {} has no model version {}", request.unit, *request.model)
                                       : fmt::format("unit {} has no model yet; run 'soak fit --unit {}' first",
                                                     request.unit, request.unit));
}

/// Whether the model is the one that the unit would be deployed with today.
base::Result<std::vector<calib::Warning>> age_warnings(const db::Catalog& catalog, const db::UnitRow& unit,
                                                       const db::ModelRow& model) {
  std::vector<calib::Warning> warnings;
  if (model.epoch != unit.epoch) {
    warnings.push_back({"older_epoch", fmt::format("the model belongs to epoch {}; the unit has been repaired or "
                                                   "re-flashed since and is in epoch {}",
                                                   model.epoch, unit.epoch)});
  }
  const auto newest = catalog.model(unit.serial);
  if (!newest) return base::forward_error(newest);
  if (*newest && (*newest)->version != model.version) {
    warnings.push_back(
        {"older_model", fmt::format("this is model {}; the newest is {}", model.version, (*newest)->version)});
  }
  return warnings;
}

struct KnownLimits {
  calib::Limits limits;
  std::optional<std::string> source;
};

/// Those of the request, else of the unit's type.
base::Result<KnownLimits> limits_for(const ReportRequest& request, const calib::Calibration& calibration) {
  if (request.limits_source) return KnownLimits{request.limits, request.limits_source};
  const auto type = known_unit_type(calibration.unit_type);
  if (!type) return base::forward_error(type);
  if (type->limits == calib::Limits{}) return KnownLimits{};
  return KnownLimits{type->limits, "unit type " + type->name};
}

/// The laboratory's references that the fit recorded; null where the model was stored before there was a register.
json records_json(const std::string& document) {
  const json stored = json::parse(document, nullptr, false);
  const json::json_pointer references("/fit/references");
  return {{"references", stored.contains(references) ? stored[references] : json()}};
}

}  // namespace

base::Result<json> report_document(const db::Catalog& catalog, const ReportRequest& request) {
  const auto unit = find_unit(catalog, request.unit);
  if (!unit) return base::forward_error(unit);
  const auto model = find_model(catalog, request);
  if (!model) return base::forward_error(model);
  const auto calibration = calib::calibration_of(model->document);
  if (!calibration) return base::forward_error(calibration);
  const auto runs = runs_of_model(catalog, *calibration);
  if (!runs) return base::forward_error(runs);
  const auto fitted = input_of(catalog, *calibration, *runs, RunUse::fitted);
  if (!fitted) return base::forward_error(fitted);
  const auto fresh = input_of(catalog, *calibration, *runs, RunUse::fresh);
  if (!fresh) return base::forward_error(fresh);
  auto warnings = age_warnings(catalog, *unit, *model);
  if (!warnings) return base::forward_error(warnings);
  warnings->insert(warnings->end(), runs->warnings.begin(), runs->warnings.end());

  const auto limits = limits_for(request, *calibration);
  if (!limits) return base::forward_error(limits);
  auto sections =
      calib::report_json({model->document, *fitted, *fresh, limits->limits, limits->source, *std::move(warnings)});
  if (!sections) return base::forward_error(sections);
  auto noise = noise_json(catalog, request.unit, model->epoch, request.progress);
  if (!noise) return base::forward_error(noise);
  auto provenance = provenance_json(catalog, *model, *calibration, *runs);
  if (!provenance) return base::forward_error(provenance);
  (*sections)["noise"] = *std::move(noise);
  (*sections)["records"] = records_json(model->document);
  (*sections)["provenance"] = *std::move(provenance);
  return json{{"unit", request.unit},
              {"model", model->version},
              {"created_utc_s", request.created_utc_s},
              {"software", request.software},
              {"sections", *std::move(sections)}};
}

}  // namespace soak::station
