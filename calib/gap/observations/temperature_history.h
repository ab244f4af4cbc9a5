// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "calib/gap/campaign/campaign.h"
#include "calib/gap/observations/observations.h"

namespace soak::calib::gap {

/// What the runs' logs say at each observation, and functionals of the temperature's whole history. Cost of each call:
/// linear in the logs.
class TemperatureHistory {
 public:
  TemperatureHistory(const LoggedCampaign& campaign, const Observations& observations);

  /// Whether the logs cover the time between the plateaus: holes of more than five minutes make up a twentieth of it at
  /// most. Over a hole the temperature is taken to go straight.
  [[nodiscard]] bool continuous() const { return continuous_; }
  /// Why what follows the temperature history cannot be told from the curve: a thermometer in steps of 0.1 K or
  /// more, or fewer than five plateaus. Nothing where it can.
  [[nodiscard]] const std::optional<std::string>& blurred() const { return blurred_; }
  /// Step of a thermometer so coarse (0.1 K or more) that what changes with time cannot be told from a temperature that
  /// moves within a step, in words; nothing for a fine one.
  [[nodiscard]] const std::optional<std::string>& coarse() const { return coarse_; }
  /// Slope of the unit's thermometer over four minutes about each observation, K/s.
  [[nodiscard]] const std::vector<double>& rate() const { return rate_; }
  /// Temperature at each observation that a first-order lag makes of its history, less the temperature itself, kelvin.
  /// It starts each run at rest, or, `under_way`, as if the slope of its first two minutes had gone on for long.
  [[nodiscard]] std::vector<double> lag(double tau_s, bool under_way = false) const;
  /// Memory of the branch, −1 to 1: dh = (sign(dT) − h)(1 − e^{−|dT|/w}) along the history, whose turns of less than
  /// 0.5 K do not count. Each run starts on the branch that leads from room temperature to its first plateau, or, with
  /// `along`, on the branch of its first movement (1), the opposite one (−1) or between them.
  [[nodiscard]] std::vector<double> branch_memory(double width_c, std::optional<double> along = {}) const;
  /// Share of the water that is left in a package which holds 1 at each run's start and dries with the time constant
  /// `tau_s` at 50 °C: dw/dt = −w/tau · exp(activation (1/323.15 K − 1/T)) [Arrhenius].
  [[nodiscard]] std::vector<double> water_left(double tau_s, double activation_k) const;
  /// Seconds since power-on.
  [[nodiscard]] const std::vector<double>& since_power_s() const { return since_power_; }
  /// Mean over each block; empty where a run has none.
  [[nodiscard]] const std::vector<double>& compressor() const { return compressor_; }
  [[nodiscard]] const std::vector<double>& supply_v() const { return supply_; }
  [[nodiscard]] const std::vector<double>& chamber_c() const { return chamber_; }
  /// The unit's own thermometer as it was logged, whatever thermometer a sensor has.
  [[nodiscard]] const std::vector<double>& unit_c() const { return unit_; }
  /// Unix time; empty where a run has none.
  [[nodiscard]] const std::vector<double>& utc_s() const { return utc_; }

 private:
  struct RunTemperature {
    std::vector<double> t_s;
    std::vector<double> temp_c;
  };
  [[nodiscard]] std::vector<double> at_observations(const std::vector<std::vector<double>>& of_runs) const;

  const Observations& observations_;
  std::vector<RunTemperature> runs_;
  bool continuous_ = true;
  std::optional<std::string> blurred_;
  std::optional<std::string> coarse_;
  std::vector<double> rate_;
  std::vector<double> since_power_;
  std::vector<double> compressor_;
  std::vector<double> supply_;
  std::vector<double> chamber_;
  std::vector<double> unit_;
  std::vector<double> utc_;
};

}  // namespace soak::calib::gap
