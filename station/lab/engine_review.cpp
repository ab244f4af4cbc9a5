// SPDX-License-Identifier: Apache-2.0
// For somebody who still fills in the form: what a campaign would be, without a device, and what the slots hold.
// Nothing begins.
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "station/config/procedure_folder.h"
#include "station/config/unit_type_json.h"
#include "station/io/host.h"
#include "station/lab/engine.h"
#include "station/lab/slot_look.h"
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

/// How many plateaus each run visits, without the pre-flight: not all where the units are switched off within a cycle.
json visits_of_runs(const Plan& plan) {
  json list = json::array();
  for (const PlannedRun& run : plan.runs) {
    if (run.preflight) continue;
    int visits = 0;
    for (std::size_t i = run.first_step; i <= run.last_step; ++i) visits = std::max(visits, plan.steps[i].visit + 1);
    list.push_back(visits);
  }
  return list;
}

json plan_part(const CheckedStart& checked) {
  const Procedure& procedure = checked.plan.procedure;
  return {{"name", procedure.name},
          {"description", procedure.description},
          {"purpose", name_of(procedure.purpose)},
          {"runs", std::ranges::count(checked.plan.runs, false, &PlannedRun::preflight)},
          {"visits", visits_of_runs(checked.plan)},
          {"turns", std::ranges::count_if(checked.plan.steps,
                                          [](const Step& step) {
                                            return step.kind == StepKind::move || step.kind == StepKind::turn_fixture;
                                          })},
          {"set_points_c", procedure.set_points_c},
          {"positions", procedure.positions},
          {"estimate_s", checked.plan.remaining_s(0)}};
}

}  // namespace

base::Result<json> Engine::check(const StartRequest& request) {
  return command([=, this] { return reviewed_document(request); });
}

base::Status Engine::begin_look() {
  const auto refused = [](std::string why) { return base::bad_input(std::move(why), "state"); };
  if (stop_requested_) return refused("soakd is stopping");
  if (is_held_) return refused(std::string(kHeld));
  if (looks_into_slots_) return refused("somebody is looking into the slots: wait some seconds for the answer");
  if (is_under_way(state_) || state_ == CampaignState::stopping) {
    return refused(fmt::format("campaign '{}' is {}, and the units are its own: wait for its end",
                               station_->campaign.name, name_of(state_)));
  }
  if (next_begins_by_itself() || (state_ == CampaignState::interrupted && resumes_by_itself_)) {
    return refused("a campaign is about to begin by itself: wait for its end, or abort");
  }
  looks_into_slots_ = true;
  return {};
}

base::Result<json> Engine::look(const std::string& user) {
  const auto begun = status_command([this] { return begin_look(); });
  if (!begun) return base::forward_error(begun);
  const auto findings = look_into_slots(config_.slots, stop_requested_);
  return command([this, &findings, user]() -> base::Result<json> {
    looks_into_slots_ = false;
    if (!findings) return base::forward_error(findings);
    log_.add("unit", "slots", look_text(*findings), user);
    return look_document(*findings);
  });
}

json Engine::procedures(const std::string& file) const {
  return procedures_document(procedure_folders(catalog_.data_folder()), file, config_.room_c);
}

json Engine::types() const { return types_document(config_.unit_types); }

base::Result<json> Engine::reviewed_document(const StartRequest& request) const {
  Mistakes mistakes;
  ReviewedStart reviewed = review_start(request, config_, catalog_);
  for (const base::Error& mistake : reviewed.mistakes) {
    // What the catalog cannot tell is no mistake of whoever asks.
    if (mistake.kind != base::ErrorKind::bad_input) return tl::unexpected(mistake);
    mistakes.add(mistake);
  }
  const auto known = catalog_.campaign(request.campaign);
  if (!known) return base::forward_error(known);
  if (*known || queue_.holds(request.campaign)) {
    const std::string where = *known ? "exists already" : "is in the queue already";
    mistakes.add({base::ErrorKind::bad_input, "campaign '" + request.campaign + "' " + where + ": choose another name",
                  "campaign"});
  }
  std::vector<std::string> notes;
  json document = {{"procedure", nullptr},
                   {"units", units_part(reviewed.units)},
                   {"disk", {{"needed_bytes", nullptr}, {"free_bytes", free_bytes(catalog_.data_folder())}}}};
  if (reviewed.procedure) {
    const CheckedStart checked{compile_plan(*reviewed.procedure, config_.room_c), std::move(reviewed.units)};
    document["procedure"] = plan_part(checked);
    for (const base::Status& able : {check_chamber(checked, *chamber_), check_fixture(checked, fixture_.get())}) {
      if (!able) mistakes.add(able.error());
    }
    // One that has to wait for its turn may find room by then.
    const bool waits = is_under_way(state_) || !queue_.empty();
    if (!checked.units.empty()) {
      document["disk"]["needed_bytes"] = needed_bytes(checked, 0);
      const auto fits = check_disk(checked, 0, catalog_.data_folder());
      if (!fits && waits) notes.push_back(fits.error().message);
      if (!fits && !waits) mistakes.add(fits.error());
    }
    const double before_s = queue_.estimate_s() + (is_under_way(state_) ? remaining_s() : 0.0);
    const auto judged =
        check_references(catalog_, checked, 0, now_utc_s() + before_s / config_.clock_rate, config_.clock_rate);
    if (!judged && judged.error().kind != base::ErrorKind::bad_input) return base::forward_error(judged);
    if (!judged) mistakes.add(judged.error());
    if (judged) notes.insert(notes.end(), judged->notes.begin(), judged->notes.end());
    const auto standards = note_on_check_standards(catalog_, checked);
    if (!standards) return base::forward_error(standards);
    if (*standards) notes.push_back(**standards);
  }
  document["mistakes"] = mistakes.list();
  document["notes"] = std::move(notes);
  return document;
}

}  // namespace soak::station
