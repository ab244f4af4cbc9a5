// SPDX-License-Identifier: Apache-2.0
#include "station/commands/campaign_commands.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "station/commands/campaign_client.h"
#include "station/commands/campaign_text.h"
#include "station/io/host.h"
#include "station/io/text_file.h"

namespace soak::station {
namespace {

using nlohmann::json;

std::string user_of(const StationCommand& command) { return command.user.empty() ? user_name() : command.user; }

/// Sends a command and prints the state that it leads to.
base::Status send(const StationCommand& station, const std::string& name, json body, const std::string& done,
                  Output& output) {
  const auto client = station_client(station);
  if (!client) return base::forward_error(client);
  body["user"] = user_of(station);
  const auto answer = client->command(name, body);
  if (!answer) return base::forward_error(answer);
  if (output.json()) return output.print_json(*answer);
  output.print(done + "\n");
  return {};
}

}  // namespace

base::Status run_campaign_start(const CampaignStartCommand& command, Output& output) {
  const auto client = station_client(command.station);
  if (!client) return base::forward_error(client);
  const auto procedure = read_text_file(command.procedure);
  if (!procedure) return base::forward_error(procedure);
  const auto answer = client->command("start", {{"procedure_text", *procedure},
                                                {"procedure_file", command.procedure},
                                                {"campaign", command.name},
                                                {"units", command.units},
                                                {"user", user_of(command.station)}});
  if (!answer) return base::forward_error(answer);
  if (output.json()) return output.print_json(*answer);
  for (const json& note : answer->value("notes", json::array())) output.note("note: " + note.get<std::string>());
  output.print(fmt::format(
      "campaign {} has started: {} runs, {} steps, about {} of process time\n'soak campaign watch' follows it\n",
      command.name, answer->value("runs", 0), answer->value("steps", 0),
      duration_text(answer->value("estimate_s", 0.0))));
  return {};
}

base::Status run_campaign_status(const StationCommand& command, Output& output) {
  const auto client = station_client(command);
  if (!client) return base::forward_error(client);
  const auto status = client->get("status");
  if (!status) return base::forward_error(status);
  if (output.json()) return output.print_json(*status);
  output.print(status_text(*status));
  return {};
}

base::Status run_campaign_pause(const StationCommand& command, Output& output) {
  return send(command, "pause", json::object(), "the campaign pauses: 'soak campaign resume' goes on", output);
}

base::Status run_campaign_resume(const StationCommand& command, Output& output) {
  return send(command, "resume", json::object(), "the campaign goes on", output);
}

base::Status run_campaign_abort(const CampaignAbortCommand& command, Output& output) {
  return send(command.station, "abort", {{"reason", command.reason}}, "the campaign stops safely", output);
}

base::Status run_campaign_confirm(const StationCommand& command, Output& output) {
  const auto client = station_client(command);
  if (!client) return base::forward_error(client);
  const auto status = client->get("status");
  if (!status) return base::forward_error(status);
  const json prompt = status->value("prompt", json());
  if (prompt.is_null()) return base::bad_input("the station asks nothing, so there is nothing to confirm", "state");
  const auto text = prompt.at("text").get<std::string>();
  return send(command, "confirm", {{"prompt", prompt.at("id")}}, "confirmed: " + text, output);
}

}  // namespace soak::station
