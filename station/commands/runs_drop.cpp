// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "station/commands/command.h"
#include "station/commands/shared.h"
#include "station/fit/fit_unit.h"
#include "station/io/host.h"
#include "station/io/text.h"
#include "station/records/sample_drop.h"

namespace soak::station {
namespace {

/// soak runs drop-samples (RUN... | --campaign NAME) --reason TEXT [--user NAME] [--yes]
struct RunsDropSamples final : CatalogCommand {
  std::vector<std::string> names;
  std::optional<std::string> campaign;
  std::string reason;
  std::string user;  ///< empty = the user that runs the program
  bool yes = false;

  void declare(OptionList& options) override {
    options.add("run RUN", &names, "Runs whose samples to drop, of all units that the file holds");
    options.add("--campaign NAME", &campaign, "All runs of this campaign that still have samples");
    options.add("--reason TEXT", &reason, "Reason, for the record").required();
    options.add("--user NAME", name_reader(user), "Name for the record (default: the user that runs the program)");
    options.add("--yes", &yes, "Do it; without this option the command only says what it would do");
  }
  base::Status run_with(db::Catalog& catalog, Output& output) override;
};

/// Ids of the runs that the command names, each once.
base::Result<std::vector<std::string>> run_ids(const db::Catalog& catalog, const RunsDropSamples& command) {
  if (command.names.empty() == !command.campaign) {
    return base::bad_input("name the runs, or a campaign with --campaign, not both", "drop-samples");
  }
  std::vector<std::string> ids;
  const auto add = [&](const std::string& id) {
    if (std::ranges::find(ids, id) == ids.end()) ids.push_back(id);
  };
  for (const std::string& name : command.names) {
    const auto parts = catalog.runs({.unit = {}, .campaign = {}, .run = name});
    if (!parts) return base::forward_error(parts);
    if (parts->empty()) return base::bad_input("there is no such run; 'soak runs list' shows them", name);
    // Parts of one run have one id; a label may name several runs.
    for (const db::RunRow& part : *parts) {
      if (part.run_id == parts->front().run_id) continue;
      return base::bad_input(fmt::format("several runs have this label ({}, {}, ...): give the run id",
                                         parts->front().run_id, part.run_id),
                             name);
    }
    add(parts->front().run_id);
  }
  if (!command.campaign) return ids;
  if (auto known = check_campaign_known(catalog, *command.campaign); !known) return base::forward_error(known);
  const auto runs = catalog.runs({.unit = {}, .campaign = command.campaign, .run = {}});
  if (!runs) return base::forward_error(runs);
  for (const db::RunRow& run : *runs) {
    if (!run.samples_dropped) add(run.run_id);
  }
  if (ids.empty()) return base::bad_input("has no run with samples", "campaign " + *command.campaign);
  return ids;
}

nlohmann::json document_of(const std::vector<SamplePlan>& plans, const RunsDropSamples& command,
                           const std::string& user) {
  nlohmann::json runs = nlohmann::json::array();
  std::uint64_t bytes = 0;
  for (const SamplePlan& plan : plans) {
    runs.push_back({{"run", plan.run.label},
                    {"run_id", plan.run.run_id},
                    {"campaign", plan.run.campaign},
                    {"units", plan.units},
                    {"file", plan.run.file_name},
                    {"bytes", plan.bytes}});
    bytes += plan.bytes;
  }
  return {{"dropped", command.yes}, {"bytes", bytes}, {"reason", command.reason}, {"user", user}, {"runs", runs}};
}

std::string text_of(const std::vector<SamplePlan>& plans, bool dropped) {
  std::string text;
  double megabytes = 0.0;
  for (const SamplePlan& plan : plans) {
    const double size_mb = 1e-6 * static_cast<double>(plan.bytes);
    megabytes += size_mb;
    text += fmt::format("{}  {:.1f} MB  run {} of {}: unit{} {}\n", plan.run.run_id, size_mb, plan.run.label,
                        plan.run.campaign, plan.units.size() == 1 ? "" : "s", fmt::join(plan.units, ", "));
  }
  if (dropped) {
    return text + fmt::format(
                      "the samples of {} run{} were dropped, {:.1f} MB; statistics, findings, records and "
                      "models stay\n",
                      plans.size(), plans.size() == 1 ? "" : "s", megabytes);
  }
  return text + fmt::format(
                    "nothing was done. With --yes the samples of {} run{} go, {:.1f} MB, for good: no chart, no "
                    "export, no noise figures and no gap search of them any more. Fits and verifications use the "
                    "statistics, which stay\n",
                    plans.size(), plans.size() == 1 ? "" : "s", megabytes);
}

base::Status interrupted_after(std::size_t runs) {
  return base::fail(base::ErrorKind::internal,
                    fmt::format("interrupted; the samples of {} run{} were dropped", runs, runs == 1 ? "" : "s"),
                    "drop-samples");
}

base::Status RunsDropSamples::run_with(db::Catalog& catalog, Output& output) {
  if (auto plain = check_text_line(reason, "--reason"); !plain) return plain;
  const auto ids = run_ids(catalog, *this);
  if (!ids) return base::forward_error(ids);
  // All are judged before the first one is touched.
  if (auto whole = catalog.verify(); !whole) return whole;
  std::vector<SamplePlan> plans;
  const auto report = output.progress("checking");
  for (const std::string& id : *ids) {
    if (!report(static_cast<double>(plans.size()) / static_cast<double>(ids->size()))) return interrupted_after(0);
    auto plan = plan_sample_drop(catalog, id);
    if (!plan) return base::forward_error(plan);
    plans.push_back(*std::move(plan));
  }
  output.end_progress();
  const std::string name = user_name(user);
  for (std::size_t done = 0; yes && done < plans.size(); ++done) {
    if (interrupted()) return interrupted_after(done);
    if (auto dropped = drop_samples(catalog, plans[done], reason, name); !dropped) return dropped;
  }
  if (output.json()) return output.print_json(document_of(plans, *this, name));
  output.print(text_of(plans, yes));
  return {};
}

}  // namespace

CommandGroup run_drop_commands() {
  return {"runs",
          "Runs: list, show, export, void, verify, drop samples",
          {{"drop-samples", "Free the disk of samples that are not needed any more; their statistics stay",
            "soak runs drop-samples soak_run_1 --reason 'kept for five years'", std::make_shared<RunsDropSamples>()}}};
}

}  // namespace soak::station
