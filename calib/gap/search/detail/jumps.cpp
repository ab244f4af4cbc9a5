// SPDX-License-Identifier: Apache-2.0
#include "calib/gap/search/detail/jumps.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <limits>
#include <utility>

#include "base/linear/dense_solve.h"
#include "base/linear/products.h"
#include "base/statistics.h"
#include "calib/gap/effects/columns.h"
#include "calib/gap/noise/wander_estimate.h"
#include "calib/gap/search/detail/jumps_beside_wander.h"
#include "calib/gap/search/detail/telegraph.h"
#include "calib/gap/search/score.h"

namespace soak::calib::gap {
namespace {

constexpr double kInvisible = 1e-3;      ///< share of a step's squares below which the base takes it up
constexpr std::size_t kMostPlaces = 80;  ///< of a step in one run; of more within visits, every second, third...
constexpr double kSuspicious = 0.01;     ///< chance of a step in one run from where the noise is told without it
constexpr double kWays = 4.0;            ///< in which chances are put together

/// Rows at which a step may come, the first of placements other than the run's first: all between visits, where most of
/// the time passes, and as many of those within visits as there may be.
std::vector<Eigen::Index> places_in(const Observations& observations, int run) {
  std::vector<Eigen::Index> places;
  for (std::size_t i = 1; i < observations.rows.size(); ++i) {
    const Observation& row = observations.rows[i];
    const Observation& before = observations.rows[i - 1];
    if (row.run == run && before.run == run && row.placement != before.placement) {
      places.push_back(static_cast<Eigen::Index>(i));
    }
  }
  const std::size_t stride = places.size() / kMostPlaces + 1;
  std::vector<Eigen::Index> kept;
  for (std::size_t k = 0; k < places.size(); ++k) {
    const auto row = static_cast<std::size_t>(places[k]);
    const bool between_visits = observations.rows[row].visit != observations.rows[row - 1].visit;
    if (between_visits || k % stride == stride / 2) kept.push_back(places[k]);
  }
  return kept;
}

/// A step to 1 at each place until the run's end, a column each.
Eigen::MatrixXd steps_at(const Observations& observations, const std::vector<Eigen::Index>& places, int run) {
  Eigen::MatrixXd steps = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(observations.rows.size()),
                                                static_cast<Eigen::Index>(places.size()));
  for (std::size_t k = 0; k < places.size(); ++k) {
    for (Eigen::Index i = places[k]; i < steps.rows(); ++i) {
      if (observations.rows[static_cast<std::size_t>(i)].run != run) break;
      steps(i, static_cast<Eigen::Index>(k)) = 1.0;
    }
  }
  return steps;
}

/// Columns of the effects in one run only, zero in the others.
Eigen::MatrixXd in_run(const Observations& observations, Eigen::MatrixXd columns, int run) {
  for (Eigen::Index i = 0; i < columns.rows(); ++i) {
    if (observations.rows[static_cast<std::size_t>(i)].run != run) columns.row(i).setZero();
  }
  return columns;
}

/// What the step that stands out most in a run takes out of the squares, more than the largest of as many chances
/// would, and its chance among all places.
struct Step {
  double excess = 0.0;
  double p = 1.0;
  int run = 0;
  Eigen::VectorXd course = {};  ///< 0 before it, 1 after it until the run's end; empty where there is none
  Eigen::Index row = 0;         ///< the first after it
  double size = 0.0;
};

/// Whitened steps in one run, of which base and effects leave so much, and what that part says of the residual.
struct StepScores {
  Eigen::VectorXd before;       ///< squares, with nothing taken off
  Eigen::VectorXd information;  ///< squares of what is left
  Eigen::VectorXd score;
};

/// What steps are tested against.
struct StepTest {
  const Observations& observations;
  const SensorResidual& residual;
  double noise_dof;
  /// BᵀB of the residual's basis.
  Eigen::MatrixXd basis_squares = base::transposed_product(residual.basis(), residual.basis());
};

/// `effects`: columns whose strength in that run is free. Steps are zero in all other runs, so that products with them
/// need the rows of this one only.
StepScores score_steps(const StepTest& test, const Eigen::MatrixXd& effects, const Eigen::MatrixXd& steps, int run) {
  const SensorResidual& residual = test.residual;
  const std::vector<Eigen::Index>& rows = residual.rows();
  const auto run_of = [&](Eigen::Index row) { return test.observations.rows[static_cast<std::size_t>(row)].run; };
  const auto [begin, end] = std::ranges::equal_range(rows, run, {}, run_of);
  const Eigen::Index first = begin - rows.begin();
  const Eigen::MatrixXd white = residual.whiten_in_run(steps, first, end - begin);
  const auto of_run = [&](const auto& all) { return all.middleRows(first, end - begin); };
  const Eigen::MatrixXd taken = base::transposed_product(of_run(residual.basis()), white);
  StepScores scores;
  scores.before = white.colwise().squaredNorm().transpose();
  // |w - B Bᵀw|²: B is orthonormal but for what the base's prior holds of it.
  scores.information = scores.before - 2.0 * taken.colwise().squaredNorm().transpose() +
                       taken.cwiseProduct(base::product(test.basis_squares, taken)).colwise().sum().transpose();
  Eigen::VectorXd left = residual.residual();
  if (effects.cols() > 0) {
    const Eigen::MatrixXd strength = residual.project(residual.whiten(in_run(test.observations, effects, run)));
    left -= strength * base::solve_pivoted_qr(strength, left);
    const Eigen::MatrixXd along = of_run(residual.project(strength)).transpose() * white;
    const Eigen::MatrixXd squares = strength.transpose() * strength;
    scores.information -= along.cwiseProduct(base::solve_orthogonal(squares, along)).colwise().sum().transpose();
  }
  scores.score = white.transpose() * of_run(residual.project(left));
  return scores;
}

Step strongest_step(const StepTest& test, const Eigen::MatrixXd& effects, int run) {
  const Observations& observations = test.observations;
  const std::vector<Eigen::Index> places = places_in(observations, run);
  if (places.empty()) return {};
  const StepScores steps = score_steps(test, effects, steps_at(observations, places, run), run);
  double gain = 0.0;
  Eigen::Index strongest = 0;
  for (Eigen::Index k = 0; k < steps.score.size(); ++k) {
    if (steps.information(k) <= kInvisible * steps.before(k)) continue;
    const double own = steps.score(k) * steps.score(k) / steps.information(k);
    if (own <= gain) continue;
    gain = own;
    strongest = k;
  }
  const auto count = static_cast<double>(places.size());
  if (gain <= 0.0 || test.noise_dof <= 0.0) return {};
  return {std::max(0.0, gain - 2.0 * std::log(count)),
          std::min(1.0, count * base::f_upper_tail(gain, 1.0, test.noise_dof)),
          run,
          steps_at(observations, {places[static_cast<std::size_t>(strongest)]}, run),
          places[static_cast<std::size_t>(strongest)],
          steps.score(strongest) / steps.information(strongest)};
}

/// The residual under noise that was estimated without that step: a step is far from the mean of its run for hours, so
/// that the estimate takes it for a slow wander, in which it then hides. Nothing where the noise cannot be told.
std::optional<SensorResidual> residual_without(const CampaignModel& model, const std::vector<NamedEffect>& effects,
                                               Sensor sensor, const Eigen::VectorXd& step) {
  const RegressorInputs in = model.regressor_inputs();
  const Eigen::VectorXd left = unexplained(model, effects, sensor);
  const Eigen::MatrixXd of_day = time_of_day(in);
  Eigen::MatrixXd nuisances(step.size(), of_day.cols() + 1);
  nuisances << of_day, step;
  const auto noise =
      WanderEstimate(in.observations, left, nuisances).of(left, model.residuals().noise[index_of(sensor)]);
  if (!noise) return std::nullopt;
  return model.residual_under(sensor, *noise);
}

/// A free level for each block from the place before a step to the place after it: a step that comes within a
/// placement, or at a turn that was not tried, is between them and no second one.
Eigen::MatrixXd next_to(const Observations& observations, const Step& step) {
  const auto in_run = [&](Eigen::Index row) {
    return row >= 0 && row < step.course.size() && observations.rows[static_cast<std::size_t>(row)].run == step.run;
  };
  const std::vector<Eigen::Index> places = places_in(observations, step.run);
  const auto at = std::ranges::find(places, step.row);
  Eigen::Index begin = at == places.begin() ? step.row - 1 : *std::prev(at);
  while (at == places.begin() && in_run(begin - 1)) --begin;
  Eigen::Index end = std::next(at) == places.end() ? step.row + 1 : *std::next(at);
  while (std::next(at) == places.end() && in_run(end)) ++end;
  Eigen::MatrixXd levels = Eigen::MatrixXd::Zero(step.course.size(), end - begin);
  for (Eigen::Index k = 0; k < levels.cols(); ++k) levels(begin + k, k) = 1.0;
  return levels;
}

/// Whether a step the other way stands out in the run of a step that does, away from that one.
bool steps_back(const StepTest& test, const Eigen::MatrixXd& effects, const Step& step) {
  if (step.p >= kGate) return false;
  const Eigen::MatrixXd levels = next_to(test.observations, step);
  Eigen::MatrixXd known(step.course.size(), effects.cols() + 1 + levels.cols());
  known << effects, step.course, levels;
  const Step second = strongest_step(test, known, step.run);
  return second.p < kGate && second.size * step.size < 0.0;
}

/// Chances of one sensor: of the step that stands out in each run, and of two levels in all of them.
struct OfSensor {
  std::vector<double> of_runs;
  std::vector<Step> steps;  ///< one of each run
  bool back = false;        ///< whether another step, the other way, stands out beside one of them in its run
  double of_levels = 1.0;
  double beside_wander = 1.0;  ///< of two levels with a wander beside them
  double excess = 0.0;
};

OfSensor look_in(const CampaignModel& model, const std::vector<NamedEffect>& effects, Sensor sensor) {
  const Observations& observations = model.regressor_inputs().observations;
  const std::size_t s = index_of(sensor);
  const Eigen::MatrixXd columns = contributions(effects, sensor, static_cast<Eigen::Index>(observations.rows.size()));
  const double noise_dof = model.residuals().noise[s].visit_dof;
  const StepTest test{observations, *model.residuals().sensor[s], noise_dof};
  std::vector<Step> steps;
  for (int run = 0; run < observations.run_count(); ++run) steps.push_back(strongest_step(test, columns, run));
  Step& strongest = *std::ranges::min_element(steps, {}, &Step::p);
  OfSensor result;
  if (strongest.p < kSuspicious) {
    if (const auto without = residual_without(model, effects, sensor, strongest.course)) {
      const StepTest again{observations, *without, noise_dof};
      strongest = strongest_step(again, columns, strongest.run);
      result.back = steps_back(again, columns, strongest);
    }
  }
  for (const Step& step : steps) {
    result.back = result.back || steps_back(test, columns, step);
  }
  for (const Step& step : steps) {
    result.of_runs.push_back(step.p);
    result.excess += step.excess;
  }
  result.of_levels = chance_of_telegraph(model, sensor);
  result.beside_wander = chance_of_jumps_beside_wander(model, sensor);
  const double levels = std::min(result.of_levels, result.beside_wander);
  result.excess -= 2.0 * std::log(std::max(levels, std::numeric_limits<double>::min()));
  result.steps = std::move(steps);
  return result;
}

BiasStep bias_step(const Observations& observations, Sensor sensor, const Step& step) {
  const Observation& after = observations.rows[static_cast<std::size_t>(step.row)];
  const auto of_run = [&](const Observation& row) { return row.run == step.run; };
  const auto first = std::ranges::find_if(observations.rows, of_run);
  return {.run = observations.runs[static_cast<std::size_t>(step.run)],
          .sensor = sensor,
          .t_s = after.t_s,
          .since_s = after.t_s - first->t_s,
          .before_s = observations.rows[static_cast<std::size_t>(step.row - 1)].t_s - first->t_s,
          .temp_c = after.temp_c,
          .size = step.size};
}

/// Which steps stand out in the sensors found, and what kind of thing they are; `by_levels`: they were found by two
/// levels in all runs, not by steps.
void describe(const Observations& observations, const std::array<OfSensor, kSensorCount>& all, bool by_levels,
              SlowNoise& found) {
  for (int run = 0; run < observations.run_count(); ++run) {
    for (const Sensor sensor : found.sensors) {
      const Step& step = all[index_of(sensor)].steps.at(static_cast<std::size_t>(run));
      if (step.p < kGate) found.steps.push_back(bias_step(observations, sensor, step));
    }
  }
  const auto back = [&](Sensor sensor) { return all[index_of(sensor)].back; };
  const auto elsewhere = [&](const BiasStep& step) { return step.run != found.steps.front().run; };
  const bool two_levels = found.steps.empty() && by_levels;
  const bool to_and_fro = two_levels || std::ranges::any_of(found.sensors, back);
  const bool in_one_run = !found.steps.empty() && std::ranges::none_of(found.steps, elsewhere);
  found.kind = to_and_fro ? StructureKind::telegraph_noise : in_one_run ? StructureKind::step : StructureKind::jumps;
}

}  // namespace

