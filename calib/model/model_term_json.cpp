// SPDX-License-Identifier: Apache-2.0
#include "calib/model/model_term_json.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <string>

namespace soak::calib {
namespace {

using nlohmann::json;

json part_json(const TermPart& part) {
  json sensors = json::array();
  for (const Sensor sensor : part.sensors) sensors.push_back(name_of(sensor));
  json parameters = json::array();
  for (const TermParameter& parameter : part.parameters) {
    parameters.push_back({{"name", parameter.name}, {"value", parameter.value}, {"unit", parameter.unit}});
  }
  return {{"sensors", std::move(sensors)},
          {"parameters", std::move(parameters)},
          {"covariance", part.covariance},
          {"centre", part.centre}};
}

json gap_json(const TermGap& gap) {
  json interval;
  if (gap.closed_ci95) interval = {gap.closed_ci95->first, gap.closed_ci95->second};
  return {{"before_rms", gap.before_rms},
          {"after_rms", gap.after_rms},
          {"floor_rms", gap.floor_rms},
          {"closed_fraction", gap.closed_fraction ? json(*gap.closed_fraction) : json()},
          {"closed_ci95", std::move(interval)}};
}

json term_json(const ModelTerm& term) {
  json parts = json::array();
  for (const TermPart& part : term.parts) parts.push_back(part_json(part));
  json gaps = json::object();
  for (const Sensor sensor : kSensors) {
    if (const auto& gap = term.gap[index_of(sensor)]) gaps[std::string(name_of(sensor))] = gap_json(*gap);
  }
  return {{"name", term.name},
          {"library", term.library},
          {"parent_version", term.parent_version},
          {"lab_only", term.lab_only},
          {"parts", std::move(parts)},
          {"temp_min_c", term.temp_min_c},
          {"temp_max_c", term.temp_max_c},
          {"p_adjusted", term.p_adjusted},
          {"delta_bic", term.delta_bic},
          {"heldout_gain", term.heldout_gain},
          {"verdict", term.verdict},
          {"confusable_with", term.confusable_with},
          {"run_hashes", term.run_hashes},
          {"gap", std::move(gaps)}};
}

base::Result<TermPart> part_of(const json& document) {
  TermPart part;
  for (const json& name : document.at("sensors")) {
    const auto sensor = sensor_named(name.get<std::string>());
    if (!sensor) return base::corrupt(fmt::format("unknown sensor '{}'", name.get<std::string>()), "accepted term");
    part.sensors.push_back(*sensor);
  }
  for (const json& entry : document.at("parameters")) {
    part.parameters.push_back(
        {entry.at("name").get<std::string>(), entry.at("value").get<double>(), entry.at("unit").get<std::string>()});
  }
  part.covariance = document.at("covariance").get<std::vector<double>>();
  part.centre = document.at("centre").get<std::vector<std::pair<double, double>>>();
  const auto side = static_cast<std::size_t>(std::lround(std::sqrt(static_cast<double>(part.covariance.size()))));
  if (side * side != part.covariance.size() || side > part.parameters.size()) {
    return base::corrupt("a covariance that does not belong to the parameters", "accepted term");
  }
  for (std::size_t i = 0; i < side; ++i) {
    if (!(part.covariance[i * side + i] >= 0.0)) return base::corrupt("a negative variance", "accepted term");
  }
  for (const char* shape : {"width_c", "tau_s"}) {
    const auto value = part.value(shape);
    if (value && !(*value > 0.0)) return base::corrupt(fmt::format("{} must be above 0", shape), "accepted term");
  }
  return part;
}

TermGap gap_of(const json& document) {
  TermGap gap;
  gap.before_rms = document.at("before_rms").get<double>();
  gap.after_rms = document.at("after_rms").get<double>();
  gap.floor_rms = document.at("floor_rms").get<double>();
  if (!document.at("closed_fraction").is_null()) gap.closed_fraction = document["closed_fraction"].get<double>();
  if (!document.at("closed_ci95").is_null()) {
    gap.closed_ci95 = {document["closed_ci95"].at(0).get<double>(), document["closed_ci95"].at(1).get<double>()};
  }
  return gap;
}

base::Result<ModelTerm> term_of(const json& document) {
  ModelTerm term;
  term.name = document.at("name").get<std::string>();
  term.library = document.at("library").get<std::string>();
  if (!document.at("parent_version").is_number_integer()) {
    return base::corrupt("parent_version must be a whole number", "accepted term");
  }
  term.parent_version = document["parent_version"].get<std::int32_t>();
  term.lab_only = document.at("lab_only").get<bool>();
  for (const json& entry : document.at("parts")) {
    auto part = part_of(entry);
    if (!part) return base::forward_error(part);
    term.parts.push_back(*std::move(part));
  }
  term.temp_min_c = document.at("temp_min_c").get<double>();
  term.temp_max_c = document.at("temp_max_c").get<double>();
  term.p_adjusted = document.at("p_adjusted").get<double>();
  term.delta_bic = document.at("delta_bic").get<double>();
  term.heldout_gain = document.at("heldout_gain").get<double>();
  term.verdict = document.at("verdict").get<std::string>();
  term.confusable_with = document.at("confusable_with").get<std::vector<std::string>>();
  term.run_hashes = document.at("run_hashes").get<std::vector<std::string>>();
  for (const Sensor sensor : kSensors) {
    const auto found = document.at("gap").find(std::string(name_of(sensor)));
    if (found != document.at("gap").end()) term.gap[index_of(sensor)] = gap_of(*found);
  }
  return term;
}

}  // namespace

json terms_json(const std::vector<ModelTerm>& terms) {
  json list = json::array();
  for (const ModelTerm& term : terms) list.push_back(term_json(term));
  return list;
}

base::Result<std::vector<ModelTerm>> terms_of(const json& document) {
  std::vector<ModelTerm> terms;
  for (const json& entry : document) {
    auto term = term_of(entry);
    if (!term) return base::forward_error(term);
    terms.push_back(*std::move(term));
  }
  return terms;
}

}  // namespace soak::calib
