// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <set>
#include <system_error>
#include <tuple>
#include <utility>

#include "db/durable.h"
#include "station/archive/archive.h"
#include "station/archive/archive_reader.h"
#include "station/io/host.h"

namespace soak::station {
namespace {

namespace fs = std::filesystem;

auto void_key(const db::VoidRecord& record) {
  return std::tie(record.unit, record.visit, record.position, record.attempt, record.reason, record.user, record.utc_s);
}

/// Whether a run's file is there already, as a pull leaves it that is killed before its rows are stored. Refuses
/// (bad_input) another file of that name: a pull replaces no recording.
base::Result<bool> is_in_place(const fs::path& path, const std::string& sha256) {
  std::error_code error;
  if (!fs::exists(path, error) && !error) return false;
  const auto here = file_sha256(path);
  if (!here) return base::forward_error(here);
  if (*here == sha256) return true;
  return base::bad_input(
      fmt::format("another file is in its place here, with the SHA-256 {}; move it away if it is no recording of yours",
                  *here),
      path.string());
}

/// The rows must say what the record says, whose names have been checked.
bool is_of_record(const db::RunRow& row, const ArchiveRecord& record) {
  return row.sealed && row.file_name == record.file_name && row.file_sha256 == record.file_sha256 &&
         row.campaign == record.campaign && row.label == record.label && row.procedure == record.procedure;
}

class Pull {
 public:
  Pull(db::Catalog& catalog, const ArchiveStore& store, const std::string& user)
      : catalog_(catalog), store_(store), user_(user) {}

  base::Result<PullSummary> run(const ArchiveProgress& progress) {
    auto all =
        for_each_record(store_, progress, summary_.troubles, [this](const ArchiveRecord& record) -> base::Status {
          auto pulled = pull(record);
          if (pulled || !is_about_the_run(pulled.error())) return pulled;
          summary_.troubles.push_back({name_of_run(record), pulled.error()});
          return {};
        });
    if (!all) return base::forward_error(all);
    warn_of_references();
    return std::move(summary_);
  }

 private:
  base::Status pull(const ArchiveRecord& record) {
    // A station that has the run from the archive pushes a record without references: the largest number is the true
    // one.
    std::size_t& references = references_[record.campaign];
    references = std::max(references, record.references);
    const auto found = catalog_.runs({.unit = {}, .campaign = {}, .run = record.run_id});
    if (!found) return base::forward_error(found);
    if (found->empty()) return pull_run(record);
    for (const db::RunRecord& run : record.runs) {
      const auto same = std::ranges::find(*found, run.unit, &db::RunRow::unit);
      if (same != found->end() && same->numbers_sha256 == run.numbers_sha256) continue;
      return base::corrupt(
          fmt::format("run {} of unit {} has other numbers here than in the archive", run.run_id, run.unit),
          record.run_id);
    }
    if (seen_.insert(record.run_id).second) ++summary_.runs_there;
    return catalog_.all_or_nothing([&]() -> base::Status {
      for (const db::UnitRow& unit : record.units) {
        if (auto raised = raise_epoch(unit, record.run_id); !raised) return raised;
      }
      return add_voids(record);
    });
  }

  base::Status pull_run(const ArchiveRecord& record) {
    const fs::path path = catalog_.data_folder() / "runs" / record.file_name;
    // Another pull may bring the same run at this moment.
    const fs::path temporary = path.parent_path() / (new_run_id() + ".soakrun.tmp");
    auto pulled = get_checked(store_, kArchiveFiles, archived_file_name(record.file_sha256), temporary);
    bool placed = false;
    const std::size_t voids_before = summary_.voids;
    if (pulled) pulled = catalog_.all_or_nothing([&] { return enter(record, temporary, path, placed); });
    std::error_code ignored;
    fs::remove(temporary, ignored);
    if (!pulled && placed) take_back(record, path);
    if (!pulled) summary_.voids = voids_before;
    if (!pulled) return pulled;
    seen_.insert(record.run_id);
    summary_.runs.push_back(name_of_run(record));
    summary_.bytes += fs::file_size(path, ignored);
    campaigns_.insert(record.campaign);
    return {};
  }

