// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "calib/gap/base/campaign_model.h"
#include "calib/gap/search/search.h"

namespace soak::calib::gap {

/// Chance of what scatter alone decides, and nothing that runs repeat bears out: a tenth of the search's gate.
inline constexpr double kSlowGate = 0.1 * kGate;

/// Scatter that hangs together in time: neighbours are more alike than those further apart.
struct SlowNoise {
  double p_adjusted = 1.0;  ///< for all sets of sensors and both distances
  double excess = 0.0;      ///< squares beyond those of white scatter, over the variance of what scatters
  std::vector<Sensor> sensors;
  StructureKind kind = StructureKind::wander;
  std::vector<BiasStep> steps = {};  ///< of jumps: those that stand out
};

/// What effects that were taken into the model read in a sensor, one column for each that acts on it, a row for each
/// observation.
[[nodiscard]] Eigen::MatrixXd contributions(const std::vector<NamedEffect>& effects, Sensor sensor, Eigen::Index rows);

/// Readings less all that the model knows, and less what each effect reads more or less in one run than in all: how
/// strong an effect is may differ from run to run, and is no noise.
[[nodiscard]] Eigen::VectorXd unexplained(const CampaignModel& model, const std::vector<NamedEffect>& effects,
                                          Sensor sensor);

/// Looks for a wander that no run repeats: a bias that steps or jumps to and fro while the unit runs. The nested noise
/// model says that visits of a run scatter independently, and placements of a visit too. Two F tests of that per
/// sensor, exact for Gaussian scatter in runs of one profile: low frequencies against high ones over the visits of a
/// run, with run and what runs repeat taken off; and slope and bow over the placements of a visit against what is left.
/// A jump that lasts longer than a run is run-to-run scatter, one shorter than a placement is noise of blocks: neither
/// can be seen. `effects`: taken into the model; how much stronger or weaker each was in a run is taken off first, as
/// that is no wander. Nothing where the chance, adjusted, is above a tenth of the search's gate.
[[nodiscard]] std::optional<SlowNoise> slow_noise(const CampaignModel& model, const std::vector<NamedEffect>& effects);

}  // namespace soak::calib::gap
