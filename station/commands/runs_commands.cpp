// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <optional>

#include "base/hash.h"
#include "db/run/run_file.h"
#include "station/commands/command.h"
#include "station/commands/shared.h"
#include "station/io/data_folder.h"
#include "station/io/host.h"
#include "station/io/text.h"
#include "station/io/text_file.h"
#include "station/runs/csv_export.h"
#include "station/runs/voiding.h"

namespace soak::station {
namespace {

namespace fs = std::filesystem;

/// soak runs export RUN [--native] [-o FILE]
struct RunsExport final : CatalogCommand {
  db::RunFilter filter;
  bool native = false;
  std::string file;  ///< empty = standard output

  void declare(OptionList& options) override {
    declare_run(options, filter);
    options.add("--native", &native,
                "Keep the headers and numbers of the source; also writes a columns map next to the CSV if importing it "
                "needs one");
    options.add("-o,--output FILE", &file, "File to write (default: standard output)");
  }
  base::Status run_with(db::Catalog& catalog, Output& output) override;
};

/// soak runs void RUN [--visit N [--position P [--attempt K]]] --reason TEXT
struct RunsVoid final : CatalogCommand {
  db::RunFilter filter;
  std::optional<std::int32_t> visit;
  std::optional<std::string> position;
  std::optional<std::int32_t> attempt;
  std::string reason;
  std::string user;  ///< empty = the user that runs the program

  void declare(OptionList& options) override {
    declare_run(options, filter);
    options.add("--visit N", &visit, "Only this visit (number of the plateau in the run, from 0)");
    options.add("--position P", &position, "Only this position of the visit");
    options.add("--attempt K", &attempt, "Only this attempt at the position");
    options.add("--reason TEXT", &reason, "Reason, for the record").required();
    options.add("--user NAME", name_reader(user), "Name for the record (default: the user that runs the program)");
  }
  base::Status run_with(db::Catalog& catalog, Output& output) override;
};

/// soak runs verify [RUN...]
struct RunsVerify final : CatalogCommand {
  std::vector<std::string> names;  ///< empty = all

