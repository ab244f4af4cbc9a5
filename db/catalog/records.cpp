// SPDX-License-Identifier: Apache-2.0
#include <SQLiteCpp/Column.h>
#include <SQLiteCpp/Statement.h>
#include <fmt/format.h>

#include "base/hash.h"
#include "db/catalog/detail/impl.h"
#include "db/detail/sqlite.h"

namespace soak::db {
namespace {

base::Status check_void(const VoidRecord& record, const std::string& where) {
  if (record.reason.empty() || record.user.empty()) {
    return base::bad_input("withdrawing data needs a reason and a user", where);
  }
  if ((record.position && !record.visit) || (record.attempt && !record.position)) {
    return base::bad_input("a position is withdrawn with its visit, an attempt with its visit and position", where);
  }
  return {};
}

/// Refuses a record that withdraws nothing: a mistyped visit or position must not go unnoticed.
base::Status require_segments(const sqlite::Connection& connection, const VoidRecord& record) {
  if (!record.visit) return {};
  const bool known = sqlite::has_row(connection.database(),
                                     "SELECT 1 FROM segment WHERE run_id = ?1 AND unit = ?2 AND visit = ?3 AND "
                                     "(?4 IS NULL OR position = ?4) AND (?5 IS NULL OR attempt = ?5)",
                                     record.run_id, record.unit, record.visit, record.position, record.attempt);
  if (known) return {};
  return base::bad_input("run " + record.run_id + " of unit " + record.unit + " has no such segment",
                         connection.path().string());
}

std::string text_of(const VoidRecord& record) {
  std::string text = "unit " + record.unit;
  if (record.visit) text += ", visit " + std::to_string(*record.visit);
  if (record.position) text += ", position '" + *record.position + "'";
  if (record.attempt) text += ", attempt " + std::to_string(*record.attempt);
  return text + ", by " + record.user + ": " + record.reason;
}

VoidRecord void_from(sqlite::Fields& fields) {
  VoidRecord record;
  record.run_id = fields.text();
  record.unit = fields.text();
  record.visit = fields.optional_integer();
  record.position = fields.optional_text();
  record.attempt = fields.optional_integer();
  record.reason = fields.text();
  record.user = fields.text();
  record.utc_s = fields.real();
  return record;
}

std::string sha256_of_text(std::string_view text) {
  base::Sha256 hash;
  hash.update(text);
  return base::to_hex(hash.finish());
}

GapReportRow report_from(sqlite::Fields& fields) {
  GapReportRow report;
  report.unit = fields.text();
  report.model_version = fields.integer32();
  report.created_utc_s = fields.real();
  report.document = fields.text();
  return report;
}

}  // namespace

base::Status Catalog::add_void(const VoidRecord& record) {
  return impl_->connection.transact("withdraw data", [&]() -> base::Status {
    if (const auto valid = check_void(record, impl_->connection.path().string()); !valid) return valid;
    if (const auto known = catalog::require_run(impl_->connection, record.run_id, record.unit); !known) return known;
    if (const auto known = require_segments(impl_->connection, record); !known) return known;
    sqlite::execute(impl_->database(),
                    "INSERT INTO void (void_id, run_id, unit, visit, position, attempt, reason, user, utc_s) "
                    "VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?)",
                    catalog::new_uuid(record.utc_s), record.run_id, record.unit, record.visit, record.position,
                    record.attempt, record.reason, record.user, record.utc_s);
    impl_->log({record.utc_s, "voided", record.run_id, text_of(record), record.user});
    return {};
  });
}

base::Result<std::vector<VoidRecord>> Catalog::voids(std::string_view run_id) const {
  return impl_->rows("read the void records",
                     "SELECT run_id, unit, visit, position, attempt, reason, user, utc_s FROM void "
                     "WHERE run_id = ? ORDER BY rowid",
                     void_from, run_id);
}

base::Result<std::int32_t> Catalog::add_model(std::string_view unit, std::int32_t epoch, double created_utc_s,
                                              const std::function<std::string(std::int32_t)>& make_document,
                                              const std::optional<ModelOrigin>& origin) {
  return impl_->connection.transact("add the model", [&]() -> base::Result<std::int32_t> {
    if (const auto known = catalog::epoch_of(impl_->connection, unit); !known) return base::forward_error(known);
    const auto newest = sqlite::first_row_of(
        impl_->database(), "SELECT coalesce(max(version), 0) FROM model WHERE unit = ?",
        [](sqlite::Fields& fields) { return fields.integer32(); }, unit);
    const std::int32_t version = *newest + 1;
    const std::string document = make_document(version);
    sqlite::execute(impl_->database(),
                    "INSERT INTO model (unit, version, epoch, created_utc_s, sha256, document) "
                    "VALUES (?, ?, ?, ?, ?, ?)",
                    unit, version, epoch, created_utc_s, sha256_of_text(document), document);
    if (origin) {
      sqlite::execute(impl_->database(),
                      "INSERT INTO model_origin (unit, version, software, user, inputs_sha256) VALUES (?, ?, ?, ?, ?)",
                      unit, version, origin->software, impl_->user, origin->inputs_sha256);
    }
    impl_->log({created_utc_s, "model_added", std::string(unit), "version " + std::to_string(version)});
    return version;
  });
}

base::Result<std::optional<ModelRow>> Catalog::model(std::string_view unit, std::optional<std::int32_t> version) const {
  return impl_->connection.run("read the model", [&]() -> base::Result<std::optional<ModelRow>> {
    SQLite::Statement query(impl_->database(),
                            "SELECT unit, version, epoch, created_utc_s, document, sha256 FROM model "
                            "WHERE unit = ?1 AND (?2 IS NULL OR version = ?2) ORDER BY version DESC LIMIT 1");
    sqlite::bind_all(query, unit, version);
    if (!query.executeStep()) return std::nullopt;
    sqlite::Fields fields(query);
    ModelRow row;
    row.unit = fields.text();
    row.version = fields.integer32();
    row.epoch = fields.integer32();
    row.created_utc_s = fields.real();
    row.document = fields.text();
    if (sha256_of_text(row.document) != fields.text()) {
      return base::corrupt(
          fmt::format(
              "model {} of unit {} has changed since it was stored; fit again, or restore the catalog from a backup",
              row.version, row.unit),
          "station.db");
    }
    return row;
  });
}

base::Status Catalog::add_gap_report(const GapReportRow& report) {
  return impl_->connection.transact("store the gap report", [&]() -> base::Status {
    if (const auto known = catalog::require_model(impl_->connection, report.unit, report.model_version); !known)
      return known;
    sqlite::execute(impl_->database(),
                    "INSERT INTO gap_report (gap_report_id, unit, model_version, created_utc_s, document) "
                    "VALUES (?, ?, ?, ?, ?)",
                    catalog::new_uuid(report.created_utc_s), report.unit, report.model_version, report.created_utc_s,
                    report.document);
    return {};
  });
}

base::Result<std::vector<GapReportRow>> Catalog::gap_reports(std::string_view unit) const {
  return impl_->rows("read the gap reports",
                     "SELECT unit, model_version, created_utc_s, document FROM gap_report WHERE unit = ? "
                     "ORDER BY rowid",
                     report_from, unit);
}

base::Status Catalog::add_calibration(const CalibrationRow& calibration) {
  return impl_->connection.transact("record the exported file", [&]() -> base::Status {
    auto known = catalog::require_model(impl_->connection, calibration.unit, calibration.model_version);
    if (!known) return known;
    sqlite::execute(impl_->database(),
                    "INSERT INTO calibration (calibration_id, unit, model_version, created_utc_s, format, "
                    "sha256, path) VALUES (?, ?, ?, ?, ?, ?, ?)",
                    catalog::new_uuid(calibration.created_utc_s), calibration.unit, calibration.model_version,
                    calibration.created_utc_s, calibration.format, calibration.sha256, calibration.path);
    impl_->log(
        {calibration.created_utc_s, "calibration_exported", calibration.unit,
         calibration.format + " of model " + std::to_string(calibration.model_version) + " to " + calibration.path,
         calibration.user});
    return {};
  });
}

}  // namespace soak::db
