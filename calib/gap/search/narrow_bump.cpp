// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

#include "base/statistics.h"
#include "calib/gap/base/smooth_curve.h"
#include "calib/gap/effects/columns.h"
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
/// Least correlation length of the rest of the curve over the distance of the levels: what is rougher is not resolved.
constexpr double kResolvedLength = 1.9;

const Effect& bump() {
  static const Effect effect = [] {
    Effect made;
    made.name = "narrow_bump";
    made.physics =
        "a feature of the curve at one temperature, narrower than the spacing of the plateaus: a resonance, a range "
        "that switches on and off again";
    made.experiment = "a grid of 2 K around it, up and down";
    made.lab_only = false;
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
  // Outwards from the middle, down to place 0 and up to place 4.
  constexpr std::array<std::array<std::size_t, 2>, 4> kFromTo = {{{2, 1}, {1, 0}, {2, 3}, {3, 4}}};
  for (const auto& [from, to] : kFromTo) {
    const auto next = next_level(level_c, five.at(from), to < from ? -1 : 1);
    if (!next) return std::nullopt;
    five.at(to) = *next;
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

/// Place and half width of a bump.
struct Place {
  double centre_c = 0.0;
  double width_c = 1.0;
};

/// A bump of height 1.
Eigen::ArrayXd shape_of(const Place& bump, const Eigen::ArrayXd& temp_c) {
  return 1.0 / (1.0 + ((temp_c - bump.centre_c) / bump.width_c).square());
}

/// Shapes of height 1 over the levels, one per column: the first are the bumps.
struct Shapes {
  Eigen::MatrixXd columns;
  std::vector<Place> bumps;
};

/// Bumps 1/(1 + ((T − T₀)/w)²) about the middle of the five, and what may be taken for one: kinks max(0, T − T₀) and
/// steps tanh((T − T₀)/w) within the five. Widths and distances are shares of that of the levels.
Shapes shapes_about(const Levels& levels, const Five& five) {
  const double distance_c = 0.5 * (levels.at_c(five[3]) - levels.at_c(five[1]));
  std::vector<Eigen::ArrayXd> columns;
  Shapes shapes;
  const Eigen::ArrayXd temp_c = Eigen::Map<const Eigen::ArrayXd>(levels.temp_c.data(), levels.value.size());
  for (const double off : {-0.4, -0.2, 0.0, 0.2, 0.4}) {
    for (const double width : {0.3, 0.5, 0.8}) {
      const Place& bump = shapes.bumps.emplace_back(levels.at_c(five[2]) + off * distance_c, width * distance_c);
      columns.emplace_back(shape_of(bump, temp_c));
    }
  }
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

/// The bump that a sensor has, where it has one.
struct BumpShape {
  double height = 0.0;
  Place place;
  /// Of height, centre and width: how far a smooth curve strays between its levels, and what they leave open of place
  /// and width.
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
};

/// Levels leave open how far beside one of them a bump is, and how wide: place and width are means over all that were
/// tried, weighted by their likelihood, and the height is that of these.
BumpShape mean_bump(const Levels& levels, const SmoothCurve& curve, const std::vector<Place>& tried,
                    const std::vector<FeatureFit>& fits, double most_likely) {
  BumpShape mean;
  mean.place = {0.0, 0.0};
  double total = 0.0;
  for (std::size_t i = 0; i < tried.size(); ++i) {
    const double weight = std::exp(fits[i].log_likelihood - most_likely);
    total += weight;
    mean.place.centre_c += (tried[i].centre_c - mean.place.centre_c) * weight / total;
    mean.place.width_c += (tried[i].width_c - mean.place.width_c) * weight / total;
  }
  const Eigen::ArrayXd temp_c = Eigen::Map<const Eigen::ArrayXd>(levels.temp_c.data(), levels.value.size());
  const FeatureFit own = curve.with_each(shape_of(mean.place, temp_c)).front();
  mean.height = own.height;
  mean.covariance(0, 0) = own.squared_ratio > 0.0 ? own.height * own.height / own.squared_ratio : 0.0;
  for (std::size_t i = 0; i < tried.size(); ++i) {
    const double weight = std::exp(fits[i].log_likelihood - most_likely) / total;
    const Eigen::Vector3d off(fits[i].height - mean.height, tried[i].centre_c - mean.place.centre_c,
                              tried[i].width_c - mean.place.width_c);
    mean.covariance += weight * off * off.transpose();
  }
  return mean;
}

/// What one sensor's curve says of a bump at one level.
struct BumpTest {
  double chance = 1.0;  ///< that it is none
  BumpShape bump;
  double turns = 1.0;  ///< chance that the curve does not turn sharply there, whatever does that
};

BumpTest test_bump(const Levels& levels, const SmoothCurve& curve, const Five& five) {
  BumpTest result;
  result.turns = chance_of_turns(levels, five);
  if (result.turns > kSensorGate) return result;
  const Shapes shapes = shapes_about(levels, five);
  const std::vector<FeatureFit> fits = curve.with_each(shapes.columns);
  const auto likelier = [](const FeatureFit& a, const FeatureFit& b) { return a.log_likelihood < b.log_likelihood; };
  const auto first_rival = fits.begin() + static_cast<std::ptrdiff_t>(shapes.bumps.size());
  const FeatureFit& best = *std::max_element(fits.begin(), first_rival, likelier);
  const FeatureFit& rival = *std::max_element(first_rival, fits.end(), likelier);
  const double distance_c = 0.5 * (levels.at_c(five[3]) - levels.at_c(five[1]));
  if (!(best.log_likelihood - rival.log_likelihood >= std::log(kOdds))) return result;
  if (best.length_c < kResolvedLength * distance_c) return result;
  // Line, height and the two numbers of the scale were taken from the levels.
  const double dof = static_cast<double>(levels.value.size()) - 5.0;
  result.chance = std::max(result.turns, base::f_upper_tail(best.squared_ratio, 1.0, dof));
  result.bump = mean_bump(levels, curve, shapes.bumps, fits, best.log_likelihood);
  return result;
}

/// One sensor's levels and what a smooth curve through them knows.
struct SensorCurve {
  Sensor sensor;
  Levels levels;
  SmoothCurve smooth;
};

std::vector<SensorCurve> curves_of(const CampaignModel& model) {
  const std::vector<double>& level_c = model.regressor_inputs().observations.level_c;
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

/// The best set of sensors at one place.
struct PlacedBump {
  std::size_t place = 0;
  double p = 1.0;  ///< adjusted
  std::vector<Sensor> sensors;
  Sensor strongest = Sensor::gyro_x;
  std::array<BumpTest, kSensorCount> test = {};
};

/// Takes the sets of sensors at one place into `found` where their chance together is less.
void pool_sensors(const std::array<BumpTest, kSensorCount>& test, const std::vector<std::vector<Sensor>>& sets,
                  double tests, std::size_t place, PlacedBump& found) {
  for (const auto& set : sets) {
    std::vector<double> chances;
    for (const Sensor sensor : set) chances.push_back(test[index_of(sensor)].chance);
    const double p = std::min(1.0, chance_together(chances) * tests);
    if (p >= found.p) continue;
    const auto least = static_cast<std::size_t>(std::min_element(chances.begin(), chances.end()) - chances.begin());
    found = {place, p, {}, set[least], test};
    for (std::size_t i = 0; i < set.size(); ++i) {
      if (chances[i] <= kSensorGate || i == least) found.sensors.push_back(set[i]);
    }
  }
}

/// Where a sensor's curve turns sharply.
struct SharpTurn {
  std::size_t place;
  Sensor sensor;
};

std::string place_text(const std::vector<double>& level_c, const Five& five) {
  return fmt::format("at {:.1f} degC", level_c[static_cast<std::size_t>(five[2])]);
}

/// Whether the five levels of one place hold the middle of the other.
bool overlap(const Five& one, const Five& other) { return other[2] >= one[0] && other[2] <= one[4]; }

NotTestable turns_without_name(const std::vector<double>& level_c, const std::vector<Five>& places,
                               const std::vector<SharpTurn>& turns) {
  constexpr std::size_t kShown = 3;
  std::string list;
  for (std::size_t i = 0; i < std::min(kShown, turns.size()); ++i) {
    list += fmt::format("{}{} {}", i == 0 ? "" : ", ", name_of(turns[i].sensor),
                        place_text(level_c, places[turns[i].place]));
  }
  if (turns.size() > kShown) list += fmt::format(" and {} more", turns.size() - kShown);
  return {"narrow_bump", fmt::format("curves turn sharply ({}): at these plateaus a kink, a step or a rough curve "
                                     "looks the same as a bump; more plateaus, 2 K apart around it, would decide",
                                     list)};
}

NotTestable too_few_plateaus(std::size_t levels, std::size_t places) {
  return {"narrow_bump", fmt::format("of {} plateaus only {} have two neighbours on either side within {} K of each "
                                     "other: at the others nothing shows how smooth the curve is, and a feature at one "
                                     "plateau counts as part of the curve. Record twelve or more, 5 K apart",
                                     levels, places, kResolved_c)};
}

NamedEffect named_bump(const PlacedBump& found, std::string shape) {
  NamedEffect named;
  named.effect = &bump();
  named.p_adjusted = found.p;
  named.sensors = found.sensors;
  named.candidate.shape = std::move(shape);
  for (const Sensor sensor : found.sensors) {
    const std::size_t s = index_of(sensor);
    const BumpShape& own = found.test[s].bump;
    named.parameters[s] = Eigen::Vector3d(own.height, own.place.centre_c, own.place.width_c);
    named.covariance[s] = own.covariance;
    named.meaning[s] = {{{"height", si_unit(sensor)}, {"centre_c", "degC"}, {"width_c", "K"}}, {}};
  }
  const double height = found.test[index_of(found.strongest)].bump.height;
  named.magnitude = {height * printed_per_si(found.strongest), std::string(printed_unit(found.strongest))};
  return named;
}

}  // namespace

OutsideTheMean look_for_bump(const CampaignModel& model) {
  OutsideTheMean result;
  const std::vector<double>& level_c = model.regressor_inputs().observations.level_c;
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
  PlacedBump found;
  std::vector<SharpTurn> turns;
  for (std::size_t place = 0; place < places.size(); ++place) {
    std::array<BumpTest, kSensorCount> test;
    for (const SensorCurve& curve : curves) {
      BumpTest& own = test[index_of(curve.sensor)];
      own = test_bump(curve.levels, curve.smooth, places[place]);
      if (own.turns * tests <= kOutsideMeanGate) turns.push_back({place, curve.sensor});
    }
    pool_sensors(test, sets, tests, place, found);
  }
  // A bump is one feature. Curves that turn in several places are rough, and none of these stands out.
  const bool alone = std::all_of(turns.begin(), turns.end(), [&](const SharpTurn& turn) {
    return overlap(places[found.place], places[turn.place]);
  });
  if (alone && found.p <= kOutsideMeanGate) {
    result.effects.push_back(named_bump(found, place_text(level_c, places[found.place])));
  } else if (!turns.empty()) {
    result.not_testable.push_back(turns_without_name(level_c, places, turns));
  }
  return result;
}

}  // namespace soak::calib::gap
