// SPDX-License-Identifier: Apache-2.0
#include "calib/judge/detail/subsampling.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "anfis/model/rule_base.h"
#include "anfis/select/structure_search.h"
#include "anfis/train/learner.h"
#include "base/random.h"
#include "calib/curve/baselines.h"

namespace soak::calib {
namespace {

// ---- one part ----

constexpr int kSpareTemperatures = 2;  ///< as in fit/families.cpp
constexpr int kFewestPartRules = 2;

/// As curves are learned (fit/families.cpp), but for the last digits: parts scatter by far more.
anfis::VariableProjectionOptions learner() {
  anfis::VariableProjectionOptions options;
  options.smoothness = 1e-7;
  options.evaluations = 40;
  options.min_rmse_change = 1e-4;
  return options;
}

base::Result<PartCurve> fit_anfis(const anfis::TrainingData& rows, int rules, anfis::Shape shape) {
  anfis::RuleBaseOptions options;
  options.memberships = {rules};
  options.shape = shape;
  const auto initial = anfis::grid_rules(rows, options);
  if (!initial) return base::forward_error(initial);
  const auto trained = anfis::train_variable_projection(*initial, rows, learner());
  if (!trained) return base::forward_error(trained);
  return PartCurve{trained->model, static_cast<double>(rules)};
}

base::Result<PartCurve> as_part(base::Result<FittedCurve> fit) {
  if (!fit) return base::forward_error(fit);
  return PartCurve{std::move(fit->curve), std::max(1.0, fit->parameters - 1.0)};
}

// ---- many parts ----

/// Choices of runs.
constexpr int kDraws = 12;

/// Draws sets of runs such that each run is drawn about equally often: stretches of one shuffled order after the other.
class RunDraws {
 public:
  RunDraws(int runs, int size, std::uint64_t seed)
      : order_(static_cast<std::size_t>(runs)), size_(size), random_(seed, static_cast<std::uint64_t>(size)) {
    std::iota(order_.begin(), order_.end(), 0);
  }

  /// Flags of the runs drawn.
  std::vector<bool> next() {
    std::vector<bool> drawn(order_.size());
    for (int i = 0; i < size_; ++i) {
      if (at_ == 0) shuffle(drawn);
      drawn[static_cast<std::size_t>(order_[at_])] = true;
      at_ = (at_ + 1) % order_.size();
    }
    return drawn;
  }

 private:
  /// A random order whose first runs are not among those that the current draw has already.
  void shuffle(const std::vector<bool>& drawn) {
    for (std::size_t i = order_.size(); i > 1; --i) {
      std::swap(order_[i - 1], order_[random_.next() % i]);
    }
    std::ranges::stable_partition(order_, [&](int run) { return !drawn[static_cast<std::size_t>(run)]; });
  }

  std::vector<int> order_;
  int size_;
  base::Random random_;
  std::size_t at_ = 0;
};

/// Sums of products of the errors of pairs of held-out runs.
class PairSums {
 public:
  explicit PairSums(std::size_t runs) : runs_(runs), sum_(runs * runs), count_(runs * runs) {}

  void add(std::size_t a, std::size_t b, double mean_product) {
    sum_[a * runs_ + b] += mean_product;
    count_[a * runs_ + b] += 1.0;
  }

  /// Mean over pairs without the run `left_out` (none: runs()); nothing without pairs.
  [[nodiscard]] std::optional<double> mean_without(std::size_t left_out) const {
    double sum = 0.0;
    double count = 0.0;
    for (std::size_t i = 0; i < sum_.size(); ++i) {
      if (i / runs_ == left_out || i % runs_ == left_out) continue;
      sum += sum_[i];
      count += count_[i];
    }
    return count > 0.0 ? std::optional(sum / count) : std::nullopt;
  }

