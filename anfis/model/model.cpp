// SPDX-License-Identifier: Apache-2.0
#include "anfis/model/model.h"

#include <algorithm>
#include <cmath>
#include <string>

namespace soak::anfis {
namespace {

std::string indexed(const char* list, std::size_t index) {
  return std::string(list) + '[' + std::to_string(index) + ']';
}

base::Status finite(double value, const std::string& where) {
  if (std::abs(value) <= kLargestNumber) return {};
  return base::bad_input("not a finite number of at most 1e100", where);
}

base::Status validate_scale(const Scale& scale, const std::string& where) {
  if (auto status = finite(scale.centre, where + ".centre"); !status) return status;
  if (scale.half_range > 0.0 && scale.half_range <= kLargestNumber) return {};
  return base::bad_input("the half range must be a positive number of at most 1e100", where + ".half_range");
}

base::Status validate_input(const Input& input, const std::string& where) {
  if (auto status = validate_scale(input.scale, where + ".scale"); !status) return status;
  if (!std::isfinite(input.min) || !std::isfinite(input.max) || input.min > input.max) {
    return base::bad_input("the valid range must be two numbers in rising order", where + ".min, max");
  }
  if (input.memberships.size() > kMostMemberships) {
    return base::bad_input("an input has at most " + std::to_string(kMostMemberships) + " memberships",
                           where + ".memberships");
  }
  for (std::size_t k = 0; k < input.memberships.size(); ++k) {
    if (auto status = validate(input.memberships[k]); !status) {
      return base::bad_input(status.error().message,
                             where + '.' + indexed("memberships", k) + '.' + status.error().where);
    }
  }
  return {};
}

base::Status validate_premise(const Model& model, const Rule& rule, const std::string& where) {
  bool asks = model.rules.size() == 1;
  for (std::size_t j = 0; j < rule.premise.size(); ++j) {
    const int index = rule.premise[j];
    asks = asks || index != kAny;
    if (index != kAny && (index < 0 || static_cast<std::size_t>(index) >= model.inputs[j].memberships.size())) {
      return base::bad_input(
          "the input has no membership " + std::to_string(index) + ", and kAny is " + std::to_string(kAny),
          where + '.' + indexed("premise", j));
    }
  }
  if (asks) return {};
  return base::bad_input("the rule asks about no input: it would fire everywhere", where + ".premise");
}

base::Status validate_consequent(const Model& model, const Rule& rule, const std::string& where) {
  if (auto status = finite(rule.offset, where + ".offset"); !status) return status;
  for (std::size_t j = 0; j < rule.gains.size(); ++j) {
    if (auto status = finite(rule.gains[j], where + '.' + indexed("gains", j)); !status) return status;
    const bool absent = model.order == 0 ||
                        std::find(rule.dropped.begin(), rule.dropped.end(), static_cast<int>(j)) != rule.dropped.end();
    if (absent && rule.gains[j] != 0.0) {
      return base::bad_input("the gain must be 0 in order 0 and where the input is dropped",
                             where + '.' + indexed("gains", j));
    }
  }
  for (std::size_t k = 0; k < rule.dropped.size(); ++k) {
    const int index = rule.dropped[k];
    const bool rising = k == 0 || rule.dropped[k - 1] < index;
    if (!rising || index < 0 || static_cast<std::size_t>(index) >= rule.gains.size()) {
      return base::bad_input("dropped inputs must exist and rise", where + ".dropped");
    }
  }
  return {};
}

base::Status validate_rule(const Model& model, const Rule& rule, const std::string& where) {
  if (rule.premise.size() != model.inputs.size() || rule.gains.size() != model.inputs.size()) {
    return base::bad_input("the rule must have one premise and one gain per input", where);
  }
  if (auto status = validate_premise(model, rule, where); !status) return status;
  return validate_consequent(model, rule, where);
}

}  // namespace

std::string_view name(TNorm t_norm) { return t_norm == TNorm::product ? "product" : "minimum"; }

base::Status validate(const Model& model) {
  if (model.order != 0 && model.order != 1) {
    return base::bad_input("the order must be 0 or 1, not " + std::to_string(model.order), "order");
  }
  if (model.inputs.empty() || model.inputs.size() > kMostInputs) {
    return base::bad_input("a model has 1 to " + std::to_string(kMostInputs) + " inputs", "inputs");
  }
  if (model.rules.empty() || model.rules.size() > kMostRules) {
    return base::bad_input("a model has 1 to " + std::to_string(kMostRules) + " rules", "rules");
  }
  if (auto status = validate_scale(model.output, "output"); !status) return status;
  for (std::size_t j = 0; j < model.inputs.size(); ++j) {
    if (auto status = validate_input(model.inputs[j], indexed("inputs", j)); !status) return status;
  }
  for (std::size_t i = 0; i < model.rules.size(); ++i) {
    if (auto status = validate_rule(model, model.rules[i], indexed("rules", i)); !status) return status;
  }
  return {};
}

std::size_t consequent_count(const Model& model) {
  std::size_t count = 0;
  for (const Rule& rule : model.rules) {
    count += 1 + (model.order == 1 ? rule.gains.size() - rule.dropped.size() : 0);
  }
  return count;
}

std::size_t premise_count(const Model& model) {
  std::size_t count = 0;
  for (const Input& input : model.inputs) {
    for (const Membership& membership : input.memberships) count += parameter_count(membership.shape);
  }
  return count;
}

}  // namespace soak::anfis
