// SPDX-License-Identifier: Apache-2.0
#include <SQLiteCpp/Column.h>
#include <SQLiteCpp/Statement.h>
#include <fmt/format.h>

#include <cstdint>
#include <utility>

#include "base/hash.h"
#include "db/catalog/detail/event_chain.h"
#include "db/catalog/detail/impl.h"
#include "db/catalog/detail/value_digest.h"
#include "db/detail/sqlite.h"

namespace soak::db {
namespace {

/// What stands before the first event.
constexpr const char* kBeginning = "";

/// An event as it is stored.
struct ChainedEvent {
  std::int64_t ordinal = 0;
  std::string event_id;
  EventRow row;
};

/// SHA-256 over the chain so far and the event's own columns but for this one.
std::string next_in_chain(std::string_view before, const ChainedEvent& event) {
  base::Sha256 hash;
  catalog::add_text(hash, before);
  catalog::add_integer(hash, event.ordinal);
  catalog::add_text(hash, event.event_id);
  catalog::add_real(hash, event.row.utc_s);
  for (const auto* text : {&event.row.kind, &event.row.subject, &event.row.text, &event.row.user}) {
    catalog::add_text(hash, *text);
  }
  return base::to_hex(hash.finish());
}

/// How many events there are, and the end of their chain.
EventChain end_of_chain(const SQLite::Database& database) {
  const auto end = sqlite::first_row_of(database, "SELECT row_count, sha256 FROM seal WHERE name = 'event'",
                                        [](sqlite::Fields& fields) {
                                          const auto count = static_cast<std::uint64_t>(fields.integer());
                                          return EventChain{count, fields.text()};
                                        });
  return end.value_or(EventChain{0, kBeginning});
}

constexpr const char* kEventColumns = "ordinal, event_id, utc_s, kind, subject, text, user, chain_sha256";

ChainedEvent chained_from(sqlite::Fields& fields) {
  ChainedEvent event;
  event.ordinal = fields.integer();
  event.event_id = fields.text();
  event.row.utc_s = fields.real();
  event.row.kind = fields.text();
  event.row.subject = fields.text();
  event.row.text = fields.text();
  event.row.user = fields.text();
  event.row.chain_sha256 = fields.text();
  event.row.number = event.ordinal;
  return event;
}

tl::unexpected<base::Error> broken_at(std::int64_t number, std::string_view what) {
  return base::corrupt(
      fmt::format("the event log is not as it was written: {}; restore the catalog from a backup", what),
      fmt::format("event {}", number));
}

/// Follows the chain from its beginning. Throws SQLite::Exception.
base::Result<EventChain> follow_chain(const SQLite::Database& database) {
  SQLite::Statement query(database, std::string("SELECT ") + kEventColumns + " FROM event ORDER BY ordinal");
  EventChain chain{0, kBeginning};
  while (query.executeStep()) {
    sqlite::Fields fields(query);
    const ChainedEvent event = chained_from(fields);
    const auto expected = static_cast<std::int64_t>(chain.events + 1);
    if (event.ordinal != expected) return broken_at(expected, "the event is missing");
    if (event.row.chain_sha256 != next_in_chain(chain.end_sha256, event)) {
      return broken_at(event.ordinal, "the event, or the one before it, was changed");
    }
    chain = {chain.events + 1, event.row.chain_sha256};
  }
  const EventChain end = end_of_chain(database);
  if (chain == end) return chain;
  return broken_at(static_cast<std::int64_t>(chain.events + 1),
                   fmt::format("{} events are there, {} were written", chain.events, end.events));
}

}  // namespace

namespace catalog {

void insert_event(SQLite::Database& database, const EventRow& event) {
  const EventChain end = end_of_chain(database);
  ChainedEvent next{static_cast<std::int64_t>(end.events + 1), new_uuid(event.utc_s), event};
  const std::string chain = next_in_chain(end.end_sha256, next);
  sqlite::execute(database, fmt::format("INSERT INTO event ({}) VALUES (?, ?, ?, ?, ?, ?, ?, ?)", kEventColumns),
                  next.ordinal, next.event_id, event.utc_s, event.kind, event.subject, event.text, event.user, chain);
  sqlite::execute(database, "UPDATE seal SET row_count = ?, sha256 = ? WHERE name = 'event'", next.ordinal, chain);
}

void chain_all_events(SQLite::Database& database) {
  EventChain chain{0, kBeginning};
  // Numbers without gaps: version 1 left them to SQLite.
  const auto ordinals = sqlite::rows_of(database, "SELECT ordinal FROM event ORDER BY ordinal",
                                        [](sqlite::Fields& fields) { return fields.integer(); });
  for (const std::int64_t ordinal : ordinals) {
    auto event = *sqlite::first_row_of(
        database, std::string("SELECT ") + kEventColumns + " FROM event WHERE ordinal = ?", chained_from, ordinal);
    event.ordinal = static_cast<std::int64_t>(++chain.events);
    chain.end_sha256 = next_in_chain(chain.end_sha256, event);
    sqlite::execute(database, "UPDATE event SET ordinal = ?, chain_sha256 = ? WHERE ordinal = ?", event.ordinal,
                    chain.end_sha256, ordinal);
  }
  sqlite::execute(database, "INSERT INTO seal (name, row_count, sha256) VALUES ('event', ?, ?)", chain.events,
                  chain.end_sha256);
}

}  // namespace catalog

void Catalog::Impl::log(EventRow event) {
  if (event.user.empty()) event.user = user;
  catalog::insert_event(database(), event);
}

void Catalog::act_as(std::string_view user) { impl_->user = user; }

base::Status Catalog::log_event(const EventRow& event) {
  return impl_->connection.transact("log an event", [&]() -> base::Status {
    impl_->log(event);
    return {};
  });
}

base::Result<std::vector<EventRow>> Catalog::events() const {
  return impl_->rows("read the event log", std::string("SELECT ") + kEventColumns + " FROM event ORDER BY ordinal",
                     [](sqlite::Fields& fields) { return chained_from(fields).row; });
}

namespace {

/// A list in one text, each value between two unit separators, which no kind and no name has; nothing where it is
/// empty.
std::optional<std::string> fenced(const std::vector<std::string>& values) {
  if (values.empty()) return std::nullopt;
  std::string text = "\x1f";
  for (const std::string& value : values) text += value + '\x1f';
  return text;
}

}  // namespace

base::Result<std::vector<EventRow>> Catalog::find_events(const EventFilter& filter) const {
  const std::string sql = fmt::format(
      "SELECT {} FROM event WHERE (?1 IS NULL OR kind = ?1) AND (?2 IS NULL OR subject = ?2) AND (?3 IS NULL OR user = "
      "?3) AND (?4 IS NULL OR utc_s >= ?4) AND (?5 IS NULL OR utc_s < ?5) AND (?6 IS NULL OR ordinal < ?6) AND "
      "(?8 IS NULL OR instr(?8, char(31) || subject || char(31)) > 0) AND (?9 IS NULL OR instr(?9, char(31) || kind || "
      "char(31)) = 0) ORDER BY ordinal DESC LIMIT ?7",
      kEventColumns);
  return impl_->rows(
      "read the event log", sql, [](sqlite::Fields& fields) { return chained_from(fields).row; }, filter.kind,
      filter.subject, filter.user, filter.from_utc_s, filter.to_utc_s, filter.before, filter.most,
      fenced(filter.subjects), fenced(filter.without_kinds));
}

base::Result<std::vector<std::string>> Catalog::event_kinds() const {
  return impl_->rows("read the event log", "SELECT DISTINCT kind FROM event ORDER BY kind", sqlite::text_from);
}

base::Result<std::vector<std::string>> Catalog::event_users() const {
  return impl_->rows("read the event log", "SELECT DISTINCT user FROM event WHERE user <> '' ORDER BY user",
                     sqlite::text_from);
}

base::Result<EventChain> Catalog::check_events() const {
  return impl_->connection.snapshot("check the event log", [&] { return follow_chain(impl_->database()); });
}

}  // namespace soak::db
