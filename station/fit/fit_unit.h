// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "calib/estimate/unit_rows.h"
#include "calib/model/unit_model.h"
#include "calib/vocabulary/warning.h"
#include "db/catalog/catalog.h"
#include "station/fit/fit_inputs.h"

/// From the catalog to the stored model of a unit.
namespace soak::station {

/// Why no fit takes any run of the unit as it is, in the words of load_unit(); empty where one would.
[[nodiscard]] base::Result<std::string> why_nothing_to_fit(const db::Catalog& catalog, const std::string& unit);

/// Sealed, unvoided runs of the unit's current epoch that are for calibration (not for verification, no pre-flight),
/// with the statistics of their segments and the references of their campaigns; of one campaign only, where that is
/// given. Samples that were stored more than once count once (calib/estimate/unit_input.h). Adds to `warnings` what
/// must be told of that and of the unit's type. Refuses an unknown unit or campaign, and a unit without such runs,
/// saying which runs there are and why they do not count; fails (corrupt) for a damaged waiver and as load_run() does.
[[nodiscard]] base::Result<calib::UnitInput> load_unit(const db::Catalog& catalog, const std::string& unit,
                                                       const std::optional<std::string>& campaign,
                                                       std::vector<calib::Warning>& warnings);

/// Whether a fit of the unit's present epoch takes a run: sealed, not voided, of that epoch, for calibration.
[[nodiscard]] bool is_for_fit(const db::RunRow& run, std::int32_t epoch);

/// Refuses (bad_input) a campaign that the catalog does not have, with some that it has.
[[nodiscard]] base::Status check_campaign_known(const db::Catalog& catalog, const std::string& campaign);

/// The unit of a calibration with what its type's file says, in the calibration's epoch; no runs yet.
[[nodiscard]] base::Result<calib::UnitInput> unit_of(const calib::Calibration& calibration);

/// A run of the catalog, of a unit of that type, as input of a fit or a verification; of a session on a bench
/// (is_bench_session()) with the gyros' samples between its rests, as long as it has samples. Fails (corrupt) where its
/// file is damaged, or missing although nobody has dropped its samples.
[[nodiscard]] base::Result<calib::RunInput> load_run(const db::Catalog& catalog, const db::RunRow& run,
                                                     const calib::UnitType& type);

/// Accepted terms that the unit's newest model carries; none where it has no model, or only of another epoch.
[[nodiscard]] base::Result<std::vector<calib::ModelTerm>> accepted_terms(const db::Catalog& catalog,
                                                                         const std::string& unit, std::int32_t epoch);

/// Takes terms off the segments of `input`, and notes them there; the run files are read for it. `warnings` gets what
/// could not be taken off (`term_not_evaluated`). Without terms nothing is done.
[[nodiscard]] base::Status take_terms_off(const db::Catalog& catalog, const std::vector<calib::ModelTerm>& terms,
                                          calib::UnitInput& input, std::vector<calib::Warning>& warnings);

/// What the check standards say of the campaigns of units that are fitted one after the other: each campaign is looked
/// at once, as its charts take all runs of the standard.
class CheckWarnings {
 public:
  explicit CheckWarnings(const db::Catalog& catalog) : catalog_(catalog) {}

  /// Of the campaigns of the unit's runs.
  [[nodiscard]] base::Result<std::vector<calib::Warning>> of(const calib::UnitInput& input);

 private:
  base::Result<std::vector<calib::Warning>> of_campaign(const std::string& campaign);

  const db::Catalog& catalog_;
  std::map<std::string, std::vector<calib::Warning>> known_;
};

/// A unit that is ready to be fitted.
struct PreparedFit {
  calib::UnitInput input;  ///< freed of the accepted terms
  calib::UnitRows rows;
  std::vector<calib::Warning> warnings;  ///< of the station, to be told with those of the fit
};

/// Takes `terms` off, makes rows, and adds to `warnings` what the station knows of the campaigns of the unit's runs:
/// check standards, references. Fails as take_terms_off() and make_rows() do.
[[nodiscard]] base::Result<PreparedFit> prepare_fit(const db::Catalog& catalog, calib::UnitInput input,
                                                    const std::vector<calib::ModelTerm>& terms,
                                                    CheckWarnings& check_warnings,
                                                    std::vector<calib::Warning> warnings);

/// How a unit is fitted; the result does not depend on it.
struct FitWork {
  int jobs = 0;                               ///< threads; 0: one per core
  std::function<bool(double)> progress = {};  ///< gets the share of the sensors that is done; calls come one at a time
};

/// Fits all sensors of a unit. Fails where a sensor cannot be fitted, and (internal) where the user interrupts.
[[nodiscard]] base::Result<calib::UnitModel> fitted_model(const PreparedFit& prepared,
                                                          const calib::CurveFitOptions& options, const FitWork& work);

/// Stores a model as the unit's next version, which it gets, as of the time when `inputs` were seen (fit_inputs.h), and
/// with their digest (empty: it is no fit of all runs, and none is stored).
[[nodiscard]] base::Status store_model(db::Catalog& catalog, calib::UnitModel& model, const FitInputs& inputs);

/// All three, one after the other: the new version carries `terms`. What sensors that were recorded one way lack comes
/// from the other units of the type as they are now (fleet_hysteresis.h). `input` comes back as it was fitted.
/// `inputs`: fit_inputs_now() before the unit was loaded; without digest where this is no fit of all its runs.
[[nodiscard]] base::Result<calib::UnitModel> fit_with_terms(db::Catalog& catalog, calib::UnitInput& input,
                                                            const std::vector<calib::ModelTerm>& terms,
                                                            const calib::CurveFitOptions& options, const FitWork& work,
                                                            CheckWarnings& check_warnings,
                                                            std::vector<calib::Warning> warnings,
                                                            const FitInputs& inputs);

/// Fits a unit as `parent` was fitted, to the same runs with the same options, but freed of `terms`. What was voided
/// since is left out, with the warning `runs_left_since`; refuses (bad_input) where nothing is left.
[[nodiscard]] base::Result<calib::UnitModel> fit_again(db::Catalog& catalog, const db::ModelRow& parent,
                                                       const std::vector<calib::ModelTerm>& terms);

}  // namespace soak::station
