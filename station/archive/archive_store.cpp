// SPDX-License-Identifier: Apache-2.0
#include "station/archive/archive_store.h"

#include <fmt/format.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <system_error>
#include <utility>
#include <vector>

#include "base/hash.h"
#include "base/text.h"
#include "db/durable.h"
#include "station/io/host.h"
#include "station/jobs/child.h"

namespace soak::station {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kOnItsWay = ".tmp-";

/// Anything else is on its way, or of the file server's own.
bool is_archived_name(std::string_view name) {
  const auto dot = name.find('.');
  if (dot == std::string_view::npos || !base::bytes_of_hex<32>(name.substr(0, dot))) return false;
  return name.substr(dot) == ".json" || name.substr(dot) == ".soakrun";
}

class FolderStore final : public ArchiveStore {
 public:
  explicit FolderStore(fs::path folder) : folder_(std::move(folder)) {}

  std::string place() const override { return folder_.string(); }
  std::optional<fs::path> local_path(const std::string& name) const override { return folder_ / name; }

  base::Result<std::set<std::string>> list(const std::string& folder) const override {
    std::set<std::string> names;
    std::error_code error;
    if (!fs::exists(folder_ / folder, error) && !error) return names;
    for (fs::directory_iterator entry(folder_ / folder, error); !error && entry != fs::end(entry);
         entry.increment(error)) {
      std::string name = entry->path().filename().string();
      if (is_archived_name(name) && entry->is_regular_file(error)) names.insert(std::move(name));
    }
    if (error) return failed("list the archive", error, folder_ / folder);
    return names;
  }

  base::Status put(const fs::path& file, const std::string& name, const std::string& sha256) override {
    const fs::path target = folder_ / name;
    if (auto made = db::create_folders_durably(target.parent_path()); !made) return made;
    // Two stations may put the same file at once: each under a name of its own, until it is whole.
    const fs::path temporary = target.string() + std::string(kOnItsWay) + new_run_id();
    std::error_code error;
    fs::copy_file(file, temporary, error);
    base::Status status;
    if (error) status = failed("write into the archive", error, target);
    if (status) status = check_copy(temporary, sha256);
    if (status) status = db::rename_durably(temporary, target);
    if (!status) fs::remove(temporary, error);
    return status;
  }

  base::Status get(const std::string& name, const fs::path& file) const override {
    std::error_code error;
    fs::copy_file(folder_ / name, file, fs::copy_options::overwrite_existing, error);
    if (error) return failed("read from the archive", error, folder_ / name);
    return {};
  }

 private:
  static base::Status check_copy(const fs::path& copy, const std::string& sha256) {
    const auto arrived = file_sha256(copy);
    if (!arrived) return base::forward_error(arrived);
    if (*arrived == sha256) return {};
    return base::fail(base::ErrorKind::internal, "the copy differs from the file; check the disk", copy.string());
  }
  static tl::unexpected<base::Error> failed(std::string_view doing, const std::error_code& error,
                                            const fs::path& path) {
    return base::fail(base::ErrorKind::internal, fmt::format("cannot {}: {}", doing, error.message()), path.string());
  }

  fs::path folder_;
};

/// Each call is a process of rclone, which tries again by itself and compares hashes where the remote has them.
class RcloneStore final : public ArchiveStore {
 public:
  RcloneStore(fs::path program, std::string remote) : program_(std::move(program)), remote_(std::move(remote)) {}

  std::string place() const override { return remote_; }
  std::optional<fs::path> local_path(const std::string& /*name*/) const override { return std::nullopt; }

  base::Result<std::set<std::string>> list(const std::string& folder) const override {
    const auto end = call({"lsf", "--files-only", at(folder)});
    if (!end) return base::forward_error(end);
    // rclone's exit status 3: the folder is not there.
    if (end->exit_status == 3) return std::set<std::string>();
    if (end->exit_status != 0 || !end->is_whole) return failed(*end, folder);
    std::set<std::string> names;
    std::istringstream lines(end->output);
    for (std::string line; std::getline(lines, line);) {
      if (is_archived_name(line)) names.insert(line);
    }
    return names;
  }

  base::Status put(const fs::path& file, const std::string& name, const std::string& /*sha256*/) override {
    return copy(file.string(), at(name));
  }

  base::Status get(const std::string& name, const fs::path& file) const override {
    return copy(at(name), file.string());
  }

 private:
  [[nodiscard]] std::string at(const std::string& name) const {
    return remote_ + (remote_.ends_with(':') || remote_.ends_with('/') ? "" : "/") + name;
  }

  [[nodiscard]] base::Status copy(const std::string& from, const std::string& to) const {
    // The scratch file of a call before may have the same size and time, which rclone takes for the same content.
    const auto end = call({"copyto", "--ignore-times", from, to});
    if (!end) return base::forward_error(end);
    if (end->exit_status != 0) return failed(*end, to);
    return {};
  }

  [[nodiscard]] base::Result<ChildEnd> call(std::vector<std::string> arguments) const {
    const std::atomic<bool> stop = false;
    return run_child({program_, std::move(arguments), user_name()}, stop);
  }

  static tl::unexpected<base::Error> failed(const ChildEnd& end, const std::string& what) {
    return base::fail(base::ErrorKind::internal,
                      fmt::format("rclone failed (exit status {}): {}", end.exit_status, end.errors), what);
  }

  fs::path program_;
  std::string remote_;
};

/// The program of that name in $PATH; empty where there is none.
fs::path program_named(const std::string& name) {
  const char* path = std::getenv("PATH");
  std::istringstream folders(path != nullptr ? path : "");
  for (std::string folder; std::getline(folders, folder, ':');) {
    const fs::path program = fs::path(folder) / name;
    if (::access(program.c_str(), X_OK) == 0) return program;
  }
  return {};
}

}  // namespace

base::Result<std::string> file_sha256(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::vector<char> block(std::size_t{1} << 20);
  base::Sha256 hash;
  while (in) {
    in.read(block.data(), static_cast<std::streamsize>(block.size()));
    hash.update(std::string_view(block.data(), static_cast<std::size_t>(in.gcount())));
  }
  if (in.eof()) return base::to_hex(hash.finish());
  return base::fail(base::ErrorKind::internal, "cannot read the file: " + std::generic_category().message(errno),
                    file.string());
}

base::Result<std::unique_ptr<ArchiveStore>> archive_store(const std::string& place) {
  const auto colon = place.find(':');
  // As rclone itself tells them apart: no remote's name has a slash.
  if (colon == std::string::npos || place.find('/') < colon) return std::make_unique<FolderStore>(place);
  fs::path program = program_named("rclone");
  if (program.empty()) {
    return base::bad_input(
        "a name with a colon is a remote of rclone, which is not installed: install Debian's package rclone, or name a "
        "folder",
        place);
  }
  return std::make_unique<RcloneStore>(std::move(program), place);
}

}  // namespace soak::station
