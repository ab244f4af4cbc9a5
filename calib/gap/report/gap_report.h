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
#include "calib/gap/experiment/next_experiment.h"
#include "calib/gap/observations/observations.h"
#include "calib/gap/report/cross_validation.h"
#include "calib/gap/report/remainder_map.h"
#include "calib/gap/report/slow_noise.h"
#include "calib/gap/search/outside_the_mean.h"
#include "calib/gap/search/search.h"
#include "calib/vocabulary/warning.h"

namespace soak::calib::gap {

/// none: nothing beyond the scatter between runs. named: the library explains it. unknown: structure that no effect of
/// the library explains. cannot_judge: the data cannot tell effect from scatter.
enum class Conclusion { none, named, unknown, cannot_judge };

constexpr std::string_view name_of(Conclusion conclusion) {
  return conclusion == Conclusion::none      ? "none"
         : conclusion == Conclusion::named   ? "named"
         : conclusion == Conclusion::unknown ? "unknown"
                                             : "cannot_judge";
}

/// A run that was locked away before the search.
struct LockedRun {
  std::string label;
  SensorGaps gap;  ///< fractions without interval: one run has no scatter
};

/// What the gap's figures have not seen: each run in turn; each branch; each half of the difference of two branches.
enum class JudgedOn { runs, branches, halves };

constexpr std::string_view name_of(JudgedOn judged_on) {
  return judged_on == JudgedOn::runs ? "run" : judged_on == JudgedOn::branches ? "branch" : "half";
}

/// What `soak gap find` says of a campaign.
struct GapReport {
  std::string unit;
  std::int32_t model = 0;
  Conclusion conclusion = Conclusion::none;
  std::string reason;  ///< a sentence, with the texts of `notes`
  /// What limits the conclusion. Codes: no_scatter (sensors whose readings never scatter are not judged),
  /// position_order (positions in one order: a memory of the one before could look like the effect named),
  /// coarse_thermometer (changes with time were not looked for), reconstructed_temperature (within the thermometer's
  /// steps it is calculated from the air), clipped (sensors that reach the end of their range are not judged),
  /// wandering_bias (sensors whose bias wanders, which is counted as noise).
  std::vector<Warning> notes;
  JudgedOn judged_on = JudgedOn::runs;
  std::vector<NamedEffect> effects;   ///< strongest first; empty but for the conclusion `named`
  std::vector<NextExperiment> next;   ///< of each of `effects`, what would tell it from its rivals
  std::vector<NamedEffect> suspects;  ///< what the search took in before a residual structure forbade names
  std::optional<ResidualStructure> residual_structure;
  std::vector<NotTestable> not_testable;
  /// RMS of a term of one parameter, changing from visit to visit, that stands at the gate (scatter then decides, half
  /// to half); SI.
  std::array<std::optional<double>, kSensorCount> detection_limit;
  SensorGaps gap;
  std::optional<RemainderMap> map;        ///< absent: cannot_judge, or no plateaus
  std::vector<GateRejection> rejections;  ///< by the data gate, in the order of runs
  std::optional<KnownNoise> noise;        ///< that wanders, where the verdict rests on such
  std::vector<SensorWander> slow_noise;   ///< the same, sensor by sensor
  std::optional<LockedRun> locked;        ///< of campaigns of more than eight runs that could be judged
};

/// The report with the conclusion `cannot_judge`.
[[nodiscard]] GapReport cannot_judge(GapReport report, std::string reason);

/// Compares the campaign with its saturated base, searches the library and concludes. With one run at plateaus:
/// cannot_judge. Of more than eight runs the last by time (by order, where a run has no Unix time) is locked away
/// before the search and judged alone. Runs in one attitude without plateaus are judged by their branches. Runs that
/// cannot be of one unit (run_agreement.h): cannot_judge; so where nothing is found, but the data gate rejected more
/// than half of the segments of a run.
[[nodiscard]] GapReport find_gap(const LoggedCampaign& campaign, std::int32_t model);

/// The document of `soak gap find --json` (docs/schema/gap-find.schema.json): deg/s and m/s².
[[nodiscard]] nlohmann::json gap_json(const GapReport& report);

/// Which of a report's effects to take: those that it names, or its suspects as well.
enum class Accepted { named, suspected };

/// The named effects of a report as terms of a model, in the report's order: of all, or of `names` where it is not
/// empty. With Accepted::suspected its suspects count as named; the terms keep the report's verdict. Refuses
/// (bad_input) a report without such an effect, and a name that it has not, saying what it has.
[[nodiscard]] base::Result<std::vector<ModelTerm>> accepted_terms(const LoggedCampaign& campaign,
                                                                  const GapReport& report,
                                                                  const std::vector<std::string>& names,
                                                                  Accepted accepted = Accepted::named);

}  // namespace soak::calib::gap
