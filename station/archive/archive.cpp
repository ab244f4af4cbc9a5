// SPDX-License-Identifier: Apache-2.0
#include "station/archive/archive.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <set>
#include <system_error>
#include <tuple>
#include <utility>

#include "db/durable.h"
#include "station/io/host.h"
#include "station/io/text_file.h"

namespace soak::station {
namespace {

namespace fs = std::filesystem;

const std::string kFiles = "files";
const std::string kRecords = "records";

std::string file_name_of(const std::string& sha256) { return sha256 + ".soakrun"; }
std::string record_name_of(const std::string& sha256) { return sha256 + ".json"; }

/// A folder that is gone again at the end.
class Scratch {
 public:
  Scratch() : folder_(fs::temp_directory_path() / ("soak-archive-" + new_run_id())) {}
  Scratch(const Scratch&) = delete;
  Scratch& operator=(const Scratch&) = delete;
  ~Scratch() {
    std::error_code ignored;
    fs::remove_all(folder_, ignored);
  }

  base::Status make() const {
    std::error_code error;
    fs::create_directories(folder_, error);
    if (!error) return {};
    return base::fail(base::ErrorKind::internal, "cannot make a temporary folder: " + error.message(),
                      folder_.string());
  }
  [[nodiscard]] fs::path file(const std::string& name) const { return folder_ / name; }

 private:
  fs::path folder_;
};

base::Status go_on(const ArchiveProgress& progress, std::size_t done, std::size_t of) {
  if (!progress || progress(static_cast<double>(done) / static_cast<double>(std::max<std::size_t>(1, of)))) return {};
  return base::fail(base::ErrorKind::internal, "interrupted; what was brought so far stays, the next call goes on",
                    "archive");
}

std::string name_of_run(const ArchiveRecord& record) { return fmt::format("{}/{}", record.campaign, record.label); }

bool is_about_the_run(const base::Error& error) {
  return error.kind == base::ErrorKind::corrupt || error.kind == base::ErrorKind::bad_input;
}

/// Gets a file whose name states its hash. Fails (corrupt) where that is not its hash.
base::Status get_checked(const ArchiveStore& store, const std::string& folder, const std::string& name,
                         const fs::path& to) {
  if (auto got = store.get(folder + "/" + name, to); !got) return got;
  const auto sha256 = file_sha256(to);
  if (!sha256) return base::forward_error(sha256);
  if (name.starts_with(*sha256 + ".")) return {};
  return base::corrupt(fmt::format("is damaged in the archive: its SHA-256 is {}", *sha256), name);
}

base::Result<ArchiveRecord> get_record(const ArchiveStore& store, const std::string& name, const Scratch& scratch) {
  const fs::path file = scratch.file("record");
  if (auto got = get_checked(store, kRecords, name, file); !got) return base::forward_error(got);
  const auto text = read_text_file(file);
  if (!text) return base::forward_error(text);
  return read_archive_record(*text, name);
}

/// `visit` with each record that is whole; the others are troubles.
base::Status for_each_record(const ArchiveStore& store, const ArchiveProgress& progress,
                             std::vector<ArchiveTrouble>& troubles,
                             const std::function<base::Status(ArchiveRecord)>& visit) {
  const Scratch scratch;
  if (auto made = scratch.make(); !made) return made;
  const auto names = store.list(kRecords);
  if (!names) return base::forward_error(names);
  std::size_t done = 0;
  for (const std::string& name : *names) {
    if (auto goes_on = go_on(progress, done++, names->size()); !goes_on) return goes_on;
    auto record = get_record(store, name, scratch);
    if (!record && !is_about_the_run(record.error())) return base::forward_error(record);
    if (!record) {
      troubles.push_back({name, record.error()});
      continue;
    }
    if (auto visited = visit(*std::move(record)); !visited) return visited;
  }
  return {};
}

// Push.

class Push {
 public:
  Push(const db::Catalog& catalog, ArchiveStore& store) : catalog_(catalog), store_(store) {}

