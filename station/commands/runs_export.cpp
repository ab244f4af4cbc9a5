// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <filesystem>

#include "db/run/run_file.h"
#include "station/commands/runs_command.h"
#include "station/io/data_folder.h"
#include "station/io/text_file.h"
#include "station/runs/csv_export.h"

namespace soak::station {
namespace {

namespace fs = std::filesystem;

fs::path map_path_beside(const fs::path& csv) { return csv.parent_path() / (csv.stem().string() + ".columns.toml"); }

base::Status write_native(const NativeCsv& native, const fs::path& csv, Output& output) {
  if (csv.empty()) {
    if (native.columns_map) {
      return base::bad_input(
          "this run needs a columns map beside the CSV to be imported again bit by bit: give -o FILE", "-o");
    }
    output.print(native.csv);
    return {};
  }
  if (native.columns_map) {
    const fs::path map = map_path_beside(csv);
    if (auto status = write_text_file(map, *native.columns_map); !status) return status;
    output.note(
        fmt::format("the CSV alone does not say all types and meanings: import it with --columns {}", map.string()));
  }
  return write_text_file(csv, native.csv);
}

}  // namespace

base::Status run_runs_export(const RunsExportCommand& command, Output& output) {
  const auto catalog = open_existing_catalog(command.data);
  if (!catalog) return base::forward_error(catalog);
  const auto run = find_run(*catalog, command.filter);
  if (!run) return base::forward_error(run);
  const auto file = db::RunFileReader::open(catalog->run_file_path(*run));
  if (!file) return base::forward_error(file);
  if (command.native) {
    const auto native = native_csv(*file, run->unit);
    if (!native) return base::forward_error(native);
    return write_native(*native, command.file, output);
  }
  const auto csv = canonical_csv(*file, run->unit);
  if (!csv) return base::forward_error(csv);
  if (!command.file.empty()) return write_text_file(command.file, *csv);
  output.print(*csv);
  return {};
}

}  // namespace soak::station
