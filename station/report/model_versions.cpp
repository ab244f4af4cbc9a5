// SPDX-License-Identifier: Apache-2.0
#include "station/report/model_versions.h"

#include <nlohmann/json.hpp>
#include <string>
#include <utility>

#include "calib/model/model_document.h"
#include "station/io/host.h"
#include "station/release/release_rule.h"
#include "station/report/release_part.h"

namespace soak::station {
namespace {

using nlohmann::json;

/// Whether the stored version is the trouble: damaged, or of a newer program.
bool is_of_document(const base::Error& error) {
  return error.kind == base::ErrorKind::corrupt || error.kind == base::ErrorKind::bad_input;
}

/// Why nothing of a version holds any more; empty where it may hold.
base::Result<std::string> why_void(const db::Catalog& catalog, const db::UnitRow& unit, const db::ModelHead& head) {
  const auto model = catalog.model(head.unit, head.version);
  if (!model) return base::forward_error(model);
  const auto calibration = calib::calibration_of((*model)->document);
  if (!calibration) return base::forward_error(calibration);
  const auto release = release_json(catalog, **model, now_utc_s());
  if (!release) return base::forward_error(release);
  return why_no_verdict(catalog, unit, **model, *calibration, *release);
}

base::Result<json> version_part(const db::Catalog& catalog, const db::UnitRow& unit, const db::ModelHead& head) {
  const auto why = why_void(catalog, unit, head);
  if (!why && !is_of_document(why.error())) return base::forward_error(why);
  const std::string text = why ? *why : why.error().message;
  return json{{"version", head.version},
              {"epoch", head.epoch},
              {"state", head.state},
              {"void", text.empty() ? json() : json(text)}};
}

/// Enters a version that is not the newest where it is released and keeps the rule now.
base::Status add_released(const db::Catalog& catalog, const db::ModelHead& head, json& versions) {
  if (head.state != "released") return {};
  const auto release = judge_release(catalog, head, now_utc_s());
  if (!release && is_of_document(release.error())) return {};
  if (!release) return base::forward_error(release);
  if (!release->obstacles.empty()) return {};
  versions["released_before"].push_back(head.version);
  if (release->calibration.simulated) versions["simulated_before"].push_back(head.version);
  return {};
}

}  // namespace

base::Result<json> model_versions(const db::Catalog& catalog, const db::UnitRow& unit) {
  const auto heads = catalog.models(unit.serial);
  if (!heads) return base::forward_error(heads);
  json versions = {
      {"versions", json::array()}, {"released_before", json::array()}, {"simulated_before", json::array()}};
  for (auto head = heads->rbegin(); head != heads->rend(); ++head) {
    auto part = version_part(catalog, unit, *head);
    if (!part) return part;
    versions["versions"].push_back(*std::move(part));
    if (head == heads->rbegin()) continue;
    if (auto added = add_released(catalog, *head, versions); !added) return base::forward_error(added);
  }
  return versions;
}

}  // namespace soak::station
