// SPDX-License-Identifier: Apache-2.0
#include "calib/plan/sensor_picture.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "base/linear/dense_solve.h"
#include "calib/curve/baselines.h"
#include "calib/curve/curve_fit.h"
#include "calib/curve/families.h"

namespace soak::calib {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kSameTemperature_c = 0.5;
constexpr std::size_t kMostTemperatures = 200;

/// Rows of one temperature in one direction, each less the offset of its run.
struct RowSums {
  double count = 0.0;
  double temp_c = 0.0;    ///< sum
  double value = 0.0;     ///< sum
  double variance = 0.0;  ///< sum of the rows' own
  double residual = 0.0;  ///< sum, about the smooth curve
  double squares = 0.0;   ///< sum of the residuals' squares

  void add(const CurveRow& row, double offset, double smooth) {
    const double left = row.value - offset - smooth;
    count += 1.0;
    temp_c += row.temp_c;
    value += row.value - offset;
    variance += row.standard_error * row.standard_error;
    residual += left;
    squares += left * left;
  }
  /// Squares of the residuals about their own mean.
  [[nodiscard]] double squares_within() const { return count > 0.0 ? squares - residual * residual / count : 0.0; }

  [[nodiscard]] double mean() const { return value / count; }
  [[nodiscard]] double noise_variance() const { return variance / count; }
};

/// The rows of one temperature; those of one direction may be missing.
struct PlateauSums {
  RowSums up;
  RowSums down;

  [[nodiscard]] bool both() const { return up.count > 0.0 && down.count > 0.0; }
};

/// What the rows of one unit say.
struct UnitScatter {
  std::vector<PlateauSums> places;
  VarianceComponents components;
  double noise_variance = 0.0;  ///< mean over rows
  /// Variance of rows of the same temperature and direction beyond their noise; absent of one run.
  std::optional<double> visit_variance;
  double dwell_s = 0.0;
};

/// Points of a mean curve.
struct MeanCurve {
  VectorXd temp_c;
  VectorXd value;
  VectorXd variance;
};

/// Residual of each run about a smooth curve, on average.
std::map<int, double> offsets_of_runs(const CurveData& data, const Curve& curve) {
  std::map<int, std::pair<double, double>> sums;
  for (const CurveRow& row : data.rows) {
    auto& [count, sum] = sums[row.run];
    count += 1.0;
    sum += row.value - evaluate(curve, row.temp_c);
  }
  std::map<int, double> offsets;
  for (const auto& [run, sum] : sums) offsets[run] = sum.second / sum.first;
  return offsets;
}

std::size_t nearest(const std::vector<double>& temps_c, double temp_c) {
  const auto closer = [temp_c](double a, double b) { return std::abs(a - temp_c) < std::abs(b - temp_c); };
  return static_cast<std::size_t>(std::min_element(temps_c.begin(), temps_c.end(), closer) - temps_c.begin());
}

/// Repetitions tell a visit's scatter from hysteresis and from what the smooth curve does not follow.
std::optional<double> visit_variance_of(const UnitScatter& scatter, double rows, double runs) {
  double squares = 0.0;
  double freedoms = rows - (runs - 1.0);
  for (const PlateauSums& place : scatter.places) {
    for (const RowSums* sums : {&place.up, &place.down}) {
      squares += sums->squares_within();
      freedoms -= sums->count > 0.0 ? 1.0 : 0.0;
    }
  }
  if (freedoms < 1.0) return std::nullopt;
  return std::max(0.0, squares / freedoms - scatter.noise_variance);
}

/// Places of a unit's temperatures.
class Places {
 public:
  explicit Places(const CurveData& data) {
    std::vector<double> temps_c;
    for (const CurveRow& row : data.rows) temps_c.push_back(row.temp_c);
    middles_c_ = temperature_clusters(temps_c, kSameTemperature_c, kMostTemperatures);
  }
  [[nodiscard]] std::size_t count() const { return middles_c_.size(); }
  [[nodiscard]] std::size_t of(const CurveRow& row) const { return nearest(middles_c_, row.temp_c); }

