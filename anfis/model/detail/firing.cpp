// SPDX-License-Identifier: Apache-2.0
#include "anfis/model/detail/firing.h"

#include <algorithm>
#include <numeric>

#include "anfis/model/detail/membership_functions.h"

namespace soak::anfis::inference {

Firing::Firing(const Model& model) : model_(model), strength_(model.rules.size()) {
  std::size_t count = 0;
  for (const Input& input : model.inputs) {
    first_.push_back(count);
    count += input.memberships.size();
  }
  degree_.resize(count);
}

void Firing::set_degrees(std::span<const double> u) {
  double* degree = degree_.data();
  for (std::size_t j = 0; j < u.size(); ++j) {
    for (const Membership& membership : model_.inputs[j].memberships) *degree++ = degree_of(membership, u[j]);
  }
}

double Firing::strength(const Rule& rule) const {
  double w = 1.0;
  for (std::size_t j = 0; j < rule.premise.size(); ++j) {
    if (rule.premise[j] == kAny) continue;
    const double mu = degree_[first_[j] + static_cast<std::size_t>(rule.premise[j])];
    // [AH05 eq. 5.8]
    w = model_.t_norm == TNorm::product ? w * mu : std::min(w, mu);
  }
  return w;
}

std::span<const double> Firing::at(std::span<const double> u) {
  set_degrees(u);
  std::transform(model_.rules.begin(), model_.rules.end(), strength_.begin(),
                 [this](const Rule& rule) { return strength(rule); });
  const double sum = std::accumulate(strength_.begin(), strength_.end(), 0.0);
  fired_ = sum >= kSmallestSum;
  if (fired_) {
    // [AH05 eq. 5.9]
    for (double& w : strength_) w /= sum;
    return strength_;
  }
  std::transform(model_.rules.begin(), model_.rules.end(), strength_.begin(),
                 [&](const Rule& rule) { return log_strength(model_, rule, u); });
  normalise_logarithms(strength_);
  return strength_;
}

void normalise_logarithms(std::span<double> log_strengths) {
  const double largest = *std::max_element(log_strengths.begin(), log_strengths.end());
  double sum = 0.0;
  for (double& w : log_strengths) sum += w = exponential(w - largest);
  for (double& w : log_strengths) w /= sum;
}

double log_strength(const Model& model, const Rule& rule, std::span<const double> u) {
  double log = 0.0;
  for (std::size_t j = 0; j < u.size(); ++j) {
    if (rule.premise[j] == kAny) continue;
    const double one = log_degree_of(model.inputs[j].memberships[static_cast<std::size_t>(rule.premise[j])], u[j]);
    log = model.t_norm == TNorm::product ? log + one : std::min(log, one);
  }
  return log;
}

}  // namespace soak::anfis::inference
