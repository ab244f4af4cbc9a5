// SPDX-License-Identifier: Apache-2.0
#include "nav/outages/pipeline.h"

#include <fmt/format.h>

#include <limits>
#include <utility>

#include "base/units.h"
#include "nav/filter/filter_run.h"
#include "nav/filter/tuning.h"

namespace soak::nav {
namespace {

void correct(ImuSample& sample, const Correction& correction, const Eigen::Matrix3d& unit_to_body) {
  sample.rate_rps = unit_to_body.transpose() * sample.rate_rps;
  sample.force_mps2 = unit_to_body.transpose() * sample.force_mps2;
  correction(sample);
  sample.rate_rps = unit_to_body * sample.rate_rps;
  sample.force_mps2 = unit_to_body * sample.force_mps2;
}

std::vector<Solution> solutions_of(FilterRun& run, std::span<const double> t_s) {
  std::vector<Solution> solutions;
  for (const double wanted_s : t_s) {
    run.advance_to(wanted_s);
    solutions.push_back({run.filter().antenna(), run.filter().antenna_velocity_mps()});
  }
  return solutions;
}

base::Result<std::vector<Solution>> solve_by_filter(const FilterPipeline& parts, const Drive& seen,
                                                    std::span<const double> t_s) {
  const auto setup = set_up(parts, seen);
  if (!setup) return base::forward_error(setup);
  FilterRun run(setup->drive, setup->start, setup->options);
  return solutions_of(run, t_s);
}

}  // namespace

base::Result<FilterSetup> set_up(const FilterPipeline& parts, const Drive& seen) {
  FilterSetup setup{seen, {}, parts.filter};
  if (parts.correction) {
    for (ImuSample& sample : setup.drive.imu) correct(sample, parts.correction, setup.drive.unit_to_body);
  }
  auto start = align(setup.drive, parts.alignment);
  if (!start) return base::forward_error(start);
  setup.start = *std::move(start);
  if (parts.tune_at_rest) {
    setup.options.sensors = tuned_at_rest(setup.drive, setup.options.sensors, parts.alignment.heading_sigma_rad);
    setup.options.standstill = standstill_at_rest(setup.drive);
  }
  return setup;
}

Pipeline filter_pipeline(FilterPipeline parts) {
  std::string name = parts.name;
  std::string description = parts.description;
  return {std::move(name), std::move(description),
          [parts = std::move(parts)](const Drive& seen, std::span<const double> t_s) {
            return solve_by_filter(parts, seen, t_s);
          }};
}

base::Result<std::vector<std::vector<Solution>>> solve_in_passing(const FilterPipeline& parts, const Drive& drive,
                                                                  std::span<const Outage> outages,
                                                                  std::span<const std::vector<double>> t_s) {
  const auto setup = set_up(parts, drive);
  if (!setup) return base::forward_error(setup);
  FilterRun run(setup->drive, setup->start, setup->options);
  std::vector<std::vector<Solution>> solutions;
  for (std::size_t i = 0; i < outages.size(); ++i) {
    if (outages[i].begin_s < run.now_s()) {
      return base::bad_input(
          fmt::format("an outage begins at {:.1f} s, before the filter can or before another outage; "
                      "the filter is at {:.1f} s: let the outages begin later, and in order",
                      outages[i].begin_s, run.now_s()),
          drive.name);
    }
    run.advance_to(outages[i].begin_s);
    FilterRun without_fixes = run;
    without_fixes.lose_fixes();
    solutions.push_back(solutions_of(without_fixes, t_s[i]));
  }
  return solutions;
}

SensorModels typical_mems() {
  using base::kRadPerDeg;
  constexpr double kNoProcess_s = std::numeric_limits<double>::infinity();
  const SensorModel gyro{0.05 * kRadPerDeg, {0.3 * kRadPerDeg, 0.0, kNoProcess_s, 0.005 * kRadPerDeg}, 0.005};
  const SensorModel accel{0.02, {0.3, 0.0, kNoProcess_s, 0.001}, 0.005};
  return same_for_axes(gyro, accel);
}

}  // namespace soak::nav
