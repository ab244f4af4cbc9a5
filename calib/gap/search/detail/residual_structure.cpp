// SPDX-License-Identifier: Apache-2.0
#include "calib/gap/search/detail/residual_structure.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "calib/gap/base/base_curve.h"
#include "calib/gap/effects/columns.h"
#include "calib/gap/search/detail/jumps.h"
#include "calib/gap/search/detail/slow_noise.h"
#include "calib/gap/search/score.h"

namespace soak::calib::gap {
namespace {

constexpr int kKnots = 6;  ///< of what is smooth in the time within a run

/// Indicator columns of all groups but the first; a group number below 0 belongs to none.
Eigen::MatrixXd indicators(const std::vector<int>& group) {
  std::map<int, Eigen::Index> column;
  for (const int g : group) {
    if (g >= 0) column.try_emplace(g, 0);
  }
  Eigen::Index next = -1;
  for (auto& [g, index] : column) index = next++;
  Eigen::MatrixXd columns =
      Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(group.size()), std::max<Eigen::Index>(0, next));
  for (std::size_t i = 0; i < group.size(); ++i) {
    if (group[i] < 0) continue;
    const Eigen::Index index = column.at(group[i]);
    if (index >= 0) columns(static_cast<Eigen::Index>(i), index) = 1.0;
  }
  return columns;
}

template <class Group>
Eigen::MatrixXd by(const Observations& observations, Group group) {
  std::vector<int> groups;
  for (const Observation& row : observations.rows) groups.push_back(group(row));
  return indicators(groups);
}

double direction(const Observation& row) { return row.sweep == Sweep::down ? -1.0 : 1.0; }

/// Half the difference between heating and cooling in each group that knows both: no group's mean, which the base has.
template <class Group>
Eigen::MatrixXd directions_by(const Observations& observations, Group group) {
  std::map<int, std::array<bool, 2>> seen;
  for (const Observation& row : observations.rows) seen[group(row)].at(row.sweep == Sweep::down ? 1 : 0) = true;
  std::map<int, Eigen::Index> column;
  for (const auto& [g, ways] : seen) {
    if (ways[0] && ways[1]) column.try_emplace(g, static_cast<Eigen::Index>(column.size()));
  }
  Eigen::MatrixXd columns = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(observations.rows.size()),
                                                  static_cast<Eigen::Index>(column.size()));
  for (Eigen::Index i = 0; i < columns.rows(); ++i) {
    const Observation& row = observations.rows[static_cast<std::size_t>(i)];
    const auto found = column.find(group(row));
    if (found != column.end()) columns(i, found->second) = direction(row);
  }
  return columns;
}

/// A smooth function of the time since each run's first row, the same in all runs.
Eigen::MatrixXd of_time_in_run(const Observations& observations) {
  std::map<int, double> start_s;
  for (const Observation& row : observations.rows) start_s.try_emplace(row.run, row.t_s);
  double longest_s = 1.0;
  for (const Observation& row : observations.rows) longest_s = std::max(longest_s, row.t_s - start_s.at(row.run));
  std::vector<double> knots;
  for (int k = 0; k < kKnots; ++k) knots.push_back(longest_s * k / (kKnots - 1));
  const LevelSpline spline(knots);
  Eigen::MatrixXd columns(static_cast<Eigen::Index>(observations.rows.size()), kKnots - 1);
  for (Eigen::Index i = 0; i < columns.rows(); ++i) {
    const Observation& row = observations.rows[static_cast<std::size_t>(i)];
    columns.row(i) = spline.weights(row.t_s - start_s.at(row.run)).tail(kKnots - 1);
  }
  return columns;
}

/// Share of the strongest named merit from which an axis, or a wander, forbids names.
constexpr double kStrange = 0.25;
/// Share of what is explained in an effect's sensors from which an axis says that the mechanism does not fit: where its
/// shape is an approximation, and where its regressors are known.
constexpr double kLooseFit = 0.10;
constexpr double kCloseFit = 0.04;
/// Share of its twin's gain below which a second effect mends the first one's fit.
constexpr double kMended = 0.5;
/// Between the sensors, of the second effect's share of the first one's gain: twice for the error of each.
constexpr double kProportion = 2.0;

/// An axis along which something unknown may sit, as free levels, tested: it names no physics.
struct AxisTest {
  std::string name;  ///< "time since the fixture turned", ...
  CandidateTest test;
  Standing standing;
  bool of_history = false;
};

