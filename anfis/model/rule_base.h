// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "anfis/data/training_data.h"
#include "anfis/model/model.h"
#include "base/result.h"

namespace soak::anfis {

/// What a rule base starts from.
struct RuleBaseOptions {
  std::vector<int> memberships = {6};  ///< of each input, 2..256; one number counts for every input
  Shape shape = Shape::bell;
  int order = 1;  ///< of the consequents: 0 or 1
  TNorm t_norm = TNorm::product;
  bool scale = true;  ///< scale inputs and output to [-1, 1]; false keeps the units of the data (scale 0, 1)
};

/// Grid partition: every combination of one membership per input is a rule [Jang93]. Memberships of an input are equal,
/// equally spaced over its range, neighbours cross at degree 1/2: bell a = range / (2 (n - 1)), b = 2; Gaussian with
/// the same crossings; triangle with feet on its neighbours' peaks; trapezoid and two-sided Gaussian with a top of a
/// third of the spacing. The first input varies slowest over the rules. Consequents are 0.
///
/// Refuses (bad_input) options out of range, more than kMostRules rules (says the product), and data that validate()
/// refuses.
[[nodiscard]] base::Result<Model> grid_rules(const TrainingData& data, const RuleBaseOptions& options);

/// Scatter partition: one rule per row of `centres` (units of the data, one column per input), its memberships Gaussian
/// or another shape of equivalent width at `widths` (standard deviations, same shape as centres). Memberships belong to
/// one rule each. With one input the rules are put in rising order of centres. options.memberships is ignored.
[[nodiscard]] base::Result<Model> scatter_rules(const TrainingData& data, const Eigen::MatrixXd& centres,
                                                const Eigen::MatrixXd& widths, const RuleBaseOptions& options);

/// A membership of `shape` around `centre` whose degree is 1/2 at centre +- half_width_at_half.
[[nodiscard]] Membership membership_around(Shape shape, double centre, double half_width_at_half);

}  // namespace soak::anfis
