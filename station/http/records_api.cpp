// SPDX-License-Identifier: Apache-2.0
#include "station/http/records_api.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>

#include "station/http/members.h"
#include "station/http/procedures_api.h"
#include "station/io/host.h"
#include "station/io/text.h"
#include "station/records/reference_entry.h"
#include "station/records/reference_register.h"
#include "station/records/station_key.h"
#include "station/release/release_rule.h"

namespace soak::station {
namespace {

using base::Result;
using nlohmann::json;

base::Status check_type(const StationService& lab, const std::string& type) {
  const json document = lab.types();
  const bool known = std::ranges::any_of(document.at("types"), [&](const json& one) { return one.at("name") == type; });
  if (known) return {};
  const auto folder = document.at("folder").get<std::string>();
  return base::bad_input(fmt::format("there is no unit type '{}' in {}, or its file is wrong", type, folder), "type");
}

/// A unit before its first campaign. That it is there already with the same type is no mistake.
Result<json> add_unit(const StationService& lab, RunArchive& archive, const json& body) {
  if (auto known = only_members(body, {"unit", "type", "user"}); !known) return base::forward_error(known);
  const auto serial = carried_member(body, "unit");
  if (!serial) return base::forward_error(serial);
  const auto type = carried_member(body, "type");
  if (!type) return base::forward_error(type);
  const auto user = carried_member(body, "user");
  if (!user) return base::forward_error(user);
  if (auto listed = check_type(lab, *type); !listed) return base::forward_error(listed);
  return archive.in_turn([&](db::Catalog& catalog) -> Result<json> {
    const auto unit = catalog.add_unit(*serial, *type, *user);
    if (!unit) return base::forward_error(unit);
    if (unit->type != *type) {
      return base::bad_input(fmt::format("unit {} exists with type '{}'", *serial, unit->type), "type");
    }
    return json{{"unit", *serial}, {"type", *type}};
  });
}

/// A unit that was repaired or changed: its runs so far are of another one. It is there: no unit comes to be by this.
Result<json> begin_epoch(const StationService&, RunArchive& archive, const json& body) {
  if (auto known = only_members(body, {"unit", "reason", "user"}); !known) return base::forward_error(known);
  // Serial numbers that were taken in may be any line of text.
  const auto serial = text_member(body, "unit", std::nullopt);
  if (!serial) return base::forward_error(serial);
  const auto reason = carried_member(body, "reason");
  if (!reason) return base::forward_error(reason);
  const auto user = carried_member(body, "user");
  if (!user) return base::forward_error(user);
  return archive.in_turn([&](db::Catalog& catalog) -> Result<json> {
    const auto known = catalog.unit(*serial);
    if (!known) return base::forward_error(known);
    if (!*known) return base::bad_input("there is no such unit; /api/v1/units lists those that there are", "unit");
    const auto unit = catalog.begin_epoch(*serial, *reason, *user);
    if (!unit) return base::forward_error(unit);
    return json{{"unit", unit->serial}, {"epoch", unit->epoch}};
  });
}

/// Withdraws a version of a unit's model: nobody may use it any more.
Result<json> withdraw_model(const StationService&, RunArchive& archive, const json& body) {
  if (auto known = only_members(body, {"unit", "model", "reason", "user"}); !known) return base::forward_error(known);
  const auto serial = text_member(body, "unit", std::nullopt);
  if (!serial) return base::forward_error(serial);
  const auto version = body.find("model");
  if (version == body.end() || !version->is_number_integer()) {
    return base::bad_input("the version of the model is missing or not a whole number", "model");
  }
  const auto reason = carried_member(body, "reason");
  if (!reason) return base::forward_error(reason);
  const auto user = carried_member(body, "user");
  if (!user) return base::forward_error(user);
  return archive.in_turn([&](db::Catalog& catalog) -> Result<json> {
    const auto heads = catalog.models(*serial);
    if (!heads) return base::forward_error(heads);
    const auto head = std::ranges::find_if(*heads, [&](const db::ModelHead& one) { return one.version == *version; });
    if (head == heads->end()) return base::bad_input("the unit has no model of that version", "model");
    if (head->state == "withdrawn") return base::bad_input("the model is withdrawn already", "state");
    auto done = catalog.set_model_state({*serial, head->version, "withdrawn", *reason, *user, now_utc_s()});
    if (!done) return base::forward_error(done);
    return json{{"unit", *serial}, {"model", head->version}, {"state", "withdrawn"}};
  });
}

/// What the catalog refuses is about that member of the body.
base::Error at_member(base::Error error, const std::string& name) {
  if (error.kind == base::ErrorKind::bad_input) error.where = name;
  return error;
}

Result<json> register_document(const db::Catalog& catalog) {
  const auto shown = shown_register(catalog, now_utc_s());
  if (!shown) return base::forward_error(shown);
  return references_document(*shown);
}

Result<EnteredReference> entered_reference(const json& body) {
  EnteredReference entry;
  for (const auto& [name, member] : {std::pair{"kind", &entry.kind},
                                     {"name", &entry.name},
                                     {"certificate", &entry.certificate},
                                     {"issued", &entry.issued},
                                     {"due", &entry.due}}) {
    const auto text = carried_member(body, name);
    if (!text) return base::forward_error(text);
    *member = *text;
  }
  const auto uncertainty = number_member(body, "uncertainty");
  if (!uncertainty) return base::forward_error(uncertainty);
  if (!*uncertainty) return base::bad_input("the member is missing", "uncertainty");
  const auto coverage = number_member(body, "k");
  if (!coverage) return base::forward_error(coverage);
  const auto correction = number_member(body, "correction");
  if (!correction) return base::forward_error(correction);
  entry.uncertainty = **uncertainty;
  entry.coverage = coverage->value_or(entry.coverage);
  entry.correction = *correction;
  return entry;
}

/// A certificate; of a reference that has one already the newer one stands.
Result<json> add_reference(const StationService&, RunArchive& archive, const json& body) {
  const auto known =
      only_members(body, {"kind", "name", "certificate", "issued", "due", "uncertainty", "k", "correction", "user"});
  if (!known) return base::forward_error(known);
  const auto entry = entered_reference(body);
  if (!entry) return base::forward_error(entry);
  const auto user = carried_member(body, "user");
  if (!user) return base::forward_error(user);
  const auto reference = reference_from(*entry, now_utc_s());
  if (!reference) return base::forward_error(reference);
  return archive.in_turn([&](db::Catalog& catalog) -> Result<json> {
    const auto added = catalog.add_reference({*reference, *user, now_utc_s()});
    if (!added) return tl::unexpected(at_member(added.error(), "certificate"));
    return register_document(catalog);
  });
}

/// Takes a reference out of use.
Result<json> retire_reference(const StationService&, RunArchive& archive, const json& body) {
  if (auto known = only_members(body, {"record_id", "reason", "user"}); !known) return base::forward_error(known);
  const auto record_id = carried_member(body, "record_id");
  if (!record_id) return base::forward_error(record_id);
  const auto reason = carried_member(body, "reason");
  if (!reason) return base::forward_error(reason);
  const auto user = carried_member(body, "user");
  if (!user) return base::forward_error(user);
  return archive.in_turn([&](db::Catalog& catalog) -> Result<json> {
    if (auto retired = catalog.retire_reference(*record_id, {*reason, *user, now_utc_s()}); !retired) {
      return tl::unexpected(at_member(retired.error(), "record_id"));
    }
    return register_document(catalog);
  });
}

/// A key of the station's own, to sign calibration files with.
Result<json> new_key(const StationService&, RunArchive& archive, const json& body) {
  if (auto known = only_members(body, {"comment", "user"}); !known) return base::forward_error(known);
  const auto comment = carried_member(body, "comment");
  if (!comment) return base::forward_error(comment);
  const auto user = carried_member(body, "user");
  if (!user) return base::forward_error(user);
  return archive.in_turn([&](db::Catalog& catalog) { return make_station_key(catalog, *comment, *user); });
}

}  // namespace

Result<json> key_answer(RunArchive& archive, const Parameters& parameters) {
  if (auto known = only_parameters(parameters, {}); !known) return base::forward_error(known);
  return archive.in_turn([](const db::Catalog& catalog) { return station_key(catalog.data_folder()); });
}

Result<json> references_answer(RunArchive& archive, const Parameters& parameters) {
  if (auto known = only_parameters(parameters, {}); !known) return base::forward_error(known);
  return archive.in_turn([](db::Catalog& catalog) { return register_document(catalog); });
}

Result<json> released_with_answer(RunArchive& archive, const Parameters& parameters) {
  if (auto known = only_parameters(parameters, {"record_id"}); !known) return base::forward_error(known);
  const auto record_id = required(parameters, "record_id", "an entry of the register, as /api/v1/references gives it");
  if (!record_id) return base::forward_error(record_id);
  return archive.in_turn([&](const db::Catalog& catalog) -> Result<json> {
    const auto entries = catalog.references();
    if (!entries) return base::forward_error(entries);
    const auto is_it = [&](const db::ReferenceRow& row) { return row.reference.record_id == *record_id; };
    if (std::ranges::none_of(*entries, is_it)) return base::bad_input("there is no such entry", "record_id");
    const auto heads = released_with(catalog, *record_id, now_utc_s());
    if (!heads) return base::forward_error(heads);
    json released = json::array();
    for (const db::ModelHead& head : *heads) released.push_back({{"unit", head.unit}, {"model", head.version}});
    return json{{"released", std::move(released)}};
  });
}

const std::vector<RecordCommand>& record_commands() {
  static const std::vector<RecordCommand> commands = {{"unit/add", add_unit},
                                                      {"unit/epoch", begin_epoch},
                                                      {"model/withdraw", withdraw_model},
                                                      {"references/add", add_reference},
                                                      {"references/retire", retire_reference},
                                                      {"key/new", new_key},
                                                      {"procedures/new", new_procedure}};
  return commands;
}

}  // namespace soak::station
