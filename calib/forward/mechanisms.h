// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <string>
#include <vector>

#include "calib/estimate/model_term.h"
#include "calib/forward/thermal_history.h"
#include "calib/gap/campaign/campaign.h"
#include "calib/vocabulary/sensor.h"

namespace soak::calib::forward {

/// When and where a term is asked what it adds.
struct Moment {
  const Segment* segment = nullptr;
  double t_s = 0.0;     ///< middle of the stretch, device time
  double half_s = 0.0;  ///< half the length of the stretch
  double temp_c = 0.0;  ///< of the sensor's thermometer
};

struct Mechanism;

/// The accepted terms of a model in one run: what each mechanism adds to a reading, from the run's logged temperature
/// history. On its own code path: the regressors that named an effect are not used. Terms that leave the mean alone
/// (noise, steps, rails) add nothing.
class Mechanisms {
 public:
  /// `terms` and `run` must outlive it. `sign_at_rest`: UnitType::sign_at_rest.
  Mechanisms(const std::vector<ModelTerm>& terms, const gap::LoggedRun& run, int sign_at_rest);

  /// What all terms add to the mean of a sensor, SI.
  [[nodiscard]] double contribution(Sensor sensor, const Moment& moment) const;
  /// Temperature of the sensing element, where a term says that it lags behind its thermometer; else that of `moment`.
  [[nodiscard]] double element_temp_c(Sensor sensor, const Moment& moment) const;
  /// Terms that this run cannot evaluate and why, a sentence each.
  [[nodiscard]] const std::vector<std::string>& not_evaluated() const { return not_evaluated_; }

 private:
  struct Prepared {
    const Mechanism* mechanism;
    const TermPart* part;
    Series regressor;
    std::map<double, Vector3> memory;  ///< what position_memory holds when a placement begins, by device time

    [[nodiscard]] double at(const Moment& moment) const;
  };

  const gap::LoggedRun& run_;
  int sign_at_rest_;
  double gravity_mps2_;
  std::vector<Prepared> prepared_;
  std::vector<std::string> not_evaluated_;
};

/// Completes terms of a unit's past (`thermal_hysteresis`, `warmup_transient`, `moisture`) and of what only a chamber
/// knows (`temperature_gradient`) with their mean over the blocks of each plateau, of every 5 K where there are none
/// (TermPart::centre): the curves of a file that cannot evaluate them must keep that mean.
void centre(const gap::LoggedCampaign& campaign, std::vector<ModelTerm>& terms);

/// Specific force of a unit at rest in a segment's position, along its axes, m/s², signed as the unit reads it; zero
/// where the position is not known.
[[nodiscard]] Vector3 force_mps2(const Segment& segment, double gravity_mps2, int sign_at_rest);

}  // namespace soak::calib::forward
