// SPDX-License-Identifier: Apache-2.0
#include "station/release/fitted_runs.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <utility>

#include "calib/estimate/unit_input.h"
#include "station/fit/fit_unit.h"

namespace soak::station {
namespace {

/// Runs with their segments, for a comparison of samples: no file is read.
base::Result<std::vector<calib::RunInput>> with_segments(const db::Catalog& catalog,
                                                         const std::vector<db::RunRow>& runs) {
  std::vector<calib::RunInput> inputs;
  for (const db::RunRow& run : runs) {
    auto segments = catalog.segments(run.run_id, run.unit, false);
    if (!segments) return base::forward_error(segments);
    inputs.push_back({run.run_id,
                      run.label,
                      run.campaign,
                      run.content_sha256,
                      run.simulated,
                      run.site,
                      *std::move(segments),
                      {},
                      {}});
  }
  return inputs;
}

}  // namespace

base::Result<FittedRuns> compare_fitted_runs(const db::Catalog& catalog, const calib::Calibration& calibration) {
  auto runs = catalog.runs({.unit = calibration.unit, .campaign = {}, .run = {}});
  if (!runs) return base::forward_error(runs);
  std::erase_if(*runs, [&](const db::RunRow& run) { return !is_for_fit(run, calibration.epoch); });
  const std::set<std::string> fitted(calibration.run_hashes.begin(), calibration.run_hashes.end());
  std::set<std::string> present;
  for (const db::RunRow& run : *runs) present.insert(run.content_sha256);
  FittedRuns found;
  found.gone = static_cast<std::size_t>(
      std::ranges::count_if(fitted, [&](const std::string& hash) { return !present.contains(hash); }));
  // The model's own runs first, so that of two copies the other one is left out.
  const auto others = std::stable_partition(runs->begin(), runs->end(),
                                            [&](const db::RunRow& run) { return fitted.contains(run.content_sha256); });
  if (others == runs->end()) return found;
  auto inputs = with_segments(catalog, *runs);
  if (!inputs) return base::forward_error(inputs);
  std::vector<calib::Warning> of_copies;
  calib::leave_out_copies(*inputs, of_copies);
  for (const calib::RunInput& run : *inputs) {
    if (fitted.contains(run.content_sha256)) continue;
    found.left_out.push_back(fmt::format("{} of campaign {}", run.label, run.campaign));
  }
  return found;
}

}  // namespace soak::station