  base::Result<PushSummary> run(const ArchiveProgress& progress) {
    if (auto made = scratch_.make(); !made) return base::forward_error(made);
    auto files = store_.list(kFiles);
    if (!files) return base::forward_error(files);
    auto records = store_.list(kRecords);
    if (!records) return base::forward_error(records);
    files_there_ = *std::move(files);
    records_there_ = *std::move(records);
    const auto runs = catalog_.runs({});
    if (!runs) return base::forward_error(runs);
    std::map<std::string, std::vector<db::RunRow>> by_file;
    for (const db::RunRow& run : *runs) by_file[run.file_name].push_back(run);
    std::size_t done = 0;
    for (const auto& [name, rows] : by_file) {
      if (auto goes_on = go_on(progress, done++, by_file.size()); !goes_on) return base::forward_error(goes_on);
      if (auto pushed = push(name, rows); !pushed) return base::forward_error(pushed);
    }
    return std::move(summary_);
  }

 private:
  base::Status push(const std::string& name, const std::vector<db::RunRow>& rows) {
    const db::RunRow& run = rows.front();
    if (!run.sealed) {
      summary_.open.push_back(name);
      return {};
    }
    const bool is_there = files_there_.contains(file_name_of(run.file_sha256));
    if (!is_there && run.samples_dropped) {
      summary_.dropped.push_back(name);
      return {};
    }
    auto pushed = is_there ? base::Status() : push_file(run);
    if (pushed) pushed = push_record(rows);
    if (pushed) summary_.files_there += is_there ? 1 : 0;
    if (pushed || pushed.error().kind != base::ErrorKind::corrupt) return pushed;
    summary_.troubles.push_back({name, pushed.error()});
    return {};
  }

  base::Status push_file(const db::RunRow& run) {
    if (auto sound = catalog_.check_run_file(run); !sound) return sound;
    const fs::path file = catalog_.run_file_path(run);
    auto put = store_.put(file, kFiles + "/" + file_name_of(run.file_sha256), run.file_sha256);
    if (!put) return put;
    std::error_code ignored;
    summary_.files.push_back(run.file_name);
    summary_.bytes += fs::file_size(file, ignored);
    return {};
  }

  /// After the file: no record names one that the archive does not have.
  base::Status push_record(const std::vector<db::RunRow>& rows) {
    const auto text = archive_record(catalog_, rows);
    if (!text) return base::forward_error(text);
    const fs::path file = scratch_.file("record");
    if (auto written = write_text_file(file, *text); !written) return written;
    const auto sha256 = file_sha256(file);
    if (!sha256) return base::forward_error(sha256);
    const std::string name = record_name_of(*sha256);
    if (records_there_.contains(name)) return {};
    ++summary_.records;
    return store_.put(file, kRecords + "/" + name, *sha256);
  }

  const db::Catalog& catalog_;
  ArchiveStore& store_;
  Scratch scratch_;
  std::set<std::string> files_there_;
  std::set<std::string> records_there_;
  PushSummary summary_;
};

// Pull.

auto void_key(const db::VoidRecord& record) {
  return std::tie(record.unit, record.visit, record.position, record.attempt, record.reason, record.user, record.utc_s);
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
    return std::move(summary_);
  }

 private:
  base::Status pull(const ArchiveRecord& record) {
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
    return catalog_.all_or_nothing([&] { return add_voids(record); });
  }

  base::Status pull_run(const ArchiveRecord& record) {
    const fs::path path = catalog_.data_folder() / "runs" / record.file_name;
    // Another pull may bring the same run at this moment.
    const fs::path temporary = path.parent_path() / (new_run_id() + ".soakrun.tmp");
    auto pulled = get_checked(store_, kFiles, file_name_of(record.file_sha256), temporary);
    if (pulled) pulled = catalog_.all_or_nothing([&] { return enter(record, temporary, path); });
    std::error_code ignored;
    fs::remove(temporary, ignored);
    if (!pulled) return pulled;
    seen_.insert(record.run_id);
    summary_.runs.push_back(name_of_run(record));
    summary_.bytes += fs::file_size(path, ignored);
    if (record.references > 0 && told_.insert(record.campaign).second) {
      summary_.warnings.push_back(
          fmt::format("campaign '{}' was measured with {} references, which an archive does not carry: fits here state "
                      "wider bands, or none, for what they cover",
                      record.campaign, record.references));
    }
    return {};
  }

