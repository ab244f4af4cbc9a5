// SPDX-License-Identifier: Apache-2.0
#include "calib/gap/search/detail/residual_structure.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <optional>
#include <vector>

#include "calib/gap/search/detail/axis_tests.h"
#include "calib/gap/search/detail/jumps.h"
#include "calib/gap/search/detail/slow_noise.h"
#include "calib/gap/search/score.h"

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
          .kind = StructureKind::between_effects,
          .axis = fmt::format("the temperature history, much as {} and {} do but not quite as either",
                              first.effect->name, second.effect->name),
          .p_adjusted = second.p_adjusted,
          .merit = second.merit,
          .sensors = second.sensors,
          .forbids_names = true,
          .of_history = true};
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
      worst = ResidualStructure{axis.kind, axis.name, p, found, effect.sensors, true, axis.of_history};
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
      .kind = found->kind,
      .axis = noise_wanders ? "time, by jumps that no other run has" : "time, differently in each run",
      .p_adjusted = found->p_adjusted,
      .merit = found->excess,
      .sensors = found->sensors,
      .forbids_names = true,
      .steps = found->steps};
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
    best = ResidualStructure{
        axis.kind, axis.name, p, stands.merit, stands.sensors, stands.merit >= kStrange * named, axis.of_history};
  }
  return best;
}

std::optional<ResidualStructure> structure_left(const CampaignModel& model, const std::vector<NamedEffect>& effects,
                                                double typical, double price) {
  const std::vector<AxisTest> axes = test_axes(model, typical, price);
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
  if (found) found->recorded.runs = model.regressor_inputs().observations.run_count();
  const bool is_open = found && found->forbids_names && !model.known_noise();
  if (!is_open || model.regressor_inputs().history.coarse()) return found;
  if (const auto slow = slow_noise(model, effects)) found->may_wander = slow->sensors;
  return found;
}

}  // namespace soak::calib::gap
