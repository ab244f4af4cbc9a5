// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "calib/gap/observations/observations.h"

namespace soak::calib::gap {

/// Mean of what was added.
struct Mean {
  double count = 0.0;
  double value = 0.0;

  void add(double x) {
    count += 1.0;
    value += (x - value) / count;
  }
};

/// One stay in a position, or one visit to a plateau: what a sensor read on average.
struct Stay {
  int run = 0;
  int visit = 0;
  int placement = 0;
  int cell = 0;   ///< equal for what runs repeat (Observation::cell); of a visit the smallest of its placements
  Mean t_s = {};  ///< of a visit over its placements, likewise
  Mean value = {};
};

[[nodiscard]] bool same_visit(const Stay& a, const Stay& b);

/// Means over placements, in the order of the rows. `values`: one per observation; NaN = no reading.
[[nodiscard]] std::vector<Stay> placements_of(const Observations& observations, const Eigen::VectorXd& values);

/// Means over visits of the means over their placements.
[[nodiscard]] std::vector<Stay> visits_of(const std::vector<Stay>& placements);

/// A bias that wanders and returns: variance sigma², correlation exp(−|Δt|/tau_s) (IEEE 952, Annex B: Markov noise).
/// Sums of such stand for bias instability and, where tau_s is longer than a run, for rate random walk.
struct GaussMarkov {
  double tau_s = 0.0;
  double sigma = 0.0;
};

inline constexpr int kMostStates = 8;  ///< of a filter: placement, visit and as many processes as there may be

/// How the blocks of one sensor scatter, standard deviations in its unit: block within placement, placement within
/// visit, visit within run. The runs' own offsets are free parameters of the base.
struct NoiseComponents {
  double block = 0.0;
  double placement = 0.0;
  double visit = 0.0;
  double block_dof = 0.0;
  double placement_dof = 0.0;
  double visit_dof = 0.0;
  bool replicated = false;  ///< whether runs repeat each other enough to say so
  /// Beside these, a bias that wanders all through the run; none where it was not looked for (WanderEstimate).
  std::vector<GaussMarkov> wander = {};
};

/// Nested analysis of variance of what differs between runs that repeat the same cell (plateau, sweep, occurrence,
/// position, block): an effect that the runs share drops out of it, so that the noise never comes from the fit's own
/// residual. `residual`: readings less the base, NaN where the sensor has none. Where runs share fewer than ten
/// degrees of freedom, the scatter within runs stands in and `replicated` is false.
[[nodiscard]] NoiseComponents noise_components(const Observations& observations, const Eigen::VectorXd& residual);

/// Variance that a wander has about its own mean over a run, at the times of the run's rows.
[[nodiscard]] double variance_about_mean(const Observations& observations, const std::vector<GaussMarkov>& wander,
                                         int run);

/// Turns the rows of one sensor into rows of unit variance that do not correlate, under nested noise and a bias that
/// wanders, by a Kalman filter over each run: what a row says beyond those before it (the inverse of the Cholesky
/// factor of their covariance). Rows without a value, and those whose `keep` is false, are passed over.
class Whitening {
 public:
  Whitening(const Observations& observations, Sensor sensor, const NoiseComponents& noise,
            const std::vector<bool>& keep);

  /// Whitened rows of `columns`, which has one row per observation.
  [[nodiscard]] Eigen::MatrixXd apply(const Eigen::Ref<const Eigen::MatrixXd>& columns) const;
  /// Of these the `count` from the `first` on, which is the first of a run: no run depends on another.
  [[nodiscard]] Eigen::MatrixXd apply_in_run(const Eigen::Ref<const Eigen::MatrixXd>& columns, Eigen::Index first,
                                             Eigen::Index count) const;
  /// ln of the determinant of the rows' covariance.
  [[nodiscard]] double log_determinant() const;
  /// Observation that whitened row i belongs to: rows keep their visit and run.
  [[nodiscard]] const std::vector<Eigen::Index>& rows() const { return rows_; }

 private:
  using States = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMostStates, 1>;
  using Covariance = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMostStates, kMostStates>;
  /// What the filter does at a row: the states fade, the row is less what they say, and corrects them.
  struct Step {
    States fade;
    States gain;
    double scale = 1.0;  ///< reciprocal standard deviation of what the row says beyond
  };
  void filter_runs(const Observations& observations, const NoiseComponents& noise);
  /// Whitens `Width` columns, or as many as there are, from the `column` on, in as many rows as `result` has.
  template <std::size_t Width>
  void filter_columns(const Eigen::Ref<const Eigen::MatrixXd>& columns, Eigen::Index column, Eigen::Index first_row,
                      Eigen::MatrixXd& result) const;
  void filter(const Eigen::Ref<const Eigen::MatrixXd>& columns, Eigen::Index first_row, Eigen::MatrixXd& result) const;

  std::vector<Eigen::Index> rows_;
  std::vector<Step> steps_;  ///< of each row
};

}  // namespace soak::calib::gap
