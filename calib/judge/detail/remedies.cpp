// SPDX-License-Identifier: Apache-2.0
#include "calib/judge/detail/remedies.h"

#include <algorithm>
#include <array>

namespace soak::calib {
namespace {

struct Remedy {
  std::string_view code;
  std::string_view text;
};

constexpr std::string_view kRecordAgain =
    "Record those segments again; where a label was wrong, correct it and import into a new campaign.";
constexpr std::string_view kNothing = "Nothing: this is for your information.";
constexpr std::string_view kFitAgain = "Fit again with 'soak fit', then make this report anew.";

constexpr std::array kRemedies = {
    // of the data gate
    Remedy{"moved", kRecordAgain},
    Remedy{"knocked", kRecordAgain},
    Remedy{"wrong_position", kRecordAgain},
    Remedy{"saturated", kRecordAgain},
    Remedy{"stuck", "Check the sensor and its connection, then record those segments again."},
    Remedy{"dropouts", "Check cable and logger for lost samples, then record those segments again."},
    Remedy{"irregular_sampling", "Check the logger's clock; standard errors take samples as equally spaced."},
    Remedy{"coarse_thermometer", "Record a thermometer with finer steps, if the unit has one."},
    // of the fit
    Remedy{"runs_left_since", "Look whether the effect still stands without them: soak gap find"},
    Remedy{"copied_runs", "Nothing: they count once. Void the copies ('soak runs void')."},
    Remedy{"unit_type_unknown", "Write the type's file in procedures/units, then fit again."},
    Remedy{"term_not_evaluated",
           "Record what the effect needs (the column that is named), or withdraw it: soak gap withdraw."},
    Remedy{"few_runs", "Record more runs: three power-ons at least, so that errors can be held out and known."},
    Remedy{"few_temperatures", "Record more plateaus."},
    Remedy{"baseline_deployed", "Nothing: the curve that was better on unseen runs is in the file."},
    Remedy{"hysteresis", "Use slower ramps, a longer soak or a better placed thermometer; expect errors of that size."},
    Remedy{"missing_position", "Record the missing positions."},
    Remedy{"scale_range", "Record the missing positions at those temperatures if the unit is used there."},
    Remedy{"own_thermometer", "Give the temperature of that sensor's own thermometer: soak eval --own-temp-c."},
    Remedy{"scale_not_measured", "Record the missing positions at those temperatures if the unit is used there."},
    Remedy{"even_order", "Check that the fixture's faces are square to each other: a crooked one looks the same."},
    Remedy{"heading_incomplete", "Give the missing azimuths and import into a new campaign, or do without them."},
    Remedy{"rate_positions", kNothing},
    Remedy{"check_standard_out_of_control", "Find what changed in the station ('soak check chart') before you ship."},
    Remedy{"reference_retired", "See whether the reason speaks against what was measured with it before."},
    Remedy{"reference_withdrawn", "Enter the certificate again as it is, then fit again."},
    Remedy{"reference_expired",
           "Have it calibrated and enter the certificate; if it had moved, void what was measured with it."},
    Remedy{"waiver_signature", "Compare with the laboratory's records; sign a new waiver, then fit and export again."},
    Remedy{"gravity_assumed", "Void these runs and import them again with latitude and height, or with gravity."},
    Remedy{"one_attitude", "Record six positions if you need absolute accelerometer bias and scale."},
    Remedy{"runs_without_plateaus", "Give plateau_c in those recordings, or fit them in a campaign of their own."},
    // of a verification
    Remedy{"not_verified", "Record or import the verification runs with that sensor."},
    Remedy{"gravity_differs", "Import the verification runs with the gravity that the file was made with."},
    Remedy{"partial_range", "Verify over the whole temperature range."},
    Remedy{"out_of_range", "Verify inside the valid range."},
    Remedy{"band_too_narrow",
           "Trust the errors of the fresh runs, not the bands: look for what changed since the fit, record more runs."},
    // of a report
    Remedy{"simulated", "Nothing: but deploy this to no real unit."},
    Remedy{"voided_since", kFitAgain},
    Remedy{"not_in_model", kFitAgain},
    Remedy{"run_missing", "Restore the run, or fit again with the runs that there are."},
    Remedy{"rows_missing", "Restore or record the runs, then fit again."},
    Remedy{"older_epoch", "Record the unit as it is now, and fit again."},
    Remedy{"older_model", "Make the report of the newest version, unless you want this one."},
    Remedy{"verification_failed", "Record or import verification runs that cover the model's temperatures."},
};

}  // namespace

std::string_view remedy_of(std::string_view code) {
  const auto* found =
      std::find_if(kRemedies.begin(), kRemedies.end(), [&](const Remedy& remedy) { return remedy.code == code; });
  return found == kRemedies.end() ? std::string_view() : found->text;
}

}  // namespace soak::calib
