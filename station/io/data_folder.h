// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/file_descriptor.h"
#include "base/result.h"
#include "db/catalog/catalog.h"

namespace soak::station {

/// The data folder: `option` (--data) if not empty, else $SOAK_DATA, else $XDG_DATA_HOME/soak, else
/// ~/.local/share/soak.
[[nodiscard]] base::Result<std::filesystem::path> data_folder(std::string_view option);

/// Opens the catalog of the data folder, which is created where it is new.
[[nodiscard]] base::Result<db::Catalog> open_catalog(std::string_view data_option);

/// Opens the catalog of an existing data folder: a mistyped folder must not look like an empty one.
[[nodiscard]] base::Result<db::Catalog> open_existing_catalog(std::string_view data_option);

/// Opens the catalog of a data folder that nobody writes, as a backup is, without changing it: any number of machines
/// may do so at once. Refuses (bad_input) one that a program has open, as far as that shows.
[[nodiscard]] base::Result<db::Catalog> open_unchanged_catalog(std::string_view data_option);

/// `where` of the refusal of what cannot be done while the data folder is not there.
inline constexpr const char* kNoFolder = "data";

/// Opens the catalog of a folder once more that a long-lived program works with. A folder that has gone (a disk that
/// was unmounted) is the world's failure (internal, where == kNoFolder), and is not made anew in its place.
[[nodiscard]] base::Result<db::Catalog> reopen_catalog(const std::filesystem::path& folder);

/// The one run that `text` names: run id, unique beginning of one, or label. Fails (bad_input) for none and for
/// several, listing them.
[[nodiscard]] base::Result<db::RunRow> find_run(const db::Catalog& catalog, const db::RunFilter& filter);

/// The unit with that serial number; fails (bad_input) if there is none.
[[nodiscard]] base::Result<db::UnitRow> find_unit(const db::Catalog& catalog, const std::string& serial);

/// A data folder that a program has open: whether what is there now is still that. Files of a folder that was
/// unmounted, deleted or replaced can be written to all the same, and nobody finds again what is in them.
class OpenedFolder {
 public:
  /// Remembers what is there now: the folder, `runs` in it, and the catalog.
  explicit OpenedFolder(const std::filesystem::path& folder);
  /// What is gone or is another one now; empty where nothing is.
  [[nodiscard]] std::string trouble() const;

 private:
  struct Place {
    std::filesystem::path path;
    std::optional<std::pair<std::uint64_t, std::uint64_t>> node;  ///< device and inode; nothing where none was there
  };
  std::vector<Place> places_;
};

/// Keeps a second process of the same kind out of a folder. The operating system lets go of it when the process ends,
/// however that happens; the file itself stays.
class FolderLock {
 public:
  /// Takes the lock of `file`, which is created where it is missing. Fails (bad_input) if another process holds it, and
  /// names that process. `what` is the program's name for the message.
  [[nodiscard]] static base::Result<FolderLock> take(const std::filesystem::path& file, std::string_view what);

  /// Who holds a lock.
  struct Holder {
    std::string process;  ///< its number
    std::string address;  ///< that it noted; empty = none
  };
  /// The process that holds the lock of `file`; nothing where nobody does or there is no such file. Writes nothing.
  [[nodiscard]] static std::optional<Holder> holder(const std::filesystem::path& file);

  /// Lets holder() tell where the process can be reached. One that cannot be written is left out.
  void note_address(std::string_view address) const;

 private:
  explicit FolderLock(base::FileDescriptor file) : file_(std::move(file)) {}
  base::FileDescriptor file_;
};

}  // namespace soak::station
