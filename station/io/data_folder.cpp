// SPDX-License-Identifier: Apache-2.0
#include "station/io/data_folder.h"

#include <fmt/format.h>

#include <cstdlib>
#include <string>
#include <system_error>

namespace soak::station {
namespace {

std::string environment(const char* name) {
  const char* value = std::getenv(name);
  return value != nullptr ? value : "";
}

}  // namespace

base::Result<std::filesystem::path> data_folder(std::string_view option) {
  if (!option.empty()) return std::filesystem::path(option);
  if (std::string folder = environment("SOAK_DATA"); !folder.empty()) return folder;
  if (const std::string folder = environment("XDG_DATA_HOME"); !folder.empty()) {
    return std::filesystem::path(folder) / "soak";
  }
  if (const std::string home = environment("HOME"); !home.empty()) {
    return std::filesystem::path(home) / ".local" / "share" / "soak";
  }
  return base::bad_input("no data folder is known: give --data DIR or set SOAK_DATA", "--data");
}

base::Result<db::Catalog> open_catalog(std::string_view data_option) {
  const auto folder = data_folder(data_option);
  if (!folder) return base::forward_error(folder);
  return db::Catalog::open(*folder);
}

base::Result<db::Catalog> open_existing_catalog(std::string_view data_option) {
  const auto folder = data_folder(data_option);
  if (!folder) return base::forward_error(folder);
  std::error_code ignored;
  if (!std::filesystem::exists(*folder / "station.db", ignored)) {
    return base::bad_input(
        "the data folder holds no station.db: import a recording first, or give the right folder with "
        "--data or SOAK_DATA",
        folder->string());
  }
  return db::Catalog::open(*folder);
}

base::Result<db::RunRow> find_run(const db::Catalog& catalog, const db::RunFilter& filter) {
  auto runs = catalog.runs(filter);
  if (!runs) return base::forward_error(runs);
  if (runs->size() == 1) return std::move(runs->front());
  const std::string name = filter.run.value_or("");
  if (runs->empty()) {
    return base::bad_input(fmt::format("there is no run '{}': 'soak runs list' shows run ids and labels", name),
                           catalog.data_folder().string());
  }
  std::string candidates;
  for (const db::RunRow& run : *runs) {
    candidates += fmt::format("\n  {}  unit {}, campaign {}, run {}", run.run_id, run.unit, run.campaign, run.label);
  }
  return base::bad_input(
      fmt::format("'{}' names {} runs: give the run id, or --unit and --campaign{}", name, runs->size(), candidates),
      catalog.data_folder().string());
}

}  // namespace soak::station
