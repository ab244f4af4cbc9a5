// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "anfis/data/training_data.h"

namespace soak::anfis::test {

/// Rows to train on and rows to check with.
struct PublishedData {
  TrainingData train;
  TrainingData check;
};

/// The series of Mackey and Glass, dx/dt = 0.2 x(t-17)/(1 + x(t-17)^10) - 0.1 x, x(0) = 1.2 and 0 before, as [Jang93 §V
/// example 3] predicts it: inputs x(t-18), x(t-12), x(t-6), x(t), output x(t+6); of 1000 rows the first 500 to train
/// and the other 500 to check. The series is chaotic: each way to integrate it is another series after some hundred
/// seconds.
///
/// Here: tests/data/vectors/mackey_glass.csv, t = 118..1117 (Runge-Kutta with step 0.1, the delayed value
/// interpolated).
PublishedData mackey_glass();

/// Here: the series of Jang's and MATLAB's demonstration, t = 117..1116. The recipe was found from its first 1201
/// values, which it repeats to their six digits: Runge-Kutta with step 0.1, the delayed value held over each step at
/// that of 169 steps before its beginning, x(0) itself never looked up.
PublishedData demonstration_mackey_glass();

/// The same rows from MATLAB's own file, and what MATLAB R2012b's anfis says after ten epochs from two bells per input:
/// first the outputs of the 500 training rows, then those of the checking rows.
struct MatlabMackeyGlass {
  PublishedData data;
  std::vector<double> outputs;
};

/// Not part of the project: read from $SOAK_TEST_DATA/matlab_anfis or, where that is unset, from
/// ../shared/data/matlab_anfis; nothing where it is absent.
std::optional<MatlabMackeyGlass> matlab_mackey_glass();

/// [Jang93 §V example 2] (1 + x^0.5 + y^-1 + z^-1.5)^2: trained on the 216 points of {1..6}^3, checked on the 125 of
/// {1.5..5.5}^3.
PublishedData three_input_function();

/// [Jang93 eq. 32] Average percentage error of these outputs: mean |y - output| / |y|, percent.
double average_percentage_error(const TrainingData& data, const Model& model);

/// A linear fit of NIST's Statistical Reference Datasets: "filip" or "wampler4", polynomials in raw powers.
struct CertifiedFit {
  Eigen::MatrixXd a;
  Eigen::VectorXd y;
  Eigen::VectorXd b;   ///< certified coefficients
  Eigen::VectorXd sd;  ///< certified standard deviations
};
CertifiedFit nist_linear(const std::string& name);

/// Digits on which two numbers agree (log relative error).
double digits(double value, double certified);

/// Noise-free values behind gyro_drift_21x20.csv: temperatures (-40..80 deg C) and drift (deg/h).
struct DenseTruth {
  std::vector<double> temp_c;
  std::vector<double> drift_degph;
};
DenseTruth gyro_truth();

/// Error of a curve against the truth after their mean difference is taken out.
struct ShapeError {
  double rmse;
  double worst;
};
ShapeError shape_error(const DenseTruth& truth, const std::function<double(double)>& curve);

}  // namespace soak::anfis::test
