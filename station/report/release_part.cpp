// SPDX-License-Identifier: Apache-2.0
#include "station/report/release_part.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "station/io/text.h"
#include "station/release/release_rule.h"
#include "station/report/unit_overview.h"

namespace soak::station {
namespace {

using nlohmann::json;

json verification_part(const std::optional<LastVerification>& last) {
  if (!last) return {};
  return {{"utc_s", last->row.utc_s},
          {"user", last->row.user},
          {"verdict", last->row.verdict},
          {"campaign", last->campaign},
          {"limits", last->limits.empty() ? json() : json(last->limits)}};
}

/// The last step into a state; null where there is none.
json step_into(const std::vector<db::ModelStateRow>& history, std::string_view state) {
  const auto step =
      std::find_if(history.rbegin(), history.rend(), [&](const db::ModelStateRow& row) { return row.state == state; });
  if (step == history.rend()) return {};
  return {{"utc_s", step->utc_s}, {"user", step->user}};
}

}  // namespace

base::Result<std::string> why_no_verdict(const db::Catalog& catalog, const db::UnitRow& unit, const db::ModelRow& model,
                                         const calib::Calibration& calibration, const json& release) {
  const auto history = catalog.model_history(model.unit, model.version);
  if (!history) return base::forward_error(history);
  if (!history->empty() && history->back().state == "withdrawn") {
    const db::ModelStateRow& step = history->back();
    return fmt::format("the model was withdrawn on {} by {}: {}", iso_date(step.utc_s), step.user, step.reason);
  }
  if (model.epoch != unit.epoch) return std::string("the unit was repaired or changed after this model");
  auto doubt = doubt_of(catalog, calibration);
  const json& last = release["verification"];
  if (!doubt || !doubt->empty() || last.is_null()) return doubt;
  const std::string campaign = last["campaign"];
  const auto withdrawn = withdrawn_since_start(catalog, model.unit, campaign, last["utc_s"]);
  if (!withdrawn) return base::forward_error(withdrawn);
  if (!*withdrawn) return std::string();
  return fmt::format("data of campaign {} were withdrawn after the model was verified with it", campaign);
}

base::Result<json> release_json(const db::Catalog& catalog, const db::ModelRow& model, double now_utc_s) {
  const auto head = model_head(catalog, model.unit, model.version);
  if (!head) return base::forward_error(head);
  const auto history = catalog.model_history(model.unit, model.version);
  if (!history) return base::forward_error(history);
  json part = {{"state", head->state},
               {"released", step_into(*history, "released")},
               {"verification", nullptr},
               {"expires_utc_s", nullptr},
               {"obstacles", json::array()}};
  const auto release = judge_release(catalog, *head, now_utc_s);
  if (!release && release.error().kind != base::ErrorKind::corrupt) return base::forward_error(release);
  if (!release) {
    part["obstacles"].push_back(release.error().message);
    return part;
  }
  part["verification"] = verification_part(release->verification);
  if (release->expires_utc_s) part["expires_utc_s"] = *release->expires_utc_s;
  part["obstacles"] = release->obstacles;
  return part;
}

}  // namespace soak::station
