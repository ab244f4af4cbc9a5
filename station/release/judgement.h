// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "calib/curve/calibration.h"
#include "calib/judge/verification.h"
#include "calib/model/unit_model.h"
#include "db/catalog/catalog.h"
#include "station/config/unit_type_file.h"

/// What fresh runs say of a calibration, and what becomes of the model that it is of.
namespace soak::station {

/// A calibration compared with fresh runs, and what the comparison rests on.
struct Judgement {
  calib::Calibration calibration;
  KnownLimits limits;
  std::string campaign;  ///< of the fresh runs
  calib::Verification verification;
  std::vector<calib::ModelTerm> terms;          ///< effects that were taken off the readings, as a device does
  std::vector<db::RunRow> runs;                 ///< the fresh ones
  std::vector<calib::ReferenceUse> references;  ///< that the fresh runs were measured with
  double read_utc_s = 0.0;                      ///< just before the fresh runs were read
};

/// Compares a calibration, as it is read from a file, with the runs of its unit in a campaign that count: sealed, not
/// voided, of its epoch, not for diagnosis. Refuses (bad_input) an unknown campaign, one without such runs, simulated
/// runs for a calibration of measured data, and what calib::verify() refuses; fails (corrupt) where stored data are
/// damaged.
[[nodiscard]] base::Result<Judgement> verify_against(const db::Catalog& catalog, calib::Calibration calibration,
                                                     const std::string& campaign, KnownLimits limits);

/// The decision rule in words. Its bound of the risk holds only where U is the whole uncertainty.
[[nodiscard]] std::string decision_rule(const calib::Verification& verification);

/// The document that is stored: verdict with limits, runs, references and the version of the program
/// (docs/schema/verify.schema.json but for `stored` and `state`, which are not of the verdict). Simulates drives: some
/// 0.2 s of processor time.
[[nodiscard]] nlohmann::json judgement_json(const Judgement& judgement);

/// The stored model that a calibration, as it is read from a file, is, whatever its file's signature or mark; nothing
/// where the catalog has none or holds other curves under that version (another station's, or the table form).
[[nodiscard]] base::Result<std::optional<db::ModelHead>> stored_model_of(const db::Catalog& catalog,
                                                                         const calib::Calibration& calibration);

/// What became of a judgement.
struct StoredJudgement {
  bool stored = false;
  std::string state;  ///< of the model from now on; empty where it is none of this catalog
  std::string why;    ///< it was not stored; empty where it was
};

/// Stores the judgement of a model of the catalog as of the time when its runs were read, all or nothing; the state is
/// that of this moment, whatever others stored meanwhile. By a pass a fitted model becomes verified; by
/// anything else a verified one becomes fitted again. A released one stays released: to withdraw it is for people to
/// decide.
/// `document`: judgement_json() of it.
[[nodiscard]] base::Result<StoredJudgement> store_judgement(db::Catalog& catalog, const Judgement& judgement,
                                                            const nlohmann::json& document);

}  // namespace soak::station
