// SPDX-License-Identifier: Apache-2.0
#include "station/commands/import_command.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <nlohmann/json.hpp>

#include "base/units.h"
#include "calib/model/reference_json.h"
#include "station/commands/type_commands.h"
#include "station/import/source_recording.h"
#include "station/io/data_folder.h"

namespace soak::station {
namespace {

constexpr std::size_t kBadRowsListed = 20;

void note_bad_rows(const std::vector<BadRow>& rows, const std::string& file, Output& output) {
  if (rows.empty()) return;
  output.note(fmt::format("{}: {} bad rows were left out:", file, rows.size()));
  for (std::size_t i = 0; i < std::min(rows.size(), kBadRowsListed); ++i) {
    const std::string column = rows[i].column.empty() ? "" : fmt::format(", column '{}'", rows[i].column);
    output.note(fmt::format("  line {}{}: {}", rows[i].line, column, rows[i].reason));
  }
  if (rows.size() > kBadRowsListed)
    output.note(fmt::format("  and {} more (--json lists all)", rows.size() - kBadRowsListed));
}

nlohmann::json document(const ImportCommand& command, const SourceRecording& recording, const ImportSummary& summary) {
  nlohmann::json runs = nlohmann::json::array();
  for (const ImportedRun& run : summary.runs) {
    runs.push_back({{"run", run.label},
                    {"run_id", run.run_id},
                    {"status", run.was_there ? "unchanged" : "imported"},
                    {"rows", run.rows},
                    {"duration_s", run.duration_s},
                    {"segments", run.segments},
                    {"content_sha256", run.content_sha256}});
  }
  nlohmann::json bad = nlohmann::json::array();
  for (const BadRow& row : recording.bad_rows) {
    bad.push_back({{"line", row.line},
                   {"column", row.column.empty() ? nlohmann::json() : nlohmann::json(row.column)},
                   {"reason", row.reason}});
  }
  nlohmann::json warnings = recording.warnings;
  for (const std::string& warning : summary.warnings) warnings.push_back(warning);
  return {{"unit", command.import.unit},
          {"campaign", command.import.campaign},
          {"file", command.file},
          {"runs", runs},
          {"references", calib::references_json(summary.references)},
          {"bad_rows", bad},
          {"warnings", warnings}};
}

std::string summary_text(const ImportSummary& summary) {
  std::string text;
  for (const ImportedRun& run : summary.runs) {
    if (run.was_there) {
      text += fmt::format("run {}: already there as {} with the same samples, nothing to do\n", run.label, run.run_id);
    } else {
      text += fmt::format("run {}: imported as {}: {} rows, {:.1f} s, {} segments\n", run.label, run.run_id, run.rows,
                          run.duration_s, run.segments);
    }
  }
  return text;
}

base::Result<SourceRecording> read_csv(const ImportCommand& command, Output& output) {
  if (command.rate_hz) return base::bad_input("it belongs to a file of a unit's bytes (--decoder)", "--rate-hz");
  CsvOptions csv;
  csv.skip_bad = command.skip_bad;
  csv.progress = output.progress("reading");
  if (!command.columns.empty()) {
    auto map = read_columns_map(command.columns);
    if (!map) return base::forward_error(map);
    csv.map = *std::move(map);
  }
  return read_csv_recording(command.file, csv);
}

/// From the label of the unit, which its type knows.
base::Result<hal::Ahrs400Ranges> ranges_of(const ImportCommand& command) {
  if (!command.import.unit_type) {
    return base::bad_input("an AHRS400 sends shares of its ranges: --type must name a unit type that states them",
                           "--decoder");
  }
  const auto type = find_unit_type({}, *command.import.unit_type);
  if (!type) return base::forward_error(type);
  if (!type->gyro_range_dps || !type->accel_range_mps2) {
    return base::bad_input(fmt::format("unit type '{}' states no ranges, of which an AHRS400 sends shares", type->name),
                           "--type");
  }
  return hal::Ahrs400Ranges{*type->gyro_range_dps, *type->accel_range_mps2 / base::kStandardGravity_mps2};
}

hal::UnitDecoder decoder_named(std::string_view name) {
  if (name == "ahrs400") return hal::UnitDecoder::ahrs400;
  return name == "vectornav" ? hal::UnitDecoder::vectornav : hal::UnitDecoder::xsens;
}

base::Result<SourceRecording> read_stream(const ImportCommand& command, Output& output) {
  if (!command.columns.empty() || command.skip_bad) {
    return base::bad_input("--columns and --skip-bad belong to CSV files", "--decoder");
  }
  StreamOptions stream;
  stream.decoder = decoder_named(command.decoder);
  stream.rate_hz = command.rate_hz.value_or(stream.rate_hz);
  stream.progress = output.progress("reading");
  if (stream.decoder == hal::UnitDecoder::ahrs400) {
    const auto ranges = ranges_of(command);
    if (!ranges) return base::forward_error(ranges);
    stream.ranges = *ranges;
  }
  return read_stream_recording(command.file, stream);
}

}  // namespace

base::Status run_import(const ImportCommand& command, Output& output) {
  const auto recording = command.decoder.empty() ? read_csv(command, output) : read_stream(command, output);
  if (!recording) return base::forward_error(recording);

  // The data folder is not touched, not even made, before the file has proved sound.
  auto catalog = open_catalog(command.data);
  if (!catalog) return base::forward_error(catalog);
  ImportOptions options = command.import;
  options.progress = output.progress("storing");
  const auto summary = store_recording(*catalog, *recording, command.file, options);
  if (!summary) return base::forward_error(summary);
  output.end_progress();

  note_bad_rows(recording->bad_rows, command.file, output);
  for (const std::string& warning : recording->warnings) output.note("warning: " + warning);
  for (const std::string& warning : summary->warnings) output.note("warning: " + warning);
  if (output.json()) return output.print_json(document(command, *recording, *summary));
  output.print(summary_text(*summary));
  return {};
}

}  // namespace soak::station
