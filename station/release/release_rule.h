// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "calib/curve/calibration.h"
#include "db/catalog/catalog.h"

/// Which models may leave the laboratory (docs/guide.md, chapter 9).
namespace soak::station {

/// A version of a unit's model, or the newest, that may be worked with. Refuses (bad_input) an unknown unit or version,
/// a unit without a model, and a model of an earlier epoch.
[[nodiscard]] base::Result<db::ModelRow> usable_model(const db::Catalog& catalog, const std::string& unit,
                                                      std::optional<std::int32_t> version);

/// A version of a unit's model without its document; fails (bad_input) for one that there is not.
[[nodiscard]] base::Result<db::ModelHead> model_head(const db::Catalog& catalog, const std::string& unit,
                                                     std::int32_t version);

/// The newest released version of a unit's model; nothing where there is none.
[[nodiscard]] base::Result<std::optional<db::ModelHead>> newest_released(const db::Catalog& catalog,
                                                                         const std::string& unit);

/// Why nobody may hand a model over before its state changes, and what would be right; names a version that is released
/// where there is one.
[[nodiscard]] base::Result<std::string> not_released_text(const db::Catalog& catalog, const db::ModelHead& head);

/// The last verification of a model.
struct LastVerification {
  db::VerificationRow row;
  std::string campaign;           ///< of the fresh runs
  std::string limits;             ///< where they stand; empty = there were none
  std::vector<std::string> runs;  ///< run ids of the fresh runs
};

/// What speaks for and against handing a model over.
struct ReleaseCase {
  db::ModelHead head;
  calib::Calibration calibration;
  std::optional<LastVerification> verification;
  std::optional<double> expires_utc_s;  ///< earliest due date of its references that needed no waiver; none: never
  std::vector<std::string> obstacles;   ///< each what is wrong and what would be right; none: the rule is kept
  /// It is released, a later verification did not pass, the last one does, and nobody has released it again: that is
  /// one of the obstacles then.
  bool is_to_be_released_again = false;
};

/// Judges a model by the rule of release at a time. **Passed**: its last verification says pass, against measured runs
/// where the model is of measured data. **Fresh**: it is of the unit's epoch; its runs are those that a fit of all
/// would take now (fitted_runs.h); nothing of its runs, of the runs of that verification and of the references of both
/// was withdrawn since; no reference that its runs were measured with has come due, but for those by a waiver. A model
/// that is withdrawn never keeps it. A release does not outlive a verification without a pass: once one says pass
/// again, somebody has to release the model anew. Fails (corrupt) where stored data are damaged.
[[nodiscard]] base::Result<ReleaseCase> judge_release(const db::Catalog& catalog, const db::ModelHead& head,
                                                      double now_utc_s);

/// The released models that keep the rule now and rest on an entry of the register of references, by their own runs or
/// by those of their last verification: retired, it would be in the way of each. A model whose records are damaged is
/// none.
[[nodiscard]] base::Result<std::vector<db::ModelHead>> released_with(const db::Catalog& catalog,
                                                                     const std::string& record_id, double now_utc_s);

}  // namespace soak::station
