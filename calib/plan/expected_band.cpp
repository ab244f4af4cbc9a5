// SPDX-License-Identifier: Apache-2.0
#include "calib/plan/expected_band.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "base/linear/dense_solve.h"
#include "base/statistics.h"

namespace soak::calib {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kNormal95 = 1.959963984540054;

/// Temperature and direction of a row: +1 heating, -1 cooling, 0 where both branches of the loop meet.
struct VisitKind {
  double temp_c = 0.0;
  double sign = 0.0;

  auto operator<=>(const VisitKind&) const = default;
};

double sign_of(Sweep sweep) { return sweep == Sweep::up ? 1.0 : sweep == Sweep::down ? -1.0 : 0.0; }

/// The visits of a power-on; one at which the temperature turns is of no direction.
std::vector<VisitKind> kinds_of(const PlannedPowerOn& power_on) {
  std::vector<VisitKind> kinds;
  for (std::size_t i = 0; i < power_on.visits.size(); ++i) {
    const PlannedVisit& visit = power_on.visits[i];
    const double sign = sign_of(visit.sweep);
    const bool turns = i + 1 < power_on.visits.size() && sign * sign_of(power_on.visits[i + 1].sweep) < 0.0;
    kinds.push_back({visit.temp_c, turns ? 0.0 : sign});
  }
  return kinds;
}

std::vector<VisitKind> kinds_of(const CampaignDesign& design) {
  std::set<VisitKind> all;
  for (const PlannedPowerOn& power_on : design.power_ons) {
    const auto kinds = kinds_of(power_on);
    all.insert(kinds.begin(), kinds.end());
  }
  return {all.begin(), all.end()};
}

/// A: for one power-on diag(w) − w wᵀ σ²/(1 + σ² Σw), w the weights of its rows.
MatrixXd information(const CampaignDesign& design, const std::vector<VisitKind>& kinds, double row_variance,
                     double offset_variance) {
  const auto n = static_cast<Index>(kinds.size());
  MatrixXd sum = MatrixXd::Zero(n, n);
  for (const PlannedPowerOn& power_on : design.power_ons) {
    VectorXd weight = VectorXd::Zero(n);
    for (const VisitKind& kind : kinds_of(power_on)) {
      weight[std::lower_bound(kinds.begin(), kinds.end(), kind) - kinds.begin()] += 1.0 / row_variance;
    }
    const double shared = offset_variance / (1.0 + offset_variance * weight.sum());
    MatrixXd one = -shared * weight * weight.transpose();
    one.diagonal() += weight;
    sum += power_on.count * one;
  }
  return sum;
}

MatrixXd covariance(const SensorPicture& picture, std::span<const double> a_c, std::span<const double> b_c) {
  MatrixXd k(static_cast<Index>(a_c.size()), static_cast<Index>(b_c.size()));
  for (Index i = 0; i < k.rows(); ++i) {
    for (Index j = 0; j < k.cols(); ++j) {
      const double apart_c = a_c[static_cast<std::size_t>(i)] - b_c[static_cast<std::size_t>(j)];
      k(i, j) = picture.scale * picture.scale * correlation(picture, apart_c);
    }
  }
  return k;
}

/// Temperatures of the kinds, each once.
std::vector<double> temperatures_of(const std::vector<VisitKind>& kinds) {
  std::vector<double> temps_c;
  for (const VisitKind& kind : kinds) {
    if (temps_c.empty() || temps_c.back() != kind.temp_c) temps_c.push_back(kind.temp_c);
  }
  return temps_c;
}

/// Covariance of the error of level + f at `temp_c`.
MatrixXd error_covariance(const SensorPicture& picture, const CampaignDesign& design, std::span<const double> temp_c) {
  constexpr double kJitter = 1e-10;
  const std::vector<VisitKind> kinds = kinds_of(design);
  const std::vector<double> visited_c = temperatures_of(kinds);
  const auto m = static_cast<Index>(visited_c.size());
  MatrixXd prior = covariance(picture, visited_c, visited_c);
  prior.diagonal().array() += kJitter * picture.scale * picture.scale;
  const MatrixXd lower = base::cholesky(prior);

  // Rows of H: 1, and L at the row's temperature. Those of S: L with the row's sign, at the scale of the gap.
  MatrixXd h(static_cast<Index>(kinds.size()), 1 + m);
  MatrixXd s(h.rows(), m);
  for (Index i = 0; i < h.rows(); ++i) {
    const VisitKind& kind = kinds[static_cast<std::size_t>(i)];
    const auto at = std::lower_bound(visited_c.begin(), visited_c.end(), kind.temp_c) - visited_c.begin();
    h(i, 0) = 1.0;
    h.row(i).tail(m) = lower.row(at);
    s.row(i) = kind.sign * picture.half_gap / picture.scale * lower.row(at);
  }
  const double row_variance = picture.visit_variance(design.dwell_s);
  const MatrixXd rows = information(design, kinds, row_variance, std::pow(picture.run_to_run, 2));
  MatrixXd precision = h.transpose() * rows * h;
  precision.diagonal().tail(m).array() += 1.0;

  // f(T*) = (L⁻¹ k*)ᵀ u + what the visits leave open.
  const MatrixXd across = base::solve_lower(lower, covariance(picture, visited_c, temp_c));
  MatrixXd wanted(1 + m, across.cols());
  wanted.row(0).setOnes();
  wanted.bottomRows(m) = across;
  const MatrixXd gain = base::solve_ldlt(precision, wanted);
  const MatrixXd of_gap = gain.transpose() * (h.transpose() * rows * s);
  return wanted.transpose() * gain + of_gap * of_gap.transpose() + covariance(picture, temp_c, temp_c) -
         across.transpose() * across;
}

double largest(const std::vector<double>& values) { return *std::ranges::max_element(values); }

}  // namespace

