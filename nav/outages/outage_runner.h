// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "base/result.h"
#include "nav/drive/drive.h"
#include "nav/outages/bootstrap.h"
#include "nav/outages/pipeline.h"

/// Outages of satellite navigation on drives whose truth is known: every pipeline meets the same ones.
namespace soak::nav {

/// What a pipeline's solution was wrong by at a time after the outage began: solution less truth, along east, north,
/// up.
struct ErrorPoint {
  double after_s = 0.0;
  Eigen::Vector3d position_m;
  Eigen::Vector3d velocity_mps;
};

/// Errors of a pipeline in an outage.
struct OutageErrors {
  std::vector<ErrorPoint> points;  ///< at each truth in the outage, the last at its end
  Eigen::Vector3d position_rmse_m;
  Eigen::Vector3d position_final_m;
  Eigen::Vector3d velocity_rmse_mps;
  Eigen::Vector3d velocity_final_mps;
  double horizontal_rmse_m = 0.0;
  double horizontal_final_m = 0.0;
};

/// An outage with the errors of all pipelines, in their order.
struct OutageResult {
  Outage outage;
  std::string drive;
  double distance_m = 0.0;  ///< that the antenna went meanwhile, in straight lines between truths
  /// Where it was at each truth, from where it was at the first one, along east, north, up.
  std::vector<Eigen::Vector3d> track_m;
  std::vector<OutageErrors> pipelines;
};

/// `number` outages of `length_s`, their beginnings evenly spread from `first_s` after the drive's first sample to the
/// last that still ends within readings and truth. Outages may overlap: each is met on its own. Refuses (bad_input) a
/// drive too short for one.
[[nodiscard]] base::Result<std::vector<Outage>> spread_outages(const Drive& drive, double first_s, double length_s,
                                                               std::size_t number);

/// Runs every pipeline through one outage. The drive must be validate()d. Fails as the pipelines do; bad_input where
/// no truth lies in the outage, internal where a pipeline gives another number of solutions than it was asked for or
/// one that is not finite. Independent of other outages: the caller may run many at once.
[[nodiscard]] base::Result<OutageResult> run_outage(const Drive& drive, const Outage& outage,
                                                    std::span<const Pipeline> pipelines);

/// All outages of a drive, in the order in which they begin, with pipelines that are filters: what run_outage() gives
/// for each with filter_pipeline() of the same parts, but for rounding, in one way through the drive for each pipeline.
/// Fails as run_outage() and solve_in_passing() do.
[[nodiscard]] base::Result<std::vector<OutageResult>> run_outages_in_passing(const Drive& drive,
                                                                             std::span<const Outage> outages,
                                                                             std::span<const FilterPipeline> pipelines);

/// A pipeline over all outages: means over outages.
struct PipelineSummary {
  std::string name;
  Estimate horizontal_rmse_m;
  Estimate horizontal_final_m;
  Eigen::Vector3d position_rmse_m = Eigen::Vector3d::Zero();   ///< per axis
  Eigen::Vector3d position_final_m = Eigen::Vector3d::Zero();  ///< per axis, of the magnitudes
  /// 1 − mean final error / that of the first pipeline, outages paired; 0 for the first itself.
  Estimate gain;
};

/// At least one result; all with these pipelines. The seed is that of the intervals.
[[nodiscard]] std::vector<PipelineSummary> summarize(std::span<const OutageResult> results,
                                                     std::span<const Pipeline> pipelines, std::uint64_t seed);

}  // namespace soak::nav
