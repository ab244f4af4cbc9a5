// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "base/statistics.h"
#include "calib/gap/base/smooth_curve.h"
#include "calib/gap/search/outside_the_mean.h"
#include "calib/gap/search/score.h"

namespace soak::calib::gap {
namespace {

constexpr std::size_t kLeastBumpLevels = 12;
constexpr double kNarrow_c = 5.0;     ///< distance over which curvature has to turn and turn back
constexpr double kResolved_c = 7.5;   ///< plateaus further apart do not show a bump of that kind
constexpr double kSensorGate = 0.01;  ///< chance from which a sensor of the set that stands out is counted in
/// Least likelihood of a bump over that of the best kink or step in its place.
constexpr double kOdds = 10.0;

const Effect& bump() {
  static const Effect effect = [] {
    Effect made;
    made.name = "narrow_bump";
    made.physics =
        "a feature of the curve at one temperature, narrower than the distance of the plateaus: a resonance, a range "
        "that switches on and off again";
    made.experiment = "a grid of 2 K about it, up and down";
    return made;
  }();
  return effect;
}

/// The levels of one sensor's bias, from the saturated base.
struct Levels {
  const std::vector<double>& temp_c;
  Eigen::VectorXd value;
  Eigen::MatrixXd covariance;
  double dof;  ///< with which the covariance is known

