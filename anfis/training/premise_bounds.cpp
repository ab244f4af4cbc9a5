// SPDX-License-Identifier: Apache-2.0
#include "anfis/training/premise_bounds.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace soak::anfis::training {
namespace {
constexpr double kWidest = 4.0;
constexpr double kGentlest = 1.0;
constexpr double kSteepest = 4.0;
constexpr double kBellEdgePerGap = 1.0;
constexpr double kGaussianWidthPerGap = 1.0;
constexpr double kSeparationPerGap = 0.5;
}  // namespace

PremiseBounds::PremiseBounds(Membership membership, std::span<const double> inputs, std::size_t rules)
    : membership_(membership), inputs_(inputs.begin(), inputs.end()) {
  std::sort(inputs_.begin(), inputs_.end());
  inputs_.erase(std::unique(inputs_.begin(), inputs_.end()), inputs_.end());
  for (std::size_t i = 1; i < inputs_.size(); ++i) {
    widest_gap_ = std::max(widest_gap_, inputs_[i] - inputs_[i - 1]);
  }
  const double range = inputs_.back() - inputs_.front();
  separation_ = std::min(kSeparationPerGap * widest_gap_, 0.5 * range / static_cast<double>(rules));
}

double PremiseBounds::gap_near(double centre) const {
  // The widest gap among those that reach into [centre - widest, centre + widest].
  double gap = 0.0;
  for (std::size_t i = 1; i < inputs_.size(); ++i) {
    if (inputs_[i] >= centre - widest_gap_ && inputs_[i - 1] <= centre + widest_gap_) {
      gap = std::max(gap, inputs_[i] - inputs_[i - 1]);
    }
  }
  return gap;
}

double PremiseBounds::least_width(double centre) const {
  const double per_gap = membership_ == Membership::bell ? kGentlest * kBellEdgePerGap : kGaussianWidthPerGap;
  return std::min(per_gap * gap_near(centre), kWidest);
}

double PremiseBounds::steepest(const Rule& rule) const {
  return std::clamp(rule.width / (kBellEdgePerGap * gap_near(rule.centre)), kGentlest, kSteepest);
}

void PremiseBounds::apply(std::span<Rule> rules) const {
  order_centres(rules);
  for (Rule& rule : rules) {
    rule.width = std::clamp(rule.width, least_width(rule.centre), kWidest);
    if (membership_ == Membership::bell) {
      rule.slope = std::clamp(rule.slope, kGentlest, steepest(rule));
    }
  }
}

void PremiseBounds::order_centres(std::span<Rule> rules) const {
  double lowest = inputs_.front();
  for (Rule& rule : rules) {
    rule.centre = std::max(rule.centre, lowest);
    lowest = rule.centre + separation_;
  }
  double highest = inputs_.back();
  for (auto rule = rules.rbegin(); rule != rules.rend(); ++rule) {
    rule->centre = std::min(rule->centre, highest);
    highest = rule->centre - separation_;
  }
}

void PremiseBounds::block(std::span<const Rule> rules, std::span<Rule> descent) const {
  constexpr double kTouch = 1e-12;
  const auto blocked = [](double value, double low, double high, double direction) {
    return (direction < 0.0 && value <= low + kTouch) || (direction > 0.0 && value >= high - kTouch);
  };
  for (std::size_t i = 0; i < rules.size(); ++i) {
    if (blocked(rules[i].width, least_width(rules[i].centre), kWidest, descent[i].width)) {
      descent[i].width = 0.0;
    }
    if (membership_ == Membership::bell && blocked(rules[i].slope, kGentlest, steepest(rules[i]), descent[i].slope)) {
      descent[i].slope = 0.0;
    }
    if (blocked(rules[i].centre, inputs_.front(), inputs_.back(), descent[i].centre)) {
      descent[i].centre = 0.0;
    }
  }
}

}  // namespace soak::anfis::training
