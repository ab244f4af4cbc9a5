// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "calib/gap/effects/effect.h"
#include "calib/gap/ramps/detail/ramp_recording.h"

namespace soak::calib::gap::ramps {

/// How the blocks of a sensor scatter about a curve of each branch's own: so that what differs between branches is not
/// taken for noise or for freedom of the curve.
struct BranchNoise {
  int intervals = 2;         ///< of the curve over the whole range, among 2 to 10: the best by the Bayesian criterion
  double sigma = 0.0;        ///< of a block; 0 where the readings do not scatter
  double correlation = 0.0;  ///< of neighbouring blocks, 0 to 0.9
};

/// How the folds predict a term, or none: means over the rows of each fold that lie within the temperatures of its
/// training rows, SI squared.
struct FoldSquares {
  std::vector<double> error;  ///< square of reading less prediction
  std::vector<double> floor;  ///< expected of a base that is right: noise, and the uncertainty of its parameters
};

/// A term fitted to all rows.
struct WholeFit {
  double squares = 0.0;        ///< of the whitened residuals
  double columns = 0.0;        ///< of base and term
  Eigen::VectorXd parameters;  ///< of the term, SI
  Eigen::MatrixXd covariance;  ///< of these, under the blocks' noise
  Eigen::VectorXd term;        ///< what it adds at each row of the sensor, SI
};

/// One sensor of a ramp recording: its base is a cubic spline of temperature (freedom: BranchNoise) and an offset per
/// run; nothing is free per branch. Rows are whitened with the correlation of neighbouring blocks.
class BranchFit {
 public:
  /// Nothing where the sensor has no readings or they do not scatter, and where fewer than two folds have 4 rows to be
  /// judged.
  [[nodiscard]] static std::optional<BranchFit> of(const RampRecording& recording, const FoldPlan& plan, Sensor sensor);

  /// The base and, where given, a shape, each fold predicted by parameters from the others. A term's parameters are
  /// held back as if drawn with three times the base's error: what the training cannot tell is 0, not anything.
  [[nodiscard]] FoldSquares predict_folds(const Candidate* shape) const;
  /// Like predict_folds() with a base for each direction: error only, NaN for folds without another of their direction.
  [[nodiscard]] std::vector<double> predict_by_direction() const;
  [[nodiscard]] WholeFit fit_all(const Candidate* shape) const;

  [[nodiscard]] const BranchNoise& noise() const { return noise_; }
  /// Judged rows of each fold.
  [[nodiscard]] const std::vector<double>& weight() const { return weight_; }
  [[nodiscard]] double rows() const { return static_cast<double>(values_.size()); }
  /// Of the base alone.
  [[nodiscard]] const FoldSquares& base() const { return base_; }

 private:
  struct Design {
    Eigen::MatrixXd columns;
    Eigen::Index base = 0;  ///< columns of the base, the first ones
  };
  BranchFit() = default;
  void choose_judged_rows(int folds);
  [[nodiscard]] Design design(const Candidate* shape) const;
  [[nodiscard]] Eigen::MatrixXd white(const Eigen::MatrixXd& columns) const;
  [[nodiscard]] Eigen::VectorXd ridge(const Design& design, const Eigen::MatrixXd& normal) const;
  [[nodiscard]] double mean_square(const Eigen::VectorXd& error, int fold) const;

  Sensor sensor_ = Sensor::gyro_x;
  BranchNoise noise_;
  double low_c_ = 0.0;
  double high_c_ = 0.0;
  std::vector<std::size_t> row_;  ///< index into the observations
  Eigen::VectorXd values_;        ///< about their mean
  Eigen::VectorXd temp_c_;
  std::vector<int> run_;
  std::vector<int> fold_;
  std::vector<int> piece_;  ///< equal for neighbours that are whitened together
  std::vector<Sweep> sweep_;
  std::vector<bool> judged_;
  std::vector<bool> lone_;  ///< of each fold: the only one of its run, whose offset the others do not know
  std::vector<double> weight_;
  FoldSquares base_;
};

}  // namespace soak::calib::gap::ramps
