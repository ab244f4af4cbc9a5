// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "calib/estimate/model_term.h"
#include "calib/forward/simulation.h"
#include "calib/gap/report/slow_noise.h"
#include "db/catalog/catalog.h"

namespace soak::station {

/// A run that was simulated.
struct ComparedRun {
  std::string label;
  std::string run_id;
  bool fitted = false;  ///< either of the models was fitted to it, or a term rests on it
};

/// How far simulations with a model before and after its accepted effects are from what one sensor read, over some
/// runs; SI.
struct SensorComparison {
  double before_rms = 0.0;  ///< about each run's own mean
  double after_rms = 0.0;
  double noise_rms = 0.0;           ///< what the samples' noise alone leaves
  std::optional<double> floor_rms;  ///< noise and scatter between runs, as the report that was accepted states them
  /// (before − after)/(before − floor) on fresh runs; absent: too small to tell, or runs that were fitted.
  std::optional<double> closed_fraction;
};

/// A unit's model against the measurement, before and after.
struct GapComparison {
  std::string unit;
  bool simulated = false;   ///< the model was made from simulated data
  bool at_plateaus = true;  ///< false: blocks are of 30 s, of recordings without plateaus
  std::int32_t model = 0;
  std::int32_t before = 0;  ///< version without the effects; that of `model` where it carries none
  std::vector<calib::ModelTerm> terms;
  std::vector<ComparedRun> runs;
  calib::forward::SimulatedCampaign simulated_before;
  calib::forward::SimulatedCampaign simulated_after;
  std::array<std::optional<SensorComparison>, calib::kSensorCount> fitted;
  std::array<std::optional<SensorComparison>, calib::kSensorCount> fresh;
  std::vector<calib::gap::SensorWander> slow_noise;  ///< as the newest search in one of the models has found it
};

/// Simulates the sealed, unvoided runs of the model's epoch, of calibration and verification, of one campaign where it
/// is given. Refuses (bad_input) an unknown unit, one without such a model, and no such run.
[[nodiscard]] base::Result<GapComparison> compare_gap(const db::Catalog& catalog, const std::string& unit,
                                                      std::optional<std::int32_t> model,
                                                      const std::optional<std::string>& campaign);

/// Whether an effect shows in what is compared here: blocks about each run's own mean.
[[nodiscard]] bool moves_blocks(std::string_view effect);

/// What fresh runs can show of an effect in that.
enum class ShownPart : std::uint8_t {
  all,
  within_a_run,  ///< only what changes within a run
  nothing        ///< it is another in each mounting, or shows in single readings only
};

[[nodiscard]] ShownPart shown_by_fresh_runs(std::string_view effect);

/// Whether a sensor agrees less well with the runs than before, by more than the chance of other rows.
[[nodiscard]] bool is_worse(const SensorComparison& figures);

/// Whether it agrees better with fresh runs: the gap was more than noise, and has shrunk by more than that chance.
[[nodiscard]] bool is_better(const SensorComparison& figures);

/// What somebody who reads the figures must know, a sentence each: no fresh run, effects that do not show here, sensors
/// that have become worse.
[[nodiscard]] std::vector<std::string> remarks(const GapComparison& comparison);

/// The figures as `soak gap show --json` prints them (deg/s, m/s²).
[[nodiscard]] nlohmann::json comparison_json(const GapComparison& comparison);

}  // namespace soak::station