double ExpectedBand::worst_shape() const { return largest(shape95); }
double ExpectedBand::worst_curve() const { return largest(curve95); }
double ExpectedBand::worst_fresh() const { return largest(fresh95); }

int count_power_ons(const CampaignDesign& design) {
  int count = 0;
  for (const PlannedPowerOn& power_on : design.power_ons) count += power_on.count;
  return count;
}

base::Result<ExpectedBand> expected_band(const SensorPicture& picture, const CampaignDesign& design,
                                         std::span<const double> temp_c) {
  const int power_ons = count_power_ons(design);
  if (power_ons < 2) return base::bad_input("a design needs two power-ons or more: one alone does not tell the level");
  if (temp_c.empty()) return base::bad_input("no temperature is given at which the band is wanted");
  const MatrixXd spread = error_covariance(picture, design, temp_c);
  const double student = base::student_t_two_sided(0.95, power_ons - 1.0);
  const VectorXd with_mean = spread.rowwise().mean();
  const double mean_variance = with_mean.mean();
  const double gap = picture.half_gap * picture.half_gap;
  ExpectedBand band;
  band.temp_c.assign(temp_c.begin(), temp_c.end());
  band.level_sigma = std::sqrt(mean_variance);
  band.level95 = student * band.level_sigma;
  for (Index i = 0; i < spread.rows(); ++i) {
    const double shape_variance = std::max(0.0, spread(i, i) - 2.0 * with_mean[i] + mean_variance);
    const double fresh_variance = mean_variance + std::pow(picture.run_to_run, 2);
    band.shape95.push_back(kNormal95 * std::sqrt(shape_variance));
    band.curve95.push_back(std::hypot(band.shape95.back(), band.level95));
    band.fresh95.push_back(
        std::hypot(band.shape95.back(), student * std::sqrt(fresh_variance), kNormal95 * std::sqrt(gap)));
  }
  return band;
}

}  // namespace soak::calib