std::optional<SlowNoise> jumps(const CampaignModel& model, const std::vector<NamedEffect>& effects) {
  std::array<OfSensor, kSensorCount> found;
  std::vector<Sensor> sensors;
  for (const Sensor sensor : kSensors) {
    if (!model.residuals().sensor[index_of(sensor)]) continue;
    sensors.push_back(sensor);
    found[index_of(sensor)] = look_in(model, effects, sensor);
  }
  const auto sets = sensor_sets(sensors);
  SlowNoise best;
  bool by_levels = false;
  for (const auto& set : sets) {
    std::vector<double> of_runs;
    std::vector<double> of_levels;
    std::vector<double> beside_wander;
    double squares = 0.0;
    for (const Sensor sensor : set) {
      const OfSensor& own = found[index_of(sensor)];
      of_runs.insert(of_runs.end(), own.of_runs.begin(), own.of_runs.end());
      of_levels.push_back(own.of_levels);
      beside_wander.push_back(own.beside_wander);
      squares += own.excess;
    }
    if (of_runs.empty()) continue;
    const double least = *std::min_element(of_runs.begin(), of_runs.end()) * static_cast<double>(of_runs.size());
    const double of_steps = std::min(chance_together(of_runs), least);
    const double two_levels = std::min(chance_together(of_levels), chance_together(beside_wander));
    const double adjusted = std::min(1.0, kWays * std::min(of_steps, two_levels) * static_cast<double>(sets.size()));
    if (adjusted >= best.p_adjusted) continue;
    best = {.p_adjusted = adjusted, .excess = squares, .sensors = set};
    by_levels = two_levels < of_steps;
  }
  if (best.p_adjusted > kSlowGate) return std::nullopt;
  describe(model.regressor_inputs().observations, found, by_levels, best);
  return best;
}

}  // namespace soak::calib::gap
