// SPDX-License-Identifier: Apache-2.0
#include "station/fit/accepted_terms.h"

#include <algorithm>
#include <array>
#include <string_view>
#include <utility>

#include "calib/forward/simulation.h"
#include "calib/model/model_document.h"
#include "station/gap/gap_search.h"

namespace soak::station {
namespace {

constexpr std::array<std::string_view, 3> kMoving = {"temperature_rate", "sensor_lag", "cross_axis"};

}  // namespace

base::Result<std::vector<calib::ModelTerm>> accepted_terms(const db::Catalog& catalog, const std::string& unit,
                                                           std::int32_t epoch) {
  const auto model = catalog.model(unit);
  if (!model) return base::forward_error(model);
  if (!*model || (*model)->epoch != epoch) return std::vector<calib::ModelTerm>();
  return calib::model_terms_of((*model)->document);
}

std::vector<calib::ModelTerm> moving_terms(const calib::Calibration& calibration) {
  std::vector<calib::ModelTerm> terms;
  for (const calib::AcceptedTerm& accepted : calibration.terms) {
    if (std::find(kMoving.begin(), kMoving.end(), accepted.name) == kMoving.end()) continue;
    // A file has a section for each part of a term.
    if (terms.empty() || terms.back().name != accepted.name) {
      terms.emplace_back();
      terms.back().name = accepted.name;
    }
    calib::TermPart part;
    part.sensors = accepted.sensors;
    for (const auto& [name, value] : accepted.parameters) part.parameters.push_back({name, value, ""});
    terms.back().parts.push_back(std::move(part));
  }
  return terms;
}

base::Status take_terms_off(const db::Catalog& catalog, const std::vector<calib::ModelTerm>& terms,
                            calib::UnitInput& input, std::vector<calib::Warning>& warnings) {
  if (terms.empty()) return {};
  auto logged = with_logs(catalog, input, false);
  if (!logged) return base::forward_error(logged);
  // Mountings scatter, and the misalignment of the next one is as uncertain as that says: a fit must see it.
  std::vector<calib::ModelTerm> of_the_unit = terms;
  std::erase_if(of_the_unit, [](const calib::ModelTerm& term) { return term.name == "fixture_tilt"; });
  for (std::string& sentence : calib::forward::subtract_terms(of_the_unit, *logged)) {
    warnings.push_back({"term_not_evaluated", std::move(sentence)});
  }
  input.runs.clear();
  for (calib::gap::LoggedRun& run : logged->runs) input.runs.push_back(std::move(run.run));
  input.terms = terms;
  return {};
}

}  // namespace soak::station
