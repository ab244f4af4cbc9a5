// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/config/config_reader.h"

#include <fmt/format.h>

#include <toml++/toml.h>
#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

namespace soak::hal::sim {

struct ConfigReader::Document {
  toml::table root;
  std::string file;
  std::set<std::string, std::less<>> asked;
  std::optional<base::Error> error;

  void refuse_at(std::string message, const toml::source_region& source) {
    if (error) return;
    const auto line = source.begin.line;
    error = base::Error{base::ErrorKind::bad_input, std::move(message), line ? fmt::format("{}:{}", file, line) : file};
  }

  const toml::node* find(std::string_view key) {
    asked.emplace(key);
    return root.at_path(key).node();
  }

  const toml::node* require(std::string_view key) {
    const toml::node* node = find(key);
    if (!node) refuse_at(fmt::format("key '{}' is missing", key), {});
    return node;
  }

  double checked_number(std::string_view key, const toml::node& node, Limits limits) {
    const auto value = node.value<double>();
    if (!value || !std::isfinite(*value) || *value < limits.low || *value > limits.high) {
      refuse_at(fmt::format("'{}' must be a number from {} to {}", key, limits.low, limits.high), node.source());
      return 0.0;
    }
    return *value;
  }

  void check_whole(std::string_view key, double value, const toml::node& node) {
    if (value != std::floor(value)) refuse_at(fmt::format("'{}' must be whole", key), node.source());
  }

  void refuse_unknown_keys_of(const std::string& table_name, const toml::table& table) {
    for (const auto& [name, value] : table) {
      const std::string key = fmt::format("{}.{}", table_name, name.str());
      if (!asked.contains(key)) refuse_at(fmt::format("unknown key '{}'", key), name.source());
    }
  }

  void refuse_unknown_keys() {
    for (const auto& [name, content] : root) {
      const std::string table_name(name.str());
      const toml::array* array = content.as_array();
      if (const toml::table* table = content.as_table()) {
        refuse_unknown_keys_of(table_name, *table);
      } else if (array && asked.contains(table_name)) {
        for (std::size_t i = 0; i < array->size(); ++i) {
          const toml::table* table = array->get(i)->as_table();
          if (table) refuse_unknown_keys_of(fmt::format("{}[{}]", table_name, i), *table);
        }
      } else {
        refuse_at(fmt::format("'{}' is not a table of this format", table_name), content.source());
      }
    }
  }
};

ConfigReader::ConfigReader(std::string_view text, std::string file) : document_(std::make_unique<Document>()) {
  document_->file = std::move(file);
  try {
    document_->root = toml::parse(text);
  } catch (const toml::parse_error& error) {
    document_->refuse_at(std::string(error.description()), error.source());
  }
}

ConfigReader::~ConfigReader() = default;

double ConfigReader::number(std::string_view key, Limits limits) {
  const toml::node* node = document_->require(key);
  return node ? document_->checked_number(key, *node, limits) : 0.0;
}

std::int64_t ConfigReader::whole(std::string_view key, Limits limits) {
  const toml::node* node = document_->require(key);
  if (!node) return 0;
  const auto value = node->value_exact<std::int64_t>();
  if (!value || static_cast<double>(*value) < limits.low || static_cast<double>(*value) > limits.high) {
    document_->refuse_at(fmt::format("'{}' must be a whole number from {} to {}", key, limits.low, limits.high),
                         node->source());
    return 0;
  }
  return *value;
}

Range ConfigReader::range(std::string_view key, Limits limits) {
  const toml::node* node = document_->require(key);
  if (!node) return {};
  const toml::array* array = node->as_array();
  if (!array || array->size() != 2) {
    document_->refuse_at(fmt::format("'{}' must be a pair [low, high]", key), node->source());
    return {};
  }
  const Range range{document_->checked_number(key, *array->get(0), limits),
                    document_->checked_number(key, *array->get(1), limits)};
  if (range.low > range.high) {
    document_->refuse_at(fmt::format("'{}' must have its lower end first", key), node->source());
  }
  return range;
}

Range ConfigReader::whole_range(std::string_view key, Limits limits) {
  const Range both = range(key, limits);
  if (const toml::node* node = document_->find(key)) {
    document_->check_whole(key, both.low, *node);
    document_->check_whole(key, both.high, *node);
  }
  return both;
}

std::vector<double> ConfigReader::numbers(std::string_view key, Limits limits) {
  const toml::node* node = document_->require(key);
  if (!node) return {};
  const toml::array* array = node->as_array();
  if (!array || array->empty()) {
    document_->refuse_at(fmt::format("'{}' must be a list of numbers", key), node->source());
    return {};
  }
  std::vector<double> values;
  for (const toml::node& element : *array) values.push_back(document_->checked_number(key, element, limits));
  return values;
}

std::vector<std::string> ConfigReader::texts(std::string_view key) {
  const toml::node* node = document_->require(key);
  if (!node) return {};
  const toml::array* array = node->as_array();
  if (!array || array->empty() || !array->is_homogeneous(toml::node_type::string)) {
    document_->refuse_at(fmt::format("'{}' must be a list of texts", key), node->source());
    return {};
  }
  std::vector<std::string> values;
  for (const toml::node& element : *array) values.push_back(element.value_or(std::string()));
  return values;
}

std::optional<double> ConfigReader::optional_number(std::string_view key, Limits limits) {
  const toml::node* node = document_->find(key);
  if (!node) return std::nullopt;
  return document_->checked_number(key, *node, limits);
}

std::string ConfigReader::text(std::string_view key) {
  if (!document_->require(key)) return {};
  return optional_text(key).value_or(std::string());
}

std::optional<std::string> ConfigReader::optional_text(std::string_view key) {
  const toml::node* node = document_->find(key);
  if (!node) return std::nullopt;
  const auto value = node->value_exact<std::string>();
  if (!value) document_->refuse_at(fmt::format("'{}' must be a text", key), node->source());
  return value.value_or(std::string());
}

std::optional<bool> ConfigReader::optional_flag(std::string_view key) {
  const toml::node* node = document_->find(key);
  if (!node) return std::nullopt;
  const auto value = node->value_exact<bool>();
  if (!value) document_->refuse_at(fmt::format("'{}' must be true or false", key), node->source());
  return value.value_or(false);
}

std::vector<std::string> ConfigReader::optional_texts(std::string_view key) {
  return document_->find(key) ? texts(key) : std::vector<std::string>{};
}

bool ConfigReader::has(std::string_view table) const { return document_->root.at_path(table).is_table(); }

std::size_t ConfigReader::table_count(std::string_view name) {
  const toml::node* node = document_->find(name);
  if (!node) return 0;
  if (!node->is_array_of_tables()) {
    document_->refuse_at(fmt::format("'{}' must be written as tables [[{}]]", name, name), node->source());
    return 0;
  }
  return node->as_array()->size();
}

void ConfigReader::refuse(std::string_view key, std::string message) {
  const toml::node* node = document_->find(key);
  document_->refuse_at(std::move(message), node ? node->source() : toml::source_region{});
}

base::Status ConfigReader::finish() {
  if (!document_->error) document_->refuse_unknown_keys();
  if (const auto& error = document_->error) return tl::unexpected<base::Error>(*error);
  return {};
}

}  // namespace soak::hal::sim
