// SPDX-License-Identifier: Apache-2.0
#include "calib/estimate/detail/gated_input.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <string>

#include "calib/segments/data_gate.h"

namespace soak::calib {
namespace {

/// A warning of one run, and in how many more it occurs.
struct Shared {
  Warning warning;
  std::size_t more_runs = 0;
};

void add(std::vector<Shared>& all, const RunInput& run) {
  std::set<std::string> counted;
  for (const Warning& warning : summarise(run.segments)) {
    const auto same =
        std::find_if(all.begin(), all.end(), [&](const Shared& shared) { return shared.warning.code == warning.code; });
    if (same == all.end() || counted.contains(warning.code)) {
      all.push_back({{warning.code, fmt::format("run {}: {} {}", run.label, warning.code, warning.text)}});
    } else {
      ++same->more_runs;
    }
    counted.insert(warning.code);
  }
}

}  // namespace

GatedInput leave_out_rejected(const UnitInput& input) {
  GatedInput gated{{input.unit, input.type, input.epoch, {}, input.references, input.terms}, {}};
  std::vector<Shared> shared;
  for (const RunInput& run : input.runs) {
    add(shared, run);
    RunInput kept = run;
    kept.segments = accepted(run.segments);
    if (!kept.segments.empty() || run.segments.empty()) gated.input.runs.push_back(std::move(kept));
  }
  for (Shared& one : shared) {
    if (one.more_runs > 0) one.warning.text += fmt::format(" (and so in {} more runs)", one.more_runs);
    gated.warnings.push_back(std::move(one.warning));
  }
  return gated;
}

}  // namespace soak::calib
