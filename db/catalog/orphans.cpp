// SPDX-License-Identifier: Apache-2.0
#include "db/catalog/orphans.h"

#include <algorithm>
#include <set>
#include <system_error>
#include <utility>

namespace soak::db {
namespace {

/// Names of all run files in a folder.
base::Result<std::set<std::string>> run_files_in(const std::filesystem::path& folder) {
  std::set<std::string> names;
  std::error_code error;
  for (std::filesystem::directory_iterator entry(folder, error); !error && entry != std::filesystem::end(entry);
       entry.increment(error)) {
    if (entry->path().extension() == ".soakrun") names.insert(entry->path().filename().string());
  }
  if (!error) return names;
  return base::fail(base::ErrorKind::internal, "cannot list the run files: " + error.message(), folder.string());
}

OrphanRunFile describe(std::filesystem::path path) {
  OrphanRunFile orphan;
  orphan.path = std::move(path);
  const auto file = RunFileReader::open(orphan.path);
  if (!file) {
    orphan.problem = file.error().message;
    return orphan;
  }
  orphan.sealed = file->sealed();
  orphan.info = file->info();
  for (const StreamInfo& stream : file->streams()) {
    const bool known = std::find(orphan.units.begin(), orphan.units.end(), stream.unit) != orphan.units.end();
    if (!stream.unit.empty() && !known) orphan.units.push_back(stream.unit);
  }
  return orphan;
}

}  // namespace

base::Result<std::vector<OrphanRunFile>> orphan_run_files(const Catalog& catalog) {
  const std::filesystem::path folder = catalog.data_folder() / "runs";
  // Files first: one that is entered meanwhile then is in the catalog's answer.
  auto names = run_files_in(folder);
  if (!names) return base::forward_error(names);
  const auto runs = catalog.runs({});
  if (!runs) return base::forward_error(runs);
  for (const RunRow& run : *runs) names->erase(run.file_name);
  std::vector<OrphanRunFile> orphans;
  for (const std::string& name : *names) orphans.push_back(describe(folder / name));
  return orphans;
}

}  // namespace soak::db
