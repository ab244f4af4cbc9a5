// SPDX-License-Identifier: Apache-2.0
#include "station/alarms/alarm_message.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <ctime>

#include "station/http/address.h"
#include "station/io/host.h"

namespace soak::station {
namespace {

using nlohmann::json;

/// "2026-11-26 15:05 CET": the station's own time, in which its people live.
std::string local_time(double utc_s) {
  const auto seconds = static_cast<std::time_t>(utc_s);
  std::tm parts{};
  localtime_r(&seconds, &parts);
  std::array<char, 64> text{};
  return {text.data(), std::strftime(text.data(), text.size(), "%Y-%m-%d %H:%M %Z", &parts)};
}

json null_if_empty(const std::string& text) { return text.empty() ? json() : json(text); }

std::string text_of(const json& member) { return member.is_string() ? member.get<std::string>() : ""; }

json base_document(const std::string& turn, const std::string& title, const AlarmPlace& place) {
  return {{"station", place.station},
          {"turn", turn},
          {"title", title},
          {"campaign", null_if_empty(place.campaign)},
          {"utc_s", place.utc_s}};
}

/// `paragraphs`: empty ones are left out. Chat programs take the member `text`.
AlarmMessage finished(json document, const std::string& headline, std::initializer_list<std::string> paragraphs,
                      const AlarmPlace& place) {
  AlarmMessage message;
  message.subject = one_line(fmt::format("Soak {}: {}", place.station, headline));
  message.text = headline + "\n";
  for (const std::string& paragraph : paragraphs) {
    if (!paragraph.empty()) message.text += "\n" + paragraph + "\n";
  }
  message.text +=
      fmt::format("\nStation {}, {}{}\n", place.station,
                  place.campaign.empty() ? "" : fmt::format("campaign {}, ", place.campaign), local_time(place.utc_s));
  document["text"] = message.text;
  message.document = std::move(document);
  return message;
}

}  // namespace

AlarmPlace place_now(std::string campaign) {
  const auto names = names_of_machine();
  return {names.empty() ? "station" : names.front(), std::move(campaign), now_utc_s()};
}

AlarmMessage message_of(const AlarmBook::Entry& entry, const AlarmPlace& place) {
  const json& alarm = entry.alarm;
  const bool began = entry.turn == AlarmTurn::began;
  const std::string title = alarm.at("title");
  json document = base_document(began ? "began" : "ended", title, place);
  for (const char* member : {"code", "about", "level", "detail", "action", "deadline"})
    document[member] = alarm.at(member);
  if (!began) return finished(std::move(document), "Over: " + title, {}, place);
  std::string action = alarm.at("action");
  if (const json& deadline = alarm.at("deadline"); deadline.is_object()) {
    action += fmt::format(" {} {}.", deadline.at("text").get<std::string>(), local_time(deadline.at("utc_s")));
  }
  return finished(std::move(document), title, {text_of(alarm.at("detail")), action}, place);
}

AlarmMessage message_of(const std::string& turn, const std::string& title, const AlarmPlace& place) {
  return finished(base_document(turn, title, place), title, {}, place);
}

std::string one_line(std::string text) {
  for (char& c : text) {
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7F) c = ' ';
  }
  const auto end = text.find_last_not_of(' ');
  text.erase(end == std::string::npos ? 0 : end + 1);
  return text;
}

}  // namespace soak::station
