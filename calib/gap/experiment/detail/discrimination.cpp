// SPDX-License-Identifier: Apache-2.0
#include "calib/gap/experiment/detail/discrimination.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "base/linear/dense_solve.h"
#include "calib/gap/base/base_curve.h"

namespace soak::calib::gap {
namespace {

LoggedCampaign with_planned(const LoggedCampaign& campaign, const std::vector<LoggedRun>& planned) {
  LoggedCampaign all = campaign;
  all.runs.insert(all.runs.end(), planned.begin(), planned.end());
  return all;
}

std::vector<double> temperatures_of(const Observations& observations, Sensor sensor) {
  std::vector<double> temp_c;
  for (const Observation& row : observations.rows) temp_c.push_back(row.sensor_temp_c[index_of(sensor)]);
  return temp_c;
}

/// What the model's coefficients say at the levels of the extended campaign, in the layout of base_design() up to the
/// scale errors. A level that the model does not have lies on its spline.
Eigen::VectorXd curve_at_levels(const Observations& known, const Observations& extended,
                                const Eigen::VectorXd& coefficients, bool with_scale) {
  const Eigen::Index count = extended.level_count();
  const Eigen::Index before = known.level_count();
  const LevelSpline spline(known.level_c);
  Eigen::VectorXd result = Eigen::VectorXd::Zero(with_scale ? 3 * count : 2 * count);
  for (Eigen::Index k = 0; k < count; ++k) {
    const Eigen::RowVectorXd weights = spline.weights(extended.level_c[static_cast<std::size_t>(k)]);
    result(k) = weights.dot(coefficients.head(before));
    if (count == before) result(count + k) = coefficients(before + k);
    if (with_scale) result(2 * count + k) = weights.dot(coefficients.segment(2 * before, before));
  }
  return result;
}

/// A level that is new has the slope of the nearest one that the model knows: no surer than that.
Eigen::VectorXd slope_prior(const Observations& known, const Observations& extended, const Eigen::VectorXd& levels) {
  constexpr double kLeast = 1e-12;
  const Eigen::VectorXd sigmas = slope_sigmas(known.level_c, levels);
  Eigen::VectorXd prior(extended.level_count());
  for (Eigen::Index k = 0; k < prior.size(); ++k) {
    const std::size_t same = nearest_level(known.level_c, extended.level_c[static_cast<std::size_t>(k)]);
    prior(k) = 1.0 / std::max(kLeast, sigmas(static_cast<Eigen::Index>(same)));
  }
  return prior;
}

/// Of columns scaled to unit length: below rounding of what they are made from, above that of the products.
constexpr double kRidge = 1e-10;
constexpr double kInvisible = 1e-6;  ///< share of a column's square that the base must leave
constexpr double kRounding = 1e-3;   ///< squared distances below that are none: 0.03 sigma
constexpr double kRelative = 1e-7;   ///< the same, of the prediction's square

const Candidate* same_shape(const std::vector<Candidate>& list, const Candidate& wanted) {
  const auto found =
      std::find_if(list.begin(), list.end(), [&](const Candidate& c) { return c.shape == wanted.shape; });
  return found == list.end() ? nullptr : &*found;
}

/// The effect's shapes on its grid, and the shape between them that was found, if it is none of those.
std::vector<Candidate> shapes_of(const RegressorInputs& in, const NamedEffect& effect) {
  std::vector<Candidate> list = effect.effect->candidates(in);
  if (same_shape(list, effect.candidate) != nullptr || !effect.effect->of_shape) return list;
  for (Candidate& candidate : effect.effect->of_shape(in, effect.candidate.shape_values.front())) {
    list.push_back(std::move(candidate));
  }
  return list;
}

/// What an effect predicts for a sensor with the parameters that were estimated for it, one row per observation.
Eigen::VectorXd prediction(const NamedEffect& effect, const Candidate& candidate, Sensor sensor, Eigen::Index rows) {
  const std::size_t s = index_of(sensor);
  const bool acts = std::find(effect.sensors.begin(), effect.sensors.end(), sensor) != effect.sensors.end();
  if (!acts || candidate.columns[s].cols() != effect.parameters[s].size()) return Eigen::VectorXd::Zero(rows);
  return candidate.columns[s] * effect.parameters[s];
}

Eigen::MatrixXd beside(const Eigen::MatrixXd& left, const Eigen::MatrixXd& right) {
  if (right.size() == 0) return left;
  if (left.size() == 0) return right;
  Eigen::MatrixXd both(left.rows(), left.cols() + right.cols());
  both << left, right;
  return both;
}

/// Columns that base and terms beside it have for a sensor, not whitened.
Eigen::MatrixXd terms_of(const RegressorInputs& in, const std::vector<const NamedEffect*>& effects, Sensor sensor) {
  Eigen::MatrixXd columns;
  for (const NamedEffect* effect : effects) {
    const bool acts = std::find(effect->sensors.begin(), effect->sensors.end(), sensor) != effect->sensors.end();
    if (!acts) continue;
    const auto candidates = shapes_of(in, *effect);
    const Candidate* candidate = same_shape(candidates, effect->candidate);
    if (candidate != nullptr) columns = beside(columns, candidate->columns[index_of(sensor)]);
  }
  return columns;
}

/// Squared part of column `v` that the columns [first, first + count) leave; `products`: with the base taken off.
/// `norm`: squares of the columns before that.
double left_of(const Eigen::MatrixXd& products, const Eigen::VectorXd& norm, Eigen::Index v, Eigen::Index first,
               Eigen::Index count) {
  Eigen::VectorXd scale = Eigen::VectorXd::Zero(count);
  for (Eigen::Index k = 0; k < count; ++k) {
    if (norm(first + k) > 0.0) scale(k) = 1.0 / std::sqrt(norm(first + k));
  }
  const Eigen::MatrixXd inner = scale.asDiagonal() * products.block(first, first, count, count) * scale.asDiagonal();
  const Eigen::VectorXd with = scale.asDiagonal() * products.col(v).segment(first, count);
  const base::SymmetricEigen eigen = base::symmetric_eigen(inner);
  double left = products(v, v);
  for (Eigen::Index k = 0; k < count; ++k) {
    if (eigen.values(k) <= kInvisible) continue;
    const double along = eigen.vectors.col(k).dot(with);
    left -= along * along / eigen.values(k);
  }
  return std::max(0.0, left);
}

}  // namespace

ExtendedCampaign::ExtendedCampaign(const LoggedCampaign& campaign, const std::vector<LoggedRun>& planned,
                                   const CampaignModel& model)
    : campaign_(with_planned(campaign, planned)),
      observations_(observe(campaign_)),
      history_(campaign_, observations_),
      whitening_(kSensorCount) {
  const std::size_t made = campaign.runs.size();
  for (const Observation& row : observations_.rows) {
    const std::size_t number = observations_.logged[static_cast<std::size_t>(row.run)];
    proposed_run_.push_back(number < made ? -1 : static_cast<int>(number - made));
  }
  const Observations& known = model.regressor_inputs().observations;
  const std::vector<bool> keep(observations_.rows.size(), true);
  for (const Sensor sensor : kSensors) {
    const std::size_t s = index_of(sensor);
    const auto& residual = model.residuals().sensor[s];
    if (!residual) continue;
    const std::vector<double> temp_c = temperatures_of(observations_, sensor);
    const bool scale = !is_gyro(sensor) && observations_.has_positions();
    const Eigen::VectorXd curve = curve_at_levels(known, observations_, residual->coefficients(), scale);
    BaseDesign design = base_design(observations_, sensor, temp_c);
    prior_[s] = Eigen::VectorXd::Zero(design.columns.cols());
    prior_[s].segment(design.levels, design.levels) =
        slope_prior(known, observations_, residual->coefficients().head(known.level_count()));
    base_[s] = std::move(design.columns);
    slope_[s] = base_slope(observations_, sensor, temp_c, curve);
    whitening_[s].emplace(observations_, sensor, model.residuals().noise[s], keep);
  }
}

Eigen::MatrixXd ExtendedCampaign::whiten(Sensor sensor, const Eigen::MatrixXd& columns) const {
  return whitening_[index_of(sensor)]->apply(columns);
}

const std::vector<Eigen::Index>& ExtendedCampaign::rows(Sensor sensor) const {
  return whitening_[index_of(sensor)]->rows();
}

Discrimination::Discrimination(const ExtendedCampaign& extended, const NamedEffect& one, const NamedEffect& other,
                               const std::vector<const NamedEffect*>& beside_both) {
  const RegressorInputs in = extended.regressor_inputs();
  const std::array<const NamedEffect*, 2> effects = {&one, &other};
  std::array<std::vector<Candidate>, 2> candidates;
  std::array<const Candidate*, 2> chosen{};
  Eigen::Index next = 0;
  for (std::size_t k = 0; k < 2; ++k) {
    candidates.at(k) = shapes_of(in, *effects.at(k));
    chosen.at(k) = same_shape(candidates.at(k), effects.at(k)->candidate);
    side_.at(k).shared = effects.at(k)->candidate.shared;
    for (const Candidate& candidate : candidates.at(k)) {
      Eigen::Index count = 0;
      for (const Eigen::MatrixXd& columns : candidate.columns) count = std::max(count, columns.cols());
      side_.at(k).shapes.push_back({next, count});
      next += count;
    }
    side_.at(k).prediction = next++;
  }
  const auto rows = static_cast<Eigen::Index>(in.observations.rows.size());
  for (const Sensor sensor : kSensors) {
    if (!extended.has(sensor) || chosen[0] == nullptr || chosen[1] == nullptr) continue;
    Eigen::MatrixXd columns = Eigen::MatrixXd::Zero(rows, next);
    for (std::size_t k = 0; k < 2; ++k) {
      for (std::size_t shape = 0; shape < candidates.at(k).size(); ++shape) {
        const Eigen::MatrixXd& own = candidates.at(k)[shape].columns[index_of(sensor)];
        if (own.size() > 0) columns.middleCols(side_.at(k).shapes[shape].first, own.cols()) = own;
      }
      columns.col(side_.at(k).prediction) = prediction(*effects.at(k), *chosen.at(k), sensor, rows);
    }
    const bool predicted =
        columns.col(side_[0].prediction).squaredNorm() > 0.0 || columns.col(side_[1].prediction).squaredNorm() > 0.0;
    if (!predicted && !side_[0].shared && !side_[1].shared) continue;
    add(extended, sensor, terms_of(in, beside_both, sensor), columns);
  }
}

void Discrimination::add(const ExtendedCampaign& extended, Sensor sensor, const Eigen::MatrixXd& base,
                         const Eigen::MatrixXd& columns) {
  SensorProducts& products = sensor_.at(index_of(sensor));
  Eigen::MatrixXd white = extended.base(sensor);
  if (base.size() > 0) white = beside(white, extended.whiten(sensor, base));
  products.base = white.cols();
  products.prior = Eigen::VectorXd::Zero(products.base);
  products.prior.head(extended.prior(sensor).size()) = extended.prior(sensor);
  white = beside(white, extended.whiten(sensor, columns));
  const auto& rows = extended.rows(sensor);
  const auto& planned = extended.proposed_run();
  const int last = *std::max_element(planned.begin(), planned.end());
  products.of_run.assign(static_cast<std::size_t>(last) + 2, Eigen::MatrixXd());
  // The runs made are −1, and come first.
  const auto group_at = [&](std::size_t i) {
    const int group = planned[static_cast<std::size_t>(rows[i])] + 1;
    return static_cast<std::size_t>(group);
  };
  for (std::size_t first = 0; first < rows.size();) {
    std::size_t end = first + 1;
    while (end < rows.size() && group_at(end) == group_at(first)) ++end;
    const auto part = white.middleRows(static_cast<Eigen::Index>(first), static_cast<Eigen::Index>(end - first));
    products.of_run[group_at(first)] = part.transpose() * part;
    first = end;
  }
}

Discrimination::Products Discrimination::beside_the_base(const std::vector<int>& proposed_runs) const {
  Products result;
  for (std::size_t s = 0; s < kSensorCount; ++s) {
    const SensorProducts& products = sensor_.at(s);
    if (products.of_run.empty()) continue;
    Eigen::MatrixXd all = products.of_run.front();
    for (const int run : proposed_runs) all += products.of_run.at(static_cast<std::size_t>(run) + 1);
    const Eigen::Index base = products.base;
    const Eigen::Index rest = all.cols() - base;
    all.topLeftCorner(base, base).diagonal() += products.prior.cwiseAbs2();
    Eigen::VectorXd scale = all.diagonal().head(base).cwiseSqrt();
    for (double& x : scale) x = x > 0.0 ? 1.0 / x : 0.0;
    Eigen::MatrixXd inner = scale.asDiagonal() * all.topLeftCorner(base, base) * scale.asDiagonal();
    inner.diagonal().array() += kRidge;
    const Eigen::MatrixXd mixed = scale.asDiagonal() * all.topRightCorner(base, rest);
    // Bottom row: squares before the base was taken off.
    result.at(s).resize(rest + 1, rest);
    result.at(s).topRows(rest) = all.bottomRightCorner(rest, rest) - mixed.transpose() * base::solve_llt(inner, mixed);
    result.at(s).bottomRows(1) = all.diagonal().tail(rest).transpose();
  }
  return result;
}

double Discrimination::distance(const Products& products, const Side& from, const Side& to) {
  double least = std::numeric_limits<double>::infinity();
  for (const Shape& shape : to.shapes) {
    double sum = 0.0;
    Eigen::MatrixXd together;
    for (const Eigen::MatrixXd& own : products) {
      if (own.size() == 0) continue;
      if (to.shared) {
        together = together.size() == 0 ? own : Eigen::MatrixXd(together + own);
      } else {
        sum +=
            left_of(own.topRows(own.cols()), own.bottomRows(1).transpose(), from.prediction, shape.first, shape.count);
      }
    }
    if (together.size() > 0) {
      sum = left_of(together.topRows(together.cols()), together.bottomRows(1).transpose(), from.prediction, shape.first,
                    shape.count);
    }
    least = std::min(least, sum);
  }
  return least;
}

double Discrimination::gained(const std::vector<int>& proposed_runs) const {
  const Products before = beside_the_base({});
  const Products after = beside_the_base(proposed_runs);
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < 2; ++k) {
    const Side& from = side_.at(k);
    const Side& to = side_.at(1 - k);
    double whole = 0.0;
    for (const Eigen::MatrixXd& own : after) {
      if (own.size() > 0) whole += own(own.rows() - 1, from.prediction);
    }
    const double more = distance(after, from, to) - distance(before, from, to);
    least = std::min(least, more > kRounding + kRelative * whole ? more : 0.0);
  }
  return std::isfinite(least) ? least : 0.0;
}

ExperimentBatch::ExperimentBatch(const LoggedCampaign& campaign, const CampaignModel& model, const RunTemplate& source,
                                 std::vector<Action> actions)
    : actions_(std::move(actions)), extended_(campaign, plan(source), model) {}

std::vector<LoggedRun> ExperimentBatch::plan(const RunTemplate& source) {
  std::vector<LoggedRun> planned;
  for (const Action& action : actions_) {
    double hours = 0.0;
    runs_of_.emplace_back();
    for (const ProposedRun& run : action.runs) {
      runs_of_.back().push_back(static_cast<int>(planned.size()));
      planned.push_back(simulate(source, run, fmt::format("planned {}", planned.size() + 1)));
      hours += hours_of(planned.back());
    }
    hours_.push_back(hours);
  }
  return planned;
}

std::vector<double> ExperimentBatch::gained(const NamedEffect& one, const NamedEffect& other,
                                            const std::vector<const NamedEffect*>& beside) const {
  const Discrimination between(extended_, one, other, beside);
  std::vector<double> squares;
  for (const std::vector<int>& runs : runs_of_) squares.push_back(between.gained(runs));
  return squares;
}

}  // namespace soak::calib::gap
