// SPDX-License-Identifier: Apache-2.0
#include "anfis/model/one_input.h"

#include <algorithm>
#include <set>

namespace soak::anfis {

Model curve_model(Shape shape, std::span<const CurveRule> rules) {
  Model model;
  model.inputs.emplace_back();
  for (const CurveRule& rule : rules) {
    model.rules.push_back({{static_cast<int>(model.rules.size())}, {rule.gain}, rule.offset, {}});
    // A slope given to a Gaussian stays where validate() finds it.
    model.inputs[0].memberships.push_back(shape == Shape::bell
                                              ? bell(rule.width, rule.slope, rule.centre)
                                              : Membership{shape, {rule.width, rule.centre, rule.slope, 0.0}});
  }
  return model;
}

base::Status validate_curve(const Model& model) {
  if (model.inputs.size() != 1) {
    return base::bad_input("a curve has one input, this model has " + std::to_string(model.inputs.size()), "inputs");
  }
  std::set<int> used;
  for (const Rule& rule : model.rules) {
    if (rule.premise[0] == kAny || !used.insert(rule.premise[0]).second) {
      return base::bad_input("each rule of a curve has a membership of its own", "rules");
    }
    const Shape shape = model.inputs[0].memberships[static_cast<std::size_t>(rule.premise[0])].shape;
    if (shape != curve_shape(model) || (shape != Shape::bell && shape != Shape::gaussian)) {
      return base::bad_input("the memberships of a curve are all bells or all Gaussians", "inputs[0].memberships");
    }
  }
  return {};
}

Shape curve_shape(const Model& model) {
  return model.inputs[0].memberships[static_cast<std::size_t>(model.rules[0].premise[0])].shape;
}

std::vector<CurveRule> curve_rules(const Model& model) {
  std::vector<CurveRule> rules;
  for (const Rule& rule : model.rules) {
    const Membership& m = model.inputs[0].memberships[static_cast<std::size_t>(rule.premise[0])];
    const bool is_bell = m.shape == Shape::bell;
    rules.push_back({m.parameters[0], is_bell ? m.parameters[1] : 0.0, centre(m), rule.gains[0], rule.offset});
  }
  return rules;
}

}  // namespace soak::anfis
