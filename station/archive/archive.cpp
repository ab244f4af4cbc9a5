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

#include "station/archive/archive_reader.h"
#include "station/io/text_file.h"

namespace soak::station {
namespace {

namespace fs = std::filesystem;

class Push {
 public:
  Push(const db::Catalog& catalog, ArchiveStore& store) : catalog_(catalog), store_(store) {}

  base::Result<PushSummary> run(const ArchiveProgress& progress) {
    if (auto made = scratch_.make(); !made) return base::forward_error(made);
    auto files = store_.list(kArchiveFiles);
    if (!files) return base::forward_error(files);
    auto records = store_.list(kArchiveRecords);
    if (!records) return base::forward_error(records);
    files_there_ = *std::move(files);
    records_there_ = *std::move(records);
    const auto runs = catalog_.runs({});
    if (!runs) return base::forward_error(runs);
    std::map<std::string, std::vector<db::RunRow>> by_file;
    for (const db::RunRow& run : *runs) by_file[run.file_name].push_back(run);
    std::size_t done = 0;
    for (const auto& [name, rows] : by_file) {
      if (auto goes_on = report_progress(progress, done++, by_file.size()); !goes_on)
        return base::forward_error(goes_on);
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
    const bool is_there = files_there_.contains(archived_file_name(run.file_sha256));
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
    auto put = store_.put(file, kArchiveFiles + "/" + archived_file_name(run.file_sha256), run.file_sha256);
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
    const std::string name = archived_record_name(*sha256);
    if (records_there_.contains(name)) return {};
    ++summary_.records;
    return store_.put(file, kArchiveRecords + "/" + name, *sha256);
  }

  const db::Catalog& catalog_;
  ArchiveStore& store_;
  ArchiveScratch scratch_;
  std::set<std::string> files_there_;
  std::set<std::string> records_there_;
  PushSummary summary_;
};

}  // namespace

base::Result<PushSummary> push_to_archive(const db::Catalog& catalog, ArchiveStore& store,
                                          const ArchiveProgress& progress) {
  return Push(catalog, store).run(progress);
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
  const auto files = store.list(kArchiveFiles);
  if (!files) return base::forward_error(files);
  std::set<std::string> named;
  auto all = for_each_record(store, {}, check.troubles, [&](const ArchiveRecord& record) -> base::Status {
    ++check.records;
    const std::string name = archived_file_name(record.file_sha256);
    if (named.insert(name).second && !files->contains(name)) {
      check.troubles.push_back(
          {name, {base::ErrorKind::corrupt, "is missing: the file of run " + name_of_run(record), name}});
    }
    return {};
  });
  if (!all) return base::forward_error(all);
  ArchiveScratch scratch;
  if (auto made = scratch.make(); !made) return base::forward_error(made);
  for (const std::string& name : *files) {
    if (auto goes_on = report_progress(progress, check.files++, files->size()); !goes_on)
      return base::forward_error(goes_on);
    auto sound = check_archived(store, kArchiveFiles, name, scratch.file("run"));
    if (!sound && !is_about_the_run(sound.error())) return base::forward_error(sound);
    if (!sound) check.troubles.push_back({name, sound.error()});
    if (!named.contains(name)) check.without_record.push_back(name);
  }
  return check;
}

}  // namespace soak::station
