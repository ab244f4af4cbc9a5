// SPDX-License-Identifier: Apache-2.0
// What a campaign would be, for somebody who still fills in the form: nothing begins and no device is touched.
#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <sstream>
#include <system_error>
#include <utility>

#include "station/config/procedure_folder.h"
#include "station/config/unit_type_json.h"
#include "station/io/host.h"
#include "station/lab/engine.h"
#include "station/lab/start_check.h"

namespace soak::station {
namespace {

using nlohmann::json;

/// Each line of a message is a mistake of its own (a procedure's are told all at once); what two checks find counts
/// once.
class Mistakes {
 public:
  void add(const base::Error& error) {
    std::istringstream lines(error.message);
    for (std::string line; std::getline(lines, line);) {
      json mistake = {{"message", line}, {"where", error.where}};
      if (std::ranges::find(list_, mistake) == list_.end()) list_.push_back(std::move(mistake));
    }
  }
  /// Whether there was none.
  template <class T>
  bool none_in(const base::Result<T>& result) {
    if (!result) add(result.error());
    return result.has_value();
  }
  [[nodiscard]] const json& list() const { return list_; }

 private:
  json list_ = json::array();
};

json units_part(const std::vector<CheckedUnit>& units) {
  json list = json::array();
  for (const CheckedUnit& unit : units) {
    list.push_back({{"slot", unit.slot.name}, {"serial", unit.serial}, {"type", unit.type.name}});
  }
  return list;
}

json free_bytes(const std::filesystem::path& folder) {
  std::error_code error;
  const auto space = std::filesystem::space(folder, error);
  return error ? json() : json(space.available);
}

json plan_part(const CheckedStart& checked) {
  const Procedure& procedure = checked.plan.procedure;
  return {{"name", procedure.name},
          {"description", procedure.description},
          {"purpose", name_of(procedure.purpose)},
          {"runs", std::ranges::count(checked.plan.runs, false, &PlannedRun::preflight)},
          {"visits", procedure.set_points_c.size()},
          {"set_points_c", procedure.set_points_c},
          {"positions", procedure.positions},
          {"estimate_s", checked.plan.remaining_s(0)}};
}

}  // namespace

base::Result<json> Engine::check(const StartRequest& request) {
  return command([=, this] { return reviewed_document(request); });
}

json Engine::procedures() const {
  return procedures_document(procedure_folders(catalog_.data_folder()), config_.room_c);
}

base::Result<json> Engine::types() const { return types_document(config_.unit_types); }

base::Result<json> Engine::reviewed_document(const StartRequest& request) const {
  Mistakes mistakes;
  ReviewedStart reviewed = review_start(request, config_, catalog_);
  for (const base::Error& mistake : reviewed.mistakes) mistakes.add(mistake);
  const auto known = catalog_.campaign(request.campaign);
  if (!known) return base::forward_error(known);
  if (*known || queue_.holds(request.campaign)) {
    mistakes.add({base::ErrorKind::bad_input, "campaign '" + request.campaign + "' exists already: choose another name",
                  "campaign"});
  }
  json notes = json::array();
  json document = {{"procedure", nullptr},
                   {"units", units_part(reviewed.units)},
                   {"disk", {{"needed_bytes", nullptr}, {"free_bytes", free_bytes(catalog_.data_folder())}}}};
  if (reviewed.procedure) {
    const CheckedStart checked{compile_plan(*reviewed.procedure, config_.room_c), std::move(reviewed.units)};
    document["procedure"] = plan_part(checked);
    if (!checked.units.empty()) document["disk"]["needed_bytes"] = needed_bytes(checked, 0);
    for (const base::Status& able : {check_chamber(checked, *chamber_), check_fixture(checked, fixture_.get()),
                                     check_disk(checked, 0, catalog_.data_folder())}) {
      (void)mistakes.none_in(able);
    }
    if (const auto judged = check_references(catalog_, checked, 0, now_utc_s(), config_.clock_rate);
        mistakes.none_in(judged)) {
      notes = judged->notes;
    }
    if (const auto standards = note_on_check_standards(catalog_, checked); mistakes.none_in(standards) && *standards) {
      notes.push_back(**standards);
    }
  }
  document["mistakes"] = mistakes.list();
  document["notes"] = std::move(notes);
  return document;
}

}  // namespace soak::station
