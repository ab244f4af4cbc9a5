// SPDX-License-Identifier: Apache-2.0
#include "calib/gap/campaign/detail/thermal_nodes.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "base/linear/dense_solve.h"

namespace soak::calib::gap {
namespace {

constexpr double kFar = 30.0;  ///< sigmas from which erfc() leaves the range of numbers

double density(double z) { return std::exp(-0.5 * z * z) / std::sqrt(2.0 * std::numbers::pi); }

/// Beyond kFar the nearer end decides: P = φ(l)/l (1 − 1/l² …).
IntervalLikelihood of_far(double l) {
  return {-0.5 * l * l - std::log(l * std::sqrt(2.0 * std::numbers::pi)), l + 1.0 / l, 1.0};
}

/// Ends in sigmas, the middle of the interval not below the mean: P = Φ(u) − Φ(l) without cancellation.
IntervalLikelihood of_upper(double l, double u) {
  if (l > kFar) return of_far(l);
  const double chance = 0.5 * (std::erfc(l / std::numbers::sqrt2) - std::erfc(u / std::numbers::sqrt2));
  const double at_l = density(l) / chance;
  const double at_u = density(u) / chance;
  const double score = at_l - at_u;
  return {std::log(chance), score, std::max(0.0, score * score - (l * at_l - u * at_u))};
}

constexpr double kShortest_s = 5.0;
constexpr double kLongest_s = 20000.0;
constexpr double kStart_c = 5.0;  ///< standard deviation, beforehand, of a node from the air when a run begins
/// The error beside the steps, in steps: wide first, so that every reading has a say in where to look.
constexpr std::array kErrors = {0.3, 0.1, 0.05};
constexpr std::array kFirst_s = {30.0, 60.0, 120.0, 240.0, 480.0, 960.0};
constexpr std::array kRatios = {3.0, 8.0, 20.0};
constexpr int kMostPasses = 40;
constexpr double kLogStep = 1e-3;  ///< of the derivative by log τ

using LogTaus = std::array<double, 2>;

/// Exact for air that goes straight from row to row; at rest with the air at the first one.
void follow(const AirAndUnit& run, double tau_s, Eigen::Ref<Eigen::VectorXd> node) {
  double off = 0.0;
  node(0) = run.air_c[0];
  for (std::size_t k = 1; k < run.t_s.size(); ++k) {
    const double dt = run.t_s[k] - run.t_s[k - 1];
    const double behind = tau_s * (run.air_c[k] - run.air_c[k - 1]) / dt;
    off = (off + behind) * std::exp(-dt / tau_s) - behind;
    node(static_cast<Eigen::Index>(k)) = run.air_c[k] + off;
  }
}

/// Columns of everything but the time constants: 1, F₁, F₂, and what is left of each run's start in each node.
class Fit {
 public:
  Fit(const std::vector<AirAndUnit>& runs, double step_c) : runs_(runs), step_c_(step_c) {
    for (const AirAndUnit& run : runs) {
      begin_.push_back(rows_);
      rows_ += static_cast<Eigen::Index>(run.t_s.size());
    }
    readings_.resize(rows_);
    for (std::size_t r = 0; r < runs.size(); ++r) {
      readings_.segment(begin_[r], length(r)) = Eigen::Map<const Eigen::VectorXd>(runs[r].unit_c.data(), length(r));
    }
    parameters_ = 3 + 2 * static_cast<Eigen::Index>(runs.size());
  }

  [[nodiscard]] bool determined() const { return rows_ > parameters_ + 2; }

  /// Least squares of the readings over a grid of time constants: where to begin.
  void begin() {
    double best = std::numeric_limits<double>::infinity();
    for (const double first_s : kFirst_s) {
      for (const double ratio : kRatios) {
        const LogTaus taus = {std::log(first_s), std::log(first_s * ratio)};
        const Eigen::MatrixXd x = columns(taus);
        Eigen::MatrixXd normal = x.transpose() * x;
        normal.diagonal() += price(step_c_);
        const Eigen::VectorXd theta = base::solve_ldlt(normal, Eigen::VectorXd(x.transpose() * readings_));
        const double squares = (readings_ - x * theta).squaredNorm();
        if (squares >= best) continue;
        best = squares;
        taus_ = taus;
        theta_ = theta;
      }
    }
  }

  /// Levenberg-Marquardt steps on the likelihood with that error, until it grows no more.
  void climb(double sigma_c) {
    double here = value(taus_, theta_, sigma_c);
    double damping = 1e-3;
    for (int pass = 0; pass < kMostPasses && damping < 1e6; ++pass) {
      const Eigen::MatrixXd x = with_taus(columns(taus_));
      const Eigen::VectorXd at = x.leftCols(parameters_) * theta_;
      Eigen::VectorXd score(rows_);
      Eigen::VectorXd curvature(rows_);
      for (Eigen::Index i = 0; i < rows_; ++i) {
        const IntervalLikelihood row = likelihood(i, at(i), sigma_c);
        score(i) = row.score;
        curvature(i) = row.curvature;
      }
      Eigen::MatrixXd normal = x.transpose() * curvature.asDiagonal() * x;
      Eigen::VectorXd slope = x.transpose() * score;
      const Eigen::VectorXd held = price(1.0);
      normal.diagonal().head(parameters_) += held;
      slope.head(parameters_) -= held.cwiseProduct(theta_);
      const double gained = improve(normal, slope, sigma_c, here, damping);
      if (gained < 1e-6 * (1.0 + std::abs(here))) return;
    }
  }