  /// Variance of the mean by leaving out one run after the other: (n − 1) / n · Σ (θ_(j) − mean θ_(j))².
  [[nodiscard]] double jackknife_variance() const {
    std::vector<double> means;
    for (std::size_t run = 0; run < runs_; ++run) {
      if (const auto mean = mean_without(run)) means.push_back(*mean);
    }
    const double n = static_cast<double>(means.size());
    const double middle = std::accumulate(means.begin(), means.end(), 0.0) / n;
    double squares = 0.0;
    for (const double mean : means) squares += (mean - middle) * (mean - middle);
    return (n - 1.0) / n * squares;
  }

  [[nodiscard]] std::size_t runs() const { return runs_; }

 private:
  std::size_t runs_;
  std::vector<double> sum_;
  std::vector<double> count_;
};

/// Errors of one held-out run, its own mean removed: place and error, in order of places.
using RunErrors = std::vector<std::pair<int, double>>;

std::vector<RunErrors> errors_by_run(const PlacedRows& rows, const Curve& curve, const std::vector<bool>& trained) {
  std::vector<double> temps_c;
  for (const CurveRow& row : rows.data.rows) temps_c.push_back(row.temp_c);
  std::vector<double> values(temps_c.size());
  evaluate(curve, temps_c, values);
  std::vector<RunErrors> errors(trained.size());
  for (std::size_t i = 0; i < values.size(); ++i) {
    const auto run = static_cast<std::size_t>(rows.data.rows[i].run);
    if (!trained[run]) errors[run].emplace_back(rows.place[i], rows.data.rows[i].value - values[i]);
  }
  for (RunErrors& run : errors) {
    double mean = 0.0;
    for (const auto& [place, error] : run) mean += error / static_cast<double>(run.size());
    for (auto& [place, error] : run) error -= mean;
    std::ranges::sort(run);
  }
  return errors;
}

/// Mean over the places that both runs visited of the product of their errors; nothing without such places.
std::optional<double> mean_product(const RunErrors& a, const RunErrors& b) {
  double sum = 0.0;
  double count = 0.0;
  for (auto i = a.begin(), j = b.begin(); i != a.end() && j != b.end();) {
    if (i->first == j->first) {
      sum += i->second * j->second;
      count += 1.0;
    }
    const bool first_behind = i->first <= j->first;
    const bool second_behind = j->first <= i->first;
    if (first_behind) ++i;
    if (second_behind) ++j;
  }
  return count > 0.0 ? std::optional(sum / count) : std::nullopt;
}

/// What the draws add up to.
struct Totals {
  explicit Totals(std::size_t runs) : pairs(runs) {}

  PairSums pairs;
  std::vector<double> draws;  ///< mean product of each draw
  double squares = 0.0;       ///< of single held-out rows
  double rows = 0.0;
  double parameters = 0.0;  ///< of the shape, over draws

