// SPDX-License-Identifier: Apache-2.0
#include "calib/model/deployed_terms.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <map>
#include <string>
#include <string_view>
#include <utility>

namespace soak::calib {
namespace {

constexpr std::array<std::string_view, 4> kMovingTerms = {"temperature_rate", "sensor_lag", "cross_axis",
                                                          "thermal_hysteresis"};
constexpr std::size_t kMostParameters = 255;  ///< of a term in a file

std::string mean_name(std::size_t number) { return fmt::format("mean_{}", number); }
std::string mean_temp_name(std::size_t number) { return mean_name(number) + "_c"; }

/// What is no pair of the mean stays a parameter.
TermPart part_of(const AcceptedTerm& accepted) {
  TermPart part;
  part.sensors = accepted.sensors;
  const std::map<std::string, double> numbers(accepted.parameters.begin(), accepted.parameters.end());
  for (std::size_t k = 1; numbers.contains(mean_temp_name(k)) && numbers.contains(mean_name(k)); ++k) {
    part.centre.emplace_back(numbers.at(mean_temp_name(k)), numbers.at(mean_name(k)));
  }
  for (const auto& [name, value] : accepted.parameters) {
    // A device takes the rate of its thermometer, not that of a node behind it; how the recording began in which the
    // effect was found says nothing of others.
    if (accepted.name == "temperature_rate" && (name == "tau_s" || name == "starts_under_way")) continue;
    if (accepted.name == "thermal_hysteresis" && name == "starts_along") continue;
    if (name.starts_with("mean_")) continue;
    part.parameters.push_back({name, value, ""});
  }
  return part;
}

}  // namespace

std::vector<AcceptedTerm> deployed_term(const ModelTerm& term) {
  std::vector<AcceptedTerm> deployed;
  for (const TermPart& part : term.parts) {
    AcceptedTerm& out = deployed.emplace_back();
    out.name = term.name;
    out.lab_only = term.lab_only;
    out.sensors = part.sensors;
    for (const TermParameter& parameter : part.parameters) out.parameters.emplace_back(parameter.name, parameter.value);
    if (term.lab_only || term.name != "thermal_hysteresis") continue;
    AcceptedTerm with_mean = out;
    for (std::size_t k = 0; k < part.centre.size(); ++k) {
      with_mean.parameters.emplace_back(mean_temp_name(k + 1), part.centre[k].first);
      with_mean.parameters.emplace_back(mean_name(k + 1), part.centre[k].second);
    }
    out.lab_only = with_mean.parameters.size() > kMostParameters || !can_be_followed(with_mean);
    if (!out.lab_only) out = std::move(with_mean);
  }
  return deployed;
}

void keep_in_the_lab_what_no_file_carries(std::vector<ModelTerm>& terms) {
  for (ModelTerm& term : terms) {
    term.lab_only = term.lab_only || std::ranges::any_of(deployed_term(term), &AcceptedTerm::lab_only);
  }
}

bool can_be_followed(const AcceptedTerm& term) {
  if (term.lab_only || term.name != "thermal_hysteresis") return true;
  const auto& list = term.parameters;
  const auto width = std::ranges::find(list, "width_c", &std::pair<std::string, double>::first);
  if (width == list.end() || !(static_cast<float>(width->second) > 0.0F)) return false;
  const auto first = std::ranges::find(list, mean_temp_name(1), &std::pair<std::string, double>::first);
  for (auto pair = first; pair != list.end(); pair += 2) {
    const auto number = static_cast<std::size_t>(pair - first) / 2 + 1;
    if (list.end() - pair < 2 || pair->first != mean_temp_name(number) || (pair + 1)->first != mean_name(number)) {
      return false;
    }
    if (pair != first && !(static_cast<float>(pair->second) > static_cast<float>((pair - 2)->second))) return false;
  }
  return true;
}

std::vector<ModelTerm> moving_terms(const Calibration& calibration) {
  std::vector<ModelTerm> terms;
  for (const AcceptedTerm& accepted : calibration.terms) {
    if (accepted.lab_only || std::ranges::find(kMovingTerms, accepted.name) == kMovingTerms.end()) continue;
    // A file has a section for each part of a term.
    if (terms.empty() || terms.back().name != accepted.name) terms.emplace_back().name = accepted.name;
    terms.back().parts.push_back(part_of(accepted));
  }
  return terms;
}

}  // namespace soak::calib