/// Tests the axes that a campaign can show.
class AxisTests {
 public:
  AxisTests(const CampaignModel& model, double typical, double price)
      : model_(model), typical_(typical), price_(price) {
    const RegressorInputs in = model.regressor_inputs();
    const Observations& o = in.observations;
    if (!in.history.blurred()) {
      add("temperature and direction of the sweep", directions_by(o, [](const Observation& row) { return row.level; }),
          true);
    }
    if (!in.history.coarse()) {
      add("time since the plateau was reached and direction of the sweep",
          directions_by(o, [](const Observation& row) { return row.order; }), true);
      add("time since the fixture turned",
          by(o, [](const Observation& row) { return static_cast<int>(row.t_in_placement_s / 60.0); }));
      add("order of the positions in a visit", by(o, [](const Observation& row) { return row.order; }));
    }
    if (o.has_positions()) add_positions(o);
    if (in.history.coarse()) return;
    add_times(in);
    if (!in.history.chamber_c().empty()) {
      Eigen::VectorXd across = as_vector(in.history.chamber_c());
      for (Eigen::Index i = 0; i < across.size(); ++i) across(i) -= o.rows[static_cast<std::size_t>(i)].temp_c;
      add("chamber air less unit", across, true);
    }
  }

  [[nodiscard]] std::vector<AxisTest> take() { return std::move(tests_); }

 private:
  void add(std::string name, const Eigen::MatrixXd& columns, bool of_history = false) {
    if (columns.cols() == 0) return;
    const Candidate candidate = for_all("", {}, columns);
    AxisTest test{std::move(name), test_candidate(model_.residuals(), candidate), {}, of_history};
    test.standing = standing(test.test, candidate, typical_, price_);
    tests_.push_back(std::move(test));
  }

  void add_positions(const Observations& o) {
    const Eigen::MatrixXd position = by(o, [](const Observation& row) { return row.position; });
    add("position", position);
    add("position before", by(o, [](const Observation& row) { return row.previous; }));
    Eigen::VectorXd since_min(position.rows());
    for (Eigen::Index i = 0; i < since_min.size(); ++i) {
      since_min(i) = o.rows[static_cast<std::size_t>(i)].t_in_placement_s / 60.0;
    }
    add("position and time since the fixture turned", since_min.asDiagonal() * position);
    add("position and temperature", reduced_temperature(o).asDiagonal() * position);
  }

  void add_times(const RegressorInputs& in) {
    add("time within the run", of_time_in_run(in.observations), true);
    add("time of day", time_of_day(in));
    if (!in.history.since_power_s().empty()) {
      std::vector<int> octave;
      for (const double t_s : in.history.since_power_s()) {
        octave.push_back(static_cast<int>(std::floor(std::log2(std::max(60.0, t_s)))));
      }
      add("time since power-on", indicators(octave));
    }
  }

  const CampaignModel& model_;
  double typical_;
  double price_;
  std::vector<AxisTest> tests_;
};

/// Gain of all effects in those sensors.
double explained(const std::vector<NamedEffect>& effects, const std::vector<Sensor>& sensors) {
  double sum = 0.0;
  for (const NamedEffect& effect : effects) {
    for (const Sensor sensor : sensors) sum += effect.gain[index_of(sensor)];
  }
  return sum;
}

/// Whether the second effect stands to the first in all sensors as in the first of them: mechanisms that have nothing
/// to do with each other do not.
bool in_proportion(const NamedEffect& first, const NamedEffect& second) {
  if (first.sensors != second.sensors || first.sensors.size() < 3) return false;
  double least = std::numeric_limits<double>::infinity();
  double most = 0.0;
  int opposed = 0;
  for (const Sensor sensor : first.sensors) {
    const std::size_t s = index_of(sensor);
    const double share = second.gain[s] / std::max(first.gain[s], std::numeric_limits<double>::min());
    least = std::min(least, share);
    most = std::max(most, share);
    if (first.parameters[s](0) * second.parameters[s](0) < 0.0) ++opposed;
  }
  const bool one_sign = opposed == 0 || opposed == static_cast<int>(first.sensors.size());
  return one_sign && most < kProportion * least;
}

