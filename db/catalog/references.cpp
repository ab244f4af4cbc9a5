// SPDX-License-Identifier: Apache-2.0
#include <SQLiteCpp/Column.h>
#include <SQLiteCpp/Statement.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "db/catalog/detail/impl.h"
#include "db/detail/sqlite.h"

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
  const bool same =
      sqlite::has_row(connection.database(),
                      "SELECT 1 FROM reference WHERE kind = ? AND name = ? AND certificate = ? AND correction IS ? "
                      "AND standard_uncertainty = ? AND issued_utc_s = ? AND due_utc_s = ? "
                      "AND record_id NOT IN (SELECT record_id FROM reference_withdrawal) "
                      "AND record_id NOT IN (SELECT record_id FROM reference_retirement)",
                      calib::name_of(reference.kind), reference.name, reference.certificate, reference.correction,
                      reference.standard_uncertainty, reference.issued_utc_s, reference.due_utc_s);
  if (!same) return {};
  return base::bad_input("certificate '" + reference.certificate + "' of '" + reference.name +
                             "' is already in the register with the same numbers",
                         connection.path().string());
}

/// "kind name" of an entry; bad_input for an unknown one.
base::Result<std::string> require_entry(const sqlite::Connection& connection, std::string_view record_id) {
  auto label =
      sqlite::first_row_of(connection.database(), "SELECT kind || ' ' || name FROM reference WHERE record_id = ?",
                           sqlite::text_from, record_id);
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

base::Status end_entry(const sqlite::Connection& connection, const Ending& ending, std::string_view record_id,
                       const EndRecord& end) {
  return connection.transact(ending.doing, [&]() -> base::Status {
    const std::string where = connection.path().string();
    if (end.reason.empty() || end.user.empty()) {
      return base::bad_input(fmt::format("{} needs a reason and a user", ending.noun), where);
    }
    const auto label = require_entry(connection, record_id);
    if (!label) return base::forward_error(label);
    const std::string ended = fmt::format("SELECT 1 FROM {} WHERE record_id = ?", ending.table);
    if (sqlite::has_row(connection.database(), ended, record_id)) {
      return base::bad_input(fmt::format("{} is {} already", *label, ending.past), where);
    }
    sqlite::execute(connection.database(),
                    fmt::format("INSERT INTO {} (record_id, reason, user, utc_s) VALUES (?, ?, ?, ?)", ending.table),
                    record_id, end.reason, end.user, end.utc_s);
    catalog::insert_event(connection.database(), {end.utc_s, ending.event, std::string(record_id),
                                                  *label + ", by " + end.user + ": " + end.reason, end.user});
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

ReferenceRow entry_from(sqlite::Fields& fields) {
  ReferenceRow row;
  row.reference = reference_from(fields);
  row.user = fields.text();
  row.entered_utc_s = fields.real();
  row.retired = ending_from(fields);
  row.withdrawn = ending_from(fields);
  return row;
}

CheckStandardRow check_standard_from(sqlite::Fields& fields) {
  CheckStandardRow row;
  row.check_standard_id = fields.text();
  row.unit = fields.text();
  row.since_utc_s = fields.real();
  row.reason = fields.text();
  row.user = fields.text();
  row.ended = ending_from(fields);
  return row;
}

/// What a campaign noted of an entry: of a waiver that is gone from its table nothing is left but its number.
calib::ReferenceUse use_from(sqlite::Fields& fields) {
  calib::ReferenceUse use{reference_from(fields), std::nullopt};
  if (const auto noted = fields.optional_text()) {
    use.waiver.emplace();
    use.waiver->waiver_id = *noted;
    use.waiver->record_id = use.reference.record_id;
  }
  if (fields.flag()) use.waiver = waiver_from(fields);
  return use;
}

bool is_noted(const SQLite::Database& database, std::string_view campaign, const calib::ReferenceUse& use) {
  return sqlite::has_row(
      database, "SELECT 1 FROM campaign_reference WHERE campaign = ? AND record_id = ? AND waiver_id IS ?", campaign,
      use.reference.record_id, use.waiver ? std::optional(use.waiver->waiver_id) : std::nullopt);
}

/// Adds a note to those of a campaign: an entry stands there once, with the waiver that comes last.
void merge_note(std::vector<calib::ReferenceUse>& uses, calib::ReferenceUse use) {
  const auto same = std::find_if(uses.begin(), uses.end(), [&](const calib::ReferenceUse& other) {
    return other.reference.record_id == use.reference.record_id;
  });
  if (same == uses.end()) {
    uses.push_back(std::move(use));
  } else if (use.waiver) {
    same->waiver = std::move(use.waiver);
  }
}

constexpr const char* kStandardNeedsReason = "a check standard needs a reason and a user";

/// Column `wanted` of a check standard that has not ended, by another of its columns.
std::optional<std::string> open_check_standard(const SQLite::Database& database, const char* wanted, const char* by,
                                               std::string_view value) {
  return sqlite::first_row_of(
      database,
      fmt::format("SELECT {} FROM check_standard LEFT JOIN check_standard_end AS e USING (check_standard_id) "
                  "WHERE {} = ? AND e.utc_s IS NULL",
                  wanted, by),
      sqlite::text_from, value);
}

}  // namespace

base::Result<std::string> Catalog::add_reference(const ReferenceRow& row) {
  return impl_->connection.transact("enter the reference", [&]() -> base::Result<std::string> {
    if (auto valid = check_entry(row, impl_->connection.path().string()); !valid) return base::forward_error(valid);
    const calib::Reference& reference = row.reference;
    if (auto is_new = refuse_same(impl_->connection, reference); !is_new) return base::forward_error(is_new);
    std::string record_id = catalog::new_uuid(row.entered_utc_s);
    sqlite::execute(impl_->database(),
                    "INSERT INTO reference (record_id, kind, name, certificate, correction, "
                    "standard_uncertainty, issued_utc_s, due_utc_s, user, entered_utc_s) "
                    "VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?)",
                    record_id, calib::name_of(reference.kind), reference.name, reference.certificate,
                    reference.correction, reference.standard_uncertainty, reference.issued_utc_s, reference.due_utc_s,
                    row.user, row.entered_utc_s);
    impl_->log({row.entered_utc_s, "reference_added", record_id,
                std::string(calib::name_of(reference.kind)) + ' ' + reference.name + ", certificate " +
                    reference.certificate + ", by " + row.user,
                row.user});
    return record_id;
  });
}

base::Result<std::vector<ReferenceRow>> Catalog::references() const {
  return impl_->rows("read the register",
                     std::string("SELECT ") + kEntryColumns +
                         ", reference.user, entered_utc_s, r.reason, r.user, r.utc_s, w.reason, w.user, w.utc_s "
                         "FROM reference LEFT JOIN reference_retirement AS r USING (record_id) "
                         "LEFT JOIN reference_withdrawal AS w USING (record_id) ORDER BY reference.rowid",
                     entry_from);
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
    sqlite::execute(impl_->database(),
                    "INSERT INTO waiver (waiver_id, record_id, reason, signer, public_key, signature, utc_s) "
                    "VALUES (?, ?, ?, ?, ?, ?, ?)",
                    waiver.waiver_id, waiver.record_id, waiver.reason, waiver.signer, waiver.public_key_hex,
                    waiver.signature_hex, waiver.utc_s);
    impl_->log({waiver.utc_s, "reference_waived", waiver.record_id,
                *label + ", by " + waiver.signer + ": " + waiver.reason, waiver.signer});
    return {};
  });
}

base::Result<std::vector<calib::Waiver>> Catalog::waivers() const {
  return impl_->rows("read the waivers", std::string("SELECT ") + kWaiverColumns + " FROM waiver ORDER BY waiver.rowid",
                     waiver_from);
}

base::Status Catalog::add_campaign_references(std::string_view campaign, const std::vector<calib::ReferenceUse>& uses) {
  return impl_->connection.transact("note the references", [&]() -> base::Status {
    const double utc_s = catalog::now_utc_s();
    for (const calib::ReferenceUse& use : uses) {
      if (const auto known = require_entry(impl_->connection, use.reference.record_id); !known) {
        return base::forward_error(known);
      }
      if (is_noted(impl_->database(), campaign, use)) continue;
      sqlite::execute(impl_->database(),
                      "INSERT INTO campaign_reference (campaign, record_id, waiver_id, utc_s) VALUES (?, ?, ?, ?)",
                      campaign, use.reference.record_id,
                      use.waiver ? std::optional(use.waiver->waiver_id) : std::nullopt, utc_s);
    }
    return {};
  });
}

base::Result<std::vector<calib::ReferenceUse>> Catalog::campaign_references(std::string_view campaign) const {
  return impl_->connection.run("read the references", [&]() -> base::Result<std::vector<calib::ReferenceUse>> {
    const bool lost = sqlite::has_row(impl_->database(),
                                      "SELECT 1 FROM campaign_reference WHERE campaign = ? AND record_id NOT IN "
                                      "(SELECT record_id FROM reference)",
                                      campaign);
    if (lost) {
      return base::corrupt("an entry of the register that the campaign was measured with is gone",
                           fmt::format("campaign {}", campaign));
    }
    std::vector<calib::ReferenceUse> uses;
    auto notes = sqlite::rows_of(impl_->database(),
                                 std::string("SELECT ") + kEntryColumns +
                                     ", c.waiver_id, waiver.waiver_id IS NOT NULL, " + kWaiverColumns +
                                     " FROM campaign_reference AS c JOIN reference USING (record_id) "
                                     "LEFT JOIN waiver ON waiver.waiver_id = c.waiver_id WHERE campaign = ? "
                                     "ORDER BY c.ordinal",
                                 use_from, campaign);
    for (calib::ReferenceUse& note : notes) merge_note(uses, std::move(note));
    return uses;
  });
}

base::Result<std::vector<std::string>> Catalog::campaigns_of_reference(std::string_view record_id) const {
  return impl_->rows("read the campaigns",
                     "SELECT campaign FROM campaign_reference WHERE record_id = ? "
                     "GROUP BY campaign ORDER BY min(ordinal)",
                     sqlite::text_from, record_id);
}

// ---- Check standards

base::Result<std::string> Catalog::add_check_standard(const CheckStandardRow& row) {
  return impl_->connection.transact("enter the check standard", [&]() -> base::Result<std::string> {
    const std::string where = impl_->connection.path().string();
    if (row.reason.empty() || row.user.empty()) return base::bad_input(kStandardNeedsReason, where);
    if (const auto known = catalog::epoch_of(impl_->connection, row.unit); !known) return base::forward_error(known);
    if (open_check_standard(impl_->database(), "check_standard_id", "unit", row.unit)) {
      return base::bad_input("unit '" + row.unit + "' is a check standard already", where);
    }
    std::string id = catalog::new_uuid(row.since_utc_s);
    sqlite::execute(impl_->database(),
                    "INSERT INTO check_standard (check_standard_id, unit, since_utc_s, reason, user) "
                    "VALUES (?, ?, ?, ?, ?)",
                    id, row.unit, row.since_utc_s, row.reason, row.user);
    impl_->log({row.since_utc_s, "check_standard_added", row.unit, "by " + row.user + ": " + row.reason, row.user});
    return id;
  });
}

base::Status Catalog::end_check_standard(std::string_view check_standard_id, const EndRecord& end) {
  return impl_->connection.transact("end the check standard", [&]() -> base::Status {
    const std::string where = impl_->connection.path().string();
    if (end.reason.empty() || end.user.empty()) return base::bad_input(kStandardNeedsReason, where);
    const auto unit = open_check_standard(impl_->database(), "unit", "check_standard_id", check_standard_id);
    if (!unit) {
      return base::bad_input(
          "there is no check standard record " + std::string(check_standard_id) + " that has not ended", where);
    }
    sqlite::execute(impl_->database(),
                    "INSERT INTO check_standard_end (check_standard_id, reason, user, utc_s) VALUES (?, ?, ?, ?)",
                    check_standard_id, end.reason, end.user, end.utc_s);
    impl_->log({end.utc_s, "check_standard_ended", *unit, "by " + end.user + ": " + end.reason, end.user});
    return {};
  });
}

base::Result<std::vector<CheckStandardRow>> Catalog::check_standards() const {
  return impl_->rows("read the check standards",
                     "SELECT check_standard_id, unit, since_utc_s, c.reason, c.user, e.reason, e.user, e.utc_s "
                     "FROM check_standard AS c LEFT JOIN check_standard_end AS e USING (check_standard_id) "
                     "ORDER BY c.rowid",
                     check_standard_from);
}

}  // namespace soak::db