  /// Inside the transaction. The file gets its name last: one without rows would look like a run that was lost here.
  /// `placed`: the file was given its name, and was not there before.
  base::Status enter(const ArchiveRecord& record, const fs::path& temporary, const fs::path& path, bool& placed) {
    for (const db::UnitRow& unit : record.units) {
      if (auto same = match_unit(unit, record.run_id); !same) return same;
    }
    if (auto same = catalog_.ensure_campaign(record.campaign, record.procedure); !same) return same;
    for (const db::RunRecord& run : record.runs) {
      if (auto added = catalog_.add_run_record(run); !added) return added;
    }
    const auto rows = catalog_.runs({.unit = {}, .campaign = {}, .run = record.run_id});
    if (!rows) return base::forward_error(rows);
    for (const db::RunRow& row : *rows) {
      if (is_of_record(row, record)) continue;
      return base::corrupt("the record's rows are of another run file, campaign, label or procedure", record.run_id);
    }
    if (auto added = add_voids(record); !added) return added;
    const auto in_place = is_in_place(path, record.file_sha256);
    if (!in_place) return base::forward_error(in_place);
    if (*in_place) return {};
    placed = true;
    return db::rename_durably(temporary, path);
  }

  /// Removes the file of a run whose rows could not be stored (full disk), unless another pull has stored them since.
  void take_back(const ArchiveRecord& record, const fs::path& path) {
    const auto removed = catalog_.all_or_nothing([&]() -> base::Status {
      const auto rows = catalog_.runs({.unit = {}, .campaign = {}, .run = record.run_id});
      if (!rows) return base::forward_error(rows);
      std::error_code ignored;
      if (rows->empty()) fs::remove(path, ignored);
      return {};
    });
    // What stays is taken by the next pull.
    static_cast<void>(removed);
  }

  base::Status match_unit(const db::UnitRow& unit, const std::string& run_id) {
    const auto here = catalog_.add_unit(unit.serial, unit.type, user_);
    if (!here) return base::forward_error(here);
    if (here->type != unit.type) {
      return base::bad_input(fmt::format("unit {} is of type {} here, and {} in the archive: one of them is wrong",
                                         unit.serial, here->type, unit.type),
                             run_id);
    }
    return raise_epoch(unit, run_id);
  }

  /// To the higher one: a unit that was repaired at one station is the repaired one everywhere.
  base::Status raise_epoch(const db::UnitRow& unit, const std::string& run_id) {
    const auto known = catalog_.unit(unit.serial);
    if (!known) return base::forward_error(known);
    std::int32_t epoch = *known ? (*known)->epoch : 0;
    for (; epoch < unit.epoch; ++epoch) {
      const auto begun = catalog_.begin_epoch(unit.serial, "begun at the station that recorded run " + run_id, user_);
      if (!begun) return base::forward_error(begun);
    }
    return {};
  }

  void warn_of_references() {
    for (const std::string& campaign : campaigns_) {
      if (references_[campaign] == 0) continue;
      summary_.warnings.push_back(
          fmt::format("campaign '{}' was measured with {} references, which an archive does not carry: fits here state "
                      "wider bands, or none, for what they cover",
                      campaign, references_[campaign]));
    }
  }

  base::Status add_voids(const ArchiveRecord& record) {
    const auto here = catalog_.voids(record.run_id);
    if (!here) return base::forward_error(here);
    for (const db::VoidRecord& entry : record.voids) {
      if (std::ranges::any_of(*here, [&](const auto& known) { return void_key(known) == void_key(entry); })) continue;
      if (auto added = catalog_.add_void(entry); !added) return added;
      ++summary_.voids;
    }
    return {};
  }

  db::Catalog& catalog_;
  const ArchiveStore& store_;
  const std::string& user_;
  std::set<std::string> seen_;                     ///< run ids; a run has a record for each state of its voids
  std::set<std::string> campaigns_;                ///< of the runs that are new here
  std::map<std::string, std::size_t> references_;  ///< by campaign
  PullSummary summary_;
};

}  // namespace

base::Result<PullSummary> pull_from_archive(db::Catalog& catalog, const ArchiveStore& store, const std::string& user,
                                            const ArchiveProgress& progress) {
  return Pull(catalog, store, user).run(progress);
}

}  // namespace soak::station