 private:
  std::vector<double> middles_c_;
};

/// Runs that were at one place alone: whatever they read goes into their offset, so that they show neither curve nor
/// gap.
std::set<int> runs_of_one_place(const CurveData& data, const Places& places) {
  std::map<int, std::set<std::size_t>> visited;
  for (const CurveRow& row : data.rows) visited[row.run].insert(places.of(row));
  std::set<int> alone;
  for (const auto& [run, at] : visited) {
    if (at.size() == 1 && places.count() > 1) alone.insert(run);
  }
  return alone;
}

base::Result<FittedCurve> smooth_curve(const CurveData& data, const VarianceComponents& components) {
  anfis::TrainingData rows = training_data(data, components);
  if (count_runs(data) < 2) {
    rows.group.clear();
  } else {
    rows.group_variance = std::numeric_limits<double>::infinity();
  }
  return fit_smoothing_spline(rows);
}

/// A pass of `scatter_of`: components, and places about the smooth curve through `flat`, which are the rows of `data`
/// less what is known of the gap.
base::Result<UnitScatter> scatter_about(const CurveData& data, const CurveData& flat, const Places& places) {
  UnitScatter scatter;
  const auto components = estimate_variance_components(flat);
  if (!components) return base::forward_error(components);
  scatter.components = *components;
  const auto spline = smooth_curve(flat, *components);
  if (!spline) return base::forward_error(spline);
  const auto offsets = offsets_of_runs(flat, spline->curve);
  const std::set<int> alone = runs_of_one_place(data, places);
  scatter.places.resize(places.count());
  double rows = 0.0;
  for (const CurveRow& row : data.rows) {
    scatter.noise_variance += row.standard_error * row.standard_error / static_cast<double>(data.rows.size());
    if (alone.contains(row.run)) continue;
    PlateauSums& place = scatter.places[places.of(row)];
    RowSums& sums = row.sweep == Sweep::down ? place.down : place.up;
    sums.add(row, offsets.at(row.run), evaluate(spline->curve, row.temp_c));
    rows += 1.0;
  }
  scatter.visit_variance = visit_variance_of(scatter, rows, static_cast<double>(offsets.size() - alone.size()));
  return scatter;
}

/// The rows without half the gap of their place, which would pass for scatter of rows, and so hide that of power-ons.
CurveData without_gap(const CurveData& data, const std::vector<PlateauSums>& sums, const Places& places) {
  CurveData flat = data;
  for (CurveRow& row : flat.rows) {
    const PlateauSums& place = sums[places.of(row)];
    if (!place.both()) continue;
    const double half = 0.5 * (place.up.mean() - place.down.mean());
    row.value -= row.sweep == Sweep::down ? -half : half;
  }
  return flat;
}

base::Result<UnitScatter> scatter_of(const StoredCurve& unit) {
  const CurveData& data = unit.data;
  const Places places(data);
  const auto first = scatter_about(data, data, places);
  if (!first) return base::forward_error(first);
  auto scatter = scatter_about(data, without_gap(data, first->places, places), places);
  if (!scatter) return base::forward_error(scatter);
  scatter->dwell_s = unit.dwell_s;
  std::erase_if(scatter->places, [](const PlateauSums& place) { return place.up.count + place.down.count == 0.0; });
  return scatter;
}

/// Sum and number of squares that are pooled over units.
struct MeanSquare {
  double sum = 0.0;
  double count = 0.0;

  void add(double square) {
    sum += square;
    count += 1.0;
  }
  /// 0 where nothing was added, and where noise explains more than there is.
  [[nodiscard]] double mean() const { return count > 0.0 ? std::max(0.0, sum / count) : 0.0; }
};

/// Half the gaps between heating and cooling, squared, less what noise contributes to them.
void add_gaps(const UnitScatter& unit, MeanSquare& gaps) {
  for (const PlateauSums& place : unit.places) {
    if (!place.both()) continue;
    const double half = 0.5 * (place.up.mean() - place.down.mean());
    const double noise =
        0.25 * (place.up.noise_variance() / place.up.count + place.down.noise_variance() / place.down.count);
    gaps.add(half * half - noise);
  }
}

/// Where both directions are there the curve is their mean.
MeanCurve mean_curve(const UnitScatter& unit, double visit_variance) {
  const auto n = static_cast<Eigen::Index>(unit.places.size());
  MeanCurve curve{VectorXd(n), VectorXd(n), VectorXd(n)};
  for (Eigen::Index i = 0; i < n; ++i) {
    const PlateauSums& place = unit.places[static_cast<std::size_t>(i)];
    const auto variance_of = [&](const RowSums& sums) { return (sums.noise_variance() + visit_variance) / sums.count; };
    curve.temp_c[i] = (place.up.temp_c + place.down.temp_c) / (place.up.count + place.down.count);
    if (place.both()) {
      curve.value[i] = 0.5 * (place.up.mean() + place.down.mean());
      curve.variance[i] = 0.25 * (variance_of(place.up) + variance_of(place.down));
      continue;
    }
    const RowSums& sums = place.up.count > 0.0 ? place.up : place.down;
    curve.value[i] = sums.mean();
    curve.variance[i] = variance_of(sums);
  }
  return curve;
}

/// Logarithm of the marginal likelihood of a mean curve under the picture, up to a constant.
double log_evidence(const MeanCurve& curve, const SensorPicture& picture) {
  constexpr double kJitter = 1e-10;
  const double power = picture.scale * picture.scale;
  const Eigen::Index n = curve.value.size();
  MatrixXd covariance(n, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    for (Eigen::Index j = 0; j <= i; ++j) {
      covariance(i, j) = power * correlation(picture, curve.temp_c[i] - curve.temp_c[j]);
    }
    covariance(i, i) += curve.variance[i] + kJitter * power;
  }
  const auto lower = base::try_cholesky(covariance);
  if (!lower) return -std::numeric_limits<double>::infinity();
  const VectorXd ones = base::solve_lower(*lower, VectorXd(VectorXd::Ones(n)));
  const VectorXd values = base::solve_lower(*lower, curve.value);
  const double information = ones.squaredNorm();
  const double squares = values.squaredNorm() - std::pow(ones.dot(values), 2) / information;
  return -0.5 * (squares + std::log(information)) - lower->diagonal().array().log().sum();
}

/// Root mean square of the curves about their means.
double spread_of(const std::vector<MeanCurve>& curves) {
  MeanSquare squares;
  for (const MeanCurve& curve : curves) {
    const double mean = curve.value.mean();
    for (const double value : curve.value) squares.add((value - mean) * (value - mean));
  }
  return std::sqrt(squares.mean());
}

void learn_smoothness(const std::vector<MeanCurve>& curves, SensorPicture& picture) {
  constexpr double kStep = 1.25;
  constexpr double kShortest_c = 3.0;
  constexpr double kLongest_c = 200.0;
  constexpr double kSmallest = 0.125;  // of the spread of the curves
  constexpr double kLargest = 16.0;
  constexpr double kFlat = 1e-9;  // SI; of readings that do not move at all
  const double spread = std::max(spread_of(curves), kFlat);
  SensorPicture tried = picture;
  double best = -std::numeric_limits<double>::infinity();
  for (const Smoothness smoothness : {Smoothness::once, Smoothness::twice}) {
    tried.smoothness = smoothness;
    for (tried.length_c = kShortest_c; tried.length_c <= kLongest_c; tried.length_c *= kStep) {
      for (tried.scale = kSmallest * spread; tried.scale <= kLargest * spread; tried.scale *= kStep) {
        double evidence = 0.0;
        for (const MeanCurve& curve : curves) evidence += log_evidence(curve, tried);
        if (evidence <= best) continue;
        best = evidence;
        picture = tried;
      }
    }
  }
}

}  // namespace

