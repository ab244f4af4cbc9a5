// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "anfis/model.h"

namespace soak::anfis::training {

/// Normalised firing strengths of all rules at all rows, and what depends on them. One row per input, one column per
/// rule; inputs and outputs are scaled as in Model.
class PremiseLayer {
 public:
  explicit PremiseLayer(std::span<const double> scaled_inputs)
      : inputs_(
            Eigen::Map<const Eigen::VectorXd>(scaled_inputs.data(), static_cast<Eigen::Index>(scaled_inputs.size()))) {}

  /// Layers 1 to 3 [AH05 eq. 5.5-5.9] for these premises.
  void compute(Membership membership, std::span<const Rule> rules);

  /// Matrix A of the consequents [AH05 eq. 5.11-5.12]: the strengths times u, all rules, then the strengths; order 0:
  /// the strengths alone.
  [[nodiscard]] Eigen::MatrixXd consequent_matrix(int order) const;

  /// Layers 4 and 5 [AH05 eq. 5.10]: output of each row.
  [[nodiscard]] Eigen::VectorXd output(std::span<const Rule> rules) const;

  /// Derivatives of the output of each row by the premises: all widths, (bell) all slopes, all centres, one column
  /// each.
  [[nodiscard]] Eigen::MatrixXd premise_jacobian(Membership membership, std::span<const Rule> rules) const;

  [[nodiscard]] const Eigen::MatrixXd& strengths() const { return strengths_; }

 private:
  Eigen::VectorXd inputs_;
  Eigen::MatrixXd distance_;
  Eigen::MatrixXd degree_;
  Eigen::MatrixXd strengths_;
};

/// Number of premise parameters of one rule that can move: 3 for the bell, 2 for the Gaussian.
[[nodiscard]] int premises_per_rule(Membership membership);

/// Stores coefficients in the order of consequent_matrix in the rules.
void set_consequents(const Eigen::VectorXd& coefficients, int order, std::span<Rule> rules);

}  // namespace soak::anfis::training
