// SPDX-License-Identifier: Apache-2.0
#include "anfis/model_json.h"

#include <nlohmann/json.hpp>
#include <string>

namespace soak::anfis {
namespace {

using nlohmann::json;

constexpr const char* kFormat = "soak-anfis-model";
constexpr int kVersion = 1;

Model read_members(const json& document) {
  Model model;
  const auto& membership = document.at("membership").get_ref<const std::string&>();
  if (membership != name(Membership::bell) && membership != name(Membership::gaussian)) {
    throw json::other_error::create(501, "membership must be bell or gaussian, not " + membership, &document);
  }
  model.membership = membership == name(Membership::bell) ? Membership::bell : Membership::gaussian;
  document.at("order").get_to(model.order);
  const json& input = document.at("input");
  input.at("centre").get_to(model.input_centre);
  input.at("half_range").get_to(model.input_half_range);
  input.at("min").get_to(model.x_min);
  input.at("max").get_to(model.x_max);
  const json& output = document.at("output");
  output.at("centre").get_to(model.output_centre);
  output.at("half_range").get_to(model.output_half_range);
  for (const json& rule : document.at("rules")) {
    model.rules.push_back({rule.at("width").get<double>(), rule.at("slope").get<double>(),
                           rule.at("centre").get<double>(), rule.at("gain").get<double>(),
                           rule.at("offset").get<double>()});
  }
  return model;
}

base::Status check_format(const json& document) {
  if (!document.is_object() || document.value("format", json()) != kFormat) {
    return base::corrupt("this is not a model: format must be \"" + std::string(kFormat) + "\"", "format");
  }
  if (document.value("version", json()) != kVersion) {
    return base::corrupt("this program reads version " + std::to_string(kVersion) + " of the model format", "version");
  }
  return {};
}

}  // namespace

base::Result<json> model_to_json(const Model& model) {
  if (auto status = validate(model); !status) {
    return base::forward_error(status);
  }
  json rules = json::array();
  for (const Rule& rule : model.rules) {
    rules.push_back({{"width", rule.width},
                     {"slope", rule.slope},
                     {"centre", rule.centre},
                     {"gain", rule.gain},
                     {"offset", rule.offset}});
  }
  return json{{"format", kFormat},
              {"version", kVersion},
              {"membership", name(model.membership)},
              {"order", model.order},
              {"input",
               {{"centre", model.input_centre},
                {"half_range", model.input_half_range},
                {"min", model.x_min},
                {"max", model.x_max}}},
              {"output", {{"centre", model.output_centre}, {"half_range", model.output_half_range}}},
              {"rules", std::move(rules)}};
}

base::Result<Model> model_from_json(const json& document) {
  if (auto status = check_format(document); !status) {
    return base::forward_error(status);
  }
  try {
    Model model = read_members(document);
    if (auto status = validate(model); !status) {
      return base::corrupt(status.error().message, status.error().where);
    }
    return model;
  } catch (const json::exception& error) {
    return base::corrupt(std::string("a member is missing or of the wrong type: ") + error.what(), "model");
  }
}

}  // namespace soak::anfis