double SensorPicture::visit_variance(double seconds) const {
  return visit * visit + noise * noise * std::max(1.0, dwell_s / seconds);
}

double correlation(const SensorPicture& picture, double apart_c) {
  // k(r) = (1 + √3 r/l) exp(−√3 r/l); (1 + √5 r/l + 5 r²/3l²) exp(−√5 r/l)
  const double order = picture.smoothness == Smoothness::once ? 3.0 : 5.0;
  const double r = std::sqrt(order) * std::abs(apart_c) / picture.length_c;
  const double polynomial = picture.smoothness == Smoothness::once ? 1.0 + r : 1.0 + r + r * r / 3.0;
  return polynomial * std::exp(-r);
}

base::Result<LearntPicture> learn_picture(std::span<const StoredCurve> units) {
  std::vector<UnitScatter> scatters;
  for (const StoredCurve& unit : units) {
    if (!unit.data.by_plateau || distinct_temperatures(unit.data) < kCurveTemperatures) continue;
    auto scatter = scatter_of(unit);
    if (!scatter) return base::forward_error(scatter);
    scatters.push_back(std::move(*scatter));
  }
  if (scatters.empty()) {
    return base::bad_input("no stored unit has runs at three plateaus or more, from which a curve could be learnt");
  }
  MeanSquare gaps;
  MeanSquare offsets;
  MeanSquare visits;
  MeanSquare noises;
  LearntPicture learnt;
  learnt.units = static_cast<int>(scatters.size());
  SensorPicture& picture = learnt.picture;
  picture.dwell_s = 0.0;
  for (const UnitScatter& unit : scatters) {
    add_gaps(unit, gaps);
    if (unit.components.run_to_run_sigma) offsets.add(std::pow(*unit.components.run_to_run_sigma, 2));
    visits.add(unit.visit_variance.value_or(std::pow(unit.components.lack_of_fit_sigma, 2)));
    noises.add(unit.noise_variance);
    picture.dwell_s += unit.dwell_s / static_cast<double>(scatters.size());
  }
  picture.half_gap = std::sqrt(gaps.mean());
  picture.run_to_run = std::sqrt(offsets.mean());
  picture.visit = std::sqrt(visits.mean());
  picture.noise = std::sqrt(noises.mean());
  learnt.half_gap_known = gaps.count > 0.0;
  learnt.run_to_run_known = offsets.count > 0.0;
  std::vector<MeanCurve> curves;
  for (const UnitScatter& unit : scatters) curves.push_back(mean_curve(unit, picture.visit * picture.visit));
  learn_smoothness(curves, picture);
  return learnt;
}

}  // namespace soak::calib