  [[nodiscard]] ThermalNodes result() const {
    ThermalNodes nodes;
    nodes.tau_s = {std::exp(taus_[0]), std::exp(taus_[1])};
    const Eigen::VectorXd at = columns(taus_) * theta_;
    for (std::size_t r = 0; r < runs_.size(); ++r) {
      const auto part = at.segment(begin_[r], length(r));
      nodes.unit_c.emplace_back(part.begin(), part.end());
    }
    return nodes;
  }

 private:
  [[nodiscard]] Eigen::Index length(std::size_t r) const { return static_cast<Eigen::Index>(runs_[r].t_s.size()); }

  /// Curvature that the starts of the runs have beforehand, times the square of `sigma_c`.
  [[nodiscard]] Eigen::VectorXd price(double sigma_c) const {
    Eigen::VectorXd held = Eigen::VectorXd::Zero(parameters_);
    held.tail(parameters_ - 3).setConstant(sigma_c * sigma_c / (kStart_c * kStart_c));
    return held;
  }

  [[nodiscard]] IntervalLikelihood likelihood(Eigen::Index i, double at, double sigma_c) const {
    return interval_likelihood(readings_(i) - 0.5 * step_c_ - at, readings_(i) + 0.5 * step_c_ - at, sigma_c);
  }

  [[nodiscard]] Eigen::VectorXd node(double log_tau) const {
    Eigen::VectorXd of_all(rows_);
    for (std::size_t r = 0; r < runs_.size(); ++r) {
      follow(runs_[r], std::exp(log_tau), of_all.segment(begin_[r], length(r)));
    }
    return of_all;
  }

  [[nodiscard]] Eigen::MatrixXd columns(const LogTaus& taus) const {
    Eigen::MatrixXd x = Eigen::MatrixXd::Zero(rows_, parameters_);
    x.col(0).setOnes();
    for (Eigen::Index k = 0; k < 2; ++k) {
      const double log_tau = taus[static_cast<std::size_t>(k)];
      x.col(1 + k) = node(log_tau);
      for (std::size_t r = 0; r < runs_.size(); ++r) {
        const auto& t_s = runs_[r].t_s;
        const Eigen::Index column = 3 + 2 * static_cast<Eigen::Index>(r) + k;
        for (std::size_t i = 0; i < t_s.size(); ++i) {
          x(begin_[r] + static_cast<Eigen::Index>(i), column) = std::exp(-(t_s[i] - t_s[0]) / std::exp(log_tau));
        }
      }
    }
    return x;
  }

  /// The derivatives by the logarithms of the time constants beside the columns; how starts decay is left out of them,
  /// which costs a step some of its length, not the summit its place.
  [[nodiscard]] Eigen::MatrixXd with_taus(const Eigen::MatrixXd& x) const {
    Eigen::MatrixXd wide(rows_, parameters_ + 2);
    wide.leftCols(parameters_) = x;
    for (Eigen::Index k = 0; k < 2; ++k) {
      const double log_tau = taus_[static_cast<std::size_t>(k)];
      wide.col(parameters_ + k) =
          theta_(1 + k) * (node(log_tau + kLogStep) - node(log_tau - kLogStep)) / (2.0 * kLogStep);
    }
    return wide;
  }

  [[nodiscard]] double value(const LogTaus& taus, const Eigen::VectorXd& theta, double sigma_c) const {
    const Eigen::VectorXd at = columns(taus) * theta;
    double sum = -0.5 * price(1.0).dot(theta.cwiseAbs2());
    for (Eigen::Index i = 0; i < rows_; ++i) sum += likelihood(i, at(i), sigma_c).log_chance;
    return sum;
  }

  /// Takes the longest damped step that makes the likelihood grow; what it gains.
  double improve(const Eigen::MatrixXd& normal, const Eigen::VectorXd& slope, double sigma_c, double& here,
                 double& damping) {
    for (; damping < 1e6; damping *= 10.0) {
      Eigen::MatrixXd damped = normal;
      damped.diagonal() *= 1.0 + damping;
      damped.diagonal().array() += 1e-9 * normal.diagonal().maxCoeff();
      const Eigen::VectorXd step = base::solve_ldlt(damped, slope);
      LogTaus taus = taus_;
      for (std::size_t k = 0; k < taus.size(); ++k) {
        const double moved = taus[k] + std::clamp(step(parameters_ + static_cast<Eigen::Index>(k)), -0.5, 0.5);
        taus[k] = std::clamp(moved, std::log(kShortest_s), std::log(kLongest_s));
      }
      Eigen::VectorXd theta = theta_ + step.head(parameters_);
      const double there = value(taus, theta, sigma_c);
      if (!(there > here)) continue;
      const double gained = there - here;
      taus_ = taus;
      theta_ = std::move(theta);
      here = there;
      damping *= 0.1;
      return gained;
    }
    return 0.0;
  }

  const std::vector<AirAndUnit>& runs_;
  double step_c_;
  Eigen::Index rows_ = 0;
  Eigen::Index parameters_ = 0;
  std::vector<Eigen::Index> begin_;
  Eigen::VectorXd readings_;
  LogTaus taus_{};
  Eigen::VectorXd theta_;
};

}  // namespace

IntervalLikelihood interval_likelihood(double low, double high, double sigma) {
  const bool above = low + high >= 0.0;
  IntervalLikelihood likelihood = above ? of_upper(low / sigma, high / sigma) : of_upper(-high / sigma, -low / sigma);
  likelihood.score *= (above ? 1.0 : -1.0) / sigma;
  likelihood.curvature /= sigma * sigma;
  return likelihood;
}

std::optional<ThermalNodes> fit_thermal_nodes(const std::vector<AirAndUnit>& runs, double step_c) {
  Fit fit(runs, step_c);
  if (!fit.determined()) return std::nullopt;
  fit.begin();
  for (const double error : kErrors) fit.climb(error * step_c);
  return fit.result();
}

}  // namespace soak::calib::gap
