// SPDX-License-Identifier: Apache-2.0
#include "station/alarms/alarm_book.h"

namespace soak::station {
namespace {

using nlohmann::json;

/// A campaign that ends, and then waits for somebody in the safe state, is one alarm.
std::string kind_of(const std::string& code) {
  const bool is_end = code == "campaign_ended" || code == "campaign_failed" || code == "campaign_interrupted";
  return is_end ? "campaign_end" : code;
}

std::pair<std::string, std::string> key_of(const json& alarm) {
  const json& about = alarm.at("about");
  return {kind_of(alarm.at("code")), about.is_string() ? about.get<std::string>() : ""};
}

}  // namespace

std::vector<AlarmBook::Entry> AlarmBook::take(const json& alarms, double now_s, const MayLast& may_last) {
  for (const json& alarm : alarms) {
    if (alarm.at("calls") != true) continue;
    const auto [place, is_new] = known_.try_emplace(key_of(alarm));
    if (is_new) place->second.since_s = now_s;
    place->second.alarm = alarm;
    place->second.seen_s = now_s;
  }
  std::vector<Entry> entries;
  for (auto place = known_.begin(); place != known_.end();) {
    Known& known = place->second;
    if (!may_last(place->first.first, place->first.second)) {
      known.was_missed = known.seen_s < now_s;
    } else if (known.is_told && !known.was_missed) {
      known.seen_s = now_s;
    }
    const double away_s = now_s - known.seen_s;
    if (away_s == 0.0 && !known.is_told && now_s - known.since_s >= kHolds_s) begin(known, now_s, entries);
    const bool is_over = away_s > 0.0 && (!known.is_told || away_s >= kStaysAway_s);
    if (is_over && known.is_told) entries.push_back({AlarmTurn::ended, std::move(known.alarm)});
    place = is_over ? known_.erase(place) : std::next(place);
  }
  return entries;
}

void AlarmBook::begin(Known& known, double now_s, std::vector<Entry>& entries) {
  known.is_told = ration_.take(now_s);
  if (!known.is_told && known.is_held_back) return;
  known.is_held_back = !known.is_told;
  entries.push_back({known.is_told ? AlarmTurn::began : AlarmTurn::held_back, known.alarm});
}

bool EngineTurns::stand_still(std::uint64_t version, double now_s) {
  if (version_ != version) rose_s_ = now_s;
  version_ = version;
  return now_s - rose_s_ >= kStuck_s;
}

}  // namespace soak::station
