// SPDX-License-Identifier: Apache-2.0
#include <SQLiteCpp/Column.h>
#include <SQLiteCpp/Exception.h>
#include <SQLiteCpp/Statement.h>
#include <SQLiteCpp/Transaction.h>
#include <sqlite3.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <random>
#include <set>
#include <system_error>
#include <thread>
#include <utility>

#include "base/text.h"
#include "db/catalog/detail/impl.h"
#include "db/catalog/detail/seals.h"
#include "db/detail/schema.h"
#include "db/durable.h"

namespace soak::db {
namespace {

base::Status make_folders(const std::filesystem::path& folder) {
  const auto made = create_folders_durably(folder / "runs");
  if (made) return {};
  return base::fail(base::ErrorKind::internal, made.error().message + ", or use another data folder", folder.string());
}

base::Status check_kind(const sqlite::Identity& identity, const std::filesystem::path& path) {
  return schema::check_identity(identity, schema::kStationApplicationId, Catalog::kSchemaVersion, "station catalog",
                                path);
}

/// Refuses what is no catalog, or one that is too new. A file without any table is a new one.
base::Status check_catalog_identity(const sqlite::Connection& connection) {
  // One transaction, as another process may be making the catalog between the readings.
  base::Result<sqlite::Identity> identity;
  const auto tables = connection.run("read the catalog", [&]() -> base::Result<int> {
    SQLite::Transaction snapshot(connection.database());
    const int count = connection.database().execAndGet("SELECT count(*) FROM sqlite_master").getInt();
    identity = connection.identity();
    return count;
  });
  if (!tables) return base::forward_error(tables);
  if (!identity) return base::forward_error(identity);
  if (*tables == 0 && identity->application_id == 0 && identity->user_version == 0) return {};
  return check_kind(*identity, connection.path());
}

/// Switches to WAL. SQLite does not wait by itself for another process that is switching the same new file, so this
/// does.
void enter_wal(SQLite::Database& database) {
  constexpr int kTries = 500;
  constexpr auto kPause = std::chrono::milliseconds(20);
  for (int i = 1;; ++i) {
    try {
      database.exec("PRAGMA journal_mode = WAL");
      return;
    } catch (const SQLite::Exception& exception) {
      if (exception.getErrorCode() != SQLITE_BUSY || i == kTries) throw;
    }
    std::this_thread::sleep_for(kPause);
  }
}

base::Status prepare(const sqlite::Connection& connection) {
  auto wal = connection.run("open the catalog", [&]() -> base::Status {
    enter_wal(connection.database());
    // FULL: rows must not be lost with the power once the caller has been told that they are stored.
    connection.database().exec("PRAGMA synchronous = FULL");
    return {};
  });
  if (!wal) return wal;
  return schema::migrate(connection, schema::station_steps(), schema::kStationApplicationId);
}

/// Whether nobody may write here: a read-only medium, an archive whose owner took the right to write away.
bool is_read_only(const std::filesystem::path& data_folder) {
  const std::filesystem::path file = data_folder / "station.db";
  const auto refused = [](const std::filesystem::path& path) {
    return ::access(path.c_str(), W_OK) != 0 && (errno == EROFS || errno == EACCES);
  };
  return refused(file) || refused(data_folder);
}

/// A catalog that can only be read. SQLite's log beside it may hold rows that only a writer can bring in.
base::Result<sqlite::Connection> open_archive(const std::filesystem::path& path, std::uint32_t version) {
  std::error_code ignored;
  const auto log_bytes = std::filesystem::file_size(std::filesystem::path(path) += "-wal", ignored);
  if (!ignored && log_bytes > 0) {
    return base::bad_input(
        "the data folder can only be read, and station.db-wal holds rows that are not in station.db yet; copy the "
        "folder to where it can be written and use the copy",
        path.string());
  }
  if (version != Catalog::kSchemaVersion) {
    return base::bad_input("the data folder can only be read, and its catalog has version " + std::to_string(version) +
                               "; copy the folder to where it can be written, which brings it to version " +
                               std::to_string(Catalog::kSchemaVersion),
                           path.string());
  }
  return sqlite::Connection::open(path, sqlite::Access::immutable);
}

/// Throws SQLite::Exception.
base::Status check_foreign_keys(const sqlite::Connection& connection) {
  SQLite::Statement check(connection.database(), "PRAGMA foreign_key_check");
  if (!check.executeStep()) return {};
  return base::corrupt("a row of table '" + check.getColumn(0).getString() + "' refers to a missing row of '" +
                           check.getColumn(2).getString() + "'; restore the catalog from a backup",
                       connection.path().string());
}

base::Status add_functions(const sqlite::Connection& connection) {
  return connection.run("open the catalog", [&]() -> base::Status {
    catalog::add_seal_function(connection.database());
    return {};
  });
}

/// Names of all run files in a folder.
base::Result<std::set<std::string>> run_files_in(const std::filesystem::path& folder) {
  std::set<std::string> names;
  std::error_code error;
  for (std::filesystem::directory_iterator entry(folder, error); !error && entry != std::filesystem::end(entry);
       entry.increment(error)) {
    if (entry->path().extension() == ".soakrun") names.insert(entry->path().filename().string());
  }
  if (!error) return names;
  return base::fail(base::ErrorKind::internal, "cannot list the run files: " + error.message(), folder.string());
}

OrphanRunFile orphan_at(std::filesystem::path path) {
  OrphanRunFile orphan;
  orphan.path = std::move(path);
  const auto file = RunFileReader::open(orphan.path);
  if (!file) {
    orphan.problem = file.error().message;
    return orphan;
  }
  orphan.sealed = file->sealed();
  orphan.info = file->info();
  for (const StreamInfo& stream : file->streams()) {
    const bool known = std::find(orphan.units.begin(), orphan.units.end(), stream.unit) != orphan.units.end();
    if (!stream.unit.empty() && !known) orphan.units.push_back(stream.unit);
  }
  return orphan;
}

}  // namespace

namespace catalog {

double now_utc_s() {
  return std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count();
}

std::string new_uuid(double utc_s) {
  std::random_device device;
  const auto word = [&device] { return (std::uint64_t{device()} << 32) | device(); };
  const double unix_ms = utc_s > 0.0 ? utc_s * 1e3 : 0.0;
  return base::uuid_v7(static_cast<std::uint64_t>(unix_ms), word(), word());
}

}  // namespace catalog

Catalog::Catalog(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Catalog::Catalog(Catalog&&) noexcept = default;
Catalog& Catalog::operator=(Catalog&&) noexcept = default;
Catalog::~Catalog() = default;

base::Result<Catalog> Catalog::open(const std::filesystem::path& data_folder) {
  const auto path = data_folder / "station.db";
  const auto header = sqlite::read_header(path);
  if (!header) return base::forward_error(header);
  // Before SQLite has it, which empties a -wal file that a crash has left: what is refused is not touched.
  if (!header->empty && header->identity.application_id != 0) {
    const auto ours = check_kind(header->identity, path);
    if (!ours) return base::forward_error(ours);
  }
  if (!header->empty && is_read_only(data_folder)) return open_unchanged(data_folder);
  if (const auto made = make_folders(data_folder); !made) return base::forward_error(made);
  auto connection = sqlite::Connection::open(path, sqlite::Access::read_write);
  if (!connection) return base::forward_error(connection);
  if (const auto ours = check_catalog_identity(*connection); !ours) return base::forward_error(ours);
  if (const auto added = add_functions(*connection); !added) return base::forward_error(added);
  if (const auto prepared = prepare(*connection); !prepared) return base::forward_error(prepared);
  return Catalog(std::make_unique<Impl>(data_folder, std::move(*connection)));
}

base::Result<Catalog> Catalog::open_unchanged(const std::filesystem::path& data_folder) {
  const auto path = data_folder / "station.db";
  const auto header = sqlite::read_header(path);
  if (!header) return base::forward_error(header);
  if (const auto ours = check_kind(header->identity, path); !ours) return base::forward_error(ours);
  auto archive = open_archive(path, header->identity.user_version);
  if (!archive) return base::forward_error(archive);
  if (const auto added = add_functions(*archive); !added) return base::forward_error(added);
  Catalog catalog(std::make_unique<Impl>(data_folder, *std::move(archive)));
  catalog.impl_->read_only = true;
  return catalog;
}

const std::filesystem::path& Catalog::data_folder() const { return impl_->data_folder; }

bool Catalog::read_only() const { return impl_->read_only; }

std::filesystem::path Catalog::run_file_path(const RunRow& run) const {
  return impl_->data_folder / "runs" / run.file_name;
}

base::Status Catalog::all_or_nothing(const std::function<base::Status()>& work) {
  return impl_->connection.transact("change the catalog", [&]() -> base::Status { return work(); });
}

base::Status Catalog::verify() const {
  if (const auto whole = impl_->connection.integrity_check(); !whole) return whole;
  return impl_->connection.snapshot("check the catalog", [&]() -> base::Status {
    if (auto schema = catalog::check_schema(impl_->connection); !schema) return schema;
    if (auto referred = check_foreign_keys(impl_->connection); !referred) return referred;
    if (auto sealed = catalog::check_all_seals(impl_->connection); !sealed) return sealed;
    const auto chained = check_events();
    return chained ? base::Status() : base::Status(base::forward_error(chained));
  });
}

base::Result<std::vector<OrphanRunFile>> orphan_run_files(const Catalog& catalog) {
  const std::filesystem::path folder = catalog.data_folder() / "runs";
  // Files first: one that is entered meanwhile then is in the catalog's answer.
  auto names = run_files_in(folder);
  if (!names) return base::forward_error(names);
  const auto runs = catalog.runs({});
  if (!runs) return base::forward_error(runs);
  for (const RunRow& run : *runs) names->erase(run.file_name);
  std::vector<OrphanRunFile> orphans;
  for (const std::string& name : *names) orphans.push_back(orphan_at(folder / name));
  return orphans;
}

}  // namespace soak::db
