// SPDX-License-Identifier: Apache-2.0
#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <memory>

#include "station/commands/campaign_commands.h"
#include "station/commands/frame.h"

namespace soak::station::cli {
namespace {

void add_station(CLI::App& command, StationCommand& station) {
  command.add_option("--station", station.station, "Where soakd listens (else $SOAK_STATION, else 127.0.0.1:8088)")
      ->type_name("HOST:PORT");
}

void add_user(CLI::App& command, StationCommand& station) {
  command.add_option("--user", station.user, "Who (else the user that runs the program)")->type_name("NAME");
}

/// A command that takes no more than the station.
using Perform = base::Status (*)(const StationCommand&, Output&);
CLI::App* add_plain(CLI::App& group, Request& request, const std::string& name, const std::string& description,
                    Perform perform, bool changes) {
  const auto options = std::make_shared<StationCommand>();
  CLI::App* command = add_command(group, request, name, description, "soak campaign " + name, true);
  add_station(*command, *options);
  if (changes) add_user(*command, *options);
  command->callback([options, perform, &request] {
    request.action = [options, perform](Output& output) { return perform(*options, output); };
  });
  return command;
}

/// SLOT=SERIAL; CLI11 prints the text that comes back as the mistake.
std::string check_unit(const std::string& text) {
  const std::size_t equals = text.find('=');
  if (equals != std::string::npos && equals > 0 && equals + 1 < text.size()) return {};
  return "'" + text + "' is not SLOT=SERIAL";
}

void register_campaign_start(CLI::App& group, Request& request) {
  const auto options = std::make_shared<CampaignStartCommand>();
  const auto units = std::make_shared<std::vector<std::string>>();
  CLI::App* command = add_command(group, request, "start", "Check a procedure and begin a campaign with it",
                                  "soak campaign start procedures/soak.toml --name acceptance --unit A=SN0042", true);
  command->add_option("procedure", options->procedure, "Procedure file")->required()->type_name("PROCEDURE.toml");
  command->add_option("--name", options->name, "Name of the campaign")->required()->type_name("NAME");
  command->add_option("--unit", *units, "Unit in a slot, once per unit (else those of the station's configuration)")
      ->type_name("SLOT=SERIAL")
      ->allow_extra_args(false)
      ->check(check_unit);
  add_station(*command, options->station);
  add_user(*command, options->station);
  command->callback([options, units, &request] {
    for (const std::string& unit : *units) {
      const std::size_t equals = unit.find('=');
      if (!options->units.emplace(unit.substr(0, equals), unit.substr(equals + 1)).second) {
        throw CLI::ValidationError("--unit", "slot '" + unit.substr(0, equals) + "' is given twice");
      }
    }
    request.action = [options](Output& output) { return run_campaign_start(*options, output); };
  });
}

void register_campaign_abort(CLI::App& group, Request& request) {
  const auto options = std::make_shared<CampaignAbortCommand>();
  CLI::App* command = add_command(group, request, "abort", "End the campaign safely",
                                  "soak campaign abort --reason 'a cable is loose'", true);
  command->add_option("--reason", options->reason, "Why")->required()->type_name("TEXT");
  add_station(*command, options->station);
  add_user(*command, options->station);
  command->callback([options, &request] {
    request.action = [options](Output& output) { return run_campaign_abort(*options, output); };
  });
}

}  // namespace

void register_campaign(CLI::App& program, Request& request) {
  CLI::App* group = add_group(program, "campaign",
                              "Campaigns of the running soakd: start, status, watch, pause, resume, abort, confirm");
  register_campaign_start(*group, request);
  add_plain(*group, request, "status", "Where the campaign is, chamber and units", run_campaign_status, false);
  add_plain(*group, request, "watch", "Follow the campaign to its end", run_campaign_watch, false)
      ->footer(
          "Example:\n  soak campaign watch\n\nEnds with the campaign: exit status 0 finished, 1 aborted or "
          "interrupted, 3 a "
          "device failed. Ctrl-C ends the watch, not the campaign.");
  add_plain(*group, request, "pause", "Hold the campaign where it is safe", run_campaign_pause, true);
  add_plain(*group, request, "resume", "Go on with a paused campaign", run_campaign_resume, true);
  register_campaign_abort(*group, request);
  add_plain(*group, request, "confirm", "Answer the prompt that the station waits on", run_campaign_confirm, true);
}

}  // namespace soak::station::cli
