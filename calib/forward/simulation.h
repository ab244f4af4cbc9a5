// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "calib/curve/calibration.h"
#include "calib/estimate/model_term.h"
#include "calib/gap/campaign/campaign.h"

namespace soak::calib::forward {

/// Takes what accepted terms say off the readings of a campaign, segments and blocks, so that a fit or a search for a
/// gap sees what is left: means lose what each mechanism adds, and the temperatures of sensors that lag become those of
/// their elements; `carried` names the terms, for what is outside the means. Nothing recorded is touched: `campaign` is
/// a copy for computing. Returns what could not be taken off and why, a sentence each. Cost: linear in blocks and logs,
/// per term.
[[nodiscard]] std::vector<std::string> subtract_terms(const std::vector<ModelTerm>& terms,
                                                      gap::LoggedCampaign& campaign);

/// What a campaign is simulated with: curves and couplings of a model version, and its accepted terms.
struct SimulatedModel {
  Calibration calibration;
  std::vector<ModelTerm> terms;
};

/// One block of one segment: what was read, and what the model says should have been.
struct SimulatedBlock {
  int run = 0;              ///< index into LoggedCampaign::runs
  int visit = 0;            ///< ordinal of the plateau in the run
  std::size_t segment = 0;  ///< index into the run's segments
  double t_s = 0.0;
  double temp_c = 0.0;
  Sweep sweep = Sweep::unknown;
  std::array<std::optional<double>, kSensorCount> measured;   ///< SI; absent: no reading, or the data gate rejected it
  std::array<std::optional<double>, kSensorCount> simulated;  ///< SI; absent: the model has no such sensor
  std::array<double, kSensorCount> noise{};  ///< standard error of the measured mean, as the samples' noise makes it
};

/// A campaign as the model says it should read.
struct SimulatedCampaign {
  /// Of segments in soak at plateaus, of all in a campaign without any; by run and time.
  std::vector<SimulatedBlock> blocks;
  std::vector<std::string> not_evaluated;  ///< terms that could not be evaluated and why
};

/// Reads off the model what each block of the campaign should read: thermal history, positions, headings and place from
/// the log, curves at the element's temperature, couplings with specific force, the known rotation of the Earth, and
/// every accepted term by its mechanism (but for `narrow_bump`, which the curve holds). Offsets that change from
/// power-on to power-on are not in it: compare() takes them off. Cost: linear in blocks and logs.
[[nodiscard]] SimulatedCampaign simulate(const SimulatedModel& model, const gap::LoggedCampaign& campaign);

/// RMS of what one sensor read beyond the simulation, SI.
struct Disagreement {
  double rms = 0.0;          ///< about each run's own mean
  double noise_rms = 0.0;    ///< what the samples' noise alone would leave
  std::vector<double> runs;  ///< the same RMS run by run, in the order of LoggedCampaign::runs; NaN = no reading
};

/// Measured less simulated, by sensor; nothing where either is missing throughout.
[[nodiscard]] std::array<std::optional<Disagreement>, kSensorCount> compare(const SimulatedCampaign& campaign);

}  // namespace soak::calib::forward
