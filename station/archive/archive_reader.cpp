// SPDX-License-Identifier: Apache-2.0
#include "station/archive/archive_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <system_error>
#include <utility>

#include "station/io/host.h"
#include "station/io/text_file.h"

namespace soak::station {
namespace {

namespace fs = std::filesystem;

base::Status check_hash(const fs::path& file, const std::string& name) {
  const auto sha256 = file_sha256(file);
  if (!sha256) return base::forward_error(sha256);
  if (name.starts_with(*sha256 + ".")) return {};
  return base::corrupt(fmt::format("is damaged in the archive: its SHA-256 is {}", *sha256), name);
}

base::Result<ArchiveRecord> get_record(const ArchiveStore& store, const std::string& name,
                                       const ArchiveScratch& scratch) {
  const fs::path file = scratch.file("record");
  if (auto got = get_checked(store, kArchiveRecords, name, file); !got) return base::forward_error(got);
  const auto text = read_text_file(file);
  if (!text) return base::forward_error(text);
  return read_archive_record(*text, name);
}

/// A wrong name, or a share that is not mounted, must not look like an archive without runs.
base::Status require_archive(const ArchiveStore& store, const std::set<std::string>& records) {
  if (!records.empty()) return {};
  const auto files = store.list(kArchiveFiles);
  if (!files) return base::forward_error(files);
  if (!files->empty()) return {};
  return base::bad_input(
      "no archive is there: neither run files nor records. Check the name, and whether the share is mounted; 'soak "
      "archive push' begins an archive",
      store.place());
}

}  // namespace

std::string archived_file_name(const std::string& sha256) { return sha256 + ".soakrun"; }
std::string archived_record_name(const std::string& sha256) { return sha256 + ".json"; }

ArchiveScratch::~ArchiveScratch() {
  std::error_code ignored;
  if (!folder_.empty()) fs::remove_all(folder_, ignored);
}

base::Status ArchiveScratch::make() {
  std::error_code error;
  const fs::path parent = fs::temp_directory_path(error);
  if (!error) {
    folder_ = parent / ("soak-archive-" + new_run_id());
    fs::create_directories(folder_, error);
  }
  if (!error) return {};
  return base::fail(base::ErrorKind::internal,
                    fmt::format("cannot make a temporary folder: {}; $TMPDIR must name a folder that can be written",
                                error.message()),
                    "archive");
}

base::Status report_progress(const ArchiveProgress& progress, std::size_t done, std::size_t of) {
  if (!progress || progress(static_cast<double>(done) / static_cast<double>(std::max<std::size_t>(1, of)))) return {};
  return base::fail(base::ErrorKind::internal, "interrupted; what was brought so far stays, the next call goes on",
                    "archive");
}

std::string name_of_run(const ArchiveRecord& record) { return fmt::format("{}/{}", record.campaign, record.label); }

bool is_about_the_run(const base::Error& error) {
  return error.kind == base::ErrorKind::corrupt || error.kind == base::ErrorKind::bad_input;
}

base::Status get_checked(const ArchiveStore& store, const std::string& folder, const std::string& name,
                         const fs::path& to) {
  if (auto got = store.get(folder + "/" + name, to); !got) return got;
  return check_hash(to, name);
}

base::Status check_archived(const ArchiveStore& store, const std::string& folder, const std::string& name,
                            const fs::path& scratch) {
  const auto there = store.local_path(folder + "/" + name);
  return there ? check_hash(*there, name) : get_checked(store, folder, name, scratch);
}

base::Status for_each_record(const ArchiveStore& store, const ArchiveProgress& progress,
                             std::vector<ArchiveTrouble>& troubles,
                             const std::function<base::Status(ArchiveRecord)>& visit) {
  ArchiveScratch scratch;
  if (auto made = scratch.make(); !made) return made;
  const auto names = store.list(kArchiveRecords);
  if (!names) return base::forward_error(names);
  if (auto there = require_archive(store, *names); !there) return there;
  std::size_t done = 0;
  for (const std::string& name : *names) {
    if (auto goes_on = report_progress(progress, done++, names->size()); !goes_on) return goes_on;
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

}  // namespace soak::station
