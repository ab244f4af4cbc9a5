// SPDX-License-Identifier: Apache-2.0
#include <SQLiteCpp/Column.h>
#include <SQLiteCpp/Statement.h>
#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <string_view>
#include <system_error>

#include "base/text.h"
#include "db/catalog/detail/impl.h"
#include "db/catalog/detail/run_digest.h"
#include "db/detail/sqlite.h"

namespace soak::db {
namespace {

/// Characters that a prefix of a run id needs at least: shorter ones are labels by all likelihood.
constexpr std::size_t kShortestPrefix = 6;

constexpr const char* kRunColumns =
    "run_id, unit, campaign, label, procedure, purpose, epoch, created_utc_s, clock_rate, simulated, sealed, "
    "file_name, file_sha256, content_sha256, latitude_deg, height_m, azimuth_deg, gravity_mps2, row_count, duration_s, "
    "cut_short, continues";

RunRow run_from(sqlite::Fields& fields) {
  RunRow run;
  run.run_id = fields.text();
  run.unit = fields.text();
  run.campaign = fields.text();
  run.label = fields.text();
  run.procedure = fields.text();
  run.purpose = fields.text();
  run.epoch = fields.integer32();
  run.created_utc_s = fields.real();
  run.clock_rate = fields.real();
  run.simulated = fields.flag();
  run.sealed = fields.flag();
  run.file_name = fields.text();
  run.file_sha256 = fields.text();
  run.content_sha256 = fields.text();
  run.site.latitude_deg = fields.optional_real();
  run.site.height_m = fields.optional_real();
  run.site.azimuth_deg = fields.optional_real();
  run.site.gravity_mps2 = fields.optional_real();
  run.rows = static_cast<std::uint64_t>(fields.integer());
  run.duration_s = fields.real();
  run.cut_short = fields.text();
  run.continues = fields.text();
  run.numbers_sha256 = fields.text();
  run.voided = fields.flag();
  return run;
}

/// Runs of a unit (?1), of a campaign (?2), of that name (?3). Only what is asked for is a condition, so that an index
/// serves it. A whole id or a label wins over the start of an id of at least ?4 characters.
std::string query_of(const RunFilter& filter) {
  const std::string_view unit = filter.unit ? "unit = ?1" : "?1 IS NULL";
  const std::string_view campaign = filter.campaign ? "campaign = ?2" : "?2 IS NULL";
  const std::string named = fmt::format(
      "(run_id = ?3 OR label = ?3 OR (length(?3) >= ?4 AND substr(run_id, 1, length(?3)) = ?3 AND NOT EXISTS (SELECT 1 "
      "FROM (SELECT run_id, label FROM run WHERE {} AND {}) AS named WHERE named.run_id = ?3 OR named.label = ?3)))",
      unit, campaign);
  return fmt::format(
      "SELECT {}, numbers_sha256, EXISTS (SELECT 1 FROM void WHERE void.run_id = run.run_id AND void.unit = run.unit "
      "AND "
      "void.visit IS NULL) FROM run WHERE {} AND {} AND {} ORDER BY created_utc_s, run_id, unit",
      kRunColumns, unit, campaign, filter.run ? named : "(?3 IS NULL AND ?4 > 0)");
}

/// In the order in which drop_from() reads them.
constexpr const char* kDropColumns = "run_id, source, bytes, reason, user, utc_s";

SampleDrop drop_from(sqlite::Fields& fields) {
  SampleDrop drop;
  drop.run_id = fields.text();
  drop.source = fields.text();
  drop.bytes = static_cast<std::uint64_t>(fields.integer());
  drop.reason = fields.text();
  drop.user = fields.text();
  drop.utc_s = fields.real();
  return drop;
}

bool is_there(const std::filesystem::path& path) {
  std::error_code ignored;
  return std::filesystem::exists(path, ignored);
}

void insert_run(SQLite::Database& database, const RunRow& run) {
  SQLite::Statement insert(database, std::string("INSERT INTO run (") + kRunColumns +
                                         ") VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)");
  sqlite::bind_all(insert, run.run_id, run.unit, run.campaign, run.label, run.procedure, run.purpose, run.epoch,
                   run.created_utc_s, run.clock_rate, run.simulated, run.sealed, run.file_name, run.file_sha256,
                   run.content_sha256, run.site.latitude_deg, run.site.height_m, run.site.azimuth_deg,
                   run.site.gravity_mps2, run.rows, run.duration_s, run.cut_short, run.continues);
  insert.exec();
}

/// Refuses what the schema's constraints would refuse, with words that help.
base::Status check_run(const sqlite::Connection& connection, const RunRow& run) {
  const std::string where = connection.path().string();
  if (run.run_id.empty() || run.file_name.empty()) {
    return base::bad_input("a run needs a run id and the name of its file", where);
  }
  if (!is_purpose(run.purpose)) {
    return base::bad_input(
        "'" + run.purpose + "' is not a purpose of a run; known are calibration, verification and diagnosis", where);
  }
  if (const auto epoch = catalog::epoch_of(connection, run.unit); !epoch) return base::forward_error(epoch);
  SQLite::Database& database = connection.database();
  if (!sqlite::has_row(database, "SELECT 1 FROM campaign WHERE name = ?", run.campaign)) {
    return base::bad_input("the catalog has no campaign '" + run.campaign + "'; add it first", where);
  }
  if (sqlite::has_row(database, "SELECT 1 FROM run WHERE run_id = ? AND unit = ?", run.run_id, run.unit)) {
    return base::bad_input("the catalog has run " + run.run_id + " of unit " + run.unit + " already", where);
  }
  const auto same =
      sqlite::first_row_of(database, "SELECT run_id FROM run WHERE campaign = ? AND unit = ? AND label = ?",
                           sqlite::text_from, run.campaign, run.unit, run.label);
  if (same) {
    return base::bad_input("campaign '" + run.campaign + "' has a run '" + run.label + "' of unit " + run.unit +
                               " already (" + *same + "); use another label or campaign",
                           where);
  }
  return {};
}

base::Status check_segments(const RunRow& run, const std::vector<calib::Segment>& segments, const std::string& where) {
  std::vector<calib::SegmentKey> seen;
  for (const calib::Segment& segment : segments) {
    const calib::SegmentKey& key = segment.key;
    const std::string name = "visit " + std::to_string(key.visit) + ", position '" + key.position + "', attempt " +
                             std::to_string(key.attempt);
    if (key.run_id != run.run_id || key.unit != run.unit) {
      return base::bad_input("the segment of " + name + " belongs to another run or unit", where);
    }
    if (std::find(seen.begin(), seen.end(), key) != seen.end()) {
      return base::bad_input("the segment of " + name + " is duplicated; a repetition is a new attempt", where);
    }
    seen.push_back(key);
  }
  return {};
}

/// A text that is no whole id and no label may be the start of one id only.
base::Status check_prefix(const std::vector<RunRow>& runs, const std::string& text, const std::string& where) {
  for (const RunRow& run : runs) {
    if (run.run_id == text || run.label == text) return {};
    if (run.run_id == runs.front().run_id) continue;
    return base::bad_input("'" + text + "' is the start of several run ids (" + runs.front().run_id + ", " +
                               run.run_id + ", ...); give more of it",
                           where);
  }
  return {};
}

}  // namespace

namespace catalog {

base::Status require_run(const sqlite::Connection& connection, std::string_view run_id, std::string_view unit) {
  if (sqlite::has_row(connection.database(), "SELECT 1 FROM run WHERE run_id = ? AND unit = ?", run_id, unit))
    return {};
  return base::bad_input("the catalog has no run '" + std::string(run_id) + "' of unit '" + std::string(unit) + "'",
                         connection.path().string());
}

}  // namespace catalog

bool is_purpose(std::string_view text) {
  return text == "calibration" || text == "verification" || text == "diagnosis";
}

base::Status Catalog::add_run(const RunRow& run, const std::vector<calib::Segment>& segments) {
  return impl_->connection.transact("add the run", [&]() -> base::Status {
    if (const auto valid = check_run(impl_->connection, run); !valid) return valid;
    auto unique = check_segments(run, segments, impl_->connection.path().string());
    if (!unique) return unique;
    insert_run(impl_->database(), run);
    for (const calib::Segment& segment : segments) catalog::insert_segment(impl_->database(), segment);
    catalog::store_numbers_sha256(impl_->database(), run.run_id, run.unit);
    impl_->log({catalog::now_utc_s(), "run_added", run.run_id,
                "unit " + run.unit + ", campaign '" + run.campaign + "', label '" + run.label + "', " +
                    std::to_string(segments.size()) + " segments"});
    return {};
  });
}

base::Status Catalog::check_run_file(const RunRow& run) const {
  const std::filesystem::path path = run_file_path(run);
  constexpr std::string_view kRemedy = "restore it from a backup, or void the run ('soak runs verify' says more)";
  auto known = impl_->file_sha256.find(run.file_name);
  if (known == impl_->file_sha256.end()) {
    if (!is_there(path)) {
      // Asked again: somebody may have dropped them since the run was read.
      const auto dropped = impl_->drop_of(run.run_id);
      if (!dropped) return base::forward_error(dropped);
      if (*dropped) return {};
      return base::corrupt(fmt::format("the run file of run '{}' is missing; {}", run.label, kRemedy), path.string());
    }
    auto sha256 = sqlite::sha256_of_file(path);
    if (!sha256) return base::forward_error(sha256);
    known = impl_->file_sha256.emplace(run.file_name, *std::move(sha256)).first;
  }
  if (known->second == run.file_sha256) return {};
  return base::corrupt(fmt::format("the run file of run '{}' is damaged: its SHA-256 is {}, the catalog says {}; {}",
                                   run.label, known->second, run.file_sha256, kRemedy),
                       path.string());
}

base::Result<std::optional<SampleDrop>> Catalog::Impl::drop_of(std::string_view run_id) const {
  return connection.run("read what was dropped", [&]() -> base::Result<std::optional<SampleDrop>> {
    return sqlite::first_row_of(
        database(),
        fmt::format("SELECT {} FROM sample_drop WHERE run_id = ? ORDER BY rowid DESC LIMIT 1", kDropColumns), drop_from,
        run_id);
  });
}

base::Result<RunFileReader> Catalog::open_run_file(const RunRow& run) const {
  const std::filesystem::path path = run_file_path(run);
  if (is_there(path)) return RunFileReader::open(path);
  const auto drop = impl_->drop_of(run.run_id);
  if (!drop) return base::forward_error(drop);
  if (!*drop) return RunFileReader::open(path);
  return base::bad_input(
      fmt::format("run '{}' of unit {} has no samples any more: {} dropped them on {} ({}). From a backup of before "
                  "they can be put back: the file {} in the folder runs",
                  run.label, run.unit, (*drop)->user, base::utc_text((*drop)->utc_s), (*drop)->reason, run.file_name),
      run.run_id);
}

base::Status Catalog::add_sample_drop(const SampleDrop& drop) {
  return impl_->connection.transact("note that samples are dropped", [&]() -> base::Status {
    if (drop.reason.empty() || drop.user.empty()) return impl_->refuse("dropping samples needs a reason and a user");
    SQLite::Database& database = impl_->database();
    if (!sqlite::has_row(database, "SELECT 1 FROM run WHERE run_id = ?", drop.run_id)) {
      return impl_->refuse("the catalog has no run '" + drop.run_id + "'");
    }
    if (sqlite::has_row(database, "SELECT 1 FROM run WHERE run_id = ? AND sealed = 0", drop.run_id)) {
      return impl_->refuse("run " + drop.run_id + " is not sealed: its samples stay");
    }
    sqlite::execute(database,
                    fmt::format("INSERT INTO sample_drop (drop_id, {}) VALUES (?, ?, ?, ?, ?, ?, ?)", kDropColumns),
                    catalog::new_uuid(drop.utc_s), drop.run_id, drop.source, static_cast<std::int64_t>(drop.bytes),
                    drop.reason, drop.user, drop.utc_s);
    impl_->log({drop.utc_s, "samples_dropped", drop.run_id,
                fmt::format("{} bytes, by {}: {}", drop.bytes, drop.user, drop.reason), drop.user});
    return {};
  });
}

base::Status Catalog::check_numbers(const RunRow& run) const {
  return impl_->connection.run("check the run's numbers", [&]() -> base::Status {
    return catalog::check_numbers(impl_->connection, run.run_id, run.unit);
  });
}

base::Result<std::vector<RunRow>> Catalog::runs(const RunFilter& filter) const {
  return impl_->connection.run("read the runs", [&]() -> base::Result<std::vector<RunRow>> {
    auto runs = sqlite::rows_of(impl_->database(), query_of(filter), run_from, filter.unit, filter.campaign, filter.run,
                                kShortestPrefix);
    SQLite::Statement last_drop(
        impl_->database(),
        fmt::format("SELECT {} FROM sample_drop WHERE run_id = ? ORDER BY rowid DESC LIMIT 1", kDropColumns));
    for (RunRow& run : runs) {
      sqlite::bind_all(last_drop, run.run_id);
      if (last_drop.executeStep() && !is_there(run_file_path(run))) {
        sqlite::Fields fields(last_drop);
        run.samples_dropped = drop_from(fields);
      }
      last_drop.reset();
    }
    if (filter.run) {
      const auto unique = check_prefix(runs, *filter.run, impl_->connection.path().string());
      if (!unique) return base::forward_error(unique);
    }
    return runs;
  });
}

}  // namespace soak::db
