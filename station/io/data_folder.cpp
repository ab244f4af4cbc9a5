// SPDX-License-Identifier: Apache-2.0
#include "station/io/data_folder.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdlib>
#include <string>
#include <system_error>

namespace soak::station {
namespace {

std::string environment(const char* name) {
  const char* value = std::getenv(name);
  return value != nullptr ? value : "";
}

/// Device and inode; nothing where nothing is there.
std::optional<std::pair<std::uint64_t, std::uint64_t>> node_of(const std::filesystem::path& path) {
  struct stat found{};
  if (::stat(path.c_str(), &found) != 0) return std::nullopt;
  return std::pair<std::uint64_t, std::uint64_t>{found.st_dev, found.st_ino};
}

/// What the process that holds the lock file has written into it: its number, a line end, its address.
FolderLock::Holder holder_of(int fd) {
  std::array<char, 300> buffer{};
  const ssize_t read = ::pread(fd, buffer.data(), buffer.size() - 1, 0);
  if (read <= 0) return {.process = "unknown", .address = {}};
  const std::string text(buffer.data());
  const auto line_end = text.find('\n');
  return {text.substr(0, line_end), line_end == std::string::npos ? "" : text.substr(line_end + 1)};
}

/// A data folder that has a catalog.
base::Result<std::filesystem::path> existing_data_folder(std::string_view data_option) {
  const auto folder = data_folder(data_option);
  if (!folder) return base::forward_error(folder);
  std::error_code ignored;
  if (std::filesystem::exists(*folder / "station.db", ignored)) return *folder;
  return base::bad_input(
      "the data folder has no station.db: import a recording first, or name the right folder with --data or "
      "SOAK_DATA",
      folder->string());
}

}  // namespace

base::Result<std::filesystem::path> data_folder(std::string_view option) {
  if (!option.empty()) return std::filesystem::path(option);
  if (std::string folder = environment("SOAK_DATA"); !folder.empty()) return folder;
  if (const std::string folder = environment("XDG_DATA_HOME"); !folder.empty()) {
    return std::filesystem::path(folder) / "soak";
  }
  if (const std::string home = environment("HOME"); !home.empty()) {
    return std::filesystem::path(home) / ".local" / "share" / "soak";
  }
  return base::bad_input("no data folder was given: use --data DIR or set SOAK_DATA", "--data");
}

base::Result<db::Catalog> open_catalog(std::string_view data_option) {
  const auto folder = data_folder(data_option);
  if (!folder) return base::forward_error(folder);
  return db::Catalog::open(*folder);
}

base::Result<db::Catalog> open_existing_catalog(std::string_view data_option) {
  const auto folder = existing_data_folder(data_option);
  if (!folder) return base::forward_error(folder);
  return db::Catalog::open(*folder);
}

base::Result<db::Catalog> open_unchanged_catalog(std::string_view data_option) {
  const auto folder = existing_data_folder(data_option);
  if (!folder) return base::forward_error(folder);
  std::error_code error;
  const auto log_bytes = std::filesystem::file_size(*folder / "station.db-wal", error);
  if (!error && log_bytes > 0) {
    return base::bad_input(
        "this data folder is being written: give a copy of it that nobody writes; 'soak backup DIR' makes one",
        folder->string());
  }
  return db::Catalog::open_unchanged(*folder);
}

base::Result<db::Catalog> reopen_catalog(const std::filesystem::path& folder) {
  std::error_code ignored;
  if (std::filesystem::exists(folder / "station.db", ignored)) return db::Catalog::open(folder);
  return base::fail(
      base::ErrorKind::internal,
      fmt::format("the data folder {} is gone (unmounted, deleted or moved?): bring it back", folder.string()),
      kNoFolder);
}

base::Result<db::RunRow> find_run(const db::Catalog& catalog, const db::RunFilter& filter) {
  auto runs = catalog.runs(filter);
  if (!runs) return base::forward_error(runs);
  if (runs->size() == 1) return std::move(runs->front());
  const std::string name = filter.run.value_or("");
  if (runs->empty()) {
    return base::bad_input(fmt::format("unknown run '{}': 'soak runs list' shows run ids and labels", name),
                           catalog.data_folder().string());
  }
  std::string candidates;
  for (const db::RunRow& run : *runs) {
    candidates += fmt::format("\n  {}  unit {}, campaign {}, run {}", run.run_id, run.unit, run.campaign, run.label);
  }
  return base::bad_input(
      fmt::format("'{}' matches {} runs: give the run id, or --unit and --campaign{}", name, runs->size(), candidates),
      catalog.data_folder().string());
}

base::Result<db::UnitRow> find_unit(const db::Catalog& catalog, const std::string& serial) {
  auto unit = catalog.unit(serial);
  if (!unit) return base::forward_error(unit);
  if (*unit) return **std::move(unit);
  return base::bad_input(fmt::format("unknown unit '{}': 'soak unit list' shows all", serial),
                         catalog.data_folder().string());
}

OpenedFolder::OpenedFolder(const std::filesystem::path& folder) {
  for (const auto& path : {folder, folder / "runs", folder / "station.db"}) places_.push_back({path, node_of(path)});
}

std::string OpenedFolder::trouble() const {
  for (const Place& place : places_) {
    const auto node = node_of(place.path);
    if (node && node == place.node) continue;
    return fmt::format("the data folder is not the one that was opened: {} {} (unmounted, deleted or replaced?)",
                       place.path.string(), node ? "is another one" : "is gone");
  }
  return {};
}

base::Result<FolderLock> FolderLock::take(const std::filesystem::path& file, std::string_view what) {
  base::FileDescriptor lock(::open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644));
  if (!lock) {
    return base::bad_input("cannot write: " + std::generic_category().message(errno), file.string());
  }
  if (::flock(lock.get(), LOCK_EX | LOCK_NB) != 0) {
    return base::bad_input(
        fmt::format("another {} (process {}) is using this data folder: stop it, or name another folder with --data",
                    what, holder_of(lock.get()).process),
        file.parent_path().string());
  }
  const std::string process = fmt::format("{}", ::getpid());
  if (::ftruncate(lock.get(), 0) != 0 ||
      ::pwrite(lock.get(), process.data(), process.size(), 0) != static_cast<ssize_t>(process.size())) {
    return base::bad_input("cannot write: " + std::generic_category().message(errno), file.string());
  }
  return FolderLock(std::move(lock));
}

std::optional<FolderLock::Holder> FolderLock::holder(const std::filesystem::path& file) {
  const base::FileDescriptor lock(::open(file.c_str(), O_RDONLY | O_CLOEXEC));
  if (!lock || ::flock(lock.get(), LOCK_EX | LOCK_NB) == 0 || errno != EWOULDBLOCK) return std::nullopt;
  return holder_of(lock.get());
}

void FolderLock::note_address(std::string_view address) const {
  const std::string text = fmt::format("{}\n{}", ::getpid(), address);
  (void)!::pwrite(file_.get(), text.data(), text.size(), 0);
}

}  // namespace soak::station
