// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <array>
#include <cstddef>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <optional>

#include "base/hash.h"
#include "db/run/run_file.h"
#include "station/commands/runs_command.h"
#include "station/io/data_folder.h"

namespace soak::station {
namespace {

base::Result<std::string> file_sha256(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) return base::corrupt("the run file is missing or cannot be read", path.string());
  base::Sha256 hash;
  std::vector<char> buffer(1U << 20);
  while (file) {
    file.read(buffer.data(), static_cast<std::streamsize>(buffer.size()));
    hash.update(std::string_view(buffer.data(), static_cast<std::size_t>(file.gcount())));
  }
  return base::to_hex(hash.finish());
}

/// What is wrong with a run's file; all checks are made, as far as they can be.
std::vector<std::string> problems_of(const db::Catalog& catalog, const db::RunRow& run) {
  std::vector<std::string> problems;
  const std::filesystem::path path = catalog.run_file_path(run);
  const auto sha256 = file_sha256(path);
  if (!sha256) return {sha256.error().message};
  if (run.sealed && *sha256 != run.file_sha256) {
    problems.push_back(fmt::format("the file's SHA-256 is {}, the catalog says {}", *sha256, run.file_sha256));
  }
  const auto file = db::RunFileReader::open(path);
  if (!file) {
    problems.push_back(file.error().message);
    return problems;
  }
  if (const auto status = file->verify(); !status) {
    problems.push_back(status.error().where.empty() ? status.error().message
                                                    : status.error().where + ": " + status.error().message);
  }
  return problems;
}

base::Result<std::vector<db::RunRow>> runs_to_verify(const db::Catalog& catalog, const RunsVerifyCommand& command) {
  if (command.runs.empty()) return catalog.runs({});
  std::vector<db::RunRow> runs;
  for (const std::string& name : command.runs) {
    auto run = find_run(catalog, {.unit = {}, .campaign = {}, .run = name});
    if (!run) return base::forward_error(run);
    runs.push_back(*std::move(run));
  }
  return runs;
}

base::Status verdict(const std::vector<std::string>& damaged) {
  if (damaged.empty()) return {};
  std::string message = "damaged:";
  for (const std::string& text : damaged) message += " " + text + ";";
  message.back() = '.';
  return base::corrupt(message + " Restore from a copy; 'soak runs void' keeps a run out of fits", "verify");
}

}  // namespace

base::Status run_runs_verify(const RunsVerifyCommand& command, Output& output) {
  const auto catalog = open_existing_catalog(command.data);
  if (!catalog) return base::forward_error(catalog);
  const auto runs = runs_to_verify(*catalog, command);
  if (!runs) return base::forward_error(runs);

  std::vector<std::string> damaged;
  const auto catalog_status = catalog->verify();
  if (!catalog_status) damaged.push_back("station.db (" + catalog_status.error().message + ")");
  nlohmann::json list = nlohmann::json::array();
  std::string text =
      fmt::format("station.db  {}\n", catalog_status ? "ok" : "DAMAGED: " + catalog_status.error().message);
  const auto report = output.progress("verifying");
  for (const db::RunRow& run : *runs) {
    if (!report(static_cast<double>(list.size()) / static_cast<double>(runs->size()))) {
      return base::fail(base::ErrorKind::internal, "interrupted", "verify");
    }
    const std::vector<std::string> problems = problems_of(*catalog, run);
    list.push_back({{"run_id", run.run_id},
                    {"run", run.label},
                    {"unit", run.unit},
                    {"ok", problems.empty()},
                    {"problems", problems}});
    text +=
        fmt::format("{}  unit {}, run {}: {}\n", run.run_id, run.unit, run.label, problems.empty() ? "ok" : "DAMAGED");
    for (const std::string& problem : problems) text += "    " + problem + "\n";
    if (!problems.empty()) damaged.push_back(fmt::format("run {} of unit {} ({})", run.label, run.unit, run.run_id));
  }
  output.end_progress();

  if (!output.json()) {
    output.print(text);
    return verdict(damaged);
  }
  const nlohmann::json catalog_problem =
      catalog_status ? nlohmann::json() : nlohmann::json(catalog_status.error().message);
  auto printed = output.print_json({{"ok", damaged.empty()},
                                    {"catalog", {{"ok", catalog_status.has_value()}, {"problem", catalog_problem}}},
                                    {"runs", list}});
  if (!printed) return printed;
  return verdict(damaged);
}

}  // namespace soak::station
