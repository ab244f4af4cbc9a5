// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>

#include "db/catalog/detail/impl.h"
#include "db/detail/sqlite.h"

namespace soak::db {
namespace {

/// What a model may become of what it is. One that is released can be released anew: after a failed verification it
/// takes somebody's name again.
constexpr std::array<std::pair<std::string_view, std::string_view>, 7> kSteps = {{{"fitted", "verified"},
                                                                                  {"verified", "released"},
                                                                                  {"released", "released"},
                                                                                  {"verified", "fitted"},
                                                                                  {"fitted", "withdrawn"},
                                                                                  {"verified", "withdrawn"},
                                                                                  {"released", "withdrawn"}}};

constexpr const char* kHeads =
    "SELECT unit, version, epoch, created_utc_s, coalesce((SELECT state FROM model_state WHERE model_state.unit = "
    "model.unit AND model_version = version ORDER BY model_state.rowid DESC LIMIT 1), 'fitted') FROM model ";

ModelHead head_from(sqlite::Fields& fields) {
  ModelHead head;
  head.unit = fields.text();
  head.version = fields.integer32();
  head.epoch = fields.integer32();
  head.created_utc_s = fields.real();
  head.state = fields.text();
  return head;
}

ModelStateRow state_from(sqlite::Fields& fields) {
  ModelStateRow row;
  row.unit = fields.text();
  row.version = fields.integer32();
  row.state = fields.text();
  row.reason = fields.text();
  row.user = fields.text();
  row.utc_s = fields.real();
  return row;
}

VerificationRow verification_from(sqlite::Fields& fields) {
  VerificationRow row;
  row.unit = fields.text();
  row.model_version = fields.integer32();
  row.utc_s = fields.real();
  row.user = fields.text();
  row.verdict = fields.text();
  row.document = fields.text();
  return row;
}

base::Status check_step(const std::string& from, const ModelStateRow& row, const std::string& where) {
  if (std::ranges::find(kSteps, std::pair<std::string_view, std::string_view>(from, row.state)) != kSteps.end()) {
    return {};
  }
  return base::bad_input(
      fmt::format("model {} of unit {} is {} and cannot become '{}': a model goes from fitted to verified to released, "
                  "and from each of these to withdrawn",
                  row.version, row.unit, from, row.state),
      where);
}

}  // namespace

base::Status catalog::require_model(const sqlite::Connection& connection, std::string_view unit, std::int32_t version) {
  const char* const sql = "SELECT 1 FROM model WHERE unit = ? AND version = ?";
  if (sqlite::has_row(connection.database(), sql, unit, version)) return {};
  return base::bad_input("unit '" + std::string(unit) + "' has no model version " + std::to_string(version),
                         connection.path().string());
}

base::Result<std::optional<ModelOrigin>> Catalog::model_origin(std::string_view unit, std::int32_t version) const {
  return impl_->connection.run("read the origin of the model", [&]() -> base::Result<std::optional<ModelOrigin>> {
    return sqlite::first_row_of(
        impl_->database(), "SELECT software, inputs_sha256, user FROM model_origin WHERE unit = ? AND version = ?",
        [](sqlite::Fields& fields) {
          ModelOrigin origin;
          origin.software = fields.text();
          origin.inputs_sha256 = fields.text();
          origin.user = fields.text();
          return origin;
        },
        unit, version);
  });
}

base::Result<std::vector<ModelHead>> Catalog::models(const std::optional<std::string>& unit) const {
  if (!unit) return impl_->rows("list the models", std::string(kHeads) + "ORDER BY unit, version", head_from);
  return impl_->rows("list the models", std::string(kHeads) + "WHERE unit = ? ORDER BY version", head_from, *unit);
}

base::Status Catalog::set_model_state(const ModelStateRow& row) {
  return impl_->connection.transact("change the state of the model", [&]() -> base::Status {
    const std::string where = impl_->connection.path().string();
    if (row.reason.empty() || row.user.empty()) {
      return base::bad_input("a change of the state of a model needs a reason and a user", where);
    }
    const auto known = sqlite::first_row_of(impl_->database(), std::string(kHeads) + "WHERE unit = ? AND version = ?",
                                            head_from, row.unit, row.version);
    if (!known) return catalog::require_model(impl_->connection, row.unit, row.version);
    if (auto allowed = check_step(known->state, row, where); !allowed) return allowed;
    sqlite::execute(impl_->database(),
                    "INSERT INTO model_state (model_state_id, unit, model_version, state, reason, user, utc_s) "
                    "VALUES (?, ?, ?, ?, ?, ?, ?)",
                    catalog::new_uuid(row.utc_s), row.unit, row.version, row.state, row.reason, row.user, row.utc_s);
    impl_->log(
        {row.utc_s, "model_" + row.state, row.unit, fmt::format("version {}: {}", row.version, row.reason), row.user});
    return {};
  });
}

base::Result<std::vector<ModelStateRow>> Catalog::model_history(std::string_view unit, std::int32_t version) const {
  return impl_->rows("read the states of the model",
                     "SELECT unit, version, 'fitted', 'fitted to its runs', coalesce((SELECT user FROM model_origin "
                     "WHERE model_origin.unit = model.unit AND model_origin.version = model.version), ''), "
                     "created_utc_s, 0 AS ordinal FROM model WHERE unit = ?1 AND version = ?2 "
                     "UNION ALL SELECT unit, model_version, state, reason, user, utc_s, rowid FROM model_state "
                     "WHERE unit = ?1 AND model_version = ?2 ORDER BY ordinal",
                     state_from, unit, version);
}

base::Status Catalog::add_verification(const VerificationRow& row) {
  return impl_->connection.transact("store the verification", [&]() -> base::Status {
    auto known = catalog::require_model(impl_->connection, row.unit, row.model_version);
    if (!known) return known;
    sqlite::execute(impl_->database(),
                    "INSERT INTO verification (verification_id, unit, model_version, utc_s, user, verdict, document) "
                    "VALUES (?, ?, ?, ?, ?, ?, ?)",
                    catalog::new_uuid(row.utc_s), row.unit, row.model_version, row.utc_s, row.user, row.verdict,
                    row.document);
    impl_->log(
        {row.utc_s, "verification", row.unit, fmt::format("version {}: {}", row.model_version, row.verdict), row.user});
    return {};
  });
}

base::Result<std::vector<VerificationRow>> Catalog::verifications(std::string_view unit, std::int32_t version) const {
  return impl_->rows("read the verifications",
                     "SELECT unit, model_version, utc_s, user, verdict, document FROM verification "
                     "WHERE unit = ? AND model_version = ? ORDER BY rowid",
                     verification_from, unit, version);
}

}  // namespace soak::db
