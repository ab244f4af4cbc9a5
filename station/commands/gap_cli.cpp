// SPDX-License-Identifier: Apache-2.0
#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <memory>

#include "station/commands/frame.h"
#include "station/commands/gap_commands.h"

namespace soak::station::cli {

namespace {

void add_unit_option(CLI::App& command, std::string& unit) {
  command.add_option("--unit", unit, "Serial number of the unit")->required()->type_name("SN");
}

void add_user_option(CLI::App& command, std::string& user) {
  command.add_option("--user", user, "Who (else the user that runs the program)")->type_name("NAME");
}

void register_find(CLI::App& group, Request& request) {
  const auto options = std::make_shared<GapFindCommand>();
  CLI::App* find = add_command(group, request, "find", "Name the effect that a unit's model lacks",
                               "soak gap find --unit SN0042", true);
  add_unit_option(*find, options->unit);
  find->add_option("--campaign", options->campaign, "Runs of this campaign only")->type_name("NAME");
  find->callback([options, &request] {
    options->data = request.data;
    request.action = [options](Output& output) { return run_gap_find(*options, output); };
  });
}

void register_accept(CLI::App& group, Request& request) {
  const auto options = std::make_shared<GapAcceptCommand>();
  CLI::App* accept = add_command(group, request, "accept", "Add the effects that are named to the model: a new version",
                                 "soak gap accept --unit SN0042", true);
  add_unit_option(*accept, options->unit);
  accept->add_option("--campaign", options->campaign, "Look in the runs of this campaign only")->type_name("NAME");
  accept->add_option("--effect", options->effects, "Only this one of the effects that are named (may be repeated)")
      ->type_name("NAME");
  add_user_option(*accept, options->user);
  accept->callback([options, &request] {
    options->data = request.data;
    request.action = [options](Output& output) { return run_gap_accept(*options, output); };
  });
}

void register_withdraw(CLI::App& group, Request& request) {
  const auto options = std::make_shared<GapWithdrawCommand>();
  CLI::App* withdraw = add_command(
      group, request, "withdraw", "Take an accepted effect out of the model again: a new version",
      "soak gap withdraw --unit SN0042 --effect temperature_rate --reason 'longer soak: it was hysteresis'", true);
  add_unit_option(*withdraw, options->unit);
  withdraw->add_option("--effect", options->effect, "Its name")->required()->type_name("NAME");
  withdraw->add_option("--reason", options->reason, "Why, for the log")->required()->type_name("TEXT");
  add_user_option(*withdraw, options->user);
  withdraw->callback([options, &request] {
    options->data = request.data;
    request.action = [options](Output& output) { return run_gap_withdraw(*options, output); };
  });
}

void register_show(CLI::App& group, Request& request) {
  const auto options = std::make_shared<GapShowCommand>();
  options->software = "soak " SOAK_VERSION;
  CLI::App* show = add_command(group, request, "show", "Simulate the runs before and after the accepted effects",
                               "soak gap show --unit SN0042 -o gap.html", true);
  add_unit_option(*show, options->unit);
  show->add_option("--model", options->model, "Version of the model (else the newest)")
      ->type_name("V")
      ->check(CLI::Range(1, 1000000));
  show->add_option("--campaign", options->campaign, "Runs of this campaign only")->type_name("NAME");
  show->add_option("-o,--output", options->file, "Write a page with pictures here")->type_name("FILE.html");
  show->callback([options, &request] {
    options->data = request.data;
    request.action = [options](Output& output) { return run_gap_show(*options, output); };
  });
}

}  // namespace

void register_gap(CLI::App& program, Request& request) {
  CLI::App* group = add_group(program, "gap", "What simulation and measurement disagree on, and which effect that is");
  register_find(*group, request);
  register_accept(*group, request);
  register_withdraw(*group, request);
  register_show(*group, request);
}

}  // namespace soak::station::cli
