// SPDX-License-Identifier: Apache-2.0
#include "station/http/api.h"

#include <algorithm>
#include <initializer_list>
#include <nlohmann/json.hpp>

#include "base/text.h"
#include "station/http/members.h"
#include "station/io/data_folder.h"

namespace soak::station {
namespace {

using base::Result;
using nlohmann::json;
using Parameter = std::optional<std::string>;

Result<json> answer_status(StationService& lab, const Parameter&, std::int64_t) { return lab.status(); }

Result<json> answer_plan(StationService& lab, const Parameter& around, std::int64_t) {
  if (!around) return lab.plan(std::nullopt);
  const auto step = base::parse_int(*around);
  if (!step || *step < 0) return base::bad_input("'" + *around + "' is not the number of a step", "around");
  return lab.plan(step);
}

Result<json> answer_history(StationService& lab, const Parameter& after_s, std::int64_t) {
  const auto value = base::parse_double(after_s.value_or("-1"));
  if (!value) return base::bad_input("'" + *after_s + "' is not a number of seconds", "after_s");
  return lab.history(*value);
}

Result<json> answer_stored(StationService& lab, const Parameter&, std::int64_t) { return lab.stored(); }

Result<json> answer_procedures(StationService& lab, const Parameter& file, std::int64_t) {
  if (file && file->empty()) return base::bad_input("the name of a file is empty", "file");
  return lab.procedures(file.value_or(""));
}

Result<json> answer_types(StationService& lab, const Parameter&, std::int64_t) { return lab.types(); }

Result<json> answer_noise(StationService& lab, const Parameter& unit, std::int64_t) {
  return lab.noise(unit.value_or(""));
}

Result<json> answer_log(StationService& lab, const Parameter& after, std::int64_t newest_log) {
  const auto value = base::parse_int(after.value_or("0"));
  if (!value) return base::bad_input("'" + *after + "' is not the number of a log entry", "after");
  return lab.log(*value >= 0 ? *value : std::max<std::int64_t>(0, newest_log + *value));
}

/// The user of a command that has no other members than `known`.
Result<std::string> user_of_command(const json& body, std::initializer_list<std::string_view> known) {
  if (auto status = only_members(body, known); !status) return base::forward_error(status);
  return line_member(body, "user", "unknown");
}

Result<std::map<std::string, std::string>> units_member(const json& body) {
  std::map<std::string, std::string> found;
  const auto member = body.find("units");
  if (member == body.end()) return found;
  if (!member->is_object()) return base::bad_input("not an object of slots and serial numbers", "units");
  for (const auto& unit : member->items()) {
    if (!unit.value().is_string()) return base::bad_input("the serial number is not text", "units." + unit.key());
    found[unit.key()] = unit.value().get<std::string>();
    if (auto fits = check_single_line(found[unit.key()], "units." + unit.key()); !fits)
      return base::forward_error(fits);
  }
  return found;
}

/// `no_name`: the campaign's name where the body has none; absent = it must have one.
Result<StartRequest> start_request(const json& body, const std::optional<std::string>& no_name = std::nullopt) {
  const auto user = user_of_command(body, {"procedure_text", "procedure_file", "campaign", "units", "user"});
  if (!user) return base::forward_error(user);
  const auto procedure = text_member(body, "procedure_text", std::nullopt);
  if (!procedure) return base::forward_error(procedure);
  const auto file = line_member(body, "procedure_file", "procedure");
  if (!file) return base::forward_error(file);
  const auto campaign = line_member(body, "campaign", no_name);
  if (!campaign) return base::forward_error(campaign);
  const auto slots = units_member(body);
  if (!slots) return base::forward_error(slots);
  return StartRequest{*procedure, *file, *campaign, *slots, *user};
}

/// What every command but start answers: the state that the laboratory is in by now.
Result<json> state_after(const base::Status& done, const StationService& lab) {
  if (!done) return base::forward_error(done);
  return json{{"state", lab.status().at("state")}};
}

Result<json> do_start(StationService& lab, const json& body) {
  const auto request = start_request(body);
  if (!request) return base::forward_error(request);
  return lab.start(*request);
}

Result<json> do_queue(StationService& lab, const json& body) {
  const auto request = start_request(body);
  if (!request) return base::forward_error(request);
  return lab.queue(*request);
}

Result<json> do_check(StationService& lab, const json& body) {
  const auto request = start_request(body, "");
  if (!request) return base::forward_error(request);
  return lab.check(*request);
}

Result<json> do_look(StationService& lab, const json& body) {
  const auto user = user_of_command(body, {"user"});
  if (!user) return base::forward_error(user);
  return lab.look(*user);
}

Result<json> do_unqueue(StationService& lab, const json& body) {
  const auto user = user_of_command(body, {"user", "campaign"});
  if (!user) return base::forward_error(user);
  const auto campaign = line_member(body, "campaign", std::nullopt);
  if (!campaign) return base::forward_error(campaign);
  return state_after(lab.unqueue(*user, *campaign), lab);
}

Result<json> do_next(StationService& lab, const json& body) {
  const auto user = user_of_command(body, {"user", "campaign"});
  if (!user) return base::forward_error(user);
  if (!body.contains("campaign")) return state_after(lab.next(*user, ""), lab);
  const auto campaign = line_member(body, "campaign", std::nullopt);
  if (!campaign) return base::forward_error(campaign);
  return state_after(lab.next(*user, *campaign), lab);
}

template <base::Status (StationService::*command)(const std::string&)>
Result<json> user_command(StationService& lab, const json& body) {
  const auto user = user_of_command(body, {"user"});
  if (!user) return base::forward_error(user);
  return state_after((lab.*command)(*user), lab);
}

Result<json> do_abort(StationService& lab, const json& body) {
  const auto user = user_of_command(body, {"user", "reason"});
  if (!user) return base::forward_error(user);
  const auto reason = line_member(body, "reason", std::nullopt);
  if (!reason) return base::forward_error(reason);
  return state_after(lab.abort(*user, *reason), lab);
}

Result<json> do_confirm(StationService& lab, const json& body) {
  const auto user = user_of_command(body, {"user", "prompt"});
  if (!user) return base::forward_error(user);
  const auto prompt = body.find("prompt");
  if (prompt == body.end() || !prompt->is_number_integer()) {
    return base::bad_input("the number of the prompt is missing or not a whole number", "prompt");
  }
  return state_after(lab.confirm(*user, prompt->get<std::int64_t>()), lab);
}

}  // namespace

const std::vector<ApiQuestion>& api_questions() {
  static const std::vector<ApiQuestion> questions = {{"status", "", answer_status},
                                                     {"plan", "around", answer_plan},
                                                     {"history", "after_s", answer_history},
                                                     {"stored", "", answer_stored},
                                                     {"noise", "unit", answer_noise},
                                                     {"log", "after", answer_log},
                                                     {"procedures", "file", answer_procedures},
                                                     {"types", "", answer_types}};
  return questions;
}

const std::vector<ApiCommand>& api_commands() {
  static const std::vector<ApiCommand> commands = {{"start", do_start},
                                                   {"queue", do_queue},
                                                   {"check", do_check},
                                                   {"look", do_look},
                                                   {"unqueue", do_unqueue},
                                                   {"next", do_next},
                                                   {"pause", user_command<&StationService::pause>},
                                                   {"resume", user_command<&StationService::resume>},
                                                   {"abort", do_abort},
                                                   {"confirm", do_confirm}};
  return commands;
}

Result<json> parse_body(const std::string& text) {
  json body = json::parse(text, nullptr, false);
  if (!body.is_object()) return base::bad_input("the body is not a JSON object", "body");
  return body;
}

int http_status(const base::Error& error) {
  switch (error.kind) {
    case base::ErrorKind::bad_input:
      return error.where == "state" ? 409 : 400;
    case base::ErrorKind::device:
      return 502;
    default:
      return error.where == kBusy || error.where == kNoFolder ? 503 : 500;
  }
}

std::string error_text(const base::Error& error) {
  return compact(
      {{"error", {{"code", static_cast<int>(error.kind)}, {"message", error.message}, {"where", error.where}}}});
}

std::string compact(const json& document) { return document.dump(-1, ' ', false, json::error_handler_t::replace); }

}  // namespace soak::station
