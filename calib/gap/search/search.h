// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "calib/gap/base/campaign_model.h"
#include "calib/gap/search/structure_kind.h"

namespace soak::calib::gap {

/// An effect that explains the same readings almost as well as one that was found.
struct Rival {
  const Effect* effect = nullptr;
  std::optional<double> odds;  ///< against the one that was found; absent where no merit was computed
};

/// Odds below which a rival is out: on campaigns of another laboratory all 297 first names that stood so were right.
inline constexpr double kOutOdds = 1e-6;

/// Whether a rival is not out beside the effect that was found: its odds are not negligible, or not known.
[[nodiscard]] inline bool has_chance(const Rival& rival) { return rival.odds.value_or(1.0) >= kOutOdds; }

/// An effect that was found.
struct NamedEffect {
  const Effect* effect = nullptr;
  Candidate candidate;
  std::vector<Sensor> sensors;
  std::array<Eigen::VectorXd, kSensorCount> parameters;  ///< SI; of a shared term the same in every sensor
  std::array<Eigen::MatrixXd, kSensorCount> covariance;
  std::array<Meaning, kSensorCount> meaning;  ///< of the parameters
  Magnitude magnitude;                        ///< of the sensor in which it stands out most
  double delta_bic = 0.0;                     ///< BIC without the term less BIC with it
  double p_adjusted = 1.0;                    ///< for the whole library and all sets of sensors
  double merit = 0.0;                         ///< gain over heterogeneity less the price of the parameters
  std::array<double, kSensorCount> gain{};    ///< whitened squares taken out of each of its sensors
  /// Fraction of the RMS of the whitened blocks in its sensors that its parameters from the other folds take away; base
  /// and noise are those of all runs.
  double heldout_gain = 0.0;
  std::vector<Rival> rivals;  ///< effects of at least 80 % of its merit, its twins from 60 %
};

/// A bias that steps, in one run, and stays there to the run's end.
struct BiasStep {
  std::string run;  ///< label
  Sensor sensor = Sensor::gyro_x;
  double t_s = 0.0;       ///< device time of the first block after it
  double since_s = 0.0;   ///< from the run's first block, which is at a plateau, to that
  double before_s = 0.0;  ///< from the run's first block to the last one before it
  double temp_c = 0.0;    ///< there
  double size = 0.0;      ///< SI, with its sign
};

/// Where something sits that the library does not know.
struct ResidualStructure {
  StructureKind kind;
  std::string axis;
  double p_adjusted = 1.0;
  double merit = 0.0;  ///< in units of the effects' gain
  std::vector<Sensor> sensors;
  bool forbids_names = false;  ///< too much of the gap for the effects found to be its cause
  bool of_history = false;     ///< what follows the history of temperature shows along that axis
  /// Sensors in which a bias that wanders, which the noise of the model does not know, may look so.
  std::vector<Sensor> may_wander = {};
  std::optional<double> closer_plateaus_k = {};  ///< plateaus that would tell, where these leave the curve unknown
  std::vector<BiasStep> steps = {};              ///< of jumps: those that stand out, in the order of runs and time
  Recorded recorded = {};
};

/// What the forward search found.
struct SearchResult {
  std::vector<NamedEffect> effects;  ///< in the order in which they were found
  std::optional<ResidualStructure> residual_structure;
  std::vector<const Effect*> absorbed;  ///< effects that the base takes up in this campaign
  std::size_t candidates = 0;           ///< that the first step tested
  double typical_heterogeneity = 1.0;
};

/// Chance of a false name that a step of the search may run.
inline constexpr double kGate = 0.003;
/// The same of each effect that is looked for outside the means: there are several, and each has its own chance to be
/// named where there is nothing.
inline constexpr double kOutsideMeanGate = 0.001;

/// Forward selection over the library: each step takes in the effect of the greatest merit, if its adjusted chance is
/// below kGate, if enough folds bear it out (Standing), and, after the first, if it takes at least 5 % of what
/// the first took out of the same sensors. At most three. Then the structure of what is left. The terms are added to
/// `model`.
[[nodiscard]] SearchResult search(CampaignModel& model);

/// The shape of an effect that stands best against `model`, in the sensors given and with the parameters estimated
/// there, for a run that the search did not see; nothing where the model cannot show it.
[[nodiscard]] std::optional<NamedEffect> best_shape(const CampaignModel& model, const Effect& effect);

}  // namespace soak::calib::gap
