// SPDX-License-Identifier: Apache-2.0
// What a customer looks for on a certificate: its number, who verified and released, until when it is good, a place to
// sign. What the station does not know is left as a line to be filled in.
#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "station/io/text.h"
#include "station/report/html.h"
#include "station/report/page_parts.h"

namespace soak::station {
namespace {

using html::member;
using nlohmann::json;

constexpr std::string_view kFillIn = "<span class=\"fill\"></span>";

/// "2026-11-28 by eva" of something with a time and a user.
std::string when_and_who(const json& step) {
  return fmt::format("{} by {}", iso_date(step["utc_s"].get<double>()), html::text_of(step, "user"));
}

/// What is wrong, without what would be right: that is for the laboratory, not for its customer.
std::string wrong_of(const std::string& obstacle) { return obstacle.substr(0, obstacle.rfind(": ")); }

std::string verified_text(const json& release) {
  const json& last = member(release, "verification");
  if (last.is_null()) return "no verification is stored";
  return fmt::format("{}, with campaign {}: {}", when_and_who(last), html::text_of(last, "campaign"),
                     verdict_word(last["verdict"].get<std::string>()));
}

std::string released_text(const json& release) {
  const std::string state = release["state"];
  if (state == "withdrawn") return "withdrawn: not to be used";
  const json& obstacles = release["obstacles"];
  if (state != "released") return obstacles.empty() ? "no, not yet" : "no";
  std::string text = when_and_who(release["released"]);
  if (obstacles.empty()) return text;
  text += ". Not to be handed over any more: " + html::escaped(wrong_of(obstacles[0].get<std::string>()));
  return obstacles.size() == 1 ? text : fmt::format("{}, and {} more", text, obstacles.size() - 1);
}

/// Only of what may be handed over: nothing else is valid until anything.
std::string expiry_text(const json& release) {
  if (release["state"] != "released" || !release["obstacles"].empty()) return "–";
  const json& expires = member(release, "expires_utc_s");
  return expires.is_number() ? iso_date(expires.get<double>()) : "no date is set";
}

}  // namespace

std::string verdict_word(const std::string& verdict) {
  std::string word = verdict == "info" ? "not judged" : verdict;
  std::ranges::replace(word, '_', ' ');
  std::ranges::transform(word, word.begin(), [](char c) { return c >= 'a' && c <= 'z' ? char(c - 32) : c; });
  return html::escaped(word);
}

std::string verdict_line(const std::string& verdict, const std::string& sentence) {
  return fmt::format("<p class=\"verdict {}\"><b>{}</b>{}</p>\n", html::escaped(verdict), verdict_word(verdict),
                     html::said(sentence));
}

std::string certificate_number(const json& document) {
  const std::string date = iso_date(document["created_utc_s"].get<double>());
  return fmt::format("{}, model {}, {}", document["unit"].get<std::string>(), document["model"].get<int>(), date);
}

std::string certificate_facts(const json& document) {
  std::vector<std::pair<std::string, std::string>> list = {
      {"Laboratory", std::string(kFillIn)}, {"Certificate number", html::escaped(certificate_number(document))}};
  const json& release = member(document["sections"], "release");
  if (release.is_object()) {
    list.emplace_back("Verified", verified_text(release));
    list.emplace_back("Released", released_text(release));
    list.emplace_back("Valid until", expiry_text(release));
  }
  return html::facts(list);
}

std::string signature_part() {
  const std::string fill(kFillIn);
  return "<div class=\"signature\">\n" + html::facts({{"Place and date", fill}, {"Name", fill}, {"Signature", fill}}) +
         "</div>\n";
}

}  // namespace soak::station
