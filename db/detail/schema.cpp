// SPDX-License-Identifier: Apache-2.0
#include "db/detail/schema.h"

#include <string>

namespace soak::db::schema {

/// docs/file-formats.md is the description of this text.
const char* const kRunFileSql = R"sql(
CREATE TABLE meta (
  key   TEXT PRIMARY KEY,
  value TEXT NOT NULL
) WITHOUT ROWID;

-- A table of samples on one time axis: of one unit, or of the chamber (unit_serial is empty).
CREATE TABLE stream (
  id          INTEGER PRIMARY KEY,
  name        TEXT NOT NULL,
  unit_serial TEXT NOT NULL,
  UNIQUE (name, unit_serial)
);

-- value in `unit` = scale * number + offset. The first channel of a stream is its time axis t_s.
CREATE TABLE channel (
  id          INTEGER PRIMARY KEY,
  stream_id   INTEGER NOT NULL REFERENCES stream (id),
  position    INTEGER NOT NULL,      -- 0, 1, 2, ... within the stream
  name        TEXT NOT NULL,
  source_name TEXT NOT NULL,
  type        TEXT NOT NULL,         -- i8 u8 i16 u16 i32 u32 i64 f32 f64
  unit        TEXT NOT NULL,
  scale       REAL NOT NULL,
  offset      REAL NOT NULL,
  labels      TEXT NOT NULL,         -- JSON array: the text that each number stands for
  UNIQUE (stream_id, position),
  UNIQUE (stream_id, name)
);

-- Rows first_row ... first_row + row_count - 1 of one channel. codec and bytes: docs/file-formats.md.
CREATE TABLE chunk (
  id          INTEGER PRIMARY KEY,
  channel_id  INTEGER NOT NULL REFERENCES channel (id),
  first_row   INTEGER NOT NULL,
  row_count   INTEGER NOT NULL,
  value_count INTEGER NOT NULL,      -- rows that have a value
  codec       TEXT NOT NULL,
  crc32c      INTEGER NOT NULL,
  presence    BLOB,                  -- NULL = every row has a value
  data        BLOB NOT NULL
);
CREATE UNIQUE INDEX chunk_by_row ON chunk (channel_id, first_row, row_count);

-- Bin b of level l covers rows b * 512 * 8^l and the next 512 * 8^l - 1. Values in the channel's unit, over the finite
-- ones of its rows; a bin without any has no row here. Times are those of the bin's first and last row.
CREATE TABLE pyramid (
  channel_id INTEGER NOT NULL REFERENCES channel (id),
  level      INTEGER NOT NULL,
  bin        INTEGER NOT NULL,
  t_first_s  REAL NOT NULL,
  t_last_s   REAL NOT NULL,
  count      INTEGER NOT NULL,
  minimum    REAL NOT NULL,
  mean       REAL NOT NULL,
  maximum    REAL NOT NULL,
  PRIMARY KEY (channel_id, level, bin)
) WITHOUT ROWID;

CREATE TABLE event (
  id   INTEGER PRIMARY KEY,
  t_s  REAL NOT NULL,
  kind TEXT NOT NULL,
  text TEXT NOT NULL
);

-- One line per channel; minimum, mean and maximum of a sealed file are those of the whole run.
CREATE VIEW summary AS
SELECT stream.name AS stream, stream.unit_serial AS unit_serial, channel.name AS channel, channel.type AS type,
       channel.unit AS unit, stored.row_count AS row_count, stored.value_count AS value_count,
       top.minimum AS minimum, top.mean AS mean, top.maximum AS maximum, stored.bytes AS stored_bytes
FROM channel
JOIN stream ON stream.id = channel.stream_id
LEFT JOIN (SELECT channel_id, sum(row_count) AS row_count, sum(value_count) AS value_count,
                  sum(length(data) + coalesce(length(presence), 0)) AS bytes
           FROM chunk GROUP BY channel_id) AS stored ON stored.channel_id = channel.id
LEFT JOIN (SELECT channel_id, max(level) AS level, minimum, mean, maximum
           FROM pyramid GROUP BY channel_id) AS top ON top.channel_id = channel.id
ORDER BY channel.stream_id, channel.position;

-- The pyramid with names instead of numbers.
CREATE VIEW plot AS
SELECT stream.name AS stream, stream.unit_serial AS unit_serial, channel.name AS channel, channel.unit AS unit,
       level, bin, t_first_s, t_last_s, count, minimum, mean, maximum
FROM pyramid
JOIN channel ON channel.id = pyramid.channel_id
JOIN stream ON stream.id = channel.stream_id;
)sql";

base::Status migrate(const sqlite::Connection& connection, std::span<const Step> steps, std::uint32_t application_id) {
  // A file that is current needs no lock: others may write to it for as long as they like.
  const auto identity = connection.identity();
  if (identity && !steps.empty() && identity->user_version == steps.back().to_version) return {};
  return connection.transact("bring the file to the current version", [&]() -> base::Status {
    SQLite::Database& database = connection.database();
    // Inside the transaction: another process may have migrated since the file was opened.
    const std::uint32_t version = database.execAndGet("PRAGMA user_version").getUInt();
    if (version == 0) database.exec("PRAGMA application_id = " + std::to_string(application_id));
    for (const Step& step : steps) {
      if (step.to_version <= version) continue;
      database.exec(step.sql);
      if (step.then) step.then(database);
      database.exec("PRAGMA user_version = " + std::to_string(step.to_version));
    }
    return {};
  });
}

base::Status check_identity(const sqlite::Identity& identity, std::uint32_t application_id, std::uint32_t newest,
                            std::string_view kind, const std::filesystem::path& path) {
  if (identity.application_id == kDevelopmentApplicationId) {
    return base::bad_input(
        "this catalog was written by a development version of soak, before release 0.2.0; no release opens it, and it "
        "was left as it is. Use another data folder and import the recordings again",
        path.string());
  }
  if (identity.application_id != application_id) {
    return base::bad_input(std::string("this SQLite file is not a Soak ").append(kind), path.string());
  }
  if (identity.user_version > newest) {
    return base::bad_input(
        std::string("the ").append(kind).append(" has version " + std::to_string(identity.user_version) +
                                                ", this soak reads up to version " + std::to_string(newest) +
                                                "; a newer soak is needed"),
        path.string());
  }
  return {};
}

}  // namespace soak::db::schema