  /// Inside the transaction. The file gets its name last: one without rows would look like a run that was lost here.
  base::Status enter(const ArchiveRecord& record, const fs::path& temporary, const fs::path& path) {
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
      if (row.sealed && row.file_name == record.file_name && row.file_sha256 == record.file_sha256) continue;
      return base::corrupt("the record's rows name another run file", record.run_id);
    }
    if (auto added = add_voids(record); !added) return added;
    return db::rename_durably(temporary, path);
  }

  base::Status match_unit(const db::UnitRow& unit, const std::string& run_id) {
    auto here = catalog_.add_unit(unit.serial, unit.type, user_);
    if (!here) return base::forward_error(here);
    if (here->type != unit.type) {
      return base::bad_input(fmt::format("unit {} is of type {} here, and {} in the archive: one of them is wrong",
                                         unit.serial, here->type, unit.type),
                             run_id);
    }
    while (here && here->epoch < unit.epoch) {
      here = catalog_.begin_epoch(unit.serial, "begun at the station that recorded run " + run_id, user_);
    }
    return here ? base::Status() : base::Status(base::forward_error(here));
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
  std::set<std::string> seen_;  ///< run ids; a run has a record for each state of its voids
  std::set<std::string> told_;  ///< campaigns
  PullSummary summary_;
};

}  // namespace

base::Result<PushSummary> push_to_archive(const db::Catalog& catalog, ArchiveStore& store,
                                          const ArchiveProgress& progress) {
  return Push(catalog, store).run(progress);
}

base::Result<PullSummary> pull_from_archive(db::Catalog& catalog, const ArchiveStore& store, const std::string& user,
                                            const ArchiveProgress& progress) {
  return Pull(catalog, store, user).run(progress);
}

base::Result<ArchiveListing> list_archive(const ArchiveStore& store) {
  ArchiveListing listing;
  std::map<std::string, ArchiveRecord> by_id;
  auto all = for_each_record(store, {}, listing.troubles, [&](ArchiveRecord record) -> base::Status {
    for (db::RunRecord& run : record.runs) run.tables.clear();
    const auto [entry, is_new] = by_id.try_emplace(record.run_id, record);
    if (!is_new && entry->second.voids.size() < record.voids.size()) entry->second = std::move(record);
    return {};
  });
  if (!all) return base::forward_error(all);
  for (auto& [id, record] : by_id) listing.runs.push_back(std::move(record));
  std::ranges::sort(listing.runs, {},
                    [](const ArchiveRecord& run) { return std::tie(run.campaign, run.created_utc_s, run.run_id); });
  return listing;
}

base::Result<ArchiveCheck> verify_archive(const ArchiveStore& store, const ArchiveProgress& progress) {
  ArchiveCheck check;
  const auto files = store.list(kFiles);
  if (!files) return base::forward_error(files);
  std::set<std::string> named;
  auto all = for_each_record(store, {}, check.troubles, [&](const ArchiveRecord& record) -> base::Status {
    ++check.records;
    const std::string name = file_name_of(record.file_sha256);
    if (named.insert(name).second && !files->contains(name)) {
      check.troubles.push_back(
          {name, {base::ErrorKind::corrupt, "is missing: the file of run " + name_of_run(record), name}});
    }
    return {};
  });
  if (!all) return base::forward_error(all);
  const Scratch scratch;
  if (auto made = scratch.make(); !made) return base::forward_error(made);
  for (const std::string& name : *files) {
    if (auto goes_on = go_on(progress, check.files++, files->size()); !goes_on) return base::forward_error(goes_on);
    auto sound = get_checked(store, kFiles, name, scratch.file("run"));
    if (!sound && !is_about_the_run(sound.error())) return base::forward_error(sound);
    if (!sound) check.troubles.push_back({name, sound.error()});
    if (!named.contains(name)) check.without_record.push_back(name);
  }
  return check;
}

}  // namespace soak::station
