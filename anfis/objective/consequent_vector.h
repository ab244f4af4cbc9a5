// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "anfis/model/model.h"

// Consequents as one vector: rule by rule the gains that are not dropped (order 1), in the order of inputs, then the
// offset.
namespace soak::anfis::training {

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

}  // namespace soak::anfis::training
