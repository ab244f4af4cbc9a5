// SPDX-License-Identifier: Apache-2.0
#include "station/io/backup.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <map>
#include <optional>
#include <span>
#include <system_error>
#include <utility>

#include "base/file_descriptor.h"
#include "base/hash.h"
#include "db/durable.h"
#include "station/io/data_folder.h"

namespace soak::station {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kBlock_bytes = std::size_t{1} << 20;

base::Status interrupted_at(const fs::path& path) {
  return base::fail(base::ErrorKind::internal, "interrupted: what was copied so far is used by the next backup",
                    path.string());
}

tl::unexpected<base::Error> failed(std::string_view doing, const fs::path& path) {
  return base::fail(base::ErrorKind::internal,
                    fmt::format("cannot {}: {}", doing, std::generic_category().message(errno)), path.string());
}

bool write_block(int descriptor, std::span<const char> block) {
  while (!block.empty()) {
    const ssize_t written = ::write(descriptor, block.data(), block.size());
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return false;
    block = block.subspan(static_cast<std::size_t>(written));
  }
  return true;
}

/// What became of reading a file: its SHA-256, or why it cannot be read.
struct FileRead {
  std::string sha256;
  std::string unreadable;
};

FileRead unreadable() { return {"", "cannot be read: " + std::generic_category().message(errno)}; }

/// Reads a file and writes what it reads to `copy` if that is a descriptor. Fails where writing does: a file that
/// cannot be read must not keep the others from being copied.
base::Result<FileRead> read_through(const fs::path& path, int copy, const fs::path& copy_path) {
  const base::FileDescriptor source(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
  if (!source) return unreadable();
  std::vector<char> block(kBlock_bytes);
  base::Sha256 hash;
  while (true) {
    const ssize_t count = ::read(source.get(), block.data(), block.size());
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return unreadable();
    if (count == 0) return FileRead{base::to_hex(hash.finish()), ""};
    const std::span<const char> bytes(block.data(), static_cast<std::size_t>(count));
    hash.update(std::string_view(bytes.data(), bytes.size()));
    if (copy >= 0 && !write_block(copy, bytes)) return failed("write the copy", copy_path);
  }
}

/// Copies a run file under its name. Returns why it is damaged; nothing where it is not.
base::Result<std::optional<std::string>> copy_run_file(const fs::path& from, const fs::path& to,
                                                       const std::string& sha256) {
  const fs::path temporary = to.string() + ".tmp";
  base::Result<FileRead> found;
  {
    const base::FileDescriptor copy(::open(temporary.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644));
    if (!copy) return failed("write the copy", temporary);
    found = read_through(from, copy.get(), temporary);
  }
  base::Status status = found ? base::Status() : base::Status(base::forward_error(found));
  if (status && found->sha256 == sha256) {
    // Read back before it gets its name.
    status = db::sync_to_disk(temporary);
    const auto again = status ? read_through(temporary, -1, {}) : found;
    if (status && again && again->sha256 == sha256)
      status = db::rename_durably(temporary, to);
    else if (status)
      status = base::fail(base::ErrorKind::internal, "the copy differs from the file; check the disk", to.string());
  }
  std::error_code ignored;
  fs::remove(temporary, ignored);
  if (!status) return base::forward_error(status);
  if (found->sha256 == sha256) return std::nullopt;
  if (!found->unreadable.empty()) return "at the station: " + found->unreadable;
  return fmt::format("damaged at the station: its SHA-256 is {}, the catalog says {}", found->sha256, sha256);
}

/// False where that cannot be known.
bool are_on_same_file_system(const fs::path& one, const fs::path& other) {
  struct stat of_one{};
  struct stat of_other{};
  return ::stat(one.c_str(), &of_one) == 0 && ::stat(other.c_str(), &of_other) == 0 && of_one.st_dev == of_other.st_dev;
}

class Backup {
 public:
  Backup(const db::Catalog& catalog, fs::path folder, const std::function<bool(double)>& progress)
      : catalog_(catalog), folder_(std::move(folder)), progress_(progress) {}

  base::Result<BackupSummary> run() {
    if (auto free = check_folder(); !free) return base::forward_error(free);
    if (auto earlier = check_earlier_backup(); !earlier) return base::forward_error(earlier);
    if (auto made = db::create_folders_durably(folder_ / "runs"); !made) return base::forward_error(made);
    summary_.on_same_disk = are_on_same_file_system(folder_ / "runs", catalog_.data_folder() / "runs");
    const auto lock = FolderLock::take(folder_ / "backup.lock", "soak backup");
    if (!lock) return base::forward_error(lock);
    if (auto copied = copy_catalog(); !copied) return base::forward_error(copied);
    const auto status = copy_runs();
    std::error_code ignored;
    if (!status) {
      fs::remove_all(staging(), ignored);
      return base::forward_error(status);
    }
    if (auto named = db::rename_durably(staging() / "station.db", folder_ / "station.db"); !named) {
      return base::forward_error(named);
    }
    fs::remove_all(staging(), ignored);
    return std::move(summary_);
  }

 private:
  /// Where the new catalog waits for its run files.
  [[nodiscard]] fs::path staging() const { return folder_ / "backup.new"; }

  [[nodiscard]] base::Status check_folder() const {
    std::error_code ignored;
    if (fs::equivalent(folder_, catalog_.data_folder(), ignored)) {
      return base::bad_input("is the data folder itself: name another one, on another disk", folder_.string());
    }
    return {};
  }

  /// A catalog that is there must be an earlier state of ours: the end of its event log is in our log.
  [[nodiscard]] base::Status check_earlier_backup() const {
    std::error_code ignored;
    if (!fs::exists(folder_ / "station.db", ignored)) return {};
    const auto earlier = db::Catalog::open_unchanged(folder_);
    if (!earlier) return base::forward_error(earlier);
    const auto end = earlier->check_events();
    if (!end) return base::forward_error(end);
    const auto events = catalog_.events();
    if (!events) return base::forward_error(events);
    const bool ours = end->events == 0 ||
                      (end->events <= events->size() && (*events)[end->events - 1].chain_sha256 == end->end_sha256);
    if (ours) return {};
    return base::bad_input(
        "holds the catalog of another station, or one that was changed after it was backed up; it is left as it is: "
        "name another folder",
        folder_.string());
  }

  base::Status copy_catalog() {
    std::error_code ignored;
    fs::remove_all(staging(), ignored);  // of a backup that was interrupted
    if (auto made = db::create_folders_durably(staging()); !made) return made;
    if (auto copied = catalog_.copy_to(staging() / "station.db"); !copied) return copied;
    const auto copy = db::Catalog::open_unchanged(staging());
    if (!copy) return base::forward_error(copy);
    if (auto sound = copy->verify(); !sound) return sound;
    const auto events = copy->check_events();
    if (!events) return base::forward_error(events);
    summary_.events = *events;
    auto runs = copy->runs({});
    if (!runs) return base::forward_error(runs);
    for (const db::RunRow& run : *runs) {
      if (auto sound = copy->check_numbers(run); !sound) return sound;
      if (run.samples_dropped) continue;
      if (run.sealed) files_.emplace(run.file_name, run.file_sha256);
      if (!run.sealed) summary_.still_open.push_back({run.file_name, "not sealed yet"});
    }
    return {};
  }

  base::Status copy_runs() {
    std::size_t done = 0;
    for (const auto& [name, sha256] : files_) {
      if (progress_ && !progress_(static_cast<double>(done++) / static_cast<double>(files_.size()))) {
        return interrupted_at(folder_);
      }
      if (auto status = take_run_file(name, sha256); !status) return status;
    }
    const auto orphans = db::orphan_run_files(catalog_);
    if (!orphans) return base::forward_error(orphans);
    for (const db::OrphanRunFile& orphan : *orphans) {
      const std::string name = orphan.path.filename().string();
      if (files_.contains(name)) continue;
      summary_.still_open.push_back({name, orphan.sealed ? "not in the catalog yet" : "not sealed yet"});
    }
    return {};
  }

  /// The copied catalog is older than what somebody may have dropped since.
  [[nodiscard]] base::Result<bool> was_dropped_meanwhile(const std::string& name) const {
    const auto runs = catalog_.runs({});
    if (!runs) return base::forward_error(runs);
    return std::ranges::any_of(*runs,
                               [&](const db::RunRow& run) { return run.file_name == name && run.samples_dropped; });
  }

  base::Status take_run_file(const std::string& name, const std::string& sha256) {
    const fs::path from = catalog_.data_folder() / "runs" / name;
    const fs::path to = folder_ / "runs" / name;
    std::error_code ignored;
    if (fs::exists(to, ignored)) {
      const auto there = read_through(to, -1, {});
      if (!there) return base::forward_error(there);
      if (there->sha256 == sha256) {
        summary_.kept.push_back(name);
      } else {
        const std::string what = there->unreadable.empty() ? "damaged" : there->unreadable;
        summary_.damaged.push_back(
            {name, "in the backup, where it is left as it is: " + what + "; move it away, then back up again"});
      }
      return {};
    }
    if (!fs::exists(from, ignored)) {
      const auto dropped = was_dropped_meanwhile(name);
      if (!dropped) return base::forward_error(dropped);
      auto& list = *dropped ? summary_.still_open : summary_.damaged;
      list.push_back({name, *dropped ? "its samples were dropped meanwhile" : "missing at the station"});
      return {};
    }
    const auto damage = copy_run_file(from, to, sha256);
    if (!damage) return base::forward_error(damage);
    if (*damage) {
      summary_.damaged.push_back({name, **damage});
      return {};
    }
    summary_.copied.push_back(name);
    summary_.copied_bytes += fs::file_size(to, ignored);
    return {};
  }

  const db::Catalog& catalog_;
  fs::path folder_;
  const std::function<bool(double)>& progress_;
  std::map<std::string, std::string> files_;  ///< SHA-256 of the sealed run files, by name
  BackupSummary summary_;
};

}  // namespace

base::Result<BackupSummary> back_up(const db::Catalog& catalog, const fs::path& folder,
                                    const std::function<bool(double)>& progress) {
  return Backup(catalog, folder, progress).run();
}

}  // namespace soak::station
