// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "calib/gap/campaign/campaign.h"

namespace soak::calib::gap {

/// How chamber and unit follow a new set point: the air goes there at a constant rate, the unit's thermometer follows
/// the air with one time constant.
struct Settling {
  std::optional<double> rate_kps;  ///< of the air; absent = too fast to be seen behind the unit
  double tau_s = 0.0;

  /// Time that the air needs for a way of `way_c` kelvin.
  [[nodiscard]] double drive_s(double way_c) const;
};

/// One plateau of a run as it was recorded.
struct TemplateVisit {
  std::vector<const Segment*> segments;  ///< in the order of time; they belong to the campaign
  double start_s = 0.0;                  ///< of the first segment
  double end_s = 0.0;                    ///< of the last
  double plateau_c = 0.0;
  double rest_c = 0.0;  ///< where the unit's thermometer would come to rest
  double soak_s = 0.0;  ///< from the arrival of the air to the first segment
  Sweep sweep = Sweep::unknown;
};

/// A run of the campaign that proposed runs are copied from: its temperatures, positions and recordings.
struct RunTemplate {
  const LoggedRun* run = nullptr;
  std::vector<TemplateVisit> visits;
  /// Median over its ways of 2 K and more. The end of a way, stay included, is fitted by a + b e^{-t/tau}; with x the
  /// part of the way that is still to go, a ramp of length L before such a lag has an area of x dt = L/2 + tau.
  Settling settling;
  double start_c = 0.0;  ///< where the unit's thermometer began
};

/// That of the last among the runs with the most segments; nothing where no run has a plateau and a log.
[[nodiscard]] std::optional<RunTemplate> run_template(const LoggedCampaign& campaign);

/// A plateau of a run that is yet to be made.
struct ProposedVisit {
  std::size_t copy_of = 0;  ///< visit of the template that gives positions and their times
  double plateau_c = 0.0;   ///< set point
  double temp_c = 0.0;      ///< where the unit's thermometer comes to rest
  double soak_s = 0.0;      ///< from the arrival of the air to the first position
  Sweep sweep = Sweep::unknown;
};

/// A run that is yet to be made, from one power-on to the next.
struct ProposedRun {
  std::vector<ProposedVisit> visits;
  Settling settling;
  double start_c = 0.0;   ///< of air and unit at power-on
  double turn_deg = 0.0;  ///< of the whole fixture about the vertical, clockwise seen from above
};

/// The run as a recording of it would look, with a count of 1 and a mean of 0 in every block of every sensor: readings
/// are for others to predict. The temperature follows `settling` in steps of 10 s; compressor and supply are those of
/// the template at the same moment of the visit, its mean on the way.
[[nodiscard]] LoggedRun simulate(const RunTemplate& source, const ProposedRun& plan, const std::string& label);

/// From power-on to the end of the last segment, hours.
[[nodiscard]] double hours_of(const LoggedRun& run);

}  // namespace soak::calib::gap
