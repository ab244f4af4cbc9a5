// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "station/commands/command.h"
#include "station/commands/shared.h"
#include "station/io/backup.h"
#include "station/io/host.h"

namespace soak::station {
namespace {

/// soak backup DIR
struct BackupCommand final : CatalogCommand {
  std::string folder;

  void declare(OptionList& options) override {
    options.add("folder DIR", &folder, "Folder of the backup, on another disk; made where it is missing").required();
  }
  base::Status run_with(db::Catalog& catalog, Output& output) override;
};

nlohmann::json uncopied_json(const std::vector<UncopiedFile>& files) {
  nlohmann::json list = nlohmann::json::array();
  for (const UncopiedFile& file : files) list.push_back({{"file", file.file}, {"reason", file.why}});
  return list;
}

/// What the operator should know of a backup that is whole.
std::vector<std::string> backup_warnings(const BackupSummary& summary) {
  if (!summary.on_same_disk) return {};
  return {
      "the backup is on the file system of the data folder: it protects from a damaged catalog, not from a dead disk; "
      "back "
      "up to another disk as well"};
}

nlohmann::json backup_document(const std::string& folder, const BackupSummary& summary) {
  return {{"folder", folder},
          {"ok", summary.damaged.empty()},
          {"events", summary.events.events},
          {"chain_sha256", summary.events.end_sha256},
          {"copied", summary.copied},
          {"copied_bytes", summary.copied_bytes},
          {"kept", summary.kept},
          {"still_open", uncopied_json(summary.still_open)},
          {"damaged", uncopied_json(summary.damaged)},
          {"warnings", backup_warnings(summary)}};
}

std::string backup_text(const std::string& folder, const BackupSummary& summary) {
  std::string text =
      fmt::format("{}: catalog with {} events, {} run files copied ({:.1f} MB), {} were there and are whole\n", folder,
                  summary.events.events, summary.copied.size(), 1e-6 * static_cast<double>(summary.copied_bytes),
                  summary.kept.size());
  for (const UncopiedFile& file : summary.still_open) text += fmt::format("left out: {}: {}\n", file.file, file.why);
  for (const UncopiedFile& file : summary.damaged) text += fmt::format("DAMAGED: {}: {}\n", file.file, file.why);
  if (!summary.events.end_sha256.empty()) {
    text += fmt::format("end of the event log: {}  (note it elsewhere: 'soak events verify --contains')\n",
                        summary.events.end_sha256);
  }
  return text;
}

base::Status backup_verdict(const BackupSummary& summary, const std::string& folder) {
  if (summary.damaged.empty()) return {};
  std::string names;
  for (const UncopiedFile& file : summary.damaged) names += (names.empty() ? "" : ", ") + file.file;
  return base::corrupt(fmt::format("all but the damaged run files were backed up: {}", names), folder);
}

base::Status BackupCommand::run_with(db::Catalog& catalog, Output& output) {
  const auto summary = back_up(catalog, folder, output.progress("copying"));
  output.end_progress();
  if (!summary) return base::forward_error(summary);
  if (output.json()) {
    if (auto printed = output.print_json(backup_document(folder, *summary)); !printed) return printed;
  } else {
    output.print(backup_text(folder, *summary));
  }
  for (const std::string& warning : backup_warnings(*summary)) output.note("warning: " + warning);
  // Last, and no failure: a backup is made where the disk is full as well.
  if (!catalog.read_only()) {
    const std::string what = fmt::format("{} events, {} run files new, {} damaged", summary->events.events,
                                         summary->copied.size(), summary->damaged.size());
    if (auto logged = catalog.log_event({now_utc_s(), "backup_made", folder, what, user_name()}); !logged) {
      output.note("note: the backup is whole, but the event log does not name it: " + logged.error().message);
    }
  }
  return backup_verdict(*summary, folder);
}

}  // namespace

CommandGroup backup_commands() {
  return {
      "",
      "",
      {{"backup", "Copy catalog and sealed run files into a folder, checked; soakd goes on meanwhile",
        "soak backup /mnt/backup/soak", std::make_shared<BackupCommand>(), true,
        "The folder is a data folder of its own: 'soak runs verify --data DIR' checks it, a copy of it is a station "
        "restored. Again into the same folder copies what is new."}}};
}

}  // namespace soak::station
