// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace soak::tests {

/// Checks a document against a JSON schema (the keywords that docs/schema uses: type, const, enum, required,
/// properties, additionalProperties, items, minItems, maxItems, anyOf, $ref to #/$defs).
class SchemaCheck {
 public:
  explicit SchemaCheck(nlohmann::json schema) : root_(std::move(schema)) {}

  /// The first place where the document breaks the schema, and how; empty if nowhere.
  [[nodiscard]] std::string mistake(const nlohmann::json& document) const { return check(root_, document, ""); }

 private:
  using Json = nlohmann::json;

  static bool has_type(const std::string& type, const Json& node) {
    if (type == "integer") return node.is_number_integer();
    if (type == "number") return node.is_number();
    return type == node.type_name();
  }

  static bool has_any_type(const Json& types, const Json& node) {
    if (types.is_string()) return has_type(types.get<std::string>(), node);
    for (const Json& type : types) {
      if (has_type(type.get<std::string>(), node)) return true;
    }
    return false;
  }

  std::string check(const Json& schema, const Json& node, const std::string& path) const {
    if (schema.contains("$ref")) {
      return check(root_.at(Json::json_pointer(schema["$ref"].get<std::string>().substr(1))), node, path);
    }
    if (schema.contains("anyOf")) {
      for (const Json& option : schema["anyOf"]) {
        if (check(option, node, path).empty()) return {};
      }
      return path + ": fits no alternative";
    }
    if (schema.contains("type") && !has_any_type(schema["type"], node)) return path + ": wrong type";
    if (schema.contains("const") && schema["const"] != node) return path + ": wrong value";
    if (schema.contains("enum")) {
      bool found = false;
      for (const Json& option : schema["enum"]) found = found || option == node;
      if (!found) return path + ": not one of the values";
    }
    if (node.is_object()) return check_object(schema, node, path);
    return node.is_array() ? check_array(schema, node, path) : std::string();
  }

  std::string check_object(const Json& schema, const Json& node, const std::string& path) const {
    for (const Json& key : schema.value("required", Json::array())) {
      if (!node.contains(key.get<std::string>())) return path + ": lacks " + key.get<std::string>();
    }
    const Json properties = schema.value("properties", Json::object());
    const Json others = schema.value("additionalProperties", Json(true));
    for (const auto& [key, value] : node.items()) {
      const std::string inner = path + '/' + key;
      if (others == Json(false) && !properties.contains(key)) return inner + ": not in the schema";
      if (!properties.contains(key) && !others.is_object()) continue;
      const std::string found = check(properties.contains(key) ? properties[key] : others, value, inner);
      if (!found.empty()) return found;
    }
    return {};
  }

  std::string check_array(const Json& schema, const Json& node, const std::string& path) const {
    if (schema.contains("minItems") && node.size() < schema["minItems"].get<std::size_t>()) return path + ": too short";
    if (schema.contains("maxItems") && node.size() > schema["maxItems"].get<std::size_t>()) return path + ": too long";
    if (!schema.contains("items")) return {};
    for (std::size_t i = 0; i < node.size(); ++i) {
      std::string inner = path;
      inner.append("/").append(std::to_string(i));
      const std::string found = check(schema["items"], node[i], inner);
      if (!found.empty()) return found;
    }
    return {};
  }

  Json root_;
};

}  // namespace soak::tests
