// SPDX-License-Identifier: Apache-2.0
#include <SQLiteCpp/Column.h>
#include <SQLiteCpp/Statement.h>

#include <algorithm>
#include <array>

#include "db/catalog/detail/impl.h"
#include "db/detail/sqlite.h"

namespace soak::db {
namespace {

constexpr std::array<std::string_view, 6> kStates = {"running",  "paused",  "interrupted",
                                                     "finished", "aborted", "failed"};

bool is_open(std::string_view state) { return state == "running" || state == "paused"; }

base::Status check_state(std::string_view state, const std::string& where) {
  if (std::find(kStates.begin(), kStates.end(), state) != kStates.end()) return {};
  return base::bad_input("'" + std::string(state) + "' is not a state of a campaign", where);
}

CampaignRow campaign_from(sqlite::Fields& fields) {
  CampaignRow row;
  row.name = fields.text();
  row.procedure = fields.text();
  row.document = fields.text();
  row.state = fields.text();
  row.reason = fields.text();
  row.created_utc_s = fields.real();
  row.updated_utc_s = fields.real();
  return row;
}

/// The journal that fits the rest of a query, which has one parameter.
std::optional<CampaignRow> find_journal(const SQLite::Database& database, const std::string& condition,
                                        std::string_view parameter) {
  return sqlite::first_row_of(database,
                              "SELECT name, procedure, document, state, reason, created_utc_s, updated_utc_s "
                              "FROM journal JOIN campaign ON campaign.name = journal.campaign WHERE " +
                                  condition,
                              campaign_from, parameter);
}

std::optional<CampaignRow> journal_of(const SQLite::Database& database, std::string_view campaign) {
  return find_journal(database, "journal.campaign = ?", campaign);
}

/// An open campaign other than `campaign`.
std::optional<CampaignRow> other_open_journal(const SQLite::Database& database, std::string_view campaign) {
  return find_journal(database, "state IN ('running', 'paused') AND journal.campaign <> ?", campaign);
}

base::Status refuse_second_open(const sqlite::Connection& connection, std::string_view campaign,
                                std::string_view state) {
  if (!is_open(state)) return {};
  const auto other = other_open_journal(connection.database(), campaign);
  if (!other) return {};
  return base::bad_input("campaign '" + other->name + "' is " + other->state + "; end it first",
                         connection.path().string());
}

base::Status require_journal(const sqlite::Connection& connection, std::string_view campaign) {
  if (journal_of(connection.database(), campaign)) return {};
  return base::bad_input("the catalog has no journal of a campaign '" + std::string(campaign) + "'",
                         connection.path().string());
}

base::Status refuse_used_name(const sqlite::Connection& connection, std::string_view campaign) {
  const char* const sql = "SELECT 1 FROM run WHERE campaign = ?1 UNION ALL SELECT 1 FROM journal WHERE campaign = ?1";
  if (!sqlite::has_row(connection.database(), sql, campaign)) return {};
  return base::bad_input("there is a campaign '" + std::string(campaign) + "' already; use another name",
                         connection.path().string());
}

base::Status check_new(const sqlite::Connection& connection, const CampaignRow& campaign) {
  const std::string where = connection.path().string();
  if (campaign.name.empty()) return base::bad_input("a campaign needs a name", where);
  if (const auto known = check_state(campaign.state, where); !known) return known;
  if (const auto free = refuse_used_name(connection, campaign.name); !free) return free;
  return refuse_second_open(connection, campaign.name, campaign.state);
}

void insert_journal(SQLite::Database& database, const CampaignRow& campaign) {
  sqlite::execute(database,
                  "INSERT INTO journal (campaign, document, state, reason, created_utc_s, updated_utc_s) "
                  "VALUES (?, ?, ?, ?, ?, ?)",
                  campaign.name, campaign.document, campaign.state, campaign.reason, campaign.created_utc_s,
                  campaign.created_utc_s);
}

base::Status check_step(const sqlite::Connection& connection, const StepRow& step) {
  const std::string where = connection.path().string();
  if (step.index < 0 || step.attempt < 0) return base::bad_input("steps and attempts count from 0", where);
  if (const auto known = require_journal(connection, step.campaign); !known) return known;
  const char* const same = "SELECT 1 FROM step WHERE campaign = ? AND step_index = ? AND attempt = ?";
  if (!sqlite::has_row(connection.database(), same, step.campaign, step.index, step.attempt)) return {};
  return base::bad_input("attempt " + std::to_string(step.attempt) + " of step " + std::to_string(step.index) +
                             " of campaign '" + step.campaign + "' is in the journal already",
                         where);
}

StepRow step_from(sqlite::Fields& fields) {
  StepRow step;
  step.campaign = fields.text();
  step.index = fields.integer32();
  step.attempt = fields.integer32();
  step.started_utc_s = fields.real();
  step.ended_utc_s = fields.real();
  step.outcome = fields.text();
  step.text = fields.text();
  step.run_id = fields.text();
  return step;
}

}  // namespace

base::Status Catalog::begin_campaign(const CampaignRow& campaign) {
  return impl_->connection.transact("begin the campaign", [&]() -> base::Status {
    if (const auto valid = check_new(impl_->connection, campaign); !valid) return valid;
    if (auto added = ensure_campaign(campaign.name, campaign.procedure); !added) return added;
    insert_journal(impl_->database(), campaign);
    impl_->log({catalog::now_utc_s(), "campaign_begun", campaign.name, "procedure '" + campaign.procedure + "'"});
    return {};
  });
}

base::Result<std::optional<CampaignRow>> Catalog::campaign(std::string_view name) const {
  return impl_->connection.run("read the campaign", [&]() -> base::Result<std::optional<CampaignRow>> {
    return journal_of(impl_->database(), name);
  });
}

base::Result<std::optional<CampaignRow>> Catalog::open_campaign() const {
  return impl_->connection.run("read the campaigns", [&]() -> base::Result<std::optional<CampaignRow>> {
    return other_open_journal(impl_->database(), "");
  });
}

base::Result<std::optional<CampaignRow>> Catalog::last_campaign() const {
  return impl_->connection.run("read the campaigns", [&]() -> base::Result<std::optional<CampaignRow>> {
    return find_journal(impl_->database(),
                        "created_utc_s = (SELECT max(created_utc_s) FROM journal) AND "
                        "journal.campaign <> ?",
                        "");
  });
}

base::Status Catalog::set_campaign_state(std::string_view name, std::string_view state, std::string_view reason,
                                         std::string_view user) {
  return impl_->connection.transact("change the campaign's state", [&]() -> base::Status {
    if (const auto known = check_state(state, impl_->connection.path().string()); !known) return known;
    if (const auto known = require_journal(impl_->connection, name); !known) return known;
    if (const auto single = refuse_second_open(impl_->connection, name, state); !single) return single;
    const double utc_s = catalog::now_utc_s();
    sqlite::execute(impl_->database(), "UPDATE journal SET state = ?, reason = ?, updated_utc_s = ? WHERE campaign = ?",
                    state, reason, utc_s, name);
    impl_->log({utc_s, "campaign_" + std::string(state), std::string(name), std::string(reason), std::string(user)});
    return {};
  });
}

base::Status Catalog::complete_step(const StepRow& step) {
  return impl_->connection.transact("enter the step", [&]() -> base::Status {
    if (const auto valid = check_step(impl_->connection, step); !valid) return valid;
    sqlite::execute(impl_->database(),
                    "INSERT INTO step (campaign, step_index, attempt, started_utc_s, ended_utc_s, outcome, "
                    "text, run_id) VALUES (?, ?, ?, ?, ?, ?, ?, ?)",
                    step.campaign, step.index, step.attempt, step.started_utc_s, step.ended_utc_s, step.outcome,
                    step.text, step.run_id);
    return {};
  });
}

base::Result<std::vector<StepRow>> Catalog::completed_steps(std::string_view campaign) const {
  return impl_->rows("read the journal",
                     "SELECT campaign, step_index, attempt, started_utc_s, ended_utc_s, outcome, text, run_id "
                     "FROM step WHERE campaign = ? ORDER BY ordinal",
                     step_from, campaign);
}

}  // namespace soak::db
