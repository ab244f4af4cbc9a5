// SPDX-License-Identifier: Apache-2.0
#include "station/import/import.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <system_error>
#include <utility>

#include "calib/estimate/unit_input.h"
#include "db/durable.h"
#include "db/run/run_file.h"
#include "station/config/unit_type_file.h"
#include "station/fit/reference_rule.h"
#include "station/io/host.h"
#include "station/io/text.h"
#include "station/runs/run_records.h"
#include "station/runs/run_streams.h"

namespace soak::station {
namespace {

namespace fs = std::filesystem;

/// Runs of the procedure of that name are for verification.
std::string purpose_of(const std::string& procedure) { return procedure == "verification" ? procedure : "calibration"; }

/// Files that are removed again unless the import succeeds.
class NewFiles {
 public:
  NewFiles() = default;
  NewFiles(const NewFiles&) = delete;
  NewFiles& operator=(const NewFiles&) = delete;
  ~NewFiles() {
    for (const fs::path& path : paths_) remove(path);
  }

  void add(fs::path path) { paths_.push_back(std::move(path)); }
  void discard(const fs::path& path) {
    remove(path);
    forget(path);
  }
  void forget(const fs::path& path) { std::erase(paths_, path); }

 private:
  static void remove(const fs::path& path) {
    std::error_code ignored;
    for (const char* suffix : {"", "-wal", "-shm", "-journal"}) fs::remove(path.string() + suffix, ignored);
  }

