// SPDX-License-Identifier: Apache-2.0
// What is an alarm, and the one thing that somebody has to do then. Texts are for people: what is wrong first.
#include "station/alarms/alarm_rules.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace soak::station {
namespace {

using nlohmann::json;

constexpr std::string_view kAlarm = "alarm";
constexpr std::string_view kWarning = "warning";
constexpr std::string_view kWaitsFor = "waits_for_";  // before the cause
/// Degrees from the expected direction within which a position is right (station/lab/position_watch.h).
constexpr int kTilt_deg = 5;
constexpr std::string_view kDoorStaysClosed = "Keep the door closed until the station says that it is safe.";

/// Where the text goes on with a time: whoever shows it knows the reader's clock.
struct Deadline {
  std::string text;
  double utc_s = 0.0;
};

struct Alarm {
  std::string code;   ///< what kind it is: the same as long as it lasts
  std::string about;  ///< which one of its kind: a unit, an alarm of the chamber, a campaign; empty = there is only one
  std::string_view level = kAlarm;
  std::string title;
  std::string action;  ///< the one thing to do
  std::string detail = {};
  std::optional<Deadline> deadline = {};
  bool calls = true;  ///< nobody who is away may miss it
};

/// What a campaign waits for by itself (docs/campaigns.md) beside a silent chamber, the most urgent first.
struct Suspension {
  std::string_view cause;
  std::string_view level;
  std::string_view title;
  std::string_view action;
};
constexpr std::array<Suspension, 5> kSuspensions = {
    {{"air", kAlarm, "The air is not at its set point: the campaign waits",
      "Close the chamber's door, and look at its display. When the air is back the campaign goes on by itself."},
     {"disk", kWarning, "The disk is full: the campaign waits",
      "Make room on the station's disk, but delete nothing in its data folder. The campaign then goes on by itself."},
     {"storage", kWarning, "What is measured cannot be written: the campaign waits",
      "Look at the station's disk. When it can be written to the campaign goes on by itself."},
     {"supply", kWarning, "A unit's supply is out of range: the campaign waits",
      "Look at the power supply and its cables. When the voltage is right the campaign goes on by itself."},
     {"catalog", kWarning, "The catalog cannot be written: the campaign waits",
      "End the other program that holds it (a stopped soak import?). The campaign then goes on by itself."}}};

/// What is asked of a status document again and again.
struct Seen {
  const json& status;
  std::string state = status.at("state");
  bool active = is_one_of(state, {"preflight", "running", "waiting", "paused", "stopping"});

