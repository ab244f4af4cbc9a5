// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

/// A gyro's bias wanders while a unit is turned on a bench, and its faces are visited one after the other. What it
/// wandered from one face to the next cannot be told from the faces' own readings, only from rests on the same face.
namespace soak::calib::six_position {

/// Random walk of a bias over a session.
struct SessionWander {
  double variance = 0.0;     ///< of the walk from the first row to the last, square of the readings' unit; 0: none
  double information = 0.0;  ///< Fisher's, on that variance
};

/// Covariance at times `tau` (any unit) of a random walk of unit variance from the first to the last of them, about its
/// mean over that time: with s, t from 0 to 1, 1/3 − max(s, t) + (s² + t²)/2.
[[nodiscard]] Eigen::MatrixXd walk_about_its_mean(const Eigen::VectorXd& tau);

/// The variance of the walk beside rows of known noise, by restricted maximum likelihood [Patterson & Thompson 1971]:
/// y = design · x + walk + noise, x unknown. `noise`: variance of each row. None where fewer than four rows are left
/// beside the unknowns. Cost: the cube of the number of rows.
[[nodiscard]] SessionWander estimate_session_wander(const Eigen::MatrixXd& design, const Eigen::VectorXd& y,
                                                    const Eigen::VectorXd& noise, const Eigen::VectorXd& tau);

}  // namespace soak::calib::six_position
