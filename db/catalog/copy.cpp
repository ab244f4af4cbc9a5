// SPDX-License-Identifier: Apache-2.0
#include <SQLiteCpp/Backup.h>
#include <SQLiteCpp/Exception.h>
#include <sqlite3.h>

#include <string>

#include "db/catalog/detail/impl.h"
#include "db/detail/sqlite.h"
#include "db/durable.h"

namespace soak::db {
namespace {

/// All pages in one go: one state of the catalog, while writers go on in its -wal file.
base::Status copy_pages(const sqlite::Connection& source, const sqlite::Connection& target) {
  return source.run("copy the catalog", [&]() -> base::Status {
    SQLite::Backup backup(target.database(), source.database());
    if (const int code = backup.executeStep(-1); code != SQLITE_DONE) {
      return base::fail(base::ErrorKind::internal,
                        std::string("cannot copy the catalog: ") + sqlite3_errstr(code) + "; try again",
                        source.path().string());
    }
    return {};
  });
}

/// Makes it one file, which needs no other beside it to be read.
base::Status leave_wal(const sqlite::Connection& copy) {
  return copy.run("finish the copy", [&]() -> base::Status {
    copy.database().execAndGet("PRAGMA journal_mode = DELETE");
    return {};
  });
}

base::Status write_copy(const sqlite::Connection& source, const std::filesystem::path& file) {
  const auto target = sqlite::Connection::open(file, sqlite::Access::read_write);
  if (!target) return base::forward_error(target);
  if (auto copied = copy_pages(source, *target); !copied) return copied;
  return leave_wal(*target);
}

}  // namespace

base::Status Catalog::copy_to(const std::filesystem::path& file) const {
  if (const auto created = sqlite::create_exclusively(file); !created) return created;
  base::Status status = write_copy(impl_->connection, file);
  if (status) status = sync_to_disk(file);
  if (status) status = sync_name(file);
  if (!status) sqlite::remove_with_companions(file);
  return status;
}

}  // namespace soak::db
