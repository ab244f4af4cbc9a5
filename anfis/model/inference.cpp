// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cassert>
#include <numeric>

#include "anfis/model/detail/inference.h"
#include "anfis/model/model.h"

namespace soak::anfis {
namespace {

/// Layers 1 to 5 at one point after the other, with the memory that they need.
class Evaluation {
 public:
  explicit Evaluation(const Model& model) : model_(model), u_(model.inputs.size()), strength_(model.rules.size()) {
    std::size_t count = 0;
    for (const Input& input : model.inputs) {
      first_.push_back(count);
      count += input.memberships.size();
    }
    degree_.resize(count);
  }

  double value(std::span<const double> x) {
    const std::span<const double> wbar = strengths(x);
    // [AH05 eq. 5.10-5.11] f = sum wbar_i (gains_i . u + offset_i)
    double f = 0.0;
    for (std::size_t i = 0; i < wbar.size(); ++i) f += wbar[i] * consequent(model_.rules[i]);
    return model_.output.unscaled(f);
  }

  /// Normalised firing strengths [AH05 eq. 5.5-5.9], valid until the next call.
  std::span<const double> strengths(std::span<const double> x) {
    scale(x);
    set_degrees();
    const auto& rules = model_.rules;
    std::ranges::transform(rules, strength_.begin(), [this](const Rule& rule) { return strength(rule); });
    const double sum = std::accumulate(strength_.begin(), strength_.end(), 0.0);
    fired_ = sum >= inference::kSmallestSum;
    if (fired_) {
      // [AH05 eq. 5.9]
      for (double& w : strength_) w /= sum;
      return strength_;
    }
    std::ranges::transform(rules, strength_.begin(),
                           [this](const Rule& rule) { return inference::log_strength(model_, rule, u_); });
    inference::normalise_logarithms(strength_);
    return strength_;
  }

  /// Whether some rule fired at the last point.
  [[nodiscard]] bool fired() const { return fired_; }

 private:
  void scale(std::span<const double> x) {
    assert(x.size() == u_.size());
    for (std::size_t j = 0; j < x.size(); ++j) {
      u_[j] = std::clamp(model_.inputs[j].scale.scaled(x[j]), -inference::kFarthest, inference::kFarthest);
    }
  }

  void set_degrees() {
    double* next = degree_.data();
    for (std::size_t j = 0; j < u_.size(); ++j) {
      for (const Membership& membership : model_.inputs[j].memberships) *next++ = degree(membership, u_[j]);
    }
  }

  [[nodiscard]] double strength(const Rule& rule) const {
    double w = 1.0;
    for (std::size_t j = 0; j < rule.premise.size(); ++j) {
      if (rule.premise[j] == kAny) continue;
      const double mu = degree_[first_[j] + static_cast<std::size_t>(rule.premise[j])];
      // [AH05 eq. 5.8]
      w = model_.t_norm == TNorm::product ? w * mu : std::min(w, mu);
    }
    return w;
  }

  [[nodiscard]] double consequent(const Rule& rule) const {
    double f = rule.offset;
    for (std::size_t j = 0; j < u_.size(); ++j) f += rule.gains[j] * u_[j];
    return f;
  }

  const Model& model_;
  std::vector<double> u_;           ///< the point in scaled units
  std::vector<std::size_t> first_;  ///< index of the first membership of each input in degree_
  std::vector<double> degree_;
  std::vector<double> strength_;
  bool fired_ = false;
};

bool in_range(const Model& model, std::span<const double> x) {
  for (std::size_t j = 0; j < x.size(); ++j) {
    if (!(x[j] >= model.inputs[j].min && x[j] <= model.inputs[j].max)) return false;
  }
  return true;
}

}  // namespace

Inference infer(const Model& model, std::span<const double> x) {
  Evaluation evaluation(model);
  Inference inference;
  inference.value = evaluation.value(x);
  inference.in_range = in_range(model, x);
  inference.fired = evaluation.fired();
  return inference;
}

double evaluate(const Model& model, std::span<const double> x) { return Evaluation(model).value(x); }

double evaluate(const Model& model, double x) { return evaluate(model, std::span(&x, 1)); }

void evaluate(const Model& model, std::span<const double> x, std::span<double> y) {
  const std::size_t inputs = model.inputs.size();
  assert(x.size() == inputs * y.size());
  Evaluation evaluation(model);
  for (std::size_t row = 0; row < y.size(); ++row) y[row] = evaluation.value(x.subspan(row * inputs, inputs));
}

void firing_strengths(const Model& model, std::span<const double> x, std::span<double> strengths) {
  Evaluation evaluation(model);
  std::ranges::copy(evaluation.strengths(x), strengths.begin());
}

}  // namespace soak::anfis

namespace soak::anfis::inference {

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
    const double one = log_degree(model.inputs[j].memberships[static_cast<std::size_t>(rule.premise[j])], u[j]);
    log = model.t_norm == TNorm::product ? log + one : std::min(log, one);
  }
  return log;
}

}  // namespace soak::anfis::inference
