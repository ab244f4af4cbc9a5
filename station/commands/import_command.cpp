// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cstddef>

#include "base/units.h"
#include "calib/model/document_parts.h"
#include "station/commands/command.h"
#include "station/commands/shared.h"
#include "station/import/columns_map.h"
#include "station/import/import.h"
#include "station/io/data_folder.h"
#include "station/io/host.h"

namespace soak::station {
namespace {

constexpr std::size_t kBadRowsListed = 20;

/// soak import FILE --unit SN
class ImportCommand final : public Command {
 public:
  void declare(OptionList& options) override;
  base::Status run(Output& output) override;

 private:
  base::Result<SourceRecording> read_csv(Output& output) const;
  base::Result<SourceRecording> read_stream(Output& output) const;
  base::Result<hal::Ahrs400Ranges> ahrs400_ranges() const;
  nlohmann::json document(const SourceRecording& recording, const ImportSummary& summary) const;

  std::string file_;
  std::string columns_;  ///< path of a columns map; empty = our own headers
  bool skip_bad_ = false;
  std::string decoder_;  ///< of a file of the unit's own bytes; empty = it is CSV
  std::optional<double> rate_hz_;
  ImportOptions import_;
};

void ImportCommand::declare(OptionList& options) {
  options.add("file FILE", &file_, "CSV file (docs/csv-format.md), or with --decoder a log of the bytes a unit sent")
      .required();
  options.add("--unit SN", &import_.unit, "Serial number of the unit").required();
  options.add("--campaign NAME", &import_.campaign, "Campaign that the runs belong to").with_default();
  options
      .add("--procedure NAME", &import_.procedure,
           "Procedure of a new campaign; runs of 'verification' are never used by fits")
      .with_default();
  options.add("--type NAME", &import_.unit_type, "Type of a new unit (default: generic)");
  calib::Site& site = import_.site;
  options.add("--latitude-deg DEG", &site.latitude_deg, "Latitude of the station, south negative").range(-90, 90);
  options.add("--height-m M", &site.height_m, "Height above sea level").range(-500, 9000);
  options.add("--azimuth-deg DEG", &site.azimuth_deg, "Heading of the fixture, clockwise from north").range(-360, 360);
  options.add("--gravity-mps2 M/S2", &site.gravity_mps2, "Local gravity (default: from latitude and height)")
      .range(9.7, 9.9);
  options.add("--columns FILE.toml", &columns_, "Columns map for other headers, units and separators");
  options.add("--decoder NAME", &decoder_, "The file holds the bytes that a unit sent, in this protocol")
      .one_of({"xsens", "ahrs400", "vectornav"});
  options.add("--rate-hz HZ", &rate_hz_, "With --decoder: packets per second that the unit was set to (default: 100)")
      .range(1, 10000);
  options.add("--skip-bad", &skip_bad_, "Skip bad rows and list them");
  options.add("--simulated", &import_.simulated, "Mark the runs as simulated");
  options.add("--references", &import_.references,
              "Recorded with this station's references (docs/records.md): fails if a certificate has expired");
}

base::Result<SourceRecording> ImportCommand::read_csv(Output& output) const {
  if (rate_hz_) return base::bad_input("only valid together with --decoder", "--rate-hz");
  CsvOptions csv;
  csv.skip_bad = skip_bad_;
  csv.progress = output.progress("reading");
  if (!columns_.empty()) {
    auto map = read_columns_map(columns_);
    if (!map) return base::forward_error(map);
    csv.map = *std::move(map);
  }
  return read_csv_recording(file_, csv);
}

/// An AHRS400 sends fractions of its ranges; the unit's type states them.
base::Result<hal::Ahrs400Ranges> ImportCommand::ahrs400_ranges() const {
  if (!import_.unit_type) {
    return base::bad_input("ahrs400 needs --type with a unit type that states the measuring ranges", "--decoder");
  }
  const auto type = find_unit_type({}, *import_.unit_type);
  if (!type) return base::forward_error(type);
  if (type->gyro_range_dps && type->accel_range_mps2) {
    return hal::Ahrs400Ranges{*type->gyro_range_dps, *type->accel_range_mps2 / base::kStandardGravity_mps2};
  }
  return base::bad_input(
      fmt::format("unit type '{}' states no measuring ranges, which the decoder ahrs400 needs", type->name), "--type");
}

base::Result<SourceRecording> ImportCommand::read_stream(Output& output) const {
  if (!columns_.empty() || skip_bad_) {
    return base::bad_input("cannot be combined with --columns or --skip-bad, which are for CSV files", "--decoder");
  }
  StreamOptions stream;
  stream.rate_hz = rate_hz_.value_or(stream.rate_hz);
  stream.progress = output.progress("reading");
  if (decoder_ == "vectornav") stream.decoder = hal::UnitDecoder::vectornav;
  if (decoder_ == "ahrs400") {
    stream.decoder = hal::UnitDecoder::ahrs400;
    const auto ranges = ahrs400_ranges();
    if (!ranges) return base::forward_error(ranges);
    stream.ranges = *ranges;
  }
  return read_stream_recording(file_, stream);
}

nlohmann::json ImportCommand::document(const SourceRecording& recording, const ImportSummary& summary) const {
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
  nlohmann::json copies = nlohmann::json::array();
  for (const CopiedRun& copy : summary.copies) {
    copies.push_back(
        {{"run", copy.label}, {"of", {{"unit", copy.of_unit}, {"campaign", copy.of_campaign}, {"run", copy.of_run}}}});
  }
  nlohmann::json warnings = recording.warnings;
  for (const std::string& warning : summary.warnings) warnings.push_back(warning);
  return {{"unit", import_.unit}, {"campaign", import_.campaign},
          {"file", file_},        {"runs", runs},
          {"copies", copies},     {"references", calib::references_json(summary.references)},
          {"bad_rows", bad},      {"warnings", warnings}};
}

void note_bad_rows(const std::vector<BadRow>& rows, const std::string& file, Output& output) {
  if (rows.empty()) return;
  output.note(fmt::format("{}: {} bad rows were skipped:", file, rows.size()));
  for (std::size_t i = 0; i < std::min(rows.size(), kBadRowsListed); ++i) {
    const std::string column = rows[i].column.empty() ? "" : fmt::format(", column '{}'", rows[i].column);
    output.note(fmt::format("  line {}{}: {}", rows[i].line, column, rows[i].reason));
  }
  if (rows.size() > kBadRowsListed) {
    output.note(fmt::format("  and {} more (--json lists all)", rows.size() - kBadRowsListed));
  }
}

std::string import_text(const ImportSummary& summary) {
  std::string text;
  for (const ImportedRun& run : summary.runs) {
    if (run.was_there) {
      text += fmt::format("run {}: unchanged, already stored as {} with the same samples\n", run.label, run.run_id);
    } else {
      text += fmt::format("run {}: imported as {}: {} rows, {:.1f} s, {} segments\n", run.label, run.run_id, run.rows,
                          run.duration_s, run.segments);
    }
  }
  return text;
}

base::Status ImportCommand::run(Output& output) {
  const auto recording = decoder_.empty() ? read_csv(output) : read_stream(output);
  if (!recording) return base::forward_error(recording);

  // The data folder is not touched, not even created, before the file has proved sound.
  auto catalog = open_catalog(data);
  if (!catalog) return base::forward_error(catalog);
  catalog->act_as(user_name());
  import_.progress = output.progress("storing");
  const auto summary = store_recording(*catalog, *recording, file_, import_);
  if (!summary) return base::forward_error(summary);
  output.end_progress();

  note_bad_rows(recording->bad_rows, file_, output);
  for (const std::string& warning : recording->warnings) output.note("warning: " + warning);
  for (const std::string& warning : summary->warnings) output.note("warning: " + warning);
  if (output.json()) return output.print_json(document(*recording, *summary));
  output.print(import_text(*summary));
  return {};
}

}  // namespace

CommandGroup import_commands() {
  return {"",
          "",
          {{"import", "Store the recording of a unit from a file: CSV, or the bytes that it sent",
            "soak import soak_run_1.csv --unit SN0042 --campaign acceptance --latitude-deg 48.1",
            std::make_shared<ImportCommand>()}}};
}

}  // namespace soak::station
