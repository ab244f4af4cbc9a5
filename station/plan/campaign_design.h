// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "base/result.h"
#include "calib/plan/expected_band.h"
#include "calib/vocabulary/unit_type.h"

namespace soak::station {

/// A campaign as its numbers. Every pass goes over all plateaus; the plateaus divide the range evenly.
struct PassDesign {
  int passes = 20;
  int plateaus = 21;
  int return_every = 1;  ///< on the way back every how manyeth plateau is visited; 0 = no way back
  int power_cycles = 0;  ///< at the first visit of each pass, each with the visit anew
  double dwell_s = 600.0;

  bool operator==(const PassDesign&) const = default;
};

/// The thesis' soak test: one way, 20 runs over 21 plateaus, ten minutes in each position.
[[nodiscard]] PassDesign full_campaign();

/// The designs that are compared: 3 to 20 passes, plateaus 4 to 10 K apart, the way back over every or every other
/// plateau as long as those are within 15 K (one_way.h), up to 9 power cycles in a pass, dwells of 2 and 10 minutes.
///
/// Three passes are the fewest of which each can be held out; all go both ways, since nothing else shows hysteresis.
/// Both ends of the range are always visited.
[[nodiscard]] std::vector<PassDesign> designs_for(double low_c, double high_c);

/// What a design is for.
struct PlannedRange {
  double low_c = 0.0;
  double high_c = 0.0;
  calib::UnitType type;
};

/// The design as a procedure file (docs/procedures.md), named `name`: each pass begins and ends at a reference plateau
/// of 25 °C where the range has it, so that the power cycles are done there, else at the lowest plateau.
[[nodiscard]] std::string procedure_text(const PassDesign& design, const PlannedRange& range, const std::string& name,
                                         const std::string& description);

/// What its procedure costs and records, by the compiled plan that `soak procedure check` shows.
struct DesignedCampaign {
  double hours = 0.0;
  calib::CampaignDesign recorded;
};

/// Fails (bad_input) as parse_procedure() does: for a range that the type's rating, overshoot included, does not allow.
[[nodiscard]] base::Result<DesignedCampaign> designed_campaign(const PassDesign& design, const PlannedRange& range);

}  // namespace soak::station