std::optional<ResidualStructure> between_twins(const std::vector<NamedEffect>& effects) {
  for (std::size_t k = 1; k < effects.size(); ++k) {
    for (std::size_t before = 0; before < k; ++before) {
      const NamedEffect& first = effects[before];
      const NamedEffect& second = effects[k];
      const bool inside = std::all_of(second.sensors.begin(), second.sensors.end(), [&](Sensor sensor) {
        return std::find(first.sensors.begin(), first.sensors.end(), sensor) != first.sensors.end();
      });
      if (!inside || !are_twins(*first.effect, *second.effect)) continue;
      if (!first.effect->follows_history || !second.effect->follows_history) continue;
      const bool small = explained({second}, second.sensors) < kMended * explained({first}, second.sensors);
      if (!small && !in_proportion(first, second)) continue;
      return ResidualStructure{
          .axis = fmt::format("the temperature history, much as {} and {} do but not quite as either",
                              first.effect->name, second.effect->name),
          .p_adjusted = second.p_adjusted,
          .merit = second.merit,
          .sensors = second.sensors,
          .forbids_names = true,
          .of_history = true,
          .between_effects = true};
    }
  }
  return std::nullopt;
}

/// The axis that finds most of what an effect should have explained in its own sensors.
std::optional<ResidualStructure> misfit(const std::vector<AxisTest>& axes, const std::vector<NamedEffect>& effects,
                                        double typical) {
  std::optional<ResidualStructure> worst;
  for (const NamedEffect& effect : effects) {
    const double known = explained(effects, effect.sensors);
    const double tolerated = effect.candidate.shape_values.empty() ? kCloseFit : kLooseFit;
    for (const AxisTest& axis : axes) {
      std::vector<const TermTest*> tests;
      for (const Sensor sensor : effect.sensors) {
        const auto& own = axis.test.sensor[index_of(sensor)];
        if (own && own->dof > 0.0) tests.push_back(&*own);
      }
      if (tests.empty()) continue;
      const TermTest together = pooled(tests);
      const double p = std::min(1.0, p_value(tests, typical) * static_cast<double>(axes.size()));
      const double found = together.gain / moderated_heterogeneity(together, typical) - together.dof;
      if (p > kGate || found < tolerated * (known + found)) continue;
      if (worst && worst->merit >= found) continue;
      worst = ResidualStructure{axis.name, p, found, effect.sensors, true, axis.of_history};
    }
  }
  return worst;
}

/// What runs do not repeat: where the noise of the model wanders, only jumps are beyond it.
std::optional<ResidualStructure> wander(const CampaignModel& model, const std::vector<NamedEffect>& effects) {
  const bool noise_wanders = model.known_noise().has_value();
  const auto found = noise_wanders ? jumps(model, effects) : slow_noise(model, effects);
  if (!found || found->excess < kStrange * explained(effects, found->sensors)) return std::nullopt;
  return ResidualStructure{
      .axis = noise_wanders ? "time, by jumps that no other run has" : "time, differently in each run",
      .p_adjusted = found->p_adjusted,
      .merit = found->excess,
      .sensors = found->sensors,
      .forbids_names = true};
}

std::optional<ResidualStructure> strongest(const std::vector<AxisTest>& axes, const std::vector<NamedEffect>& effects) {
  double named = 0.0;
  for (const NamedEffect& effect : effects) named = std::max(named, effect.merit);
  std::optional<ResidualStructure> best;
  for (const AxisTest& axis : axes) {
    const Standing& stands = axis.standing;
    const double p = std::min(1.0, stands.p * static_cast<double>(axes.size()));
    if (p > kGate || !stands.enough_folds || stands.merit <= 0.0) continue;
    if (best && best->merit >= stands.merit) continue;
    best = ResidualStructure{axis.name,      p, stands.merit, stands.sensors, stands.merit >= kStrange * named,
                             axis.of_history};
  }
  return best;
}

std::optional<ResidualStructure> structure_left(const CampaignModel& model, const std::vector<NamedEffect>& effects,
                                                double typical, double price) {
  const std::vector<AxisTest> axes = AxisTests(model, typical, price).take();
  auto any = strongest(axes, effects);
  if (any && any->forbids_names) return any;
  if (auto found = between_twins(effects)) return found;
  if (auto found = misfit(axes, effects, typical)) return found;
  // A temperature that is known to a step wanders within it, and the readings with it.
  if (model.regressor_inputs().history.coarse()) return any;
  if (auto found = wander(model, effects)) return found;
  return any;
}

}  // namespace

std::optional<ResidualStructure> find_residual_structure(const CampaignModel& model,
                                                         const std::vector<NamedEffect>& effects, double typical,
                                                         double price) {
  auto found = structure_left(model, effects, typical, price);
  const bool is_open = found && found->forbids_names && !model.known_noise();
  if (!is_open || model.regressor_inputs().history.coarse()) return found;
  if (const auto slow = slow_noise(model, effects)) found->may_wander = slow->sensors;
  return found;
}

}  // namespace soak::calib::gap
