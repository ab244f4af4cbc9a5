// SPDX-License-Identifier: Apache-2.0
#include "station/lab/lost_runs.h"

#include <fmt/format.h>

#include "db/orphans.h"
#include "db/run_file.h"
#include "station/identity.h"
#include "station/lab/run_records.h"
#include "station/lab/run_source.h"

namespace soak::station {
namespace {

constexpr std::string_view kWhy = "soakd ended in mid-run";

base::Status void_rows(db::Catalog& catalog, const std::vector<db::RunRow>& rows) {
  for (const db::RunRow& row : rows) {
    db::VoidRecord record;
    record.run_id = row.run_id;
    record.unit = row.unit;
    record.reason = kWhy;
    record.user = "soakd";
    record.utc_s = now_utc_s();
    if (auto status = catalog.add_void(record); !status) return status;
  }
  return {};
}

base::Status enter(db::Catalog& catalog, const db::OrphanRunFile& orphan) {
  const auto sha256 = db::RunFileWriter::seal_interrupted(orphan.path, kWhy);
  if (!sha256) return base::forward_error(sha256);
  SealedRun run;
  run.path = orphan.path;
  run.sha256 = *sha256;
  for (const std::string& serial : orphan.units) run.units.push_back({serial, "generic"});
  const auto rows = enter_run(catalog, run);
  if (!rows) return base::forward_error(rows);
  return void_rows(catalog, *rows);
}

}  // namespace

base::Status enter_lost_runs(db::Catalog& catalog, EventLog& log) {
  const auto orphans = db::orphan_run_files(catalog);
  if (!orphans) return base::forward_error(orphans);
  for (const db::OrphanRunFile& orphan : *orphans) {
    const std::string name = orphan.path.filename().string();
    // Files of other writers (an import that is at work) are theirs.
    if (!orphan.info || orphan.info->source != kRunSource) continue;
    const auto entered = enter(catalog, orphan);
    log.add("run", orphan.info->label,
            entered ? fmt::format("{} was left open: sealed, entered and voided", name)
                    : fmt::format("{} was left open and stays as it is: {}", name, entered.error().message));
  }
  return {};
}

}  // namespace soak::station
