// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "hal/sim/campaign/run_plan.h"
#include "hal/sim/config/campaign_config.h"

namespace soak::hal::sim {

/// Temperatures of a unit and of the chamber's air through one run, without noise.
class RunTemperature {
 public:
  RunTemperature(const CampaignConfig& config, const std::vector<Visit>& visits, std::uint64_t run_seed);

  /// Temperature of the unit, which all its sensors and its thermometer share: an exponential approach to where the
  /// visit settles, then also the linear drift of the plateau.
  [[nodiscard]] double unit_c(std::size_t visit, double t_s) const;

  /// Temperature of the air: exponential approach to the set point.
  [[nodiscard]] double chamber_c(std::size_t visit, double t_s) const;

 private:
  struct Course {
    Visit visit;
    double from_c = 0.0;          ///< the unit when the set point changed
    double settled_c = 0.0;       ///< where the unit's approach ends
    double drift_c = 0.0;         ///< over the plateau
    double chamber_from_c = 0.0;  ///< the set point before
  };

  ThermometerMagnitudes thermometer_;
  ChamberMagnitudes chamber_;
  std::vector<Course> courses_;
};

}  // namespace soak::hal::sim
