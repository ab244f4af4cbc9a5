// SPDX-License-Identifier: Apache-2.0
#include "station/lab/lost_runs.h"

#include <fmt/format.h>

#include <string>
#include <string_view>

#include "db/catalog/catalog.h"
#include "db/run/run_file.h"
#include "station/lab/run_source.h"
#include "station/runs/run_records.h"

namespace soak::station {
namespace {

constexpr std::string_view kWhy = "soakd ended in mid-run";
constexpr std::string_view kTypeOfUnknownUnit = "generic";

/// Number of units whose samples were entered; 0 where the file holds none.
base::Result<std::size_t> enter(db::Catalog& catalog, const db::OrphanRunFile& orphan) {
  auto sha256 = db::RunFileWriter::seal_interrupted(orphan.path, kWhy);
  if (!sha256) return base::forward_error(sha256);
  SealedRun run;
  run.path = orphan.path;
  run.sha256 = *std::move(sha256);
  run.void_reason = kWhy;
  for (const std::string& serial : orphan.units) run.units.push_back({serial, std::string(kTypeOfUnknownUnit)});
  const auto rows = enter_run(catalog, run);
  if (!rows) return base::forward_error(rows);
  return rows->size();
}

std::string outcome_text(const base::Result<std::size_t>& entered) {
  if (!entered) return "stays as it is: " + entered.error().message;
  return *entered > 0 ? "is sealed, entered and voided" : "is sealed; it holds no samples";
}

}  // namespace

base::Status enter_lost_runs(db::Catalog& catalog, EventLog& log) {
  const auto orphans = db::orphan_run_files(catalog);
  if (!orphans) return base::forward_error(orphans);
  for (const db::OrphanRunFile& orphan : *orphans) {
    // Files of other writers (an import that is at work) are theirs.
    if (!orphan.info || orphan.info->source != kRunSource) continue;
    const auto entered = enter(catalog, orphan);
    // An empty file that was sealed before has been told of then.
    if (entered && *entered == 0 && orphan.sealed) continue;
    log.add("run", orphan.info->label,
            fmt::format("{} was left behind and {}", orphan.path.filename().string(), outcome_text(entered)));
  }
  return {};
}

}  // namespace soak::station
