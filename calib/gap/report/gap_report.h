// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "calib/gap/experiment/next_experiment.h"
#include "calib/gap/observations/gate_rejections.h"
#include "calib/gap/report/cross_validation.h"
#include "calib/gap/search/outside_the_mean.h"
#include "calib/gap/search/search.h"

namespace soak::calib::gap {

/// none: nothing beyond the scatter between runs. named: the library explains it. unknown: structure that no effect of
/// the library explains. cannot_judge: the data cannot tell effect from scatter.
enum class Verdict { none, named, unknown, cannot_judge };

constexpr std::string_view name_of(Verdict verdict) {
  return verdict == Verdict::none      ? "none"
         : verdict == Verdict::named   ? "named"
         : verdict == Verdict::unknown ? "unknown"
                                       : "cannot_judge";
}

/// A run that was locked away before the search.
struct LockedRun {
  std::string label;
  std::array<std::optional<SensorGap>, kSensorCount> gap;  ///< fractions without interval: one run has no scatter
};

/// What the gap's figures have not seen: each run in turn; each branch; each half of the difference of two branches.
enum class HeldOut { runs, branches, halves };

constexpr std::string_view name_of(HeldOut held_out) {
  return held_out == HeldOut::runs ? "run" : held_out == HeldOut::branches ? "branch" : "half";
}

/// What `soak gap find` says of a campaign.
struct GapReport {
  std::string unit;
  std::int32_t model = 0;
  Verdict verdict = Verdict::none;
  std::string reason;  ///< a sentence
  HeldOut held_out = HeldOut::runs;
  std::vector<NamedEffect> effects;   ///< strongest first; empty but for verdict `named`
  std::vector<NextExperiment> next;   ///< of each of `effects`, what would tell it from its rivals
  std::vector<NamedEffect> suspects;  ///< what the search took in before a leftover forbade names
  std::optional<Leftover> leftover;
  std::vector<NotTestable> not_testable;
  /// RMS of a term of one parameter, changing from visit to visit, that stands at the gate (scatter then decides, half
  /// to half); SI.
  std::array<std::optional<double>, kSensorCount> detection_limit;
  std::array<std::optional<SensorGap>, kSensorCount> gap;
  std::vector<LeftOut> left_out;    ///< by the data gate, in the order of runs
  std::optional<LockedRun> locked;  ///< of campaigns of more than eight runs that could be judged
};

/// Compares the campaign with its saturated base, searches the library and gives a verdict. With one run at plateaus:
/// cannot_judge. Of more than eight runs the last by time (by order, where a run has no Unix time) is locked away
/// before the search and judged alone. Runs in one attitude without plateaus are judged by their branches. Runs that
/// cannot be of one unit (run_agreement.h): cannot_judge; so where nothing is found, but the data gate left out more
/// than half of the segments of a run.
[[nodiscard]] GapReport find_gap(const LoggedCampaign& campaign, std::int32_t model);

}  // namespace soak::calib::gap
