// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "base/text.h"
#include "station/archive/archive.h"
#include "station/commands/command.h"
#include "station/io/host.h"

namespace soak::station {
namespace {

void declare_archive(OptionList& options, std::string& place) {
  options.add("archive ARCHIVE", &place, "Folder, or a remote of rclone (\"s3:soak/archive\")").required();
}

/// soak archive push ARCHIVE
struct ArchivePush final : CatalogCommand {
  std::string place;

  void declare(OptionList& options) override { declare_archive(options, place); }
  base::Status run_with(db::Catalog& catalog, Output& output) override;
};

/// soak archive pull ARCHIVE
struct ArchivePull final : CatalogCommand {
  std::string place;

  void declare(OptionList& options) override { declare_archive(options, place); }
  base::Status run_with(db::Catalog& catalog, Output& output) override;
};

/// soak archive list ARCHIVE
struct ArchiveList final : Command {
  std::string place;

  void declare(OptionList& options) override { declare_archive(options, place); }
  base::Status run(Output& output) override;
};

/// soak archive verify ARCHIVE
struct ArchiveVerify final : Command {
  std::string place;

  void declare(OptionList& options) override { declare_archive(options, place); }
  base::Status run(Output& output) override;
};

nlohmann::json troubles_json(const std::vector<ArchiveTrouble>& troubles) {
  nlohmann::json list = nlohmann::json::array();
  for (const auto& [name, error] : troubles) {
    list.push_back({{"name", name}, {"code", static_cast<int>(error.kind)}, {"reason", error.message}});
  }
  return list;
}

/// Fails as the first trouble, and names all.
base::Status archive_verdict(const std::vector<ArchiveTrouble>& troubles, std::string_view what,
                             const std::string& place) {
  if (troubles.empty()) return {};
  std::string message = fmt::format("{} {}:", troubles.size(), what);
  for (const auto& [name, error] : troubles) message += fmt::format("\n  {}: {}", name, error.message);
  return base::fail(troubles.front().error.kind, std::move(message), place);
}

/// Prints a document or a text.
base::Status show(Output& output, const nlohmann::json& document, const std::string& text) {
  if (output.json()) return output.print_json(document);
  output.print(text);
  return {};
}

double megabytes(std::uint64_t bytes) { return 1e-6 * static_cast<double>(bytes); }

base::Status ArchivePush::run_with(db::Catalog& catalog, Output& output) {
  auto store = archive_store(place);
  if (!store) return base::forward_error(store);
  const auto pushed = push_to_archive(catalog, **store, output.progress("pushing"));
  output.end_progress();
  if (!pushed) return base::forward_error(pushed);
  std::string text = fmt::format("{}: {} run files brought ({:.1f} MB), {} were there; {} records brought\n", place,
                                 pushed->files.size(), megabytes(pushed->bytes), pushed->files_there, pushed->records);
  for (const std::string& name : pushed->open) text += fmt::format("left out: {}: not sealed yet\n", name);
  for (const std::string& name : pushed->dropped) text += fmt::format("left out: {}: its samples were dropped\n", name);
  auto shown = show(output,
                    {{"archive", place},
                     {"pushed", pushed->files},
                     {"pushed_bytes", pushed->bytes},
                     {"were_there", pushed->files_there},
                     {"records", pushed->records},
                     {"open", pushed->open},
                     {"dropped", pushed->dropped},
                     {"troubles", troubles_json(pushed->troubles)}},
                    text);
  if (!shown) return shown;
  return archive_verdict(pushed->troubles, "runs are damaged here and were not pushed", place);
}

base::Status ArchivePull::run_with(db::Catalog& catalog, Output& output) {
  if (catalog.read_only()) {
    return base::fail(base::ErrorKind::internal, "this folder cannot be written, so no run could be stored",
                      catalog.data_folder().string());
  }
  const auto store = archive_store(place);
  if (!store) return base::forward_error(store);
  const auto pulled = pull_from_archive(catalog, **store, user_name(), output.progress("pulling"));
  output.end_progress();
  if (!pulled) return base::forward_error(pulled);
  for (const std::string& warning : pulled->warnings) output.note("warning: " + warning);
  auto shown = show(output,
                    {{"archive", place},
                     {"pulled", pulled->runs},
                     {"pulled_bytes", pulled->bytes},
                     {"were_there", pulled->runs_there},
                     {"voids", pulled->voids},
                     {"warnings", pulled->warnings},
                     {"troubles", troubles_json(pulled->troubles)}},
                    fmt::format("{}: {} runs are new here ({:.1f} MB), {} were there; {} void records are new\n", place,
                                pulled->runs.size(), megabytes(pulled->bytes), pulled->runs_there, pulled->voids));
  if (!shown) return shown;
  return archive_verdict(pulled->troubles, "runs or records were not pulled", place);
}

base::Status ArchiveList::run(Output& output) {
  const auto store = archive_store(place);
  if (!store) return base::forward_error(store);
  const auto listing = list_archive(**store);
  if (!listing) return base::forward_error(listing);
  nlohmann::json runs = nlohmann::json::array();
  std::vector<std::vector<std::string>> table = {{"campaign", "run", "units", "recorded", "MB", "voids"}};
  for (const ArchiveRecord& run : listing->runs) {
    nlohmann::json units = nlohmann::json::array();
    for (const db::UnitRow& unit : run.units) units.push_back(unit.serial);
    table.push_back({run.campaign, run.label,
                     run.units.size() == 1 ? run.units.front().serial : fmt::format("{} units", run.units.size()),
                     base::utc_text(run.created_utc_s), fmt::format("{:.1f}", megabytes(run.bytes)),
                     std::to_string(run.voids.size())});
    runs.push_back({{"run", run.run_id},
                    {"campaign", run.campaign},
                    {"label", run.label},
                    {"units", std::move(units)},
                    {"created_utc", base::utc_text(run.created_utc_s)},
                    {"bytes", run.bytes},
                    {"file_sha256", run.file_sha256},
                    {"voids", run.voids.size()}});
  }
  auto shown =
      show(output, {{"archive", place}, {"runs", std::move(runs)}, {"troubles", troubles_json(listing->troubles)}},
           text_table(table));
  if (!shown) return shown;
  return archive_verdict(listing->troubles, "records cannot be read", place);
}

base::Status ArchiveVerify::run(Output& output) {
  const auto store = archive_store(place);
  if (!store) return base::forward_error(store);
  const auto check = verify_archive(**store, output.progress("checking"));
  output.end_progress();
  if (!check) return base::forward_error(check);
  for (const std::string& name : check->without_record) {
    output.note("note: no record names " + name + ": a push was cut off; push again from that station");
  }
  auto shown = show(output,
                    {{"archive", place},
                     {"ok", check->troubles.empty()},
                     {"records", check->records},
                     {"files", check->files},
                     {"without_record", check->without_record},
                     {"troubles", troubles_json(check->troubles)}},
                    fmt::format("{}: {} records and {} run files read\n", place, check->records, check->files));
  if (!shown) return shown;
  return archive_verdict(check->troubles, "records or run files are damaged or missing", place);
}

}  // namespace

CommandGroup archive_commands() {
  return {
      "archive",
      "Sealed runs of several stations in one place, known by their hashes",
      {{"push", "Bring sealed run files and the catalog's entries of them into an archive",
        "soak archive push /mnt/archive", std::make_shared<ArchivePush>(), true,
        "What is there already is not brought again: a push that was cut off goes on. Models and references stay "
        "here."},
       {"pull", "Bring all runs of an archive that this station does not have into its catalog",
        "soak archive pull s3:soak/archive", std::make_shared<ArchivePull>(), true,
        "Files and entries are checked by their hashes. Runs that this catalog has already only get new void records."},
       {"list", "List the runs of an archive", "soak archive list /mnt/archive", std::make_shared<ArchiveList>()},
       {"verify", "Read all of an archive and compare it with its hashes", "soak archive verify /mnt/archive",
        std::make_shared<ArchiveVerify>()}}};
}

}  // namespace soak::station
