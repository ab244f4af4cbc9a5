// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>

#include "anfis/model/model.h"

// Premises as one vector: input by input, membership by membership, their parameters in the order of parameter_names().
namespace soak::anfis::training {

/// Calls visit(membership, index of its first parameter in the vector) for every membership in order.
template <class AnyModel, class Visit>
void for_each_membership(AnyModel& model, Visit&& visit) {
  std::size_t first = 0;
  for (auto& input : model.inputs) {
    for (auto& membership : input.memberships) {
      visit(membership, first);
      first += parameter_count(membership.shape);
    }
  }
}

/// Writes the premises of the model to a vector of premise_count(model) numbers.
inline void read_premises(const Model& model, std::span<double> theta) {
  for_each_membership(model, [&](const Membership& membership, std::size_t first) {
    for (std::size_t p = 0; p < parameter_count(membership.shape); ++p) theta[first + p] = membership.parameters[p];
  });
}

/// Stores such a vector in the model.
inline void set_premises(std::span<const double> theta, Model& model) {
  for_each_membership(model, [&](Membership& membership, std::size_t first) {
    for (std::size_t p = 0; p < parameter_count(membership.shape); ++p) membership.parameters[p] = theta[first + p];
  });
}

}  // namespace soak::anfis::training
