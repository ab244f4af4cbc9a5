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

/// The narrowest range of plateaus that is planned for: five of them 1.5 K apart.
inline constexpr double kNarrowestRange_c = 6.0;

/// Where each run ends: 25 °C, or the coldest place above that the type's rating, less the overshoot, allows.
[[nodiscard]] double end_of_runs_c(const calib::UnitType& type);

/// The thesis' soak test: one way, 20 runs over 21 plateaus, ten minutes in each position; fewer plateaus over a range
/// in which they would be closer than those of the designs.
[[nodiscard]] PassDesign full_campaign(double low_c, double high_c);

/// The designs that are compared: 3 to 20 passes, plateaus 4 to 10 K apart (of a range below 80 K, as many as the full
/// campaign visits with its reference plateau), the way back over every or every other
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

/// The design as a procedure file (docs/procedures.md), named `name`. A pass both ways begins and ends at the same end
/// of the range: the lowest plateau, or the highest where all are above the temperature at which runs end. The power
/// cycles are done there, where the branches of a loop meet, so that hysteresis does not go into their level; a
/// reference plateau of 25 °C would be reached from the same side each time. One way, each pass begins and ends at
/// that, where the range has it. Runs end at 25 °C, or at the coldest place that the type's rating allows.
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