  [[nodiscard]] double at_c(Eigen::Index k) const { return temp_c[static_cast<std::size_t>(k)]; }
};

/// A level, and two on either side of it at some 5 K from one to the next.
using Five = std::array<Eigen::Index, 5>;

/// The level whose distance from level `from` in the direction `step` is nearest to 5 K; nothing beyond 7.5 K.
std::optional<Eigen::Index> next_level(const std::vector<double>& level_c, Eigen::Index from, Eigen::Index step) {
  const auto count = static_cast<Eigen::Index>(level_c.size());
  const auto distance_c = [&](Eigen::Index k) {
    return std::abs(level_c[static_cast<std::size_t>(k)] - level_c[static_cast<std::size_t>(from)]);
  };
  std::optional<Eigen::Index> best;
  for (Eigen::Index k = from + step; k >= 0 && k < count && distance_c(k) <= kResolved_c; k += step) {
    if (!best || std::abs(distance_c(k) - kNarrow_c) < std::abs(distance_c(*best) - kNarrow_c)) best = k;
  }
  return best;
}

std::optional<Five> five_about(const std::vector<double>& level_c, Eigen::Index k) {
  Five five = {k, k, k, k, k};
  for (const int side : {-1, 1}) {
    for (int i = 1; i <= 2; ++i) {
      const auto next = next_level(level_c, five[static_cast<std::size_t>(2 + side * (i - 1))], side);
      if (!next) return std::nullopt;
      five[static_cast<std::size_t>(2 + side * i)] = *next;
    }
  }
  return five;
}

/// Weights of three levels in their second divided difference, which is a mean of f″ between the outer two.
Eigen::RowVectorXd curvature_weights(const Levels& levels, Eigen::Index a, Eigen::Index b, Eigen::Index c) {
  Eigen::RowVectorXd weights = Eigen::RowVectorXd::Zero(levels.value.size());
  const auto weight = [&](Eigen::Index i, Eigen::Index j, Eigen::Index k) {
    weights(i) = 1.0 / ((levels.at_c(i) - levels.at_c(j)) * (levels.at_c(i) - levels.at_c(k)));
  };
  weight(a, b, c);
  weight(b, a, c);
  weight(c, a, b);
  return weights;
}

/// Chance that scatter alone makes the curvature turn and turn back within the five levels: that about the middle has
/// one sign, those beside it the other. However steep a curve is, a kink or a step has one turn there at most. All
/// three signs have to be sure, so that the largest of their chances is that of the three [Berger 1982].
double chance_of_turns(const Levels& levels, const Five& five) {
  std::array<Eigen::RowVectorXd, 3> weights;
  for (std::size_t i = 0; i < 3; ++i) weights.at(i) = curvature_weights(levels, five[i], five[i + 1], five[i + 2]);
  const double turn = weights[1] * levels.value > 0.0 ? 1.0 : -1.0;
  double chance = 0.0;
  for (std::size_t i = 0; i < 3; ++i) {
    const double value = (i == 1 ? turn : -turn) * weights.at(i).dot(levels.value);
    const double variance = weights.at(i) * levels.covariance * weights.at(i).transpose();
    if (value <= 0.0) return 1.0;
    if (variance > 0.0) chance = std::max(chance, 0.5 * base::f_upper_tail(value * value / variance, 1.0, levels.dof));
  }
  return chance;
}

/// Shapes of height 1 over the levels, one per column: the first `bumps` are bumps about one level.
struct Shapes {
  Eigen::MatrixXd columns;
  std::size_t bumps = 0;
};

/// Bumps 1/(1 + ((T − T₀)/w)²) about the middle of the five, and what may be taken for one: kinks max(0, T − T₀) and
/// steps tanh((T − T₀)/w) within the five. Widths and distances are shares of that of the levels.
Shapes shapes_about(const Levels& levels, const Five& five) {
  const double distance_c = 0.5 * (levels.at_c(five[3]) - levels.at_c(five[1]));
  std::vector<Eigen::ArrayXd> columns;
  const Eigen::ArrayXd temp_c = Eigen::Map<const Eigen::ArrayXd>(levels.temp_c.data(), levels.value.size());
  for (const double off : {-0.4, -0.2, 0.0, 0.2, 0.4}) {
    for (const double width : {0.3, 0.5, 0.8}) {
      const double centre_c = levels.at_c(five[2]) + off * distance_c;
      columns.emplace_back(1.0 / (1.0 + ((temp_c - centre_c) / (width * distance_c)).square()));
    }
  }
  Shapes shapes;
  shapes.bumps = columns.size();
  for (double centre_c = levels.at_c(five[0]); centre_c <= levels.at_c(five[4]); centre_c += 0.25 * distance_c) {
    columns.emplace_back((temp_c - centre_c).max(0.0));
    for (const double width : {0.1, 0.5, 1.0, 2.0}) {
      columns.emplace_back(((temp_c - centre_c) / (width * distance_c)).tanh());
    }
  }
  shapes.columns.resize(levels.value.size(), static_cast<Eigen::Index>(columns.size()));
  for (std::size_t c = 0; c < columns.size(); ++c) shapes.columns.col(static_cast<Eigen::Index>(c)) = columns[c];
  return shapes;
}

/// What one sensor's curve says of a bump at one level.
struct BumpTest {
  double chance = 1.0;  ///< that it is none
  double height = 0.0;
  bool undecided = false;  ///< something sticks out, but a kink or a step explains it as well
};

/// `gate`: chance from which a bump is named.
BumpTest test_bump(const Levels& levels, const SmoothCurve& curve, const Five& five, double gate) {
  BumpTest result;
  const double turns = chance_of_turns(levels, five);
  if (turns > kSensorGate) return result;
  const Shapes shapes = shapes_about(levels, five);
  const std::vector<FeatureFit> fits = curve.with_each(shapes.columns);
  const auto likelier = [](const FeatureFit& a, const FeatureFit& b) { return a.log_likelihood < b.log_likelihood; };
  const auto first_rival = fits.begin() + static_cast<std::ptrdiff_t>(shapes.bumps);
  const FeatureFit& best = *std::max_element(fits.begin(), first_rival, likelier);
  const FeatureFit& rival = *std::max_element(first_rival, fits.end(), likelier);
  // Line, height and the two numbers of the scale were taken from the levels.
  const double dof = static_cast<double>(levels.value.size()) - 5.0;
  const double chance = std::max(turns, base::f_upper_tail(best.squared_ratio, 1.0, dof));
  if (best.log_likelihood - rival.log_likelihood >= std::log(kOdds)) {
    result.chance = chance;
    result.height = best.height;
  } else {
    result.undecided = chance <= gate;
  }
  return result;
}

/// One sensor's levels and what a smooth curve through them knows.
struct SensorCurve {
  Sensor sensor;
  Levels levels;
  SmoothCurve smooth;
};

std::vector<SensorCurve> curves_of(const CampaignModel& model) {
  const std::vector<double>& level_c = model.circumstances().observations.level_c;
  const auto count = static_cast<Eigen::Index>(level_c.size());
  std::vector<SensorCurve> curves;
  for (const Sensor sensor : kSensors) {
    const auto& residual = model.residuals().sensor[index_of(sensor)];
    if (!residual) continue;
    const Eigen::MatrixXd factor = residual->coefficient_factor().topRows(count);
    const Levels levels{level_c, residual->coefficients().head(count), factor * factor.transpose(),
                        scatter_dof(model.residuals().noise[index_of(sensor)])};
    curves.push_back({sensor, levels, SmoothCurve(level_c, levels.value, levels.covariance)});
  }
  return curves;
}

/// Takes the sets of sensors at one place into `found` where their chance together is less.
void pool_sensors(const std::array<BumpTest, kSensorCount>& test, const std::vector<std::vector<Sensor>>& sets,
                  double tests, const std::string& place, NamedEffect& found) {
  for (const auto& set : sets) {
    std::vector<double> chances;
    for (const Sensor sensor : set) chances.push_back(test[index_of(sensor)].chance);
    const double p = std::min(1.0, chance_together(chances) * tests);
    if (p >= found.p_adjusted) continue;
    found.p_adjusted = p;
    found.sensors.clear();
    const auto least = static_cast<std::size_t>(std::min_element(chances.begin(), chances.end()) - chances.begin());
    for (std::size_t i = 0; i < set.size(); ++i) {
      if (chances[i] <= kSensorGate || i == least) found.sensors.push_back(set[i]);
    }
    const Sensor strongest = set[least];
    found.candidate.shape = place;
    found.magnitude = {test[index_of(strongest)].height * printed_per_si(strongest),
                       std::string(printed_unit(strongest))};
  }
}

NotTestable too_few_plateaus(std::size_t levels, std::size_t places) {
  return {
      "narrow_bump",
      fmt::format("of {} plateaus {} have two neighbours on either side within {} K of each other: the others do not "
                  "say how smooth the curve is there, and a feature of one is taken for the curve's own. Record "
                  "twelve or more, 5 K apart about it",
                  levels, places, kResolved_c)};
}

}  // namespace

OutsideTheMean look_for_bump(const CampaignModel& model) {
  OutsideTheMean result;
  const std::vector<double>& level_c = model.circumstances().observations.level_c;
  std::vector<Five> places;
  for (Eigen::Index k = 0; k < static_cast<Eigen::Index>(level_c.size()); ++k) {
    if (const auto five = five_about(level_c, k)) places.push_back(*five);
  }
  if (level_c.size() < kLeastBumpLevels || places.empty()) {
    result.not_testable.push_back(too_few_plateaus(level_c.size(), places.size()));
    return result;
  }
  const std::vector<SensorCurve> curves = curves_of(model);
  std::vector<Sensor> sensors;
  for (const SensorCurve& curve : curves) sensors.push_back(curve.sensor);
  const auto sets = sensor_sets(sensors);
  const auto tests = static_cast<double>(sets.size() * places.size());
  NamedEffect found;
  found.effect = &bump();
  std::string undecided;
  for (const Five& five : places) {
    const std::string place = fmt::format("at {:.1f} degC", level_c[static_cast<std::size_t>(five[2])]);
    std::array<BumpTest, kSensorCount> test;
    for (const SensorCurve& curve : curves) {
      BumpTest& own = test[index_of(curve.sensor)];
      own = test_bump(curve.levels, curve.smooth, five, kOutsideMeanGate / tests);
      if (own.undecided)
        undecided += fmt::format("{}{} {}", undecided.empty() ? "" : ", ", name_of(curve.sensor), place);
    }
    pool_sensors(test, sets, tests, place, found);
  }
  if (found.p_adjusted <= kOutsideMeanGate) result.effects.push_back(std::move(found));
  if (!undecided.empty()) {
    result.not_testable.push_back(
        {"narrow_bump", fmt::format("the curve turns sharply in {}: a kink or a step reads the same at these plateaus, "
                                    "and some more every 2 K about it would tell",
                                    undecided)});
  }
  return result;
}

}  // namespace soak::calib::gap
