// SPDX-License-Identifier: Apache-2.0
#include "anfis/premises/premise_bounds.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace soak::anfis::training {
namespace {

constexpr Interval kResolvedSlopes = {1.0, 4.0};
constexpr Interval kOrderedSlopes = {0.25, 16.0};
constexpr double kOrderedGap = 0.02;
constexpr double kSeparationPerGap = 0.5;

std::vector<double> scaled_column(const Model& model, const TrainingData& data, std::size_t input) {
  std::vector<double> values;
  for (std::size_t i = 0; i < data.rows(); ++i) values.push_back(model.inputs[input].scale.scaled(data.row(i)[input]));
  return values;
}

bool in_rising_order(const Input& input) {
  return std::is_sorted(input.memberships.begin(), input.memberships.end(),
                        [](const Membership& a, const Membership& b) { return centre(a) < centre(b); });
}

/// Moves a membership as a whole.
void shift(Membership& membership, double by) {
  auto& p = membership.parameters;
  switch (membership.shape) {
    case Shape::bell:
      p[2] += by;
      break;
    case Shape::gaussian:
      p[1] += by;
      break;
    case Shape::two_sided_gaussian:
      p[1] += by;
      p[3] += by;
      break;
    case Shape::triangle:
    case Shape::trapezoid:
      for (std::size_t i = 0; i < parameter_count(membership.shape); ++i) p[i] += by;
      break;
  }
}

/// Shrinks a top about its middle until it lies inside the range, which holds the middle.
void fit_top(Membership& membership, Interval range) {
  if (membership.shape != Shape::two_sided_gaussian && membership.shape != Shape::trapezoid) return;
  auto& p = membership.parameters;
  double& right = membership.shape == Shape::trapezoid ? p[2] : p[3];
  if (p[1] >= range.low && right <= range.high && p[1] <= right) return;
  const double middle = centre(membership);
  const double half = std::clamp(0.5 * (right - p[1]), 0.0, std::min(middle - range.low, range.high - middle));
  p[1] = middle - half;
  right = middle + half;
}

Interval bell_interval(const InputGaps& gaps, const Interval& slopes, const Membership& m, std::size_t index) {
  const double gap = std::min(gaps.near(m.parameters[2]), gaps.longest());
  switch (index) {
    case 0:
      return {std::min(slopes.low * gap, gaps.longest()), gaps.longest()};
    case 1:
      return {slopes.low, std::clamp(m.parameters[0] / gap, slopes.low, slopes.high)};
    default:
      return {gaps.lowest(), gaps.highest()};
  }
}

Interval two_sided_interval(const InputGaps& gaps, const Membership& m, std::size_t index) {
  const auto& p = m.parameters;
  switch (index) {
    case 0:
      return {std::min(gaps.near(p[1]), gaps.longest()), gaps.longest()};
    case 1:
      return {gaps.lowest(), std::min(p[3], gaps.highest())};
    case 2:
      return {std::min(gaps.near(p[3]), gaps.longest()), gaps.longest()};
    default:
      return {std::max(p[1], gaps.lowest()), gaps.highest()};
  }
}

/// The foot of a straight flank that meets its top at `top`; side -1: left, 1: right.
Interval foot_interval(const InputGaps& gaps, double top, double side) {
  const double gap = std::min(gaps.near(top), gaps.longest());
  return side < 0.0 ? Interval{top - gaps.longest(), top - gap} : Interval{top + gap, top + gaps.longest()};
}

Interval polygon_interval(const InputGaps& gaps, const Membership& m, std::size_t index) {
  const auto& p = m.parameters;
  const bool triangle = m.shape == Shape::triangle;
  const std::size_t last = triangle ? 2 : 3;
  if (index == 0) return foot_interval(gaps, p[1], -1.0);
  if (index == last) return foot_interval(gaps, p[last - 1], 1.0);
  if (triangle) return {gaps.lowest(), gaps.highest()};
  return index == 1 ? Interval{gaps.lowest(), std::min(p[2], gaps.highest())}
                    : Interval{std::max(p[1], gaps.lowest()), gaps.highest()};
}

/// Parameters in an order in which each one's interval depends on settled ones only: positions first.
std::array<std::size_t, 4> settling_order(Shape shape) {
  switch (shape) {
    case Shape::bell:
      return {2, 0, 1, 3};
    case Shape::gaussian:
    case Shape::triangle:
      return {1, 0, 2, 3};
    case Shape::two_sided_gaussian:
      return {1, 3, 0, 2};
    case Shape::trapezoid:
      return {1, 2, 0, 3};
  }
  return {0, 1, 2, 3};
}

}  // namespace