  std::vector<fs::path> paths_;
};

/// When a run was made: what its channel utc_s says, else now.
MeasurementTime measurement_time(const SourceRun& run) {
  MeasurementTime time{std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
  if (const auto channel = find_channel(run.channels, "utc_s")) {
    for (const double utc_s :
         db::values_of(run.columns[*channel], run.channels[*channel].scale, run.channels[*channel].offset)) {
      if (!std::isfinite(utc_s)) continue;
      time.begin_utc_s = std::min(time.begin_utc_s, utc_s);
      time.end_utc_s = std::max(time.end_utc_s, utc_s);
    }
  }
  if (std::isfinite(time.begin_utc_s)) return time;
  const double now_s = now_utc_s();
  return {now_s, now_s};
}

/// A run that is written and sealed under a temporary name but not yet recorded.
struct StagedRun {
  db::RunRow row;
  std::vector<calib::Segment> segments;
  fs::path temporary;
};

bool same_circumstances(const db::RunRow& stored, const ImportOptions& options) {
  return stored.site == options.site && stored.simulated == options.simulated;
}

class Importer {
 public:
  Importer(db::Catalog& catalog, const SourceRecording& recording, const fs::path& source, const ImportOptions& options)
      : catalog_(catalog), recording_(recording), source_(source), options_(options) {}

  base::Result<ImportSummary> run() {
    if (auto status = look_up_unit(); !status) return base::forward_error(status);
    if (auto status = look_up_references(); !status) return base::forward_error(status);
    if (auto status = look_up_runs(); !status) return base::forward_error(status);
    for (const SourceRun& run : recording_.runs) {
      if (!report_progress()) return interrupted();
      if (auto status = stage(run); !status) return base::forward_error(status);
    }
    if (!report_progress()) return interrupted();
    if (auto status = record(); !status) return base::forward_error(status);
    return std::move(summary_);
  }

 private:
  [[nodiscard]] bool report_progress() const {
    const auto done = static_cast<double>(summary_.runs.size());
    return !options_.progress || options_.progress(done / static_cast<double>(recording_.runs.size()));
  }

  [[nodiscard]] base::Result<ImportSummary> interrupted() const {
    return base::fail(base::ErrorKind::internal, "interrupted: nothing was imported", source_.string());
  }

  base::Status look_up_unit() {
    const auto unit = catalog_.unit(options_.unit);
    if (!unit) return base::forward_error(unit);
    if (!*unit) return take_type(stated_unit_type(options_.unit_type.value_or("generic")));
    epoch_ = (*unit)->epoch;
    if (options_.unit_type && *options_.unit_type != (*unit)->type) {
      return base::bad_input(fmt::format("unit '{}' is of type '{}', not '{}': omit --type, or correct it",
                                         options_.unit, (*unit)->type, *options_.unit_type),
                             "--type");
    }
    for (calib::Warning& warning : unit_type_warnings((*unit)->type)) add_note(std::move(warning.text));
    return take_type(known_unit_type((*unit)->type));
  }

  base::Status look_up_runs() {
    auto runs = catalog_.runs({});
    if (!runs) return base::forward_error(runs);
    stored_ = *std::move(runs);
    return {};
  }

  /// Each run is judged by the certificates of its own time.
  base::Status look_up_references() {
    if (!options_.references) return {};
    for (const SourceRun& run : recording_.runs) {
      auto judged = judge_references(catalog_, measurement_time(run));
      if (!judged) {
        judged.error().message = fmt::format("run '{}': {}", run.label, judged.error().message);
        return base::forward_error(judged);
      }
      for (calib::ReferenceUse& use : judged->uses) add_reference(std::move(use));
      for (std::string& note : judged->notes) add_note(std::move(note));
    }
    return {};
  }

  /// Each entry once; with a waiver where a run needs one.
  void add_reference(calib::ReferenceUse use) {
    const auto same = std::ranges::find_if(summary_.references, [&](const calib::ReferenceUse& other) {
      return other.reference.record_id == use.reference.record_id;
    });
    if (same == summary_.references.end()) {
      summary_.references.push_back(std::move(use));
    } else if (use.waiver) {
      same->waiver = std::move(use.waiver);
    }
  }

  /// Each warning once: most runs have the same.
  void add_note(std::string note) {
    if (std::ranges::find(summary_.warnings, note) == summary_.warnings.end()) {
      summary_.warnings.push_back(std::move(note));
    }
  }

  base::Status take_type(base::Result<calib::UnitType> type) {
    if (!type) return base::forward_error(type);
    type_ = *std::move(type);
    return {};
  }

  base::Status stage(const SourceRun& run) {
    StagedRun staged;
    staged.row.run_id = new_run_id();
    staged.row.file_name = staged.row.run_id + ".soakrun";
    staged.temporary = catalog_.run_file_path(staged.row).string() + ".tmp";
    files_.add(staged.temporary);
    if (auto status = write(run, staged); !status) return status;
    if (auto status = describe(run, staged); !status) return status;
    return decide(std::move(staged));
  }

  base::Status write(const SourceRun& run, StagedRun& staged) const {
    db::RunInfo info;
    info.run_id = staged.row.run_id;
    info.label = run.label;
    info.campaign = options_.campaign;
    info.procedure = options_.procedure;
    info.purpose = purpose_of(options_.procedure);
    info.created_utc_s = now_utc_s();
    info.simulated = options_.simulated;
    info.source = "import " + source_.filename().string();
    info.site = options_.site;
    auto file = db::RunFileWriter::create(staged.temporary, info);
    if (!file) return base::forward_error(file);
    const auto stream = file->add_stream({std::string(kImuStream), options_.unit, run.channels});
    if (!stream) return base::forward_error(stream);
    if (auto status = file->append(*stream, run.columns); !status) return status;
    if (auto status = write_positions(*file, options_.unit, run.positions, run.channels, run.columns); !status) {
      return status;
    }
    auto sha256 = file->seal();
    if (!sha256) return base::forward_error(sha256);
    staged.row.file_sha256 = *std::move(sha256);
    return {};
  }

  base::Status describe(const SourceRun& run, StagedRun& staged) {
    const auto file = db::RunFileReader::open(staged.temporary);
    if (!file) return base::forward_error(file);
    auto content = file->content_hash();
    if (!content) return base::forward_error(content);
    auto record = describe_run(*file, options_.unit, type_);
    if (!record) return base::forward_error(record);
    for (const std::string& warning : record->warnings) {
      summary_.warnings.push_back(fmt::format("run '{}': {}", run.label, warning));
    }
    record->row.epoch = epoch_;
    record->row.file_name = staged.row.file_name;
    record->row.file_sha256 = std::move(staged.row.file_sha256);
    record->row.content_sha256 = *std::move(content);
    staged.row = std::move(record->row);
    staged.segments = std::move(record->segments);
    return {};
  }

  /// A staged run is new, is already stored, or conflicts with a stored one.
  base::Status decide(StagedRun staged) {
    const auto same_label = std::find_if(stored_.begin(), stored_.end(), [&](const db::RunRow& run) {
      return run.unit == options_.unit && run.campaign == options_.campaign && run.label == staged.row.label;
    });
    if (same_label == stored_.end()) {
      if (auto status = warn_of_copies(staged); !status) return status;
      summary_.runs.push_back(outcome(staged.row, staged.segments.size(), false));
      staged_.push_back(std::move(staged));
      return {};
    }
    if (same_label->content_sha256 != staged.row.content_sha256) {
      return conflict(*same_label, fmt::format("has other samples (content {:.12}; in the file {:.12})",
                                               same_label->content_sha256, staged.row.content_sha256));
    }
    if (!same_circumstances(*same_label, options_)) {
      return conflict(*same_label, "has the same samples, but another site or another --simulated");
    }
    if (same_label->voided) {
      summary_.warnings.push_back(fmt::format("run '{}' is already stored, but voided", staged.row.label));
    }
    if (same_label->samples_dropped) {
      summary_.warnings.push_back(
          fmt::format("run '{}' is already stored; its samples were dropped, and stay so: import into another campaign "
                      "to have them again",
                      staged.row.label));
    }
    files_.discard(staged.temporary);
    summary_.runs.push_back(outcome(*same_label, staged.segments.size(), true));
    return {};
  }

  [[nodiscard]] base::Status conflict(const db::RunRow& stored, std::string_view why) const {
    return base::bad_input(
        fmt::format("run '{0}' of {1}: run '{0}' ({2}) of unit '{3}' in campaign '{4}' {5}. Import into another "
                    "campaign (--campaign NAME), or give the run another label; if the stored run is wrong, exclude it "
                    "with 'soak runs void {2} --reason TEXT'. Nothing was imported",
                    stored.label, source_.filename().string(), stored.run_id, stored.unit, stored.campaign, why),
        source_.string());
  }

  /// Whether a stored run that counts is the same recording. The content hash knows serial numbers, types and columns;
  /// where it differs the numbers of the segments tell.
  [[nodiscard]] base::Result<bool> is_same_recording(const StagedRun& staged, const db::RunRow& other) const {
    if (other.voided) return false;
    if (other.unit == staged.row.unit && other.content_sha256 == staged.row.content_sha256) return true;
    if (other.rows != staged.row.rows || other.duration_s != staged.row.duration_s) return false;
    const auto segments = catalog_.segments(other.run_id, other.unit, false);
    if (!segments) return base::forward_error(segments);
    return calib::same_samples(staged.segments, *segments);
  }

  /// Names one copy of the unit itself, and one of another unit.
  base::Status warn_of_copies(const StagedRun& staged) {
    bool own = false;
    bool foreign = false;
    for (const db::RunRow& other : stored_) {
      bool& told = other.unit == staged.row.unit ? own : foreign;
      if (told) continue;
      const auto same = is_same_recording(staged, other);
      if (!same) return base::forward_error(same);
      if (!*same) continue;
      told = true;
      add_copy(staged.row, other);
    }
    for (const StagedRun& other : staged_) {
      if (other.row.content_sha256 != staged.row.content_sha256 || own) continue;
      own = true;
      add_copy(staged.row, other.row);
    }
    return {};
  }

  void add_copy(const db::RunRow& row, const db::RunRow& other) {
    summary_.warnings.push_back(copy_text(row, other));
    summary_.copies.push_back({row.label, other.unit, other.campaign, other.label});
  }

  static std::string copy_text(const db::RunRow& row, const db::RunRow& other) {
    if (other.unit == row.unit) {
      return fmt::format("run '{}' has the same samples as run '{}' of campaign '{}': a fit uses them once", row.label,
                         other.label, other.campaign);
    }
    return fmt::format(
        "run '{}' has the same samples as run '{}' of unit {} in campaign '{}': one of the two serial numbers is "
        "wrong; void the runs that are not of that unit ('soak runs void {} --unit {}')",
        row.label, other.label, other.unit, other.campaign, other.run_id, other.unit);
  }

  static ImportedRun outcome(const db::RunRow& row, std::size_t segments, bool was_there) {
    return {row.label, row.run_id, was_there, row.rows, row.duration_s, segments, row.content_sha256};
  }

  /// Gives the files their names and, once those are on the disk, enters them into the catalog.
  base::Status record() {
    if (staged_.empty()) return catalog_.add_campaign_references(options_.campaign, summary_.references);
    for (const StagedRun& staged : staged_) {
      const fs::path path = catalog_.run_file_path(staged.row);
      files_.add(path);
      if (auto named = db::rename_durably(staged.temporary, path); !named) return named;
      files_.forget(staged.temporary);
    }
    auto recorded = catalog_.all_or_nothing([&]() -> base::Status {
      const auto unit = catalog_.ensure_unit(options_.unit, options_.unit_type.value_or("generic"));
      if (!unit) return base::forward_error(unit);
      if (auto status = catalog_.ensure_campaign(options_.campaign, options_.procedure); !status) return status;
      for (const StagedRun& staged : staged_) {
        if (auto status = catalog_.add_run(staged.row, staged.segments); !status) return status;
      }
      return catalog_.add_campaign_references(options_.campaign, summary_.references);
    });
    if (!recorded) return recorded;
    for (const StagedRun& staged : staged_) files_.forget(catalog_.run_file_path(staged.row));
    return {};
  }

  db::Catalog& catalog_;
  const SourceRecording& recording_;
  const fs::path& source_;
  const ImportOptions& options_;
  std::int32_t epoch_ = 0;
  calib::UnitType type_;
  std::vector<db::RunRow> stored_;  ///< of all units
  std::vector<StagedRun> staged_;
  ImportSummary summary_;
  NewFiles files_;
};

}  // namespace

base::Result<ImportSummary> store_recording(db::Catalog& catalog, const SourceRecording& recording,
                                            const fs::path& source, const ImportOptions& options) {
  if (auto plain = check_carried_line(options.unit, "--unit"); !plain) return base::forward_error(plain);
  if (auto plain = check_text_line(options.campaign, "--campaign"); !plain) return base::forward_error(plain);
  return Importer(catalog, recording, source, options).run();
}

}  // namespace soak::station
