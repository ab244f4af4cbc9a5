// SPDX-License-Identifier: Apache-2.0
#include <SQLiteCpp/Column.h>
#include <SQLiteCpp/Statement.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "db/catalog/detail/impl.h"
#include "db/detail/fields.h"

namespace soak::db {
namespace {

/// Columns of an entry and of its end, in the order in which reference_from() and retirement_from() read them.
constexpr const char* kEntryColumns =
    "reference.record_id, kind, name, certificate, correction, standard_uncertainty, issued_utc_s, due_utc_s";
constexpr const char* kWaiverColumns =
    "waiver.waiver_id, waiver.record_id, waiver.reason, waiver.signer, waiver.public_key, waiver.signature, "
    "waiver.utc_s";

calib::Reference reference_from(sqlite::Fields& fields) {
  calib::Reference reference;
  reference.record_id = fields.text();
  // The table's CHECK keeps other kinds out.
  reference.kind = calib::reference_kind_named(fields.text()).value_or(calib::ReferenceKind::chamber_probe);
  reference.name = fields.text();
  reference.certificate = fields.text();
  reference.correction = fields.optional_real();
  reference.standard_uncertainty = fields.real();
  reference.issued_utc_s = fields.real();
  reference.due_utc_s = fields.real();
  return reference;
}

calib::Waiver waiver_from(sqlite::Fields& fields) {
  calib::Waiver waiver;
  waiver.waiver_id = fields.text();
  waiver.record_id = fields.text();
  waiver.reason = fields.text();
  waiver.signer = fields.text();
  waiver.public_key_hex = fields.text();
  waiver.signature_hex = fields.text();
  waiver.utc_s = fields.real();
  return waiver;
}

base::Status check_texts(const ReferenceRow& row, const std::string& where) {
  const calib::Reference& reference = row.reference;
  if (!reference.name.empty() && !reference.certificate.empty() && !row.user.empty()) return {};
  return base::bad_input("an entry of the register needs a name, a certificate and a user", where);
}

base::Status check_entry(const ReferenceRow& row, const std::string& where) {
  if (auto texts = check_texts(row, where); !texts) return texts;
  const calib::Reference& reference = row.reference;
  if (!std::isfinite(reference.standard_uncertainty) || reference.standard_uncertainty < 0.0 ||
      !std::isfinite(reference.correction.value_or(0.0))) {
    return base::bad_input("the uncertainty must be a number of 0 or more, the correction a finite one", where);
  }
  if (!std::isfinite(reference.issued_utc_s) || !std::isfinite(reference.due_utc_s) ||
      reference.due_utc_s <= reference.issued_utc_s) {
    return base::bad_input("the certificate must be due after the day of its issue", where);
  }
  return {};
}

base::Status refuse_same(const sqlite::Connection& connection, const calib::Reference& reference) {
  SQLite::Statement same(connection.database(),
                         "SELECT 1 FROM reference WHERE kind = ? AND name = ? AND certificate = ? AND correction IS ? "
                         "AND standard_uncertainty = ? AND issued_utc_s = ? AND due_utc_s = ? "
                         "AND record_id NOT IN (SELECT record_id FROM reference_withdrawal) "
                         "AND record_id NOT IN (SELECT record_id FROM reference_retirement)");
  sqlite::bind_all(same, calib::name_of(reference.kind), reference.name, reference.certificate, reference.correction,
                   reference.standard_uncertainty, reference.issued_utc_s, reference.due_utc_s);
  if (!same.executeStep()) return {};
  return base::bad_input("certificate '" + reference.certificate + "' of '" + reference.name +
                             "' stands in the register with the same numbers already",
                         connection.path().string());
}

/// Name of an entry for messages and the log; nothing for an unknown one.
std::optional<std::string> label_of(const sqlite::Connection& connection, std::string_view record_id) {
  SQLite::Statement query(connection.database(), "SELECT kind || ' ' || name FROM reference WHERE record_id = ?");
  sqlite::bind_all(query, record_id);
  if (!query.executeStep()) return std::nullopt;
  return sqlite::Fields(query).text();
}

base::Result<std::string> require_entry(const sqlite::Connection& connection, std::string_view record_id) {
  auto label = label_of(connection, record_id);
  if (label) return *std::move(label);
  return base::bad_input("the register has no entry " + std::string(record_id), connection.path().string());
}

/// What can be put to an end in an entry of the register: the table that tells of it, and its words.
struct Ending {
  const char* table;
  const char* doing;  ///< "retire the reference"
  const char* noun;   ///< "retiring"
  const char* event;  ///< kind of the log's line
  const char* past;   ///< "retired"
};
constexpr Ending kRetirement = {"reference_retirement", "retire the reference", "retiring", "reference_retired",
                                "retired"};
constexpr Ending kWithdrawal = {"reference_withdrawal", "withdraw the entry", "withdrawing", "reference_withdrawn",
                                "withdrawn"};

bool has_ended(const SQLite::Database& database, const Ending& ending, std::string_view record_id) {
  SQLite::Statement query(database, fmt::format("SELECT 1 FROM {} WHERE record_id = ?", ending.table));
  sqlite::bind_all(query, record_id);
  return query.executeStep();
}

base::Status end_entry(const sqlite::Connection& connection, const Ending& ending, std::string_view record_id,
                       const EndRecord& end) {
  return connection.transact(ending.doing, [&]() -> base::Status {
    const std::string where = connection.path().string();
    if (end.reason.empty() || end.user.empty()) {
      return base::bad_input(fmt::format("{} needs a reason and a user", ending.noun), where);
    }
    const auto label = require_entry(connection, record_id);
    if (!label) return base::forward_error(label);
    if (has_ended(connection.database(), ending, record_id)) {
      return base::bad_input(fmt::format("{} is {} already", *label, ending.past), where);
    }
    SQLite::Statement insert(
        connection.database(),
        fmt::format("INSERT INTO {} (record_id, reason, user, utc_s) VALUES (?, ?, ?, ?)", ending.table));
    sqlite::bind_all(insert, record_id, end.reason, end.user, end.utc_s);
    insert.exec();
    catalog::insert_event(connection.database(), {end.utc_s, ending.event, std::string(record_id),
                                                  *label + ", by " + end.user + ": " + end.reason});
    return {};
  });
}

/// Reads what end_entry() has written; nothing where it has not.
std::optional<EndRecord> ending_from(sqlite::Fields& fields) {
  const auto reason = fields.optional_text();
  const auto user = fields.optional_text();
  const auto utc_s = fields.optional_real();
  if (!reason) return std::nullopt;
  return EndRecord{*reason, user.value_or(""), utc_s.value_or(0.0)};
}

bool is_noted(const SQLite::Database& database, std::string_view campaign, const calib::ReferenceUse& use) {
  SQLite::Statement query(database,
                          "SELECT 1 FROM campaign_reference WHERE campaign = ? AND record_id = ? AND waiver_id IS ?");
  sqlite::bind_all(query, campaign, use.reference.record_id,
                   use.waiver ? std::optional(use.waiver->waiver_id) : std::nullopt);
  return query.executeStep();
}

/// Adds a note to those of a campaign: an entry stands there once, with the waiver that comes last.
void merge(std::vector<calib::ReferenceUse>& uses, calib::ReferenceUse use) {
  const auto same = std::find_if(uses.begin(), uses.end(), [&](const calib::ReferenceUse& other) {
    return other.reference.record_id == use.reference.record_id;
  });
  if (same == uses.end()) {
    uses.push_back(std::move(use));
  } else if (use.waiver) {
    same->waiver = std::move(use.waiver);
  }
}

}  // namespace

base::Result<std::string> Catalog::add_reference(const ReferenceRow& row) {
  return impl_->connection.transact("enter the reference", [&]() -> base::Result<std::string> {
    if (auto valid = check_entry(row, impl_->connection.path().string()); !valid) return base::forward_error(valid);
    const calib::Reference& reference = row.reference;
    if (auto is_new = refuse_same(impl_->connection, reference); !is_new) return base::forward_error(is_new);
    std::string record_id = catalog::new_uuid(row.entered_utc_s);
    SQLite::Statement insert(impl_->database(),
                             "INSERT INTO reference (record_id, kind, name, certificate, correction, "
                             "standard_uncertainty, issued_utc_s, due_utc_s, user, entered_utc_s) "
                             "VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?)");
    sqlite::bind_all(insert, record_id, calib::name_of(reference.kind), reference.name, reference.certificate,
                     reference.correction, reference.standard_uncertainty, reference.issued_utc_s, reference.due_utc_s,
                     row.user, row.entered_utc_s);
    insert.exec();
    catalog::insert_event(impl_->database(), {row.entered_utc_s, "reference_added", record_id,
                                              std::string(calib::name_of(reference.kind)) + ' ' + reference.name +
                                                  ", certificate " + reference.certificate + ", by " + row.user});
    return record_id;
  });
}

base::Result<std::vector<ReferenceRow>> Catalog::references() const {
  return impl_->connection.run("read the register", [&]() -> base::Result<std::vector<ReferenceRow>> {
    SQLite::Statement query(impl_->database(),
                            std::string("SELECT ") + kEntryColumns +
                                ", reference.user, entered_utc_s, r.reason, r.user, r.utc_s, w.reason, w.user, w.utc_s "
                                "FROM reference LEFT JOIN reference_retirement AS r USING (record_id) "
                                "LEFT JOIN reference_withdrawal AS w USING (record_id) ORDER BY reference.rowid");
    std::vector<ReferenceRow> rows;
    while (query.executeStep()) {
      sqlite::Fields fields(query);
      ReferenceRow& row = rows.emplace_back();
      row.reference = reference_from(fields);
      row.user = fields.text();
      row.entered_utc_s = fields.real();
      row.retired = ending_from(fields);
      row.withdrawn = ending_from(fields);
    }
    return rows;
  });
}

base::Status Catalog::retire_reference(std::string_view record_id, const EndRecord& end) {
  return end_entry(impl_->connection, kRetirement, record_id, end);
}

base::Status Catalog::withdraw_reference(std::string_view record_id, const EndRecord& end) {
  return end_entry(impl_->connection, kWithdrawal, record_id, end);
}

base::Status Catalog::add_waiver(const calib::Waiver& waiver) {
  return impl_->connection.transact("store the waiver", [&]() -> base::Status {
    const auto label = require_entry(impl_->connection, waiver.record_id);
    if (!label) return base::forward_error(label);
    SQLite::Statement insert(impl_->database(),
                             "INSERT INTO waiver (waiver_id, record_id, reason, signer, public_key, signature, utc_s) "
                             "VALUES (?, ?, ?, ?, ?, ?, ?)");
    sqlite::bind_all(insert, waiver.waiver_id, waiver.record_id, waiver.reason, waiver.signer, waiver.public_key_hex,
                     waiver.signature_hex, waiver.utc_s);
    insert.exec();
    catalog::insert_event(impl_->database(), {waiver.utc_s, "reference_waived", waiver.record_id,
                                              *label + ", by " + waiver.signer + ": " + waiver.reason});
    return {};
  });
}

base::Result<std::vector<calib::Waiver>> Catalog::waivers() const {
  return impl_->connection.run("read the waivers", [&]() -> base::Result<std::vector<calib::Waiver>> {
    SQLite::Statement query(impl_->database(),
                            std::string("SELECT ") + kWaiverColumns + " FROM waiver ORDER BY waiver.rowid");
    std::vector<calib::Waiver> waivers;
    while (query.executeStep()) {
      sqlite::Fields fields(query);
      waivers.push_back(waiver_from(fields));
    }
    return waivers;
  });
}

base::Status Catalog::add_campaign_references(std::string_view campaign, const std::vector<calib::ReferenceUse>& uses) {
  return impl_->connection.transact("note the references", [&]() -> base::Status {
    const double utc_s = catalog::now_utc_s();
    for (const calib::ReferenceUse& use : uses) {
      if (const auto known = require_entry(impl_->connection, use.reference.record_id); !known) {
        return base::forward_error(known);
      }
      if (is_noted(impl_->database(), campaign, use)) continue;
      SQLite::Statement insert(
          impl_->database(),
          "INSERT INTO campaign_reference (campaign, record_id, waiver_id, utc_s) VALUES (?, ?, ?, ?)");
      sqlite::bind_all(insert, campaign, use.reference.record_id,
                       use.waiver ? std::optional(use.waiver->waiver_id) : std::nullopt, utc_s);
      insert.exec();
    }
    return {};
  });
}

base::Result<std::vector<calib::ReferenceUse>> Catalog::campaign_references(std::string_view campaign) const {
  return impl_->connection.run("read the references", [&]() -> base::Result<std::vector<calib::ReferenceUse>> {
    SQLite::Statement lost(impl_->database(),
                           "SELECT count(*) FROM campaign_reference WHERE campaign = ? AND record_id NOT IN "
                           "(SELECT record_id FROM reference)");
    sqlite::bind_all(lost, campaign);
    if (lost.executeStep() && lost.getColumn(0).getInt() > 0) {
      return base::corrupt("an entry of the register that the campaign was measured with is gone",
                           fmt::format("campaign {}", campaign));
    }
    SQLite::Statement query(impl_->database(),
                            std::string("SELECT ") + kEntryColumns + ", c.waiver_id, waiver.waiver_id IS NOT NULL, " +
                                kWaiverColumns +
                                " FROM campaign_reference AS c JOIN reference USING (record_id) "
                                "LEFT JOIN waiver ON waiver.waiver_id = c.waiver_id WHERE campaign = ? "
                                "ORDER BY c.ordinal");
    sqlite::bind_all(query, campaign);
    std::vector<calib::ReferenceUse> uses;
    while (query.executeStep()) {
      sqlite::Fields fields(query);
      calib::ReferenceUse use{reference_from(fields), std::nullopt};
      const auto noted = fields.optional_text();
      if (noted) {
        use.waiver.emplace();
        use.waiver->waiver_id = *noted;
        use.waiver->record_id = use.reference.record_id;
      }
      if (fields.flag()) use.waiver = waiver_from(fields);
      merge(uses, std::move(use));
    }
    return uses;
  });
}

base::Result<std::vector<std::string>> Catalog::campaigns_of_reference(std::string_view record_id) const {
  return impl_->connection.run("read the campaigns", [&]() -> base::Result<std::vector<std::string>> {
    SQLite::Statement query(impl_->database(),
                            "SELECT campaign FROM campaign_reference WHERE record_id = ? "
                            "GROUP BY campaign ORDER BY min(ordinal)");
    sqlite::bind_all(query, record_id);
    std::vector<std::string> names;
    while (query.executeStep()) names.push_back(sqlite::Fields(query).text());
    return names;
  });
}

}  // namespace soak::db
