// SPDX-License-Identifier: Apache-2.0
#include "calib/model/document_parts.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>

#include "base/text.h"

namespace soak::calib {

NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(TermParameter, name, value, unit)

namespace {

using nlohmann::json;

// Accepted terms.

json term_part_json(const TermPart& part) {
  json sensors = json::array();
  for (const Sensor sensor : part.sensors) sensors.push_back(name_of(sensor));
  return {{"sensors", std::move(sensors)},
          {"parameters", part.parameters},
          {"covariance", part.covariance},
          {"centre", part.centre}};
}

json term_gap_json(const TermGap& gap) {
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
  for (const TermPart& part : term.parts) parts.push_back(term_part_json(part));
  json gaps = json::object();
  for (const Sensor sensor : kSensors) {
    if (const auto& gap = term.gap[index_of(sensor)]) gaps[std::string(name_of(sensor))] = term_gap_json(*gap);
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

base::Result<TermPart> term_part_of(const json& document) {
  TermPart part;
  for (const json& name : document.at("sensors")) {
    const auto sensor = sensor_named(name.get<std::string>());
    if (!sensor) return base::corrupt(fmt::format("unknown sensor '{}'", name.get<std::string>()), "accepted term");
    part.sensors.push_back(*sensor);
  }
  document.at("parameters").get_to(part.parameters);
  document.at("covariance").get_to(part.covariance);
  document.at("centre").get_to(part.centre);
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

TermGap term_gap_of(const json& document) {
  TermGap gap;
  document.at("before_rms").get_to(gap.before_rms);
  document.at("after_rms").get_to(gap.after_rms);
  document.at("floor_rms").get_to(gap.floor_rms);
  if (!document.at("closed_fraction").is_null()) gap.closed_fraction = document["closed_fraction"].get<double>();
  if (!document.at("closed_ci95").is_null()) {
    gap.closed_ci95 = {document["closed_ci95"].at(0).get<double>(), document["closed_ci95"].at(1).get<double>()};
  }
  return gap;
}

base::Result<ModelTerm> model_term_of(const json& document) {
  ModelTerm term;
  document.at("name").get_to(term.name);
  document.at("library").get_to(term.library);
  if (!document.at("parent_version").is_number_integer()) {
    return base::corrupt("parent_version must be a whole number", "accepted term");
  }
  term.parent_version = document["parent_version"].get<std::int32_t>();
  document.at("lab_only").get_to(term.lab_only);
  for (const json& entry : document.at("parts")) {
    auto part = term_part_of(entry);
    if (!part) return base::forward_error(part);
    term.parts.push_back(*std::move(part));
  }
  document.at("temp_min_c").get_to(term.temp_min_c);
  document.at("temp_max_c").get_to(term.temp_max_c);
  document.at("p_adjusted").get_to(term.p_adjusted);
  document.at("delta_bic").get_to(term.delta_bic);
  document.at("heldout_gain").get_to(term.heldout_gain);
  document.at("verdict").get_to(term.verdict);
  document.at("confusable_with").get_to(term.confusable_with);
  document.at("run_hashes").get_to(term.run_hashes);
  for (const Sensor sensor : kSensors) {
    const auto found = document.at("gap").find(std::string(name_of(sensor)));
    if (found != document.at("gap").end()) term.gap[index_of(sensor)] = term_gap_of(*found);
  }
  return term;
}

// References of the laboratory.

nlohmann::ordered_json waiver_json(const std::optional<Waiver>& waiver) {
  if (!waiver) return {};
  return {{"waiver_id", waiver->waiver_id},
          {"reason", waiver->reason},
          {"signer", waiver->signer},
          {"signed_utc", base::utc_text(waiver->utc_s)},
          {"public_key", waiver->public_key_hex},
          {"signature", waiver->signature_hex}};
}

nlohmann::ordered_json reference_json(const ReferenceUse& use) {
  const Reference& reference = use.reference;
  const double factor = printed_per_si(reference.kind);
  return {{"record_id", reference.record_id},
          {"kind", name_of(reference.kind)},
          {"name", reference.name},
          {"certificate", reference.certificate},
          {"issued_utc", base::utc_text(reference.issued_utc_s)},
          {"due_utc", base::utc_text(reference.due_utc_s)},
          {"unit", printed_unit(reference.kind)},
          {"correction",
           reference.correction ? nlohmann::ordered_json(factor * *reference.correction) : nlohmann::ordered_json()},
          {"standard_uncertainty", factor * reference.standard_uncertainty},
          {"waiver", waiver_json(use.waiver)}};
}

json stored_waiver(const Waiver& waiver) {
  return {{"waiver_id", waiver.waiver_id},
          {"reason", waiver.reason},
          {"signer", waiver.signer},
          {"utc_s", waiver.utc_s},
          {"public_key", waiver.public_key_hex},
          {"signature", waiver.signature_hex}};
}

Waiver stored_waiver_of(const json& stored, const std::string& record_id) {
  return {stored.at("waiver_id").get<std::string>(),  record_id,
          stored.at("reason").get<std::string>(),     stored.at("signer").get<std::string>(),
          stored.at("public_key").get<std::string>(), stored.at("utc_s").get<double>(),
          stored.at("signature").get<std::string>()};
}

base::Result<ReferenceUse> reference_use_of(const json& stored) {
  const auto name = stored.at("kind").get<std::string>();
  const auto kind = reference_kind_named(name);
  if (!kind) return base::corrupt("unknown kind of reference '" + name + "'", "model document");
  ReferenceUse use;
  stored.at("record_id").get_to(use.reference.record_id);
  use.reference.kind = *kind;
  stored.at("name").get_to(use.reference.name);
  stored.at("certificate").get_to(use.reference.certificate);
  if (stored.contains("correction")) use.reference.correction = stored["correction"].get<double>();
  stored.at("standard_uncertainty").get_to(use.reference.standard_uncertainty);
  stored.at("issued_utc_s").get_to(use.reference.issued_utc_s);
  stored.at("due_utc_s").get_to(use.reference.due_utc_s);
  if (stored.contains("campaigns")) stored["campaigns"].get_to(use.campaigns);
  if (stored.contains("waiver")) use.waiver = stored_waiver_of(stored["waiver"], use.reference.record_id);
  return use;
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
    auto term = model_term_of(entry);
    if (!term) return base::forward_error(term);
    terms.push_back(*std::move(term));
  }
  return terms;
}

nlohmann::ordered_json references_json(const std::vector<ReferenceUse>& uses) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const ReferenceUse& use : uses) list.push_back(reference_json(use));
  return list;
}

json stored_references(const std::vector<ReferenceUse>& uses) {
  json list = json::array();
  for (const ReferenceUse& use : uses) {
    const Reference& reference = use.reference;
    json entry = {{"record_id", reference.record_id},
                  {"kind", name_of(reference.kind)},
                  {"name", reference.name},
                  {"certificate", reference.certificate},
                  {"standard_uncertainty", reference.standard_uncertainty},
                  {"issued_utc_s", reference.issued_utc_s},
                  {"due_utc_s", reference.due_utc_s}};
    if (reference.correction) entry["correction"] = *reference.correction;
    if (!use.campaigns.empty()) entry["campaigns"] = use.campaigns;
    if (use.waiver) entry["waiver"] = stored_waiver(*use.waiver);
    list.push_back(std::move(entry));
  }
  return list;
}

base::Result<std::vector<ReferenceUse>> references_of(const json& stored) {
  std::vector<ReferenceUse> uses;
  for (const json& entry : stored) {
    auto use = reference_use_of(entry);
    if (!use) return base::forward_error(use);
    uses.push_back(*std::move(use));
  }
  return uses;
}

}  // namespace soak::calib
