// SPDX-License-Identifier: Apache-2.0
#include "db/run/detail/tables.h"

#include <SQLiteCpp/Column.h>
#include <SQLiteCpp/Statement.h>

#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>

#include "base/text.h"
#include "db/detail/sqlite.h"

namespace soak::db::run {
namespace {

using MetaTexts = std::map<std::string, std::string, std::less<>>;

/// Keys that may be absent: what is not known of the site.
constexpr std::array<std::pair<const char*, std::optional<double> calib::Site::*>, 4> kSiteKeys = {{
    {"latitude_deg", &calib::Site::latitude_deg},
    {"height_m", &calib::Site::height_m},
    {"azimuth_deg", &calib::Site::azimuth_deg},
    {"gravity_mps2", &calib::Site::gravity_mps2},
}};

constexpr std::array<std::pair<const char*, std::string RunInfo::*>, 5> kTextKeys = {{
    {"run_id", &RunInfo::run_id},
    {"label", &RunInfo::label},
    {"campaign", &RunInfo::campaign},
    {"procedure", &RunInfo::procedure},
    {"source", &RunInfo::source},
}};

void insert_pair(SQLite::Database& database, std::string_view key, std::string_view value) {
  sqlite::execute(database, "INSERT INTO meta VALUES (?, ?)", key, value);
}

base::Result<MetaTexts> read_texts(const sqlite::Connection& connection) {
  return connection.run("read what the run says of itself", [&]() -> base::Result<MetaTexts> {
    MetaTexts texts;
    SQLite::Statement query(connection.database(), "SELECT key, value FROM meta");
    while (query.executeStep()) {
      sqlite::Fields fields(query);
      std::string key = fields.text();
      texts[std::move(key)] = fields.text();
    }
    return texts;
  });
}

/// Reads `key` into `value`; false if it is absent or no number.
bool read_number(const MetaTexts& texts, std::string_view key, double& value) {
  const auto found = texts.find(key);
  if (found == texts.end()) return false;
  const auto number = base::parse_double(found->second);
  value = number.value_or(0.0);
  return number.has_value();
}

/// JSON array of texts, made by SQLite's own quoting.
std::string json_of(const SQLite::Database& database, const std::vector<std::string>& labels) {
  std::string json = "[";
  SQLite::Statement quote(database, "SELECT json_quote(?)");
  for (const std::string& label : labels) {
    sqlite::bind_all(quote, label);
    quote.executeStep();
    if (json.size() > 1) json += ',';
    json += quote.getColumn(0).getString();
    quote.reset();
  }
  return json += ']';
}

/// The labels of a channel; nothing where the text is no JSON array.
std::optional<std::vector<std::string>> labels_of(const SQLite::Database& database, const std::string& json) {
  if (!sqlite::has_row(database, "SELECT 1 WHERE CASE WHEN json_valid(?1) THEN json_type(?1) = 'array' ELSE 0 END",
                       json))
    return std::nullopt;
  return sqlite::rows_of(database, "SELECT value FROM json_each(?)", sqlite::text_from, json);
}

std::string title_of(const StreamInfo& stream, const ChannelInfo& channel) {
  return stream.name + (stream.unit.empty() ? "" : "/" + stream.unit) + "/" + channel.name;
}

base::Status read_channels(const sqlite::Connection& connection, std::int64_t stream_id, StoredStream& stream) {
  SQLite::Statement query(connection.database(),
                          "SELECT id, name, source_name, type, unit, scale, offset, labels FROM channel "
                          "WHERE stream_id = ? ORDER BY position");
  sqlite::bind_all(query, stream_id);
  while (query.executeStep()) {
    sqlite::Fields fields(query);
    StoredChannel channel;
    channel.id = fields.integer();
    channel.info.name = fields.text();
    channel.info.source_name = fields.text();
    const std::string type = fields.text();
    channel.info.unit = fields.text();
    channel.info.scale = fields.real();
    channel.info.offset = fields.real();
    const std::string labels = fields.text();
    channel.title = title_of(stream.info, channel.info);
    auto names = labels_of(connection.database(), labels);
    if (!names) {
      return base::corrupt("the labels of its numbers are damaged; restore the file from a copy",
                           connection.path().string() + ", channel " + channel.title);
    }
    channel.info.labels = *std::move(names);
    const auto known = sample_type_named(type);
    if (!known) {
      return base::corrupt("unknown type of numbers '" + type + "'",
                           connection.path().string() + ", channel " + channel.title);
    }
    channel.info.type = *known;
    stream.info.channels.push_back(channel.info);
    stream.channels.push_back(std::move(channel));
  }
  if (stream.channels.empty()) {
    return base::corrupt("the stream '" + stream.info.name + "' has no channels", connection.path().string());
  }
  return {};
}

}  // namespace

void insert_meta(SQLite::Database& database, const RunInfo& info) {
  for (const auto& [key, member] : kTextKeys) insert_pair(database, key, info.*member);
  insert_pair(database, "purpose", info.purpose);
  if (!info.continues.empty()) insert_pair(database, "continues", info.continues);
  insert_pair(database, "created_utc_s", base::shortest(info.created_utc_s));
  insert_pair(database, "clock_rate", base::shortest(info.clock_rate));
  insert_pair(database, "simulated", info.simulated ? "1" : "0");
  for (const auto& [key, member] : kSiteKeys) {
    const std::optional<double>& value = info.site.*member;
    if (value) insert_pair(database, key, base::shortest(*value));
  }
}

void insert_finished(SQLite::Database& database) { insert_pair(database, "finished", "1"); }

base::Result<Meta> read_meta(const sqlite::Connection& connection) {
  const auto texts = read_texts(connection);
  if (!texts) return base::forward_error(texts);
  const auto incomplete = [&](const char* key) {
    return base::corrupt(std::string("the table meta lacks a valid '") + key + "'", connection.path().string());
  };
  Meta meta;
  for (const auto& [key, member] : kTextKeys) {
    const auto found = texts->find(key);
    if (found == texts->end()) return incomplete(key);
    meta.info.*member = found->second;
  }
  if (const auto purpose = texts->find("purpose"); purpose != texts->end()) meta.info.purpose = purpose->second;
  if (const auto before = texts->find("continues"); before != texts->end()) meta.info.continues = before->second;
  if (!read_number(*texts, "created_utc_s", meta.info.created_utc_s)) return incomplete("created_utc_s");
  if (!read_number(*texts, "clock_rate", meta.info.clock_rate)) return incomplete("clock_rate");
  double simulated = 0.0;
  if (!read_number(*texts, "simulated", simulated)) return incomplete("simulated");
  meta.info.simulated = simulated != 0.0;
  for (const auto& [key, member] : kSiteKeys) {
    double value = 0.0;
    if (!texts->contains(key)) continue;
    if (!read_number(*texts, key, value)) return incomplete(key);
    meta.info.site.*member = value;
  }
  meta.finished = texts->contains("finished");
  return meta;
}

base::Status check_stream(const StreamInfo& info) {
  if (info.channels.empty() || info.channels.front().name != "t_s") {
    return base::bad_input("the first channel of a stream must be the time axis t_s", "stream " + info.name);
  }
  std::set<std::string> names;
  for (const ChannelInfo& channel : info.channels) {
    const std::string where = "channel " + title_of(info, channel);
    if (!names.insert(channel.name).second) return base::bad_input("a channel name is duplicated in its stream", where);
    if (!std::isfinite(channel.scale) || !std::isfinite(channel.offset)) {
      return base::bad_input("scale and offset must be finite", where);
    }
    for (const std::string& label : channel.labels) {
      if (label.find('\0') != std::string::npos) return base::bad_input("a label may not hold a zero byte", where);
    }
  }
  return {};
}

StoredStream insert_stream(SQLite::Database& database, const StreamInfo& info) {
  StoredStream stream{info, {}, 0};
  sqlite::execute(database, "INSERT INTO stream (name, unit_serial) VALUES (?, ?)", info.name, info.unit);
  const std::int64_t stream_id = database.getLastInsertRowid();
  SQLite::Statement add(database,
                        "INSERT INTO channel (stream_id, position, name, source_name, type, unit, scale, offset, "
                        "labels) VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?)");
  for (std::size_t i = 0; i < info.channels.size(); ++i) {
    const ChannelInfo& channel = info.channels[i];
    sqlite::bind_all(add, stream_id, i, channel.name, channel.source_name, name_of(channel.type), channel.unit,
                     channel.scale, channel.offset, json_of(database, channel.labels));
    add.exec();
    add.reset();
    stream.channels.push_back({database.getLastInsertRowid(), title_of(info, channel), channel});
  }
  return stream;
}

base::Result<std::vector<StoredStream>> read_streams(const sqlite::Connection& connection) {
  return connection.run("read the streams", [&]() -> base::Result<std::vector<StoredStream>> {
    std::vector<StoredStream> streams;
    SQLite::Statement query(connection.database(), "SELECT id, name, unit_serial FROM stream ORDER BY id");
    while (query.executeStep()) {
      sqlite::Fields fields(query);
      const std::int64_t id = fields.integer();
      StoredStream& stream = streams.emplace_back();
      stream.info.name = fields.text();
      stream.info.unit = fields.text();
      if (const auto read = read_channels(connection, id, stream); !read) return base::forward_error(read);
      const auto rows = stored_rows(connection, stream.channels.front());
      if (!rows) return base::forward_error(rows);
      stream.rows = *rows;
    }
    return streams;
  });
}

void insert_event(SQLite::Database& database, const RunEvent& event) {
  sqlite::execute(database, "INSERT INTO event (t_s, kind, text) VALUES (?, ?, ?)", event.t_s, event.kind, event.text);
}

base::Result<std::vector<RunEvent>> read_events(const sqlite::Connection& connection) {
  return connection.run("read the events", [&]() -> base::Result<std::vector<RunEvent>> {
    return sqlite::rows_of(connection.database(), "SELECT t_s, kind, text FROM event ORDER BY id",
                           [](sqlite::Fields& fields) {
                             RunEvent event;
                             event.t_s = fields.real();
                             event.kind = fields.text();
                             event.text = fields.text();
                             return event;
                           });
  });
}

}  // namespace soak::db::run
