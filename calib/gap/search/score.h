// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <span>
#include <vector>

#include "calib/gap/base/campaign_model.h"
#include "calib/vocabulary/sensor.h"

namespace soak::calib::gap {

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
  /// Share of the parameters' variance that comes from slow processes, which each run shows about once.
  double slow_share = 0.0;
  /// Squares that parameters from all other folds take out of each fold; empty entries: the fold does not show it.
  std::vector<std::optional<double>> fold_gain;
};

/// The tests of sensors with parameters of their own as one: gains and degrees of freedom add up, as do the folds'.
[[nodiscard]] TermTest pooled(std::span<const TermTest* const> tests);

/// Degrees of freedom that the library's median heterogeneity counts for.
inline constexpr double kPriorDof = 12.0;

/// Degrees of freedom of the scatter that the gain of one sensor is held against: those with which visits of replicate
/// runs tell the noise, at most 24. More would trust the base too far: a feature of the curve that no knot follows
/// looks the same in all runs. It sits in one sensor, so that those of several sensors add up.
[[nodiscard]] double scatter_dof(const NoiseComponents& noise);

/// Degrees of freedom of the variance of a term's parameters, `slow_share` of which comes from slow processes: each run
/// shows those about once [Satterthwaite 1946].
[[nodiscard]] double term_dof(const NoiseComponents& noise, double slow_share, int runs);

/// Upper tail of F = (gain/dof)/max(1, λ) with λ drawn towards `typical`, the median over the library, as few folds
/// hardly tell it. As λ counts for 1 at least, the tail is that of the noise. How far slow processes go was learnt from
/// the same scatter of runs that λ comes from: in their share it counts once.
[[nodiscard]] double p_value(const TermTest& test, double typical);
/// The same of sensors with parameters of their own, together. Where noise is quick its size is well known, and their
/// squares add up; how far a slow process goes is known of each sensor by itself, from as many values as there are
/// runs, and one sensor with far more than it was thought to have would stand for all: their chances are put together.
[[nodiscard]] double p_value(std::span<const TermTest* const> tests, double typical);
/// λ so drawn, at least 1.
[[nodiscard]] double moderated_heterogeneity(const TermTest& test, double typical);

/// One candidate against the residuals.
struct CandidateTest {
  std::array<std::optional<TermTest>, kSensorCount> sensor;  ///< each on its own, also of a shared term
  std::optional<TermTest> shared;                            ///< of all sensors with one set of parameters
};

/// Estimates the parameters and how evenly the folds bear them out. A term that the base absorbs has dof 0.
[[nodiscard]] CandidateTest test_candidate(const Residuals& residuals, const Candidate& candidate);

/// How well a candidate stands: what search and verdict compare.
struct Standing {
  double p = 1.0;               ///< of its best set of sensors, adjusted for the choice among the sets
  double merit = 0.0;           ///< gain over heterogeneity less the price of its parameters, over the sensors it helps
  double gain = 0.0;            ///< the same without the price
  std::vector<Sensor> sensors;  ///< that it helps, each by itself
  /// Whether parameters from the other folds make half of the folds better, of at least two, and the sum of all even
  /// without the one that gains most.
  bool enough_folds = false;
};

/// `typical`: median heterogeneity of the library. `price`: of one parameter, in units of the whitened gain; a free
/// number in the shape costs one more.
[[nodiscard]] Standing standing(const CandidateTest& test, const Candidate& candidate, double typical, double price);

/// Sets of sensors that a mechanism may act on together: all of those given, their gyros, their accelerometers, and
/// each alone; none empty, none twice.
[[nodiscard]] std::vector<std::vector<Sensor>> sensor_sets(const std::vector<Sensor>& sensors);

/// Chance that independent chances are as small together as those given (Fisher): −2 Σ ln p is χ² with two degrees of
/// freedom for each. 1 for none.
[[nodiscard]] double chance_together(std::span<const double> chances);

}  // namespace soak::calib::gap
