// SPDX-License-Identifier: Apache-2.0
#include "anfis/training/premise_layer.h"

#include "anfis/inference/membership.h"

namespace soak::anfis::training {

using Eigen::Index;

void PremiseLayer::compute(Membership membership, std::span<const Rule> rules) {
  const auto count = static_cast<Index>(rules.size());
  distance_.resize(inputs_.size(), count);
  degree_.resize(inputs_.size(), count);
  strengths_.resize(inputs_.size(), count);
  std::vector<double> distance(rules.size());
  std::vector<double> strength(rules.size());
  for (Index row = 0; row < inputs_.size(); ++row) {
    for (std::size_t i = 0; i < rules.size(); ++i) {
      distance[i] = inference::distance_measure(membership, rules[i], inputs_(row));
      strength[i] = inference::membership_degree(membership, rules[i], distance[i]);
      distance_(row, static_cast<Index>(i)) = distance[i];
      degree_(row, static_cast<Index>(i)) = strength[i];
    }
    inference::normalise_strengths(membership, rules, distance, strength);
    strengths_.row(row) = Eigen::Map<const Eigen::RowVectorXd>(strength.data(), count);
  }
}

Eigen::MatrixXd PremiseLayer::consequent_matrix(int order) const {
  if (order == 0) {
    return strengths_;
  }
  Eigen::MatrixXd a(strengths_.rows(), 2 * strengths_.cols());
  a.leftCols(strengths_.cols()) = strengths_.array().colwise() * inputs_.array();
  a.rightCols(strengths_.cols()) = strengths_;
  return a;
}

Eigen::VectorXd PremiseLayer::output(std::span<const Rule> rules) const {
  Eigen::VectorXd f = Eigen::VectorXd::Zero(inputs_.size());
  for (std::size_t i = 0; i < rules.size(); ++i) {
    f.array() += strengths_.col(static_cast<Index>(i)).array() * (rules[i].gain * inputs_.array() + rules[i].offset);
  }
  return f;
}

Eigen::MatrixXd PremiseLayer::premise_jacobian(Membership membership, std::span<const Rule> rules) const {
  const auto count = static_cast<Index>(rules.size());
  Eigen::MatrixXd jacobian(inputs_.size(), premises_per_rule(membership) * count);
  const Eigen::VectorXd f = output(rules);
  for (Index i = 0; i < count; ++i) {
    const Rule& rule = rules[static_cast<std::size_t>(i)];
    for (Index row = 0; row < inputs_.size(); ++row) {
      // [AH05 eq. 5.18-5.19] df/d theta_i = wbar_i (f_i - f) d ln mu_i / d theta_i
      const double pull = strengths_(row, i) * (rule.gain * inputs_(row) + rule.offset - f(row));
      const inference::LogDerivatives d =
          inference::log_derivatives(membership, rule, inputs_(row), distance_(row, i), degree_(row, i));
      jacobian(row, i) = pull * d.width;
      if (membership == Membership::bell) {
        jacobian(row, count + i) = pull * d.slope;
      }
      jacobian(row, jacobian.cols() - count + i) = pull * d.centre;
    }
  }
  return jacobian;
}

int premises_per_rule(Membership membership) { return membership == Membership::bell ? 3 : 2; }

void set_consequents(const Eigen::VectorXd& coefficients, int order, std::span<Rule> rules) {
  const auto count = static_cast<Index>(rules.size());
  for (Index i = 0; i < count; ++i) {
    Rule& rule = rules[static_cast<std::size_t>(i)];
    rule.gain = order == 0 ? 0.0 : coefficients(i);
    rule.offset = coefficients(order == 0 ? i : count + i);
  }
}

}  // namespace soak::anfis::training
