// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "calib/gap/base/campaign_model.h"
#include "calib/gap/noise/noise.h"
#include "calib/gap/search/search.h"

namespace soak::calib::gap {

/// Bias instability B of a sensor in a recording at rest, from the Allan deviation (signal::AllanFit); SI.
struct InstabilityAtRest {
  double value = 0.0;
  double low = 0.0;  ///< of the 95 % interval
  double high = 0.0;
  double tau_s = 0.0;  ///< averaging time of the least deviation
  std::string campaign;
  std::string run;  ///< label
  double duration_s = 0.0;
};

/// Slow noise of one sensor: how its bias wanders while the unit runs, in another way in each run (bias instability,
/// rate random walk).
struct SensorWander {
  Sensor sensor = Sensor::gyro_x;
  double within_run = 0.0;     ///< standard deviation about its mean over a run, SI
  double share_minutes = 0.0;  ///< of that variance, what is forgotten within minutes: time constants below an hour
  double share_hours = 0.0;    ///< the rest: within hours, or not within a run
  /// What stands beside it; filled in by who has such a recording.
  std::optional<InstabilityAtRest> at_rest = {};
};

/// Variance of a wander about its mean over a run, in the mean of the runs.
[[nodiscard]] double wander_variance(const Observations& observations, const std::vector<GaussMarkov>& wander);

/// Noise of a campaign in which the bias wanders: told by what the first search has left. Nothing where none of the
/// `sensors`, which look so, has wander, or where there are too few runs to tell one from what they share.
[[nodiscard]] std::optional<KnownNoise> wandering_noise(const CampaignModel& model,
                                                        const std::vector<NamedEffect>& effects,
                                                        const std::vector<Sensor>& sensors);

/// Of each sensor whose noise wanders, how far.
[[nodiscard]] std::vector<SensorWander> slow_noise_in(const Observations& observations, const KnownNoise& noise);

/// The list `slow_noise` of documents: deg/s and m/s² (docs/schema/gap-find.schema.json).
[[nodiscard]] nlohmann::json slow_noise_json(const std::vector<SensorWander>& wanders);

/// Back from the document of a report; nothing where it has no such list.
[[nodiscard]] std::vector<SensorWander> slow_noise_of(const nlohmann::json& document);

}  // namespace soak::calib::gap
