// SPDX-License-Identifier: Apache-2.0
#include "calib/gap/search/detail/residual_structure.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "calib/gap/search/detail/residual_axes.h"
#include "calib/gap/search/slow_noise.h"

namespace soak::calib::gap {
namespace {

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

struct AxisTest {
  std::string name;
  CandidateTest test;
  Standing standing;
};

std::vector<AxisTest> tested_axes(const CampaignModel& model, double typical, double price) {
  std::vector<AxisTest> tests;
  for (const Axis& axis : leftover_axes(model.circumstances())) {
    AxisTest test{axis.name, test_candidate(model.residuals(), axis.candidate), {}};
    test.standing = standing(test.test, axis.candidate, typical, price);
    tests.push_back(std::move(test));
  }
  return tests;
}

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

std::optional<Leftover> between_twins(const std::vector<NamedEffect>& effects) {
  for (std::size_t k = 1; k < effects.size(); ++k) {
    for (std::size_t before = 0; before < k; ++before) {
      const NamedEffect& first = effects[before];
      const NamedEffect& second = effects[k];
      const bool inside = std::all_of(second.sensors.begin(), second.sensors.end(), [&](Sensor sensor) {
        return std::find(first.sensors.begin(), first.sensors.end(), sensor) != first.sensors.end();
      });
      if (!inside || !are_twins(*first.effect, *second.effect)) continue;
      if (!first.effect->of_course || !second.effect->of_course) continue;
      const bool small = explained({second}, second.sensors) < kMended * explained({first}, second.sensors);
      if (!small && !in_proportion(first, second)) continue;
      return Leftover{.axis = fmt::format("the course of the temperature as {} and {} do, but as neither",
                                          first.effect->name, second.effect->name),
                      .p_adjusted = second.p_adjusted,
                      .merit = second.merit,
                      .sensors = second.sensors,
                      .forbids_names = true};
    }
  }
  return std::nullopt;
}

/// The axis that finds most of what an effect should have explained in its own sensors.
std::optional<Leftover> misfit(const std::vector<AxisTest>& axes, const std::vector<NamedEffect>& effects,
                               double typical) {
  std::optional<Leftover> worst;
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
      const double p = std::min(1.0, p_value(together, typical) * static_cast<double>(axes.size()));
      const double found = together.gain / moderated_heterogeneity(together, typical) - together.dof;
      if (p > kGate || found < tolerated * (known + found)) continue;
      if (worst && worst->merit >= found) continue;
      worst = Leftover{axis.name, p, found, effect.sensors, true};
    }
  }
  return worst;
}

std::optional<Leftover> wander(const CampaignModel& model, const std::vector<NamedEffect>& effects) {
  const auto slow = slow_noise(model, effects);
  if (!slow || slow->excess < kStrange * explained(effects, slow->sensors)) return std::nullopt;
  return Leftover{"time, in another way in each run", slow->p_adjusted, slow->excess, slow->sensors, true};
}

std::optional<Leftover> strongest(const std::vector<AxisTest>& axes, const std::vector<NamedEffect>& effects) {
  double named = 0.0;
  for (const NamedEffect& effect : effects) named = std::max(named, effect.merit);
  std::optional<Leftover> best;
  for (const AxisTest& axis : axes) {
    const Standing& stands = axis.standing;
    const double p = std::min(1.0, stands.p * static_cast<double>(axes.size()));
    if (p > kGate || !enough_folds(stands) || stands.merit <= 0.0) continue;
    if (best && best->merit >= stands.merit) continue;
    best = Leftover{axis.name, p, stands.merit, stands.sensors, stands.merit >= kStrange * named};
  }
  return best;
}

}  // namespace

std::optional<Leftover> find_leftover(const CampaignModel& model, const std::vector<NamedEffect>& effects,
                                      double typical, double price) {
  const std::vector<AxisTest> axes = tested_axes(model, typical, price);
  auto any = strongest(axes, effects);
  if (any && any->forbids_names) return any;
  if (auto found = between_twins(effects)) return found;
  if (auto found = misfit(axes, effects, typical)) return found;
  // A temperature that is known to a step wanders within it, and the readings with it.
  if (model.circumstances().courses.coarse()) return any;
  if (auto found = wander(model, effects)) return found;
  return any;
}

}  // namespace soak::calib::gap
