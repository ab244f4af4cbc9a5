// SPDX-License-Identifier: Apache-2.0
#include "calib/model/reference_json.h"

#include <nlohmann/json.hpp>
#include <string>
#include <utility>

#include "base/text.h"

namespace soak::calib {
namespace {

using nlohmann::json;
using Ordered = nlohmann::ordered_json;

Ordered waiver_json(const std::optional<Waiver>& waiver) {
  if (!waiver) return {};
  return {{"waiver_id", waiver->waiver_id},
          {"reason", waiver->reason},
          {"signer", waiver->signer},
          {"signed_utc", base::utc_text(waiver->utc_s)},
          {"public_key", waiver->public_key_hex},
          {"signature", waiver->signature_hex}};
}

Ordered reference_json(const ReferenceUse& use) {
  const Reference& reference = use.reference;
  const double factor = printed_per_si(reference.kind);
  return {{"record_id", reference.record_id},
          {"kind", name_of(reference.kind)},
          {"name", reference.name},
          {"certificate", reference.certificate},
          {"issued_utc", base::utc_text(reference.issued_utc_s)},
          {"due_utc", base::utc_text(reference.due_utc_s)},
          {"unit", printed_unit(reference.kind)},
          {"correction", reference.correction ? Ordered(factor * *reference.correction) : Ordered()},
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

Waiver waiver_of(const json& stored, const std::string& record_id) {
  return {stored.at("waiver_id").get<std::string>(),  record_id,
          stored.at("reason").get<std::string>(),     stored.at("signer").get<std::string>(),
          stored.at("public_key").get<std::string>(), stored.at("utc_s").get<double>(),
          stored.at("signature").get<std::string>()};
}

base::Result<ReferenceUse> use_of(const json& stored) {
  const auto name = stored.at("kind").get<std::string>();
  const auto kind = reference_kind_named(name);
  if (!kind) return base::corrupt("unknown kind of reference '" + name + "'", "model document");
  ReferenceUse use;
  use.reference.record_id = stored.at("record_id").get<std::string>();
  use.reference.kind = *kind;
  use.reference.name = stored.at("name").get<std::string>();
  use.reference.certificate = stored.at("certificate").get<std::string>();
  if (stored.contains("correction")) use.reference.correction = stored["correction"].get<double>();
  use.reference.standard_uncertainty = stored.at("standard_uncertainty").get<double>();
  use.reference.issued_utc_s = stored.at("issued_utc_s").get<double>();
  use.reference.due_utc_s = stored.at("due_utc_s").get<double>();
  if (stored.contains("waiver")) use.waiver = waiver_of(stored["waiver"], use.reference.record_id);
  return use;
}

}  // namespace

Ordered references_json(const std::vector<ReferenceUse>& uses) {
  Ordered list = Ordered::array();
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
    if (use.waiver) entry["waiver"] = stored_waiver(*use.waiver);
    list.push_back(std::move(entry));
  }
  return list;
}

base::Result<std::vector<ReferenceUse>> references_of(const json& stored) {
  std::vector<ReferenceUse> uses;
  for (const json& entry : stored) {
    auto use = use_of(entry);
    if (!use) return base::forward_error(use);
    uses.push_back(*std::move(use));
  }
  return uses;
}

}  // namespace soak::calib
