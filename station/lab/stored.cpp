// SPDX-License-Identifier: Apache-2.0
#include "station/lab/stored.h"

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "station/lab/start_check.h"

namespace soak::station {
namespace {

using nlohmann::json;

/// Which unit each slot held in the newest campaign that this station carried out.
base::Result<std::map<std::string, std::string>> newest_units(const db::Catalog& catalog) {
  const auto newest = catalog.last_campaign();
  if (!newest) return base::forward_error(newest);
  if (!*newest) return std::map<std::string, std::string>();
  const auto request = request_of(**newest);
  return request ? request->units : std::map<std::string, std::string>();  // an offer only
}

json slots_part(const StationConfig& config, const std::map<std::string, std::string>& newest) {
  json slots = json::array();
  for (const Slot& slot : config.slots) {
    const auto last = newest.find(slot.name);
    slots.push_back({{"name", slot.name},
                     {"unit", slot.unit},
                     {"unit_type", slot.unit_type},
                     {"last_unit", last == newest.end() ? "" : last->second}});
  }
  return slots;
}

/// Runs that count: neither withdrawn nor a pre-flight.
bool counts(const db::RunRow& run) { return !run.voided && run.purpose != "diagnosis"; }

json units_part(const std::vector<db::UnitRow>& units, const std::vector<db::RunRow>& runs) {
  std::map<std::string, std::pair<int, double>> of_unit;  // number, time of the newest
  for (const db::RunRow& run : runs) {
    if (!counts(run)) continue;
    auto& [number, newest_utc_s] = of_unit[run.unit];
    ++number;
    newest_utc_s = std::max(newest_utc_s, run.created_utc_s);
  }
  json list = json::array();
  for (const db::UnitRow& unit : units) {
    const auto found = of_unit.find(unit.serial);
    const bool has_runs = found != of_unit.end();
    list.push_back({{"serial", unit.serial},
                    {"type", unit.type},
                    {"runs", has_runs ? found->second.first : 0},
                    {"newest_run_utc_s", has_runs ? json(found->second.second) : json()}});
  }
  return list;
}

struct CampaignRuns {
  std::set<std::string> units;
  std::set<std::string> labels;
  double begun_utc_s = 0.0;
};

/// State and reason of a campaign that this station carried out; of one that was imported there is no journal.
base::Result<json> campaign_part(const db::Catalog& catalog, const std::string& name, const CampaignRuns& runs) {
  const auto journal = catalog.campaign(name);
  if (!journal) return base::forward_error(journal);
  const bool known = journal->has_value();
  const double begun_utc_s = known ? (*journal)->created_utc_s : runs.begun_utc_s;
  return json{{"name", name},
              {"procedure", known ? json((*journal)->procedure) : json()},
              {"state", known ? json((*journal)->state) : json()},
              {"reason", known && !(*journal)->reason.empty() ? json((*journal)->reason) : json()},
              {"begun_utc_s", begun_utc_s > 0.0 ? json(begun_utc_s) : json()},
              {"runs", runs.labels.size()},
              {"units", runs.units}};
}

base::Result<json> campaigns_part(const db::Catalog& catalog, const std::vector<db::RunRow>& runs) {
  const auto names = catalog.campaigns();
  if (!names) return base::forward_error(names);
  std::map<std::string, CampaignRuns> of_campaign;
  for (const db::RunRow& run : runs) {
    CampaignRuns& those = of_campaign[run.campaign];
    const bool is_first = those.begun_utc_s == 0.0 || run.created_utc_s < those.begun_utc_s;
    if (is_first) those.begun_utc_s = run.created_utc_s;
    if (!counts(run)) continue;
    those.units.insert(run.unit);
    those.labels.insert(run.label);
  }
  std::vector<json> list;
  for (const std::string& name : *names) {
    auto part = campaign_part(catalog, name, of_campaign[name]);
    if (!part) return part;
    list.push_back(*std::move(part));
  }
  const auto begun = [](const json& one) {
    return one["begun_utc_s"].is_null() ? 0.0 : one["begun_utc_s"].get<double>();
  };
  std::ranges::sort(list, [&](const json& a, const json& b) { return begun(a) > begun(b); });
  return json(std::move(list));
}

}  // namespace

base::Result<json> stored_document(const StationConfig& config, const db::Catalog& catalog) {
  const auto units = catalog.units();
  if (!units) return base::forward_error(units);
  const auto runs = catalog.runs({.unit = {}, .campaign = {}, .run = {}});
  if (!runs) return base::forward_error(runs);
  auto campaigns = campaigns_part(catalog, *runs);
  if (!campaigns) return campaigns;
  const auto newest = newest_units(catalog);
  if (!newest) return base::forward_error(newest);
  return json{{"slots", slots_part(config, *newest)},
              {"units", units_part(*units, *runs)},
              {"campaigns", *std::move(campaigns)}};
}

}  // namespace soak::station
