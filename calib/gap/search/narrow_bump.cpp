// SPDX-License-Identifier: Apache-2.0
#include "calib/gap/search/outside_the_mean.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <limits>

#include "base/statistics.h"
#include "calib/gap/search/score.h"

namespace soak::calib::gap {
namespace {

constexpr int kLeastBumpLevels = 12;
constexpr Eigen::Index kReach = 2;    ///< neighbours on either side
constexpr double kSensorGate = 0.01;  ///< chance from which a sensor of the set that stands out is counted in

const Effect& bump() {
  static const Effect effect = [] {
    Effect made;
    made.name = "narrow_bump";
    made.physics =
        "a feature of the curve at one temperature, narrower than the distance of the plateaus: a resonance, a range "
        "that switches";
    made.experiment = "a grid of 2 K about it, up and down";
    return made;
  }();
  return effect;
}

/// Levels that do not touch level `k` or its neighbours' cubics: what says how far levels lie off by themselves.
struct Others {
  double mean_square = 0.0;
  double dof = 0.0;
};

Others others_than(Eigen::Index k, const Eigen::VectorXd& off) {
  Others others;
  for (Eigen::Index j = kReach; j + kReach < off.size(); ++j) {
    if (std::abs(j - k) <= kReach) continue;
    others.dof += 1.0;
    others.mean_square += (off(j) * off(j) - others.mean_square) / others.dof;
  }
  return others;
}

/// Chance that level `k` lies so far off as one of the others.
double chance_of(Eigen::Index k, const Eigen::VectorXd& off) {
  const Others others = others_than(k, off);
  if (others.dof < 1.0 || others.mean_square <= 0.0) return 1.0;
  return base::f_upper_tail(off(k) * off(k) / others.mean_square, 1.0, others.dof);
}

}  // namespace

Eigen::VectorXd off_neighbours(const std::vector<double>& level_c, const Eigen::VectorXd& levels) {
  Eigen::VectorXd off = Eigen::VectorXd::Constant(levels.size(), std::numeric_limits<double>::quiet_NaN());
  const auto at_c = [&](Eigen::Index k) { return level_c[static_cast<std::size_t>(k)]; };
  for (Eigen::Index k = kReach; k + kReach < levels.size(); ++k) {
    double predicted = 0.0;
    for (Eigen::Index j = k - kReach; j <= k + kReach; ++j) {
      if (j == k) continue;
      double weight = 1.0;  // Lagrange's
      for (Eigen::Index i = k - kReach; i <= k + kReach; ++i) {
        if (i != j && i != k) weight *= (at_c(k) - at_c(i)) / (at_c(j) - at_c(i));
      }
      predicted += weight * levels(j);
    }
    off(k) = levels(k) - predicted;
  }
  return off;
}

OutsideTheMean look_for_bump(const CampaignModel& model) {
  OutsideTheMean result;
  const Observations& observations = model.circumstances().observations;
  const Eigen::Index count = observations.level_count();
  if (count < kLeastBumpLevels) {
    result.not_testable.push_back(
        {"narrow_bump",
         fmt::format("{} plateaus do not say how smooth the curve is between them: a feature of one is taken for the "
                     "curve's own. Record twelve or more, 5 K apart about it",
                     count)});
    return result;
  }
  std::array<Eigen::VectorXd, kSensorCount> off;
  std::vector<Sensor> sensors;
  for (const Sensor sensor : kSensors) {
    const auto& residual = model.residuals().sensor[index_of(sensor)];
    if (!residual) continue;
    off[index_of(sensor)] = off_neighbours(observations.level_c, residual->coefficients().head(count));
    sensors.push_back(sensor);
  }
  const auto sets = sensor_sets(sensors);
  const auto tests = static_cast<double>(sets.size()) * static_cast<double>(count - 2 * kReach);
  NamedEffect found;
  found.effect = &bump();
  for (Eigen::Index k = kReach; k + kReach < count; ++k) {
    for (const auto& set : sets) {
      std::vector<double> chances;
      for (const Sensor sensor : set) chances.push_back(chance_of(k, off[index_of(sensor)]));
      const double p = std::min(1.0, chance_together(chances) * tests);
      if (p >= found.p_adjusted) continue;
      found.p_adjusted = p;
      found.sensors.clear();
      const auto least = static_cast<std::size_t>(std::min_element(chances.begin(), chances.end()) - chances.begin());
      for (std::size_t i = 0; i < set.size(); ++i) {
        if (chances[i] <= kSensorGate || i == least) found.sensors.push_back(set[i]);
      }
      const Sensor strongest = set[least];
      found.candidate.shape = fmt::format("at {:.1f} degC", observations.level_c[static_cast<std::size_t>(k)]);
      found.magnitude = {off[index_of(strongest)](k) * printed_per_si(strongest), std::string(printed_unit(strongest))};
    }
  }
  if (found.p_adjusted <= kOutsideMeanGate) result.effects.push_back(std::move(found));
  return result;
}

}  // namespace soak::calib::gap
