// SPDX-License-Identifier: Apache-2.0
#include "station/records/sample_drop.h"

#include <fmt/format.h>

#include <filesystem>
#include <optional>
#include <system_error>
#include <utility>

#include "calib/estimate/moves.h"
#include "db/durable.h"
#include "db/run/run_file.h"
#include "station/fit/fit_unit.h"
#include "station/io/host.h"

namespace soak::station {
namespace {

namespace fs = std::filesystem;

/// The campaign may still go on, and then looks at what it has recorded.
base::Status check_campaign_is_over(const db::Catalog& catalog, const db::RunRow& run) {
  const auto journal = catalog.campaign(run.campaign);
  if (!journal) return base::forward_error(journal);
  if (!*journal || ((*journal)->state != "running" && (*journal)->state != "paused")) {
    const auto last = catalog.last_campaign();
    if (!last) return base::forward_error(last);
    const bool may_go_on = *last && (*last)->name == run.campaign && (*last)->state == "interrupted";
    if (!may_go_on) return {};
  }
  return base::bad_input(fmt::format("campaign '{}' is not over ({}): its samples stay until it is finished or aborted",
                                     run.campaign, (*journal)->state),
                         run.label);
}

/// Whether a fit or a verification may ever read this part of a run.
bool may_be_used(const db::RunRow& part, const db::UnitRow& unit) {
  return !part.voided && part.epoch == unit.epoch && part.purpose != "diagnosis";
}

/// Fits use the catalog's statistics; two of their steps read samples.
base::Status check_no_fit_needs_samples(const db::Catalog& catalog, const db::RunRow& part) {
  const auto unit = catalog.unit(part.unit);
  if (!unit) return base::forward_error(unit);
  if (!*unit || !may_be_used(part, **unit)) return {};
  const auto segments = catalog.segments(part.run_id, part.unit, false);
  if (!segments) return base::forward_error(segments);
  if (calib::is_bench_session(*segments)) {
    return base::bad_input(fmt::format("run '{}' of unit {} is a session on a bench: each fit reads what the unit did "
                                       "between its rests. Void the run first if it is not wanted any more",
                                       part.label, part.unit),
                           part.run_id);
  }
  const auto terms = accepted_terms(catalog, part.unit, (*unit)->epoch);
  if (!terms) return base::forward_error(terms);
  if (terms->empty()) return {};
  return base::bad_input(
      fmt::format("the model of unit {} carries the accepted term '{}', which each later fit and verification takes "
                  "off the samples of run '{}'",
                  part.unit, terms->front().name, part.label),
      part.run_id);
}

/// What the catalog keeps must be whole before the samples that could give it again are gone.
base::Status check_part(const db::Catalog& catalog, const db::RunRow& part) {
  if (!part.sealed) return base::bad_input("is not sealed: its recording has not ended", part.label);
  if (auto kept = catalog.check_numbers(part); !kept) return kept;
  if (auto whole = catalog.check_run_file(part); !whole) return whole;
  return check_no_fit_needs_samples(catalog, part);
}

}  // namespace

base::Result<SamplePlan> plan_sample_drop(const db::Catalog& catalog, const std::string& run_id) {
  const auto parts = catalog.runs({.unit = {}, .campaign = {}, .run = run_id});
  if (!parts) return base::forward_error(parts);
  if (parts->empty()) return base::bad_input("the catalog has no such run", run_id);
  SamplePlan plan;
  plan.run = parts->front();
  for (const db::RunRow& part : *parts) plan.units.push_back(part.unit);
  const fs::path path = catalog.run_file_path(plan.run);
  std::error_code ignored;
  if (plan.run.samples_dropped) {
    if (!fs::exists(path, ignored)) return base::forward_error(catalog.open_run_file(plan.run));
    plan.source = plan.run.samples_dropped->source;
    plan.bytes = fs::file_size(path, ignored);
    plan.is_noted = true;
    return plan;
  }
  if (auto over = check_campaign_is_over(catalog, plan.run); !over) return base::forward_error(over);
  for (const db::RunRow& part : *parts) {
    if (auto free = check_part(catalog, part); !free) return base::forward_error(free);
  }
  const auto file = catalog.open_run_file(plan.run);
  if (!file) return base::forward_error(file);
  plan.source = file->info().source;
  plan.bytes = fs::file_size(path, ignored);
  return plan;
}

base::Status drop_samples(db::Catalog& catalog, const SamplePlan& plan, std::string_view reason,
                          std::string_view user) {
  if (!plan.is_noted) {
    db::SampleDrop drop{plan.run.run_id, plan.source, plan.bytes, std::string(reason), std::string(user), now_utc_s()};
    if (auto noted = catalog.add_sample_drop(drop); !noted) return noted;
  }
  const fs::path path = catalog.run_file_path(plan.run);
  std::error_code error;
  fs::remove(path, error);
  if (error) {
    return base::fail(
        base::ErrorKind::internal,
        fmt::format("the drop is noted, but the file cannot be removed: {}; give the command again", error.message()),
        path.string());
  }
  return db::sync_name(path);
}

}  // namespace soak::station
