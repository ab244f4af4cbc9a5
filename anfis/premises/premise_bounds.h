// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "anfis/data/training_data.h"
#include "anfis/model/model.h"

namespace soak::anfis {

/// What premises may become in a training; see PremiseBounds.
enum class PremiseLimits {
  resolved,  ///< memberships and their edges no narrower than the gaps between inputs: for noisy data
  ordered,   ///< memberships in order, centres inside the data: for data without noise that fill the input space
  none,      ///< whatever the gradient says [Jang93]: hybrid learning only
};

}  // namespace soak::anfis

namespace soak::anfis::training {

// Premises as one vector: input by input, membership by membership, their parameters in the order of parameter_names().

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

/// Interval that a premise parameter may lie in.
struct Interval {
  double low;
  double high;
};

/// Gaps between neighbouring values that one input takes, in scaled units.
class InputGaps {
 public:
  /// most: a gap counts as at most this share of half the range (PremiseLimits::ordered looks past the gaps).
  explicit InputGaps(std::vector<double> values, double most = 1e9);

  [[nodiscard]] double lowest() const { return values_.front(); }
  [[nodiscard]] double highest() const { return values_.back(); }
  [[nodiscard]] double widest() const { return widest_; }
  /// Longest width or flank that still says something: four times half the range.
  [[nodiscard]] double longest() const { return 2.0 * (highest() - lowest()); }
  /// The widest gap among those that reach into [u - widest(), u + widest()].
  [[nodiscard]] double near(double u) const { return near({u, u}); }
  /// The widest of near(u) for u in an interval.
  [[nodiscard]] double near(const Interval& interval) const;

 private:
  std::vector<double> values_;  ///< sorted, distinct
  double widest_ = 0.0;
  double most_;
};

/// What premises may become. The data cannot see what happens between two neighbouring inputs, and least squares uses
/// every freedom it gets: a membership narrower than the gap between inputs, or an edge sharper than it, puts a wiggle
/// there that costs no training error. So, with gap(c) the widest distance between neighbouring distinct values of that
/// input near c:
///  - bell: slope in [1, 4] and width/slope, the width of its edges, at least gap(c), so its width too; from slope 1 up
///    the bell is twice differentiable at its centre;
///  - Gaussian flanks: width >= gap; straight flanks: length >= gap;
///  - widths and flanks at most four times half the range: wider memberships are the same everywhere;
///  - centres and tops inside the range of the data; the memberships of an input that rules share (or of the only
///    input) stay in order, neighbours at least half the widest gap apart: closer ones are the same twice and leave the
///    consequents undetermined.
/// Measured on the 20 problems of tests/anfis/thermal_drift_test.cpp with 4 runs: bell edges down to half a gap raise
/// the worst error between temperatures from 0.0045 to 0.0059.
///
/// That is PremiseLimits::resolved. With `ordered` a gap counts as at most 0.02 half ranges and slopes may be 0.25..16;
/// with `none` there are no bounds at all.
class PremiseBounds {
 public:
  PremiseBounds(const Model& model, const TrainingData& data, PremiseLimits limits = PremiseLimits::resolved);

  /// The nearest admissible premises, parameter by parameter.
  void apply(Model& model) const;

  /// Sets to zero the components of `descent` (a direction to move in, in the order of read_premises()) that would
  /// leave the admissible set from where the model lies on its border.
  void block(const Model& model, std::span<double> descent) const;

  /// Range of a bell's slope, whatever its width.
  [[nodiscard]] Interval slopes() const { return slopes_; }
  [[nodiscard]] const InputGaps& gaps(std::size_t input) const { return inputs_[input].gaps; }
  /// Whether the memberships of the input must stay in order, and how far apart at least.
  [[nodiscard]] bool ordered(std::size_t input) const { return inputs_[input].ordered; }
  [[nodiscard]] double separation(std::size_t input) const { return inputs_[input].separation; }

  /// The interval of parameter `index` of a membership of input `input`, the other parameters given.
  [[nodiscard]] Interval interval(std::size_t input, const Membership& membership, std::size_t index) const;

 private:
  struct InputBounds {
    InputGaps gaps;
    bool ordered;
    double separation;  ///< least distance of neighbouring centres
  };

  static void order_centres(const InputBounds& bounds, std::span<Membership> memberships);

  PremiseLimits limits_;
  Interval slopes_;
  std::vector<InputBounds> inputs_;
};

}  // namespace soak::anfis::training
