// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <span>
#include <vector>

#include "calib/gap/base_curve/base_design.h"
#include "calib/gap/noise/whitening.h"

namespace soak::calib::gap {

/// What a term is tested against, sensor by sensor: the readings with base and accepted terms projected out, whitened.
class SensorResidual {
 public:
  /// `base`: columns of the base and of accepted terms, one row per observation; they may depend on each other. `keep`:
  /// observations that take part. `prior`: per column the reciprocal standard deviation that its coefficient has about
  /// 0; 0 = free.
  SensorResidual(const Observations& observations, Sensor sensor, const Eigen::MatrixXd& base,
                 const NoiseComponents& noise, const std::vector<bool>& keep, const Eigen::VectorXd& prior);

  [[nodiscard]] Eigen::MatrixXd whiten(const Eigen::MatrixXd& columns) const { return whitening_.apply(columns); }
  /// Whitened columns freed of what the base takes up.
  [[nodiscard]] Eigen::MatrixXd project(Eigen::MatrixXd white) const;
  /// Whitened readings, freed likewise: the residual.
  [[nodiscard]] const Eigen::VectorXd& residual() const { return residual_; }
  [[nodiscard]] const std::vector<Eigen::Index>& rows() const { return whitening_.rows(); }
  /// Coefficients of the base's columns, by generalised least squares.
  [[nodiscard]] const Eigen::VectorXd& coefficients() const { return coefficients_; }
  /// F with F Fᵀ the covariance of the coefficients.
  [[nodiscard]] const Eigen::MatrixXd& coefficient_factor() const { return coefficient_factor_; }

 private:
  Whitening whitening_;
  /// Orthonormal, of the whitened base and, below it, the prior's rows; a column's part of the former.
  Eigen::MatrixXd basis_;
  Eigen::VectorXd coefficients_;
  Eigen::MatrixXd coefficient_factor_;
  Eigen::VectorXd residual_;
};

/// Score and information of a term's parameters, fold by fold: all that a test of it needs.
struct TermScore {
  std::vector<Eigen::VectorXd> score;        ///< Dᵀe of each fold
  std::vector<Eigen::MatrixXd> information;  ///< DᵀD of each fold
  Eigen::VectorXd total_score;
  Eigen::MatrixXd total_information;
  /// Share of the whitened columns' squares that the base leaves: 0 = the base absorbs the term.
  double visible_share = 0.0;

  /// Adds that of another sensor with the same parameters.
  void add(const TermScore& other);
};

/// `folds`: fold number of each observation, `fold_count` of them.
[[nodiscard]] TermScore score_term(const SensorResidual& sensor, const Eigen::MatrixXd& columns,
                                   const std::vector<int>& folds, int fold_count);

/// Result of the test of one term.
struct TermTest {
  Eigen::VectorXd parameters;
  Eigen::MatrixXd covariance;  ///< of the parameters under the noise alone: a heterogeneity is the caller's to multiply
  double gain = 0.0;           ///< squares that the term takes out of the whitened residual
  double dof = 0.0;            ///< of the gain: parameters that the rows show
  double heterogeneity = 1.0;  ///< λ: scatter of the folds about the common parameters, 1 by noise alone
  double heterogeneity_dof = 0.0;
  /// Of the noise that the rows were made white with, as replicates told it: the caller knows.
  double noise_dof = 0.0;
  /// Squares that parameters from all other folds take out of each fold; empty entries: the fold does not show it.
  std::vector<std::optional<double>> fold_gain;

  [[nodiscard]] int judged_folds() const;
  /// Folds that parameters from all other folds make better.
  [[nodiscard]] int supporting_folds() const;
  /// Sum of fold_gain without the fold that gains most.
  [[nodiscard]] double gain_beside_best_fold() const;
};

/// The tests of sensors with parameters of their own as one: gains and degrees of freedom add up, as do the folds'.
[[nodiscard]] TermTest pooled(std::span<const TermTest* const> tests);

/// Estimates the parameters and how evenly the folds bear them out. A term that the base absorbs has dof 0.
[[nodiscard]] TermTest test_term(const TermScore& score);

/// Degrees of freedom that the library's median heterogeneity counts for.
inline constexpr double kPriorDof = 12.0;

/// Degrees of freedom of the scatter that the gain of one sensor is held against: those with which visits of replicate
/// runs tell the noise, at most 24. More would trust the base too far: a feature of the curve that no knot follows
/// looks the same in all runs. It sits in one sensor, so that those of several sensors add up.
[[nodiscard]] double scatter_dof(const NoiseComponents& noise);

/// Upper tail of F = (gain/dof)/max(1, λ) with λ drawn towards `typical`, the median over the library, as few folds
/// hardly tell it. As λ counts for 1 at least, the tail is that of the noise.
[[nodiscard]] double p_value(const TermTest& test, double typical);
/// λ so drawn, at least 1.
[[nodiscard]] double moderated_heterogeneity(const TermTest& test, double typical);

}  // namespace soak::calib::gap
