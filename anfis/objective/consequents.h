// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "anfis/data/training_data.h"
#include "anfis/model/model.h"
#include "base/linear/dense_solve.h"

namespace soak::anfis::training {

// Consequents as one vector: rule by rule the gains that are not dropped (order 1), in the order of inputs, then the
// offset.

/// Calls visit(rule index, input index or -1 for the offset) for every free consequent in order.
template <class Visit>
void for_each_consequent(const Model& model, Visit&& visit) {
  for (std::size_t i = 0; i < model.rules.size(); ++i) {
    auto dropped = model.rules[i].dropped.begin();
    const auto end = model.rules[i].dropped.end();
    const int gains = model.order == 1 ? static_cast<int>(model.inputs.size()) : 0;
    for (int j = 0; j < gains; ++j) {
      if (dropped != end && *dropped == j) {
        ++dropped;
      } else {
        visit(i, j);
      }
    }
    visit(i, -1);
  }
}

/// Stores a vector of consequents in the rules.
inline void set_consequents(const Eigen::Ref<const Eigen::VectorXd>& x, Model& model) {
  Eigen::Index next = 0;
  for_each_consequent(model, [&](std::size_t i, int j) {
    Rule& rule = model.rules[i];
    (j < 0 ? rule.offset : rule.gains[static_cast<std::size_t>(j)]) = x(next++);
  });
}

/// Free offsets (group_variance = +infinity) leave the level of the curve open: it becomes the plain mean of the
/// groups' levels. Does nothing for other data.
void set_level(Model& model, const TrainingData& data);

/// Least squares in the epoch loop: what solve_least_squares() of anfis/linear/least_squares.h computes, without
/// allocating memory. Rows are condensed to a triangular factor first (kernels.h), block by block so that each
/// stays in the cache; its columns are then scaled and pivoted to reveal the rank. Only a rank-deficient problem goes
/// to the general solver for its solution of least norm.
class ConsequentSolver {
 public:
  ConsequentSolver(Eigen::Index rows, Eigen::Index columns);

  /// x that minimises || A x - b ||; valid until the next call. Not finite where A or b is not.
  const Eigen::VectorXd& solve(const Eigen::MatrixXd& a, const Eigen::VectorXd& b);

 private:
  void condense(const Eigen::MatrixXd& a, const Eigen::VectorXd& b);
  Eigen::Index scale_and_decompose();

  Eigen::Index block_;      ///< rows condensed at a time
  Eigen::MatrixXd work_;    ///< a block of A and b under the factor of those before it
  Eigen::MatrixXd factor_;  ///< R of both
  Eigen::VectorXd scale_;
  Eigen::MatrixXd scaled_;
  base::SquareQr qr_;
  Eigen::VectorXd right_;
  Eigen::VectorXd solution_;
};

}  // namespace soak::anfis::training
