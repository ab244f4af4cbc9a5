// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "anfis/data/training_data.h"
#include "anfis/model/rule_base.h"

namespace soak::anfis::test {

/// Text of tests/data/vectors/NAME.
std::string read_vector_file(const std::string& name);

/// grid_rules() with so many memberships on each input; throws where it refuses.
Model grid(const TrainingData& data, int memberships = 6, Shape shape = Shape::bell, int order = 1);

/// Rows of gyro_drift_21x20.csv: measured temperature and drift (deg/h) of the runs of one split, "train" or "heldout".
TrainingData gyro_drift(bool training_runs);

/// A made-up sensor: a smooth thermal curve with one or two Gaussian features, seen by several power-ons.
struct DriftProblem {
  TrainingData data;
  std::function<double(double)> truth;
};

/// 21 temperatures -30..70 deg C, scattered by 0.3 deg C; curve spanning 0.5 plus one or two Gaussians of height 0.1
/// and sigma 6..9 deg C; offset of each run sigma 0.02, row noise 0.002. passes: rows per temperature and run.
DriftProblem drift_problem(unsigned seed, int runs, int passes = 1);

/// Largest |f - truth| over -30..70 after the mean difference is removed.
double worst_shape_error(const DriftProblem& problem, const std::function<double(double)>& f);

/// Natural cubic spline through the means of the plateaus, each run's own mean removed first. Rows of one plateau lie
/// within half of `spacing` around first + k spacing.
std::function<double(double)> plateau_spline(const TrainingData& data, double first, double spacing, int plateaus);

/// Fold 0..folds-1 of each row by its group.
std::vector<int> folds_by_group(const TrainingData& data, int folds);

}  // namespace soak::anfis::test