InputGaps::InputGaps(std::vector<double> values, double most) : values_(std::move(values)) {
  std::sort(values_.begin(), values_.end());
  values_.erase(std::unique(values_.begin(), values_.end()), values_.end());
  for (std::size_t i = 1; i < values_.size(); ++i) widest_ = std::max(widest_, values_[i] - values_[i - 1]);
  most_ = most * 0.5 * (highest() - lowest());
}

double InputGaps::near(const Interval& interval) const {
  // values_[i] - values_[i - 1] reaches into the window if values_[i] >= low - widest and values_[i - 1] <= high +
  // widest.
  const auto first = std::lower_bound(values_.begin() + 1, values_.end(), interval.low - widest_);
  const auto last = std::upper_bound(values_.begin(), values_.end() - 1, interval.high + widest_);
  double gap = 0.0;
  for (auto upper = first; upper <= last && upper != values_.end(); ++upper) gap = std::max(gap, *upper - *(upper - 1));
  return std::min(gap > 0.0 ? gap : widest_, most_);
}

PremiseBounds::PremiseBounds(const Model& model, const TrainingData& data, PremiseLimits limits)
    : limits_(limits), slopes_(limits == PremiseLimits::resolved ? kResolvedSlopes : kOrderedSlopes) {
  const double most = limits == PremiseLimits::resolved ? 1e9 : kOrderedGap;
  for (std::size_t j = 0; j < model.inputs.size(); ++j) {
    const Input& input = model.inputs[j];
    InputGaps gaps(scaled_column(model, data, j), most);
    const bool shared = model.inputs.size() == 1 || input.memberships.size() < model.rules.size();
    const double range = gaps.highest() - gaps.lowest();
    const double separation =
        std::min(kSeparationPerGap * std::min(gaps.widest(), most * 0.5 * range),
                 0.5 * range / static_cast<double>(std::max<std::size_t>(1, input.memberships.size())));
    inputs_.push_back({std::move(gaps), shared && in_rising_order(input), separation});
  }
}

Interval PremiseBounds::interval(std::size_t input, const Membership& membership, std::size_t index) const {
  const InputGaps& gaps = inputs_[input].gaps;
  switch (membership.shape) {
    case Shape::bell:
      return bell_interval(gaps, slopes_, membership, index);
    case Shape::gaussian:
      if (index == 1) return {gaps.lowest(), gaps.highest()};
      return {std::min(gaps.near(membership.parameters[1]), gaps.longest()), gaps.longest()};
    case Shape::two_sided_gaussian:
      return two_sided_interval(gaps, membership, index);
    case Shape::triangle:
    case Shape::trapezoid:
      return polygon_interval(gaps, membership, index);
  }
  return {0.0, 0.0};
}

void PremiseBounds::apply(Model& model) const {
  if (limits_ == PremiseLimits::none) return;
  for (std::size_t j = 0; j < model.inputs.size(); ++j) {
    std::vector<Membership>& memberships = model.inputs[j].memberships;
    const Interval range = {inputs_[j].gaps.lowest(), inputs_[j].gaps.highest()};
    if (inputs_[j].ordered) order_centres(inputs_[j], memberships);
    for (Membership& membership : memberships) {
      const double middle = centre(membership);
      shift(membership, std::clamp(middle, range.low, range.high) - middle);
      fit_top(membership, range);
      const auto order = settling_order(membership.shape);
      for (std::size_t k = 0; k < parameter_count(membership.shape); ++k) {
        double& value = membership.parameters[order[k]];
        const Interval bounds = interval(j, membership, order[k]);
        value = std::clamp(value, bounds.low, std::max(bounds.low, bounds.high));
      }
    }
  }
}

void PremiseBounds::order_centres(const InputBounds& bounds, std::span<Membership> memberships) {
  double lowest = bounds.gaps.lowest();
  for (Membership& membership : memberships) {
    shift(membership, std::max(lowest - centre(membership), 0.0));
    lowest = centre(membership) + bounds.separation;
  }
  double highest = bounds.gaps.highest();
  for (auto membership = memberships.rbegin(); membership != memberships.rend(); ++membership) {
    shift(*membership, std::min(highest - centre(*membership), 0.0));
    highest = centre(*membership) - bounds.separation;
  }
}

void PremiseBounds::block(const Model& model, std::span<double> descent) const {
  if (limits_ == PremiseLimits::none) return;
  constexpr double kTouch = 1e-12;
  std::size_t next = 0;
  for (std::size_t j = 0; j < model.inputs.size(); ++j) {
    for (const Membership& membership : model.inputs[j].memberships) {
      for (std::size_t p = 0; p < parameter_count(membership.shape); ++p, ++next) {
        const Interval bounds = interval(j, membership, p);
        const double value = membership.parameters[p];
        if ((descent[next] < 0.0 && value <= bounds.low + kTouch) ||
            (descent[next] > 0.0 && value >= bounds.high - kTouch)) {
          descent[next] = 0.0;
        }
      }
    }
  }
}

}  // namespace soak::anfis::training
