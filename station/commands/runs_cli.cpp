// SPDX-License-Identifier: Apache-2.0
#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <memory>
#include <utility>

#include "station/commands/frame.h"
#include "station/commands/runs_command.h"

namespace soak::station::cli {
namespace {

void add_filter(CLI::App& command, db::RunFilter& filter) {
  command.add_option("--unit", filter.unit, "Only runs of this unit")->type_name("SN");
  command.add_option("--campaign", filter.campaign, "Only runs of this campaign")->type_name("NAME");
}

void add_run_and_filter(CLI::App& command, db::RunFilter& filter) {
  command.add_option("run", filter.run, "Run id, unique beginning of one, or label")->required()->type_name("RUN");
  add_filter(command, filter);
}

/// Makes `perform(options, output)` what the command does.
template <class Options, class Perform>
void set_action(CLI::App& command, Request& request, std::shared_ptr<Options> options, Perform perform) {
  command.callback([options = std::move(options), perform, &request] {
    options->data = request.data;
    request.action = [options, perform](Output& output) { return perform(*options, output); };
  });
}

void register_runs_list(CLI::App& group, Request& request) {
  const auto options = std::make_shared<RunsListCommand>();
  CLI::App* command = add_command(group, request, "list", "All runs", "soak runs list --unit SN0042 --json", true);
  add_filter(*command, options->filter);
  set_action(*command, request, options, run_runs_list);
}

void register_runs_show(CLI::App& group, Request& request) {
  const auto options = std::make_shared<RunsShowCommand>();
  CLI::App* command = add_command(group, request, "show", "One run: channels, segments with their means, void records",
                                  "soak runs show soak_run_1", true);
  add_run_and_filter(*command, options->filter);
  set_action(*command, request, options, run_runs_show);
}

void register_runs_export(CLI::App& group, Request& request) {
  const auto options = std::make_shared<RunsExportCommand>();
  CLI::App* command = add_command(group, request, "export", "Write the samples of a run as CSV",
                                  "soak runs export soak_run_1 --native -o soak_run_1.csv", false);
  add_run_and_filter(*command, options->filter);
  command->add_flag(
      "--native", options->native,
      "The source's own headers and numbers; with a columns map beside the CSV where its import needs one");
  command->add_option("-o,--output", options->file, "File to write (else standard output)")->type_name("FILE");
  set_action(*command, request, options, run_runs_export);
}

void register_runs_void(CLI::App& group, Request& request) {
  const auto options = std::make_shared<RunsVoidCommand>();
  CLI::App* command = add_command(group, request, "void", "Withdraw a run, a visit or a segment; nothing is deleted",
                                  "soak runs void soak_run_1 --visit 3 --position +X --reason 'door was open'", true);
  add_run_and_filter(*command, options->filter);
  command->add_option("--visit", options->visit, "Only this visit (ordinal of the plateau in the run)")->type_name("N");
  command->add_option("--position", options->position, "Only this position of the visit")->type_name("P");
  command->add_option("--attempt", options->attempt, "Only this attempt at the position")->type_name("K");
  command->add_option("--reason", options->reason, "Why")->required()->type_name("TEXT");
  command->add_option("--user", options->user, "Who (else the user that runs the program)")->type_name("NAME");
  set_action(*command, request, options, run_runs_void);
}

void register_runs_verify(CLI::App& group, Request& request) {
  const auto options = std::make_shared<RunsVerifyCommand>();
  CLI::App* command =
      add_command(group, request, "verify", "Check catalog and run files against their hashes and checks",
                  "soak runs verify", true);
  command->add_option("run", options->runs, "Runs to check (else all)")->type_name("RUN");
  set_action(*command, request, options, run_runs_verify);
}

}  // namespace

void register_runs(CLI::App& program, Request& request) {
  CLI::App* group = add_group(program, "runs", "Runs: list, show, export, void, verify");
  register_runs_list(*group, request);
  register_runs_show(*group, request);
  register_runs_export(*group, request);
  register_runs_void(*group, request);
  register_runs_verify(*group, request);
}

}  // namespace soak::station::cli
