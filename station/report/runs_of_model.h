// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "calib/curve/calibration.h"
#include "calib/estimate/unit_rows.h"
#include "calib/vocabulary/warning.h"
#include "db/catalog/catalog.h"

namespace soak::station {

/// What a run of the unit is to a model of it.
enum class RunUse {
  fitted,     ///< the model was fitted to it
  fresh,      ///< of a verification: no fit sees it
  not_used,   ///< could be fitted and was not: entered later, or of a campaign that was left out
  diagnosis,  ///< pre-flight, Allan recording
  voided,     ///< withdrawn
  unsealed,   ///< still being recorded, or cut short
};

constexpr std::string_view name_of(RunUse use) {
  constexpr std::string_view kNames[] = {"fitted", "fresh", "not_used", "diagnosis", "voided", "unsealed"};
  return kNames[static_cast<int>(use)];
}

/// A run with all its void records.
struct UsedRun {
  db::RunRow run;
  RunUse use = RunUse::not_used;
  std::vector<db::VoidRecord> voids;
};

/// The runs of a unit in the epoch of a model, in the catalog's order, and what must be said of them: runs of the model
/// that are gone or were withdrawn after the fit, runs that it could have used.
struct RunsOfModel {
  std::vector<UsedRun> runs;
  std::vector<calib::Warning> warnings;
};

/// A run belongs to the model where the model lists its content hash, as often as it lists it, unless it was withdrawn
/// before the fit.
[[nodiscard]] base::Result<RunsOfModel> runs_of_model(const db::Catalog& catalog,
                                                      const calib::Calibration& calibration);

/// The references that a run was measured with: those that the model stored for its own runs, else those of the run's
/// campaign.
[[nodiscard]] base::Result<std::vector<calib::ReferenceUse>> references_of(const db::Catalog& catalog,
                                                                           const calib::Calibration& calibration,
                                                                           const UsedRun& run);

/// The segments of the runs of one use with their references, as make_rows() takes them; none of a run that was
/// withdrawn as a whole. Samples that were stored more than once count once: a warning says so.
[[nodiscard]] base::Result<calib::UnitInput> input_of(const db::Catalog& catalog, const calib::Calibration& calibration,
                                                      const RunsOfModel& runs, RunUse use,
                                                      std::vector<calib::Warning>& warnings);

/// The section `provenance` of a report: each run of the unit's epoch with its content hash, how it was recorded, what
/// it is to the model, and what of it is void; the hash of the stored model document. `calibration` is that of `model`.
[[nodiscard]] base::Result<nlohmann::json> provenance_json(const db::Catalog& catalog, const db::ModelRow& model,
                                                           const calib::Calibration& calibration,
                                                           const RunsOfModel& runs);

}  // namespace soak::station
