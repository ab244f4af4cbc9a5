// SPDX-License-Identifier: Apache-2.0
#include "nav/outages/outage_runner.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>

namespace soak::nav {
namespace {

using Eigen::Vector3d;

double horizontal(const Vector3d& v) { return std::hypot(v.x(), v.y()); }

OutageErrors errors_of(std::span<const TruthPoint> truth, std::span<const Solution> solutions, double begin_s) {
  OutageErrors errors;
  Vector3d position_squares = Vector3d::Zero();
  Vector3d velocity_squares = Vector3d::Zero();
  for (std::size_t i = 0; i < truth.size(); ++i) {
    errors.points.push_back({truth[i].t_s - begin_s, offset_m(truth[i].position, solutions[i].antenna),
                             solutions[i].velocity_mps - truth[i].velocity_mps});
    position_squares += errors.points.back().position_m.cwiseAbs2();
    velocity_squares += errors.points.back().velocity_mps.cwiseAbs2();
  }
  const auto count = static_cast<double>(truth.size());
  errors.position_rmse_m = (position_squares / count).cwiseSqrt();
  errors.velocity_rmse_mps = (velocity_squares / count).cwiseSqrt();
  errors.position_final_m = errors.points.back().position_m;
  errors.velocity_final_mps = errors.points.back().velocity_mps;
  errors.horizontal_rmse_m = horizontal(errors.position_rmse_m);
  errors.horizontal_final_m = horizontal(errors.position_final_m);
  return errors;
}

base::Result<std::span<const TruthPoint>> truth_in(const Drive& drive, const Outage& outage) {
  const auto first = std::ranges::upper_bound(drive.truth, outage.begin_s, {}, &TruthPoint::t_s);
  const auto last = std::ranges::upper_bound(drive.truth, outage.end_s, {}, &TruthPoint::t_s);
  if (first != last) return std::span<const TruthPoint>(first, last);
  return base::bad_input(fmt::format("no truth lies in the outage from {} s to {} s", outage.begin_s, outage.end_s),
                         drive.name);
}

std::vector<double> times_of(std::span<const TruthPoint> truth) {
  std::vector<double> t_s;
  for (const TruthPoint& point : truth) t_s.push_back(point.t_s);
  return t_s;
}

/// The outage as the antenna went through it; no pipeline's errors yet.
OutageResult way_of(const Drive& drive, const Outage& outage, std::span<const TruthPoint> truth) {
  OutageResult result{outage, drive.name, 0.0, {}, {}};
  for (const TruthPoint& point : truth) result.track_m.push_back(offset_m(truth.front().position, point.position));
  for (std::size_t i = 1; i < truth.size(); ++i) {
    result.distance_m += offset_m(truth[i - 1].position, truth[i].position).norm();
  }
  return result;
}

base::Status add_errors_of(const std::string& pipeline, std::span<const TruthPoint> truth,
                           std::span<const Solution> solutions, OutageResult& result) {
  const auto is_finite = [](const Solution& solution) {
    return to_ecef(solution.antenna).allFinite() && solution.velocity_mps.allFinite();
  };
  if (solutions.size() != truth.size() || !std::ranges::all_of(solutions, is_finite)) {
    return base::fail(base::ErrorKind::internal,
                      fmt::format("pipeline {} gave no finite solution for each of {} times", pipeline, truth.size()),
                      result.drive);
  }
  result.pipelines.push_back(errors_of(truth, solutions, result.outage.begin_s));
  return {};
}

/// Mean over the chosen outages of a number of one pipeline's errors.
double mean_of(std::span<const OutageResult> results, std::span<const std::size_t> chosen, std::size_t pipeline,
               const std::function<double(const OutageErrors&)>& number) {
  double sum = 0.0;
  for (const std::size_t i : chosen) sum += number(results[i].pipelines[pipeline]);
  return sum / static_cast<double>(chosen.size());
}

}  // namespace

base::Result<std::vector<Outage>> spread_outages(const Drive& drive, double first_s, double length_s,
                                                 std::size_t number) {
  const double begin_s = drive.imu.front().t_s + first_s;
  const double end_s = std::min(drive.imu.back().t_s, drive.truth.empty() ? begin_s : drive.truth.back().t_s);
  const double room_s = end_s - length_s - begin_s;
  if (room_s < 0.0) {
    return base::bad_input(fmt::format("an outage of {} s that begins {} s after the start needs a drive of {} s with "
                                       "truth; this one has {:.0f} s",
                                       length_s, first_s, first_s + length_s, end_s - drive.imu.front().t_s),
                           drive.name);
  }
  std::vector<Outage> outages;
  for (std::size_t i = 0; i < number; ++i) {
    const double share = number > 1 ? static_cast<double>(i) / static_cast<double>(number - 1) : 0.0;
    outages.push_back({begin_s + share * room_s, begin_s + share * room_s + length_s});
  }
  return outages;
}

base::Result<OutageResult> run_outage(const Drive& drive, const Outage& outage, std::span<const Pipeline> pipelines) {
  const auto truth = truth_in(drive, outage);
  if (!truth) return base::forward_error(truth);
  const std::vector<double> t_s = times_of(*truth);
  OutageResult result = way_of(drive, outage, *truth);
  const Drive seen = with_outage(drive, outage);
  for (const Pipeline& pipeline : pipelines) {
    const auto solutions = pipeline.solve(seen, t_s);
    if (!solutions) return base::forward_error(solutions);
    if (auto added = add_errors_of(pipeline.name, *truth, *solutions, result); !added) {
      return base::forward_error(added);
    }
  }
  return result;
}

base::Result<std::vector<OutageResult>> run_outages_in_passing(const Drive& drive, std::span<const Outage> outages,
                                                               std::span<const FilterPipeline> pipelines) {
  std::vector<std::span<const TruthPoint>> truths;
  std::vector<std::vector<double>> t_s;
  std::vector<OutageResult> results;
  for (const Outage& outage : outages) {
    const auto truth = truth_in(drive, outage);
    if (!truth) return base::forward_error(truth);
    truths.push_back(*truth);
    t_s.push_back(times_of(*truth));
    results.push_back(way_of(drive, outage, *truth));
  }
  for (const FilterPipeline& pipeline : pipelines) {
    const auto solutions = solve_in_passing(pipeline, drive, outages, t_s);
    if (!solutions) return base::forward_error(solutions);
    for (std::size_t i = 0; i < outages.size(); ++i) {
      if (auto added = add_errors_of(pipeline.name, truths[i], (*solutions)[i], results[i]); !added) {
        return base::forward_error(added);
      }
    }
  }
  return results;
}

std::vector<PipelineSummary> summarize(std::span<const OutageResult> results, std::span<const Pipeline> pipelines,
                                       std::uint64_t seed) {
  const auto rmse = [](const OutageErrors& errors) { return errors.horizontal_rmse_m; };
  const auto final_error = [](const OutageErrors& errors) { return errors.horizontal_final_m; };
  std::vector<PipelineSummary> summaries;
  for (std::size_t p = 0; p < pipelines.size(); ++p) {
    PipelineSummary summary;
    summary.name = pipelines[p].name;
    const auto estimate = [&](const auto& number) {
      return bootstrap(
          results.size(), [&](std::span<const std::size_t> chosen) { return mean_of(results, chosen, p, number); },
          seed);
    };
    summary.horizontal_rmse_m = estimate(rmse);
    summary.horizontal_final_m = estimate(final_error);
    for (const OutageResult& result : results) {
      summary.position_rmse_m += result.pipelines[p].position_rmse_m / static_cast<double>(results.size());
      summary.position_final_m += result.pipelines[p].position_final_m.cwiseAbs() / static_cast<double>(results.size());
    }
    summary.gain = bootstrap(
        results.size(),
        [&](std::span<const std::size_t> chosen) {
          return 1.0 - mean_of(results, chosen, p, final_error) / mean_of(results, chosen, 0, final_error);
        },
        seed);
    summaries.push_back(std::move(summary));
  }
  return summaries;
}

}  // namespace soak::nav
