// SPDX-License-Identifier: Apache-2.0
#include "station/records/sample_drop.h"

#include <fmt/format.h>

#include <filesystem>
#include <optional>
#include <system_error>
#include <utility>

#include "calib/estimate/moves.h"
#include "calib/model/model_document.h"
#include "db/durable.h"
#include "db/run/run_file.h"
#include "station/io/host.h"

namespace soak::station {
namespace {

namespace fs = std::filesystem;

/// The campaign may still go on, and then looks at what it has recorded.
base::Status check_campaign_is_over(const db::Catalog& catalog, const db::RunRow& run) {
  const auto journal = catalog.campaign(run.campaign);
  if (!journal) return base::forward_error(journal);
  const auto last = catalog.last_campaign();
  if (!last) return base::forward_error(last);
  if (!*journal) return {};
  const std::string& state = (*journal)->state;
  const bool goes_on = state == "running" || state == "paused";
  // The last campaign can be resumed after these, until another one begins.
  const bool may_go_on = (*last)->name == run.campaign && (state == "interrupted" || state == "failed");
  if (!goes_on && !may_go_on) return {};
  return base::bad_input(fmt::format("campaign '{}' is {}: its samples stay until it is finished, or given up with "
                                     "'soak campaign abort'",
                                     run.campaign, state),
                         run.label);
}

/// Versions of a unit's model of that epoch that carry accepted terms: the newest such version with one of its terms.
base::Result<std::optional<std::pair<std::int32_t, std::string>>> model_with_term(const db::Catalog& catalog,
                                                                                  const std::string& unit,
                                                                                  std::int32_t epoch) {
  const auto newest = catalog.model(unit);
  if (!newest) return base::forward_error(newest);
  for (std::int32_t version = *newest ? (*newest)->version : 0; version > 0; --version) {
    const auto model = catalog.model(unit, version);
    if (!model) return base::forward_error(model);
    if (!*model || (*model)->epoch != epoch) continue;
    const auto terms = calib::model_terms_of((*model)->document);
    if (!terms) return base::forward_error(terms);
    if (!terms->empty()) return std::pair(version, terms->front().name);
  }
  return std::nullopt;
}

/// Fits, verifications and reports use the catalog's statistics; two of their steps read samples.
base::Status check_nothing_needs_samples(const db::Catalog& catalog, const db::RunRow& part) {
  if (part.voided || part.purpose == "diagnosis") return {};
  const auto segments = catalog.segments(part.run_id, part.unit, false);
  if (!segments) return base::forward_error(segments);
  if (calib::is_bench_session(*segments)) {
    return base::bad_input(fmt::format("run '{}' of unit {} is a session on a bench: each fit reads what the unit did "
                                       "between its rests. Void the run first if it is not wanted any more",
                                       part.label, part.unit),
                           part.run_id);
  }
  const auto model = model_with_term(catalog, part.unit, part.epoch);
  if (!model) return base::forward_error(model);
  if (!*model) return {};
  return base::bad_input(
      fmt::format("model {} of unit {} carries the accepted term '{}', which is taken off the samples of run '{}' "
                  "whenever that model is verified, reported or fitted again",
                  (*model)->first, part.unit, (*model)->second, part.label),
      part.run_id);
}

/// What the catalog keeps must be whole before the samples that could give it again are gone.
base::Status check_run_part(const db::Catalog& catalog, const db::RunRow& part) {
  if (!part.sealed) return base::bad_input("is not sealed: its recording has not ended", part.label);
  if (auto kept = catalog.check_numbers(part); !kept) return kept;
  if (auto whole = catalog.check_run_file(part); !whole) return whole;
  return check_nothing_needs_samples(catalog, part);
}

}  // namespace

base::Result<SamplePlan> plan_sample_drop(const db::Catalog& catalog, const std::string& run_id) {
  const auto parts = catalog.runs({.unit = {}, .campaign = {}, .run = run_id});
  if (!parts) return base::forward_error(parts);
  if (parts->empty()) return base::bad_input("the catalog has no such run", run_id);
  SamplePlan plan;
  plan.run = parts->front();
  for (const db::RunRow& part : *parts) plan.units.push_back(part.unit);
  if (plan.run.samples_dropped) return base::forward_error(catalog.open_run_file(plan.run));
  if (auto over = check_campaign_is_over(catalog, plan.run); !over) return base::forward_error(over);
  for (const db::RunRow& part : *parts) {
    if (auto free = check_run_part(catalog, part); !free) return base::forward_error(free);
  }
  const auto file = catalog.open_run_file(plan.run);
  if (!file) return base::forward_error(file);
  plan.source = file->info().source;
  std::error_code ignored;
  plan.bytes = fs::file_size(catalog.run_file_path(plan.run), ignored);
  return plan;
}

base::Status drop_samples(db::Catalog& catalog, const SamplePlan& plan, std::string_view reason,
                          std::string_view user) {
  if (auto over = check_campaign_is_over(catalog, plan.run); !over) return over;
  const auto parts = catalog.runs({.unit = {}, .campaign = {}, .run = plan.run.run_id});
  if (!parts) return base::forward_error(parts);
  for (const db::RunRow& part : *parts) {
    if (auto free = check_nothing_needs_samples(catalog, part); !free) return free;
  }
  auto noted = catalog.add_sample_drop(
      {plan.run.run_id, plan.source, plan.bytes, std::string(reason), std::string(user), now_utc_s()});
  if (!noted) return noted;
  const fs::path path = catalog.run_file_path(plan.run);
  std::error_code error;
  fs::remove(path, error);
  if (error) {
    return base::fail(
        base::ErrorKind::internal,
        fmt::format("the drop is noted, but the file cannot be removed: {}; mend that and give the command again",
                    error.message()),
        path.string());
  }
  return db::sync_name(path);
}

}  // namespace soak::station