  static bool is_one_of(const std::string& text, std::initializer_list<std::string_view> words) {
    return std::ranges::find(words, text) != words.end();
  }
  /// A text of the document; "" where it is null.
  [[nodiscard]] std::string text(const char* pointer) const {
    const json& value = status.at(json::json_pointer(pointer));
    return value.is_string() ? value.get<std::string>() : "";
  }
  [[nodiscard]] const json& at(const char* pointer) const { return status.at(json::json_pointer(pointer)); }
  /// Of the campaign; "" where there is none.
  [[nodiscard]] std::string of_campaign(const char* key) const {
    const json& campaign = status.at("campaign");
    return campaign.is_object() && campaign.at(key).is_string() ? campaign.at(key).get<std::string>() : "";
  }
};

bool is_cause(const Seen& seen, std::string_view cause) {
  const json& suspension = seen.at("/suspension");
  if (!suspension.is_object()) return false;
  return std::ranges::any_of(suspension.at("causes"),
                             [&](const json& one) { return one.get_ref<const std::string&>() == cause; });
}

Deadline end_of_wait(const Seen& seen) {
  const double left_s = seen.at("/suspension/gives_up_in_s").get<double>() / seen.at("/clock/rate").get<double>();
  return {"Otherwise it ends at", seen.at("/clock/utc_s").get<double>() + left_s};
}

bool is_lost(const json& unit) { return unit.at("dropped").is_string() || unit.at("state") == "failed"; }

bool no_unit_is_left(const Seen& seen) {
  const json& units = seen.at("/units");
  return !units.empty() && std::ranges::all_of(units, is_lost);
}

/// Whether nothing comes from any unit either, as where the power of the laboratory has failed.
bool no_unit_is_heard(const Seen& seen) {
  const json& units = seen.at("/units");
  return !units.empty() &&
         std::ranges::all_of(units, [](const json& unit) { return is_lost(unit) || unit.at("state") == "silent"; });
}

std::string action_at_silent_chamber(const Seen& seen) {
  if (seen.state == "stopping") {
    return "Go to the chamber: one that does not answer can only be switched off by hand, once the units are warm.";
  }
  const json& suspension = seen.at("/suspension");
  std::string then = "If it answers within a minute the campaign goes on at once.";
  if (seen.state == "paused") then = "The campaign stays paused; Resume gives the chamber its set point again.";
  if (suspension.is_object()) {
    const bool alone = suspension.at("causes") == json::array({"chamber"});
    then = alone ? "When it answers the campaign goes on by itself." : "The campaign waits for something else, too.";
  }
  if (seen.state != "paused" && no_unit_is_heard(seen)) {
    return "Go to the chamber: has the power failed? No unit is heard either. A unit that was without power cannot go "
           "on "
           "with its run: if all were, the campaign ends, and Resume continues it.";
  }
  return "Go to the chamber: is it switched on, is its cable plugged in? " + then;
}

/// One alarm as long as the chamber is silent, whatever the campaign does meanwhile.
void add_silent_chamber(const Seen& seen, std::vector<Alarm>& alarms) {
  const bool waits = is_cause(seen, "chamber");
  if (!waits && (!seen.active || seen.at("/chamber/connected") == true)) return;
  // The reason of a campaign that waits, whose numbers move, stands with the step; that of an end with its own alarm.
  const std::string detail = waits || seen.state == "stopping" ? "" : seen.text("/reason");
  alarms.push_back({"chamber_silent", "", kAlarm, "The chamber does not answer", action_at_silent_chamber(seen), detail,
                    waits ? std::optional(end_of_wait(seen)) : std::nullopt});
}

void add_chamber(const Seen& seen, std::vector<Alarm>& alarms) {
  add_silent_chamber(seen, alarms);
  for (const std::string name : seen.at("/chamber/alarms")) {
    alarms.push_back({"chamber_alarm", name, kAlarm, "The chamber reports an alarm: " + name,
                      fmt::format("Go to the chamber and look at its display. {}", kDoorStaysClosed)});
  }
}

void add_folder(const Seen& seen, std::vector<Alarm>& alarms) {
  const std::string trouble = seen.text("/data/trouble");
  if (trouble.empty()) return;
  alarms.push_back({"data_folder", "", kAlarm, "The data folder is gone",
                    "Bring it back (is its disk mounted?), or start soakd again. No campaign begins before that.",
                    trouble});
}

/// A label with the true minus sign, as people read it.
std::string face(std::string label) {
  if (label.empty()) return "an unknown face";
  if (const auto minus = label.find('-'); minus != std::string::npos) label.replace(minus, 1, "\u2212");
  return label;
}

/// How a unit that rests wrong comes to rest as it should: turned, or seated where the right face is up already.
std::string turn_text(const std::string& up, const std::string& expected) {
  if (up == expected) return fmt::format("rests more than {}° from {}: seat it", kTilt_deg, face(expected));
  if (up.empty()) return fmt::format("{} is up now, turn it to {}", face(up), face(expected));
  const bool half = up.substr(1) == expected.substr(1);
  return fmt::format("{} is up now, turn it {} to {}", face(up), half ? "half a turn" : "a quarter turn",
                     face(expected));
}

void add_wrong_face(const Seen& seen, const json& unit, const std::string& who, std::vector<Alarm>& alarms) {
  const json& attitude = unit.at("attitude");
  if (!attitude.is_object() || attitude.at("right") != false || seen.at("/prompt").is_object()) return;
  const std::string up = attitude.at("up").is_string() ? attitude.at("up").get<std::string>() : "";
  const std::string expected = attitude.at("expected");
  const bool tilted = up == expected;
  const std::string turn = turn_text(up, expected);
  const bool turning =
      Seen::is_one_of(seen.of_campaign("step_kind"), {"move", "spin"}) && seen.at("/fixture/moving") == true;
  std::string action =
      "Look whether it is mounted as the station's configuration says, and whether the fixture is where it reports to "
      "be.";
  if (seen.text("/fixture/description") == "by hand") action = "Turn the fixture: " + turn + ".";
  if (tilted) action = "It " + turn + ".";
  alarms.push_back({"unit_face", unit.at("serial"), turning ? kWarning : kAlarm,
                    tilted ? who + " is tilted" : fmt::format("{} has {} up, not {}", who, face(up), face(expected)),
                    std::move(action), "", std::nullopt, !turning});
}

/// What to do about a lost unit, and what becomes of the others.
std::string action_at_lost_unit(const Seen& seen, std::string_view then) {
  return fmt::format("Look at its cable and its supply. {}",
                     no_unit_is_left(seen) ? "No unit is left: the campaign cannot go on without one." : then);
}

/// Why a campaign has ended: where that is because no unit is left, with what became of each.
std::string reason_of_end(const Seen& seen) {
  std::string reason = seen.text("/reason");
  if (!no_unit_is_left(seen)) return reason;
  for (const json& unit : seen.at("/units")) {
    const json& why = unit.at("dropped");
    reason += fmt::format("{}{}: {}", reason.empty() ? "" : "; ", unit.at("serial").get<std::string>(),
                          why.is_string() ? why.get<std::string>() : "has failed");
  }
  return reason;
}

void add_units(const Seen& seen, std::vector<Alarm>& alarms) {
  // The alarm of the campaign's end names them.
  const bool named_with_end = seen.state == "stopping" && no_unit_is_left(seen);
  for (const json& unit : seen.at("/units")) {
    const std::string serial = unit.at("serial");
    const std::string who = fmt::format("Unit {} in slot {}", serial, unit.at("slot").get<std::string>());
    if (seen.active && !named_with_end && unit.at("dropped").is_string()) {
      alarms.push_back({"unit_dropped", serial, kWarning, who + " was dropped: not recorded in this run",
                        action_at_lost_unit(seen, "The other units go on, and the next run tries it again."),
                        unit.at("dropped")});
    } else if (seen.active && !named_with_end && unit.at("state") == "failed") {
      alarms.push_back(
          {"unit_failed", serial, kAlarm, who + " has failed", action_at_lost_unit(seen, "The other units go on.")});
    }
    add_wrong_face(seen, unit, who, alarms);
  }
}

/// Every cause: one that is joined by a more urgent one is not over.
void add_suspension(const Seen& seen, const std::string& campaign, std::vector<Alarm>& alarms) {
  for (const Suspension& one : kSuspensions) {
    if (!is_cause(seen, one.cause)) continue;
    alarms.push_back({fmt::format("{}{}", kWaitsFor, one.cause), campaign, one.level, std::string(one.title),
                      std::string(one.action), "", end_of_wait(seen)});
  }
}

void add_chamber_not_off(const std::string& why, std::vector<Alarm>& alarms) {
  alarms.push_back({"chamber_not_off", "", kAlarm, "The chamber does not go off",
                    fmt::format("Go to the chamber, and switch heating and cooling off by hand. {}", kDoorStaysClosed),
                    why});
}

void add_stopping(const Seen& seen, const std::string& campaign, std::vector<Alarm>& alarms) {
  const std::string reason = reason_of_end(seen);
  const json& ending = seen.at("/ending");
  const bool refuses = ending.is_object() && ending.at("needs_somebody") == true;
  if (refuses && seen.at("/chamber/connected") == true) add_chamber_not_off(reason, alarms);
  // Somebody asked for this end, and the chamber does what it is told.
  if (ending.is_object() && !refuses && ending.at("outcome") == "aborted") {
    alarms.push_back({"campaign_aborted", campaign, kWarning,
                      "The campaign was aborted: the station is being made safe", std::string(kDoorStaysClosed), reason,
                      std::nullopt, false});
    return;
  }
  const bool can_go_on = ending.is_object() && ending.at("outcome") != "aborted";
  std::string_view action = "Mend what is named here.";
  if (can_go_on) action = "Mend what is named here. Resume continues it once the station is safe.";
  // By a soakd that somebody stops, or by the one after it.
  if (ending.is_object() && ending.at("outcome") == "interrupted") {
    action = "Resume continues it once the station is safe. Where soakd was stopped, start it again first.";
  }
  if (seen.at("/resumes_by_itself") == true) action = "It then goes on by itself: abort it to stop that.";
  alarms.push_back({"campaign_ended", campaign, kAlarm, "The campaign has ended: the station is being made safe",
                    fmt::format("{} {}", action, kDoorStaysClosed), reason});
}

void add_interrupted(const Seen& seen, const std::string& campaign, std::vector<Alarm>& alarms) {
  const std::string reason = seen.text("/reason");
  if (seen.at("/resumes_by_itself") == true) {
    alarms.push_back({"campaign_interrupted", campaign, kWarning, "The campaign was interrupted, and goes on by itself",
                      "Keep the door closed. To stop that, abort it.", reason, std::nullopt, false});
    return;
  }
  alarms.push_back({"campaign_interrupted", campaign, kWarning, "The campaign was interrupted",
                    seen.at("/resumable").is_string() ? "Press Resume: it goes on from the plateau before the break."
                                                      : "Start a new campaign.",
                    reason});
}

void add_queue(const Seen& seen, std::vector<Alarm>& alarms) {
  const std::string trouble = seen.text("/queue/trouble");
  if (seen.at("/queue/campaigns").empty()) return;
  const std::string next = seen.at("/queue/campaigns/0/name");
  if (seen.at("/queue/waits_for") == "time") {
    alarms.push_back({"queue_begins", next, kWarning, fmt::format("Campaign {} begins by itself", next),
                      "Keep the door closed. To stop that, abort it.", trouble,
                      Deadline{"It begins at", seen.at("/queue/begins_utc_s")}, false});
  } else if (!trouble.empty() && !seen.active) {
    alarms.push_back({"queue_held", next, kWarning, fmt::format("Campaign {} does not begin", next),
                      "Mend what is named here, then press Begin next.", trouble});
  }
}

void add_campaign(const Seen& seen, std::vector<Alarm>& alarms) {
  const std::string resumable = seen.text("/resumable");
  const std::string campaign = seen.of_campaign("name").empty() ? resumable : seen.of_campaign("name");
  const std::string trouble = seen.of_campaign("step_trouble");
  if (seen.state == "waiting" && !trouble.empty()) {
    add_chamber_not_off(trouble, alarms);
  } else if (seen.state == "waiting") {
    add_suspension(seen, campaign, alarms);
  } else if (seen.state == "failed") {
    alarms.push_back({"campaign_failed", campaign, kAlarm, "The campaign failed",
                      resumable.empty() ? "Mend what is named here, then start a new campaign."
                                        : "Mend what is named here, then press Resume: it goes on from the plateau "
                                          "before the break.",
                      reason_of_end(seen)});
  } else if (seen.state == "stopping") {
    add_stopping(seen, campaign, alarms);
  } else if (seen.state == "interrupted") {
    add_interrupted(seen, campaign, alarms);
  } else {
    add_queue(seen, alarms);
  }
}

json document_of(const Alarm& alarm) {
  const auto null_if_empty = [](const std::string& text) { return text.empty() ? json() : json(text); };
  return {
      {"code", alarm.code},
      {"about", null_if_empty(alarm.about)},
      {"level", alarm.level},
      {"title", alarm.title},
      {"detail", null_if_empty(alarm.detail)},
      {"action", alarm.action},
      {"deadline", alarm.deadline ? json{{"text", alarm.deadline->text}, {"utc_s", alarm.deadline->utc_s}} : json()},
      {"calls", alarm.calls}};
}

}  // namespace

json alarms_of(const json& status) {
  const Seen seen{status};
  std::vector<Alarm> alarms;
  add_chamber(seen, alarms);
  add_folder(seen, alarms);
  add_units(seen, alarms);
  add_campaign(seen, alarms);
  std::ranges::stable_partition(alarms, [](const Alarm& alarm) { return alarm.level == kAlarm; });
  json list = json::array();
  for (const Alarm& alarm : alarms) list.push_back(document_of(alarm));
  return list;
}

bool may_last_unseen(const json& status, std::string_view code, std::string_view about) {
  const Seen seen{status};
  if (code.starts_with(kWaitsFor)) return seen.state == "paused";
  if (code != "unit_dropped" && code != "unit_failed") return false;
  if (!seen.active || (seen.state == "stopping" && no_unit_is_left(seen))) return true;
  // Each run tries a unit anew; it is well once it sends again. Of a unit that takes no part nobody knows that.
  return std::ranges::none_of(seen.at("/units"), [&](const json& unit) {
    return unit.at("serial").get_ref<const std::string&>() == about && unit.at("state") == "streaming" &&
           !unit.at("dropped").is_string();
  });
}

}  // namespace soak::station