  void add(const std::vector<RunErrors>& errors) {
    double sum = 0.0;
    double count = 0.0;
    for (std::size_t a = 0; a < errors.size(); ++a) {
      for (const auto& [place, error] : errors[a]) squares += error * error;
      rows += static_cast<double>(errors[a].size());
      for (std::size_t b = a + 1; b < errors.size(); ++b) {
        const auto product = mean_product(errors[a], errors[b]);
        if (!product) continue;
        pairs.add(a, b, *product);
        sum += *product;
        count += 1.0;
      }
    }
    if (count > 0.0) draws.push_back(sum / count);
  }
};

anfis::TrainingData part_of(const PlacedRows& rows, const std::vector<bool>& keep, const std::vector<bool>& trained,
                            int runs) {
  std::vector<bool> used(keep);
  for (std::size_t i = 0; i < used.size(); ++i) {
    used[i] = keep[i] && trained[static_cast<std::size_t>(rows.data.rows[i].run)];
  }
  anfis::TrainingData part = training_data(rows.data, rows.components, used);
  if (runs < 2) {
    part.group.clear();
    part.group_variance = 0.0;
  }
  return part;
}

/// Variance of the mean squared error that comes from which runs the fits were given. Two bounds, of which the lesser
/// counts:
/// - all the error is noise in ν parameters, χ² with ν degrees of freedom, of as many fits as there are independent
///   ones: 2 θ² / (ν · fits);
/// - the scatter s² of the draws, which share runs [Nadeau & Bengio 2003, with the roles of the two parts exchanged as
///   the fits are what varies]: s² (1 / draws + used / left over).
double variance_of_fits(const Totals& totals, double mean, int runs) {
  const double all = static_cast<double>(totals.pairs.runs());
  const double draws = static_cast<double>(totals.draws.size());
  const double as_noise = 2.0 * mean * mean / (totals.parameters * std::min<double>(kDraws, all - 1.0));
  const double middle = std::accumulate(totals.draws.begin(), totals.draws.end(), 0.0) / draws;
  double squares = 0.0;
  for (const double draw : totals.draws) squares += (draw - middle) * (draw - middle);
  return std::min(as_noise, squares / (draws - 1.0) * (1.0 / draws + runs / (all - runs)));
}

/// floor + per_run / runs.
struct Trend {
  double floor = 0.0;
  double per_run = 0.0;
};

Trend fit_trend(const std::vector<TrendPoint>& points) {
  double w = 0.0;
  double wx = 0.0;
  double wy = 0.0;
  double wxx = 0.0;
  double wxy = 0.0;
  for (const TrendPoint& point : points) {
    const double weight = 1.0 / std::max(1e-300, point.error.standard_error * point.error.standard_error);
    const double x = 1.0 / point.runs;
    w += weight;
    wx += weight * x;
    wy += weight * point.error.value;
    wxx += weight * x * x;
    wxy += weight * x * point.error.value;
  }
  const double determinant = w * wxx - wx * wx;
  const double slope = points.size() > 1 ? (w * wxy - wx * wy) / determinant : 0.0;
  const double floor = (wy - slope * wx) / w;
  if (slope < 0.0) return {std::max(0.0, wy / w), 0.0};
  if (floor < 0.0) return {0.0, std::max(0.0, wxy / wxx)};
  return {floor, slope};
}

}  // namespace

PartStructure structure_of(const CurveFit& fit) {
  const bool bell = fit.membership != anfis::name(anfis::Shape::gaussian);
  return {fit.deployed, fit.rules, bell ? anfis::Shape::bell : anfis::Shape::gaussian};
}

base::Result<PartCurve> fit_part(const anfis::TrainingData& rows, const PartStructure& structure) {
  if (structure.family == Family::anfis) {
    const int rules = std::min(structure.rules, (anfis::resolved_values(rows) - kSpareTemperatures) / 2);
    if (rules >= kFewestPartRules) return fit_anfis(rows, rules, structure.shape);
  } else if (structure.family != Family::spline) {
    auto fit = as_part(fit_polynomial(rows, structure.family == Family::poly3 ? 3 : 5));
    if (fit) return fit;
  }
  return as_part(fit_smoothing_spline(rows));
}

std::optional<SquaredError> subsampled_error(const PlacedRows& rows, const std::vector<bool>& keep, int runs,
                                             std::uint64_t seed) {
  const std::size_t all = rows.data.runs.size();
  if (static_cast<std::size_t>(runs) + 2 > all) return std::nullopt;
  RunDraws draws(static_cast<int>(all), runs, seed);
  Totals totals(all);
  for (int draw = 0; draw < kDraws; ++draw) {
    const std::vector<bool> trained = draws.next();
    const auto fit = fit_part(part_of(rows, keep, trained, runs), rows.structure);
    if (!fit) return std::nullopt;
    totals.add(errors_by_run(rows, fit->curve, trained));
    totals.parameters += fit->parameters / kDraws;
  }
  const auto mean = totals.pairs.mean_without(all);
  if (!mean) return std::nullopt;
  const double variance = totals.pairs.jackknife_variance() + variance_of_fits(totals, *mean, runs);
  return SquaredError{*mean, std::sqrt(variance), std::max(0.0, totals.squares / totals.rows - *mean)};
}

std::optional<SquaredError> extrapolated_error(const std::vector<TrendPoint>& points, int runs) {
  if (points.empty()) return std::nullopt;
  const Trend trend = fit_trend(points);
  SquaredError error = points.back().error;
  error.value = trend.floor + trend.per_run / runs;
  return error;
}

}  // namespace soak::calib
