// SPDX-License-Identifier: Apache-2.0
#include "station/report/rows_of_model.h"

#include <fmt/format.h>

#include <string>
#include <utility>
#include <vector>

#include "calib/model/deployed_terms.h"
#include "calib/model/model_document.h"
#include "station/config/unit_type_file.h"
#include "station/fit/fit_unit.h"
#include "station/fit/reference_rule.h"
#include "station/io/data_folder.h"
#include "station/records/signing.h"

namespace soak::station {
namespace {

base::Result<db::ModelRow> find_model(const db::Catalog& catalog, const RowsRequest& request) {
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
    warnings.push_back(
        {"older_epoch",
         fmt::format("the model belongs to epoch {}; the unit has been repaired or re-flashed since and is in epoch {}",
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

/// Those of the request, else of the unit's type.
base::Result<KnownLimits> limits_for(const RowsRequest& request, const calib::Calibration& calibration) {
  if (request.source) return KnownLimits{request.limits, request.source};
  return limits_of_type(calibration.unit_type);
}

/// What must be told beside what fit and verification say.
base::Result<std::vector<calib::Warning>> station_warnings(const db::Catalog& catalog, const db::UnitRow& unit,
                                                           const db::ModelRow& model, const RunsOfModel& runs,
                                                           const calib::Calibration& calibration) {
  auto warnings = age_warnings(catalog, unit, model);
  if (!warnings) return warnings;
  const auto since = reference_warnings(catalog, calibration.references);
  if (!since) return base::forward_error(since);
  for (const auto& more : {runs.warnings, *since, waiver_warnings(calibration.references)}) {
    warnings->insert(warnings->end(), more.begin(), more.end());
  }
  return warnings;
}

base::Result<calib::UnitInput> input_less_terms(const db::Catalog& catalog, const calib::Calibration& calibration,
                                                const RunsOfModel& runs, RunUse use,
                                                const std::vector<calib::ModelTerm>& terms,
                                                std::vector<calib::Warning>& warnings) {
  auto input = input_of(catalog, calibration, runs, use, warnings);
  if (!input) return input;
  if (auto taken = take_terms_off(catalog, terms, *input, warnings); !taken) return base::forward_error(taken);
  return input;
}

}  // namespace

base::Result<RowsOfModel> rows_of_model(const db::Catalog& catalog, const RowsRequest& request) {
  const auto unit = find_unit(catalog, request.unit);
  if (!unit) return base::forward_error(unit);
  auto model = find_model(catalog, request);
  if (!model) return base::forward_error(model);
  auto calibration = calib::calibration_of(model->document);
  if (!calibration) return base::forward_error(calibration);
  auto runs = runs_of_model(catalog, *calibration);
  if (!runs) return base::forward_error(runs);
  auto warnings = station_warnings(catalog, *unit, *model, *runs, *calibration);
  if (!warnings) return base::forward_error(warnings);
  auto terms = calib::model_terms_of(model->document);
  if (!terms) return base::forward_error(terms);
  // Rows are shown as the curve was fitted: less the accepted terms. Fresh runs are judged as `soak verify` does: less
  // what a device corrects.
  auto fitted = input_less_terms(catalog, *calibration, *runs, RunUse::fitted, *terms, *warnings);
  if (!fitted) return base::forward_error(fitted);
  auto fresh =
      input_less_terms(catalog, *calibration, *runs, RunUse::fresh, calib::moving_terms(*calibration), *warnings);
  if (!fresh) return base::forward_error(fresh);
  const auto limits = limits_for(request, *calibration);
  if (!limits) return base::forward_error(limits);
  calib::ReportInput input{model->document, *std::move(fitted), *std::move(fresh),
                           limits->limits,  limits->source,     *std::move(warnings)};
  return RowsOfModel{*std::move(model), *std::move(calibration), *std::move(runs), *std::move(terms), std::move(input)};
}

}  // namespace soak::station
