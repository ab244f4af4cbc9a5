// SPDX-License-Identifier: Apache-2.0
#include "station/fit/fit_job.h"

#include <fmt/format.h>

#include <set>
#include <string>
#include <utility>

#include "calib/model/model_document.h"
#include "station/fit/accepted_terms.h"
#include "station/fit/fit_unit.h"
#include "station/fit/reference_rule.h"

namespace soak::station {
namespace {

/// Content hashes of the runs that a model was fitted to.
base::Result<std::set<std::string>> runs_of(const db::ModelRow& model) {
  const auto calibration = calib::calibration_of(model.document);
  if (!calibration) return base::forward_error(calibration);
  return std::set<std::string>(calibration->run_hashes.begin(), calibration->run_hashes.end());
}

}  // namespace

base::Result<calib::UnitModel> fit_with_terms(db::Catalog& catalog, calib::UnitInput& input,
                                              const std::vector<calib::ModelTerm>& terms,
                                              const calib::CurveFitOptions& options, int jobs,
                                              CheckWarnings& check_warnings, std::vector<calib::Warning> warnings) {
  const auto checks = check_warnings.of(input);
  if (!checks) return base::forward_error(checks);
  warnings.insert(warnings.end(), checks->begin(), checks->end());
  const auto since = reference_warnings(catalog, input.references);
  if (!since) return base::forward_error(since);
  warnings.insert(warnings.end(), since->begin(), since->end());
  if (const auto taken = take_terms_off(catalog, terms, input, warnings); !taken) return base::forward_error(taken);
  return fit_unit(catalog, input, options, jobs, warnings);
}

base::Result<calib::UnitModel> fit_again(db::Catalog& catalog, const db::ModelRow& parent,
                                         const std::vector<calib::ModelTerm>& terms) {
  const auto options = calib::fit_options_of(parent.document);
  if (!options) return base::forward_error(options);
  auto known = runs_of(parent);
  if (!known) return base::forward_error(known);
  std::vector<calib::Warning> warnings;
  auto input = load_unit(catalog, parent.unit, {}, warnings);
  if (!input) return base::forward_error(input);
  std::erase_if(input->runs, [&](const calib::RunInput& run) { return known->count(run.content_sha256) == 0; });
  if (input->runs.empty()) {
    return base::bad_input(fmt::format("all runs of model {} of unit {} are void; 'soak fit --unit {}' fits the others",
                                       parent.version, parent.unit, parent.unit));
  }
  std::vector<std::string> campaigns;
  for (const calib::RunInput& run : input->runs) campaigns.push_back(run.campaign);
  auto references = references_of_campaigns(catalog, campaigns);
  if (!references) return base::forward_error(references);
  input->references = *std::move(references);
  if (input->runs.size() < known->size()) {
    warnings.push_back(
        {"runs_left_since", fmt::format("of the {} runs of model {}, {} were voided since and are left out",
                                        known->size(), parent.version, known->size() - input->runs.size())});
  }
  CheckWarnings check_warnings(catalog);
  return fit_with_terms(catalog, *input, terms, *options, 0, check_warnings, std::move(warnings));
}

}  // namespace soak::station