  void declare(OptionList& options) override { options.add("run RUN", &names, "Runs to check (default: all)"); }
  base::Status run_with(db::Catalog& catalog, Output& output) override;
};

fs::path map_path_beside(const fs::path& csv) { return csv.parent_path() / (csv.stem().string() + ".columns.toml"); }

base::Status write_native(const NativeCsv& made, const fs::path& csv, Output& output) {
  if (csv.empty()) {
    if (made.columns_map) {
      return base::bad_input("this run needs a columns map next to the CSV for an identical import: give -o FILE",
                             "-o");
    }
    output.print(made.csv);
    return {};
  }
  if (made.columns_map) {
    const fs::path map = map_path_beside(csv);
    if (auto status = write_text_file(map, *made.columns_map); !status) return status;
    output.note(
        fmt::format("the CSV alone does not state all types and meanings: import it with --columns {}", map.string()));
  }
  return write_text_file(csv, made.csv);
}

base::Status RunsExport::run_with(db::Catalog& catalog, Output& output) {
  const auto row = find_run(catalog, filter);
  if (!row) return base::forward_error(row);
  const auto reader = catalog.open_run_file(*row);
  if (!reader) return base::forward_error(reader);
  if (native) {
    const auto made = native_csv(*reader, row->unit);
    if (!made) return base::forward_error(made);
    return write_native(*made, file, output);
  }
  const auto csv = canonical_csv(*reader, row->unit);
  if (!csv) return base::forward_error(csv);
  if (!file.empty()) return write_text_file(file, *csv);
  output.print(*csv);
  return {};
}

base::Status check_void(const RunsVoid& command) {
  if (auto plain = check_text_line(command.reason, "--reason"); !plain) return plain;
  if (command.position && !command.visit) return base::bad_input("requires --visit", "--position");
  if (command.attempt && !command.position) return base::bad_input("requires --position", "--attempt");
  return {};
}

base::Status RunsVoid::run_with(db::Catalog& catalog, Output& output) {
  if (auto status = check_void(*this); !status) return status;
  const auto row = find_run(catalog, filter);
  if (!row) return base::forward_error(row);
  const auto made = void_part(catalog, *row,
                              {row->run_id, row->unit, visit, position, attempt, reason, user_name(user), now_utc_s()});
  if (!made) return base::forward_error(made);
  if (output.json()) return output.print_json(voided_part_json(*made));
  output.print(
      fmt::format("run {} ({}): {} of {} segments voided\n", row->label, row->run_id, made->withdrawn, made->counted));
  return {};
}

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

/// All problems of a run's file.
std::vector<std::string> problems_of(const db::Catalog& catalog, const db::RunRow& run) {
  std::vector<std::string> problems;
  if (const auto sound = catalog.check_numbers(run); !sound) problems.push_back(sound.error().message);
  if (run.samples_dropped) return problems;
  const std::filesystem::path path = catalog.run_file_path(run);
  const auto sha256 = file_sha256(path);
  if (!sha256) {
    problems.push_back(sha256.error().message);
    return problems;
  }
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

base::Result<std::vector<db::RunRow>> runs_to_verify(const db::Catalog& catalog, const RunsVerify& command) {
  if (command.names.empty()) return catalog.runs({});
  std::vector<db::RunRow> runs;
  for (const std::string& name : command.names) {
    auto run = find_run(catalog, {.unit = {}, .campaign = {}, .run = name});
    if (!run) return base::forward_error(run);
    runs.push_back(*std::move(run));
  }
  return runs;
}

std::string verdict_text(const db::RunRow& run, bool is_sound) {
  if (!is_sound) return "DAMAGED";
  return run.samples_dropped ? "ok, samples dropped" : "ok";
}

base::Status damage_error(const std::vector<std::string>& damaged) {
  if (damaged.empty()) return {};
  std::string message = "damaged:";
  for (const std::string& text : damaged) message += " " + text + ";";
  message.back() = '.';
  return base::corrupt(message + " Restore them from a backup; 'soak runs void' excludes a run from fits", "verify");
}

base::Status RunsVerify::run_with(db::Catalog& catalog, Output& output) {
  const auto runs = runs_to_verify(catalog, *this);
  if (!runs) return base::forward_error(runs);

  std::vector<std::string> damaged;
  const auto catalog_status = catalog.verify();
  if (!catalog_status) damaged.push_back("station.db (" + catalog_status.error().message + ")");
  nlohmann::json list = nlohmann::json::array();
  std::string text =
      fmt::format("station.db  {}\n", catalog_status ? "ok" : "DAMAGED: " + catalog_status.error().message);
  const auto report = output.progress("verifying");
  for (const db::RunRow& row : *runs) {
    if (!report(static_cast<double>(list.size()) / static_cast<double>(runs->size()))) {
      return base::fail(base::ErrorKind::internal, "interrupted", "verify");
    }
    const std::vector<std::string> problems = problems_of(catalog, row);
    list.push_back({{"run_id", row.run_id},
                    {"run", row.label},
                    {"unit", row.unit},
                    {"ok", problems.empty()},
                    {"samples_dropped", row.samples_dropped.has_value()},
                    {"problems", problems}});
    text +=
        fmt::format("{}  unit {}, run {}: {}\n", row.run_id, row.unit, row.label, verdict_text(row, problems.empty()));
    for (const std::string& problem : problems) text += "    " + problem + "\n";
    if (!problems.empty()) damaged.push_back(fmt::format("run {} of unit {} ({})", row.label, row.unit, row.run_id));
  }
  output.end_progress();

  if (!output.json()) {
    output.print(text);
    return damage_error(damaged);
  }
  const nlohmann::json catalog_problem =
      catalog_status ? nlohmann::json() : nlohmann::json(catalog_status.error().message);
  auto printed = output.print_json({{"ok", damaged.empty()},
                                    {"catalog", {{"ok", catalog_status.has_value()}, {"problem", catalog_problem}}},
                                    {"runs", list}});
  if (!printed) return printed;
  return damage_error(damaged);
}

}  // namespace

CommandGroup run_commands() {
  return {"runs",
          "Runs: list, show, export, void, verify, drop samples",
          {{"export", "Write the samples of a run as CSV", "soak runs export soak_run_1 --native -o soak_run_1.csv",
            std::make_shared<RunsExport>(), false},
           {"void", "Exclude a run, a visit or a segment from all results; nothing is deleted",
            "soak runs void soak_run_1 --visit 3 --position +X --reason 'door was open'", std::make_shared<RunsVoid>()},
           {"verify", "Check the catalog and the run files against their hashes", "soak runs verify",
            std::make_shared<RunsVerify>()}}};
}

}  // namespace soak::station
