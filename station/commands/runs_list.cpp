// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "station/commands/run_document.h"
#include "station/commands/runs_command.h"
#include "station/io/data_folder.h"

namespace soak::station {
namespace {

std::string state(const db::RunRow& run) {
  std::string text = run.sealed ? "sealed" : "open";
  if (run.voided) text += ", void";
  if (run.simulated) text += ", SIMULATED";
  return text;
}

}  // namespace

base::Status run_runs_list(const RunsListCommand& command, Output& output) {
  const auto catalog = open_existing_catalog(command.data);
  if (!catalog) return base::forward_error(catalog);
  const auto runs = catalog->runs(command.filter);
  if (!runs) return base::forward_error(runs);
  if (output.json()) {
    nlohmann::json list = nlohmann::json::array();
    for (const db::RunRow& run : *runs) list.push_back(run_document(run));
    return output.print_json({{"runs", list}});
  }
  std::vector<std::vector<std::string>> table = {
      {"unit", "campaign", "run", "purpose", "run id", "rows", "seconds", "state"}};
  for (const db::RunRow& run : *runs) {
    table.push_back({run.unit, run.campaign, run.label, run.purpose, run.run_id, std::to_string(run.rows),
                     fmt::format("{:.1f}", run.duration_s), state(run)});
  }
  output.print(text_table(table));
  return {};
}

}  // namespace soak::station
