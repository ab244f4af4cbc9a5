// SPDX-License-Identifier: Apache-2.0
#include "anfis/persist/model_json.h"

#include <algorithm>
#include <cstdint>
#include <limits>
#include <nlohmann/json.hpp>
#include <string>

namespace soak::anfis {
namespace {

using nlohmann::json;

constexpr const char* kFormat = "soak-anfis-model";
constexpr int kVersion = 2;

json membership_json(const Membership& membership) {
  json document = {{"shape", name(membership.shape)}};
  const auto names = parameter_names(membership.shape);
  for (std::size_t i = 0; i < names.size(); ++i) document[std::string(names[i])] = membership.parameters[i];
  return document;
}

json input_json(const Input& input) {
  json memberships = json::array();
  for (const Membership& membership : input.memberships) memberships.push_back(membership_json(membership));
  return {{"name", input.name},
          {"centre", input.scale.centre},
          {"half_range", input.scale.half_range},
          {"min", input.min},
          {"max", input.max},
          {"memberships", std::move(memberships)}};
}

json rule_json(const Rule& rule) {
  json premise = json::array();
  for (const int index : rule.premise) premise.push_back(index == kAny ? json() : json(index));
  json document = {{"premise", std::move(premise)}, {"gains", rule.gains}, {"offset", rule.offset}};
  if (!rule.dropped.empty()) document["dropped"] = rule.dropped;
  return document;
}

/// A whole number from 0.
int read_int(const json& number) {
  const bool fits = number.is_number_integer() && (number.is_number_unsigned() || number.get<std::int64_t>() >= 0) &&
                    number.get<std::uint64_t>() <= std::numeric_limits<int>::max();
  if (!fits) {
    throw json::other_error::create(
        501, std::string("a number must be a whole number of 0 or more, not ") + number.type_name(), nullptr);
  }
  return number.get<int>();
}

/// The list that stands there.
const json& list(const json& document, const char* name) {
  const json& found = document.at(name);
  if (found.is_array()) return found;
  throw json::other_error::create(501, std::string(name) + " must be a list, not " + found.type_name(), nullptr);
}

Shape read_shape(const json& document) {
  const auto& text = document.get_ref<const std::string&>();
  const auto* const found = std::ranges::find_if(kShapes, [&](Shape shape) { return name(shape) == text; });
  if (found == kShapes.end()) throw json::other_error::create(501, "unknown shape of membership: " + text, nullptr);
  return *found;
}

Membership read_membership(const json& document) {
  Membership membership;
  membership.shape = read_shape(document.at("shape"));
  const auto names = parameter_names(membership.shape);
  for (std::size_t i = 0; i < names.size(); ++i) {
    membership.parameters[i] = document.at(std::string(names[i])).get<double>();
  }
  return membership;
}

Scale read_scale(const json& document) {
  return {document.at("centre").get<double>(), document.at("half_range").get<double>()};
}

Input read_input(const json& document) {
  Input input;
  input.name = document.value("name", "");
  input.scale = read_scale(document);
  input.min = document.at("min").get<double>();
  input.max = document.at("max").get<double>();
  for (const json& membership : list(document, "memberships")) input.memberships.push_back(read_membership(membership));
  return input;
}

Rule read_rule(const json& document) {
  Rule rule;
  for (const json& index : list(document, "premise")) rule.premise.push_back(index.is_null() ? kAny : read_int(index));
  rule.gains = document.at("gains").get<std::vector<double>>();
  rule.offset = document.at("offset").get<double>();
  if (document.contains("dropped")) {
    for (const json& index : list(document, "dropped")) rule.dropped.push_back(read_int(index));
  }
  return rule;
}

TNorm read_t_norm(const json& document) {
  const auto& text = document.get_ref<const std::string&>();
  for (const TNorm t_norm : {TNorm::product, TNorm::minimum}) {
    if (name(t_norm) == text) return t_norm;
  }
  throw json::other_error::create(501, "unknown T-norm: " + text, nullptr);
}

Model read_model(const json& document) {
  Model model;
  model.order = read_int(document.at("order"));
  model.t_norm = read_t_norm(document.at("t_norm"));
  for (const json& input : list(document, "inputs")) model.inputs.push_back(read_input(input));
  model.output = read_scale(document.at("output"));
  for (const json& rule : list(document, "rules")) model.rules.push_back(read_rule(rule));
  return model;
}

/// Foreign values are looked at where they stand: to copy or print a deep one would exhaust the stack.
base::Status check_format(const json& document) {
  if (!document.is_object() || !document.contains("format") || document.at("format") != kFormat) {
    return base::corrupt(std::string("not an ANFIS model: \"format\" must be \"") + kFormat + '"', "format");
  }
  const bool known =
      document.contains("version") && document.at("version").is_number_integer() && document.at("version") == kVersion;
  if (known) return {};
  return base::corrupt("unknown version of the model format: this program reads version " + std::to_string(kVersion),
                       "version");
}

}  // namespace

base::Result<json> model_to_json(const Model& model) {
  if (auto status = validate(model); !status) return base::forward_error(status);
  json inputs = json::array();
  for (const Input& input : model.inputs) inputs.push_back(input_json(input));
  json rules = json::array();
  for (const Rule& rule : model.rules) rules.push_back(rule_json(rule));
  return json{{"format", kFormat},
              {"version", kVersion},
              {"order", model.order},
              {"t_norm", name(model.t_norm)},
              {"inputs", std::move(inputs)},
              {"output", {{"centre", model.output.centre}, {"half_range", model.output.half_range}}},
              {"rules", std::move(rules)}};
}

base::Result<Model> model_from_json(const json& document) {
  if (auto status = check_format(document); !status) return base::forward_error(status);
  try {
    Model model = read_model(document);
    if (auto status = validate(model); !status) {
      return base::corrupt(status.error().message, status.error().where);
    }
    return model;
  } catch (const json::exception& error) {
    return base::corrupt(std::string("a member is missing or of the wrong type: ") + error.what(), "model");
  }
}

}  // namespace soak::anfis
