// SPDX-License-Identifier: Apache-2.0
#include "settings/reader.h"

#include <fmt/format.h>

#include <toml++/toml.h>
#include <algorithm>
#include <cmath>
#include <fstream>
#include <set>

namespace soak::hal {
namespace {

/// Many times what anyone writes. The parser's stack bounds how deep keys may be nested: this bounds both.
constexpr std::size_t kLongestText = 32768;

}  // namespace

struct SettingsTable::Place {
  const toml::table* table;
  std::string name;  ///< for messages: "" for the root, else "stability."
};

struct SettingsTable::Document {
  struct Mistake {
    std::uint32_t line;
    std::string text;
  };

  toml::table root;
  std::string file;
  std::set<const toml::node*> asked;
  std::set<const toml::table*> opened;  ///< tables whose keys were to be read
  std::set<const toml::node*> refused;
  std::vector<Mistake> mistakes;

  void mistake(const toml::source_region& source, std::string text) {
    mistakes.push_back({source.begin.line, std::move(text)});
  }

  /// The node under a key, from now on a known one; an absent one is a mistake if `required`.
  const toml::node* find(const Place& place, std::string_view key, bool required) {
    const toml::node* node = place.table->get(key);
    if (node) asked.insert(node);
    if (!node && required) mistake(place.table->source(), fmt::format("key '{}{}' is missing", place.name, key));
    return node;
  }

  void refuse_unknown(const toml::table& table) {
    for (const auto& [key, node] : table) {
      if (!asked.contains(&node)) {
        mistake(key.source(), fmt::format("unknown key '{}'", key.str()));
        continue;
      }
      if (const toml::table* inner = node.as_table()) refuse_unknown_in(*inner);
      if (const toml::array* array = node.as_array()) {
        for (const toml::node& element : *array) {
          if (const toml::table* inner = element.as_table()) refuse_unknown_in(*inner);
        }
      }
    }
  }

  /// A table that stands where another type belongs is one mistake, not one for each of its keys.
  void refuse_unknown_in(const toml::table& inner) {
    if (opened.contains(&inner)) refuse_unknown(inner);
  }
};

namespace {

std::string range_text(Limits limits) { return fmt::format("from {} to {}", limits.low, limits.high); }

std::optional<double> number_in(const toml::node& node, Limits limits) {
  const auto value = node.is_number() ? node.value<double>() : std::nullopt;
  if (!value || !std::isfinite(*value) || *value < limits.low || *value > limits.high) return std::nullopt;
  return value;
}

std::optional<int> whole_in(const toml::node& node, Limits limits) {
  const auto value = node.value_exact<std::int64_t>();
  if (!value || static_cast<double>(*value) < limits.low || static_cast<double>(*value) > limits.high) {
    return std::nullopt;
  }
  return static_cast<int>(*value);
}

}  // namespace

SettingsTable::SettingsTable(std::shared_ptr<Document> document, std::shared_ptr<const Place> place)
    : document_(std::move(document)), place_(std::move(place)) {}

bool SettingsTable::has(std::string_view key) const { return place_->table->contains(key); }

std::vector<std::string> SettingsTable::keys() const {
  std::vector<std::pair<toml::source_position, std::string>> found;
  for (const auto& [key, node] : *place_->table) found.emplace_back(key.source().begin, std::string(key.str()));
  std::sort(found.begin(), found.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<std::string> names;
  for (auto& [position, name] : found) names.push_back(std::move(name));
  return names;
}

void SettingsTable::refuse(std::string_view key, std::string message) const {
  const toml::node* node = place_->table->get(key);
  if (node && !document_->refused.insert(node).second) return;
  document_->mistake(node ? node->source() : place_->table->source(), std::move(message));
}

double SettingsTable::number(std::string_view key, Limits limits, std::optional<double> fallback) const {
  const bool required = !fallback;
  const toml::node* node = document_->find(*place_, key, required);
  if (!node) return fallback.value_or(0.0);
  const auto value = number_in(*node, limits);
  if (!value) refuse(key, fmt::format("'{}{}' must be a number {}", place_->name, key, range_text(limits)));
  return value.value_or(fallback.value_or(0.0));
}

int SettingsTable::whole(std::string_view key, Limits limits, std::optional<int> fallback) const {
  const bool required = !fallback;
  const toml::node* node = document_->find(*place_, key, required);
  if (!node) return fallback.value_or(0);
  const auto value = whole_in(*node, limits);
  if (!value) refuse(key, fmt::format("'{}{}' must be a whole number {}", place_->name, key, range_text(limits)));
  return value.value_or(fallback.value_or(0));
}

std::string SettingsTable::text(std::string_view key, const std::optional<std::string>& fallback) const {
  const bool required = !fallback;
  const toml::node* node = document_->find(*place_, key, required);
  if (!node) return fallback.value_or("");
  const auto value = node->value_exact<std::string>();
  if (!value) refuse(key, fmt::format("'{}{}' must be a text in quotes", place_->name, key));
  return value.value_or(fallback.value_or(""));
}

bool SettingsTable::flag(std::string_view key, std::optional<bool> fallback) const {
  const bool required = !fallback;
  const toml::node* node = document_->find(*place_, key, required);
  if (!node) return fallback.value_or(false);
  const auto value = node->value_exact<bool>();
  if (!value) refuse(key, fmt::format("'{}{}' must be true or false", place_->name, key));
  return value.value_or(fallback.value_or(false));
}

std::optional<double> SettingsTable::optional_number(std::string_view key, Limits limits) const {
  if (!has(key)) return std::nullopt;
  return number(key, limits);
}

std::optional<int> SettingsTable::optional_whole(std::string_view key, Limits limits) const {
  if (!has(key)) return std::nullopt;
  return whole(key, limits);
}

std::vector<double> SettingsTable::numbers(std::string_view key, Limits limits, bool required) const {
  const toml::node* node = document_->find(*place_, key, required);
  if (!node) return {};
  std::vector<double> values;
  const toml::array* array = node->as_array();
  bool good = array != nullptr;
  for (std::size_t i = 0; good && i < array->size(); ++i) {
    const auto value = number_in(*array->get(i), limits);
    good = value.has_value();
    if (good) values.push_back(*value);
  }
  if (!good) refuse(key, fmt::format("'{}{}' must be a list of numbers {}", place_->name, key, range_text(limits)));
  return values;
}

std::vector<int> SettingsTable::wholes(std::string_view key, Limits limits, bool required) const {
  const toml::node* node = document_->find(*place_, key, required);
  if (!node) return {};
  std::vector<int> values;
  const toml::array* array = node->as_array();
  bool good = array != nullptr;
  for (std::size_t i = 0; good && i < array->size(); ++i) {
    const auto value = whole_in(*array->get(i), limits);
    good = value.has_value();
    if (good) values.push_back(*value);
  }
  if (!good)
    refuse(key, fmt::format("'{}{}' must be a list of whole numbers {}", place_->name, key, range_text(limits)));
  return values;
}

std::vector<std::string> SettingsTable::texts(std::string_view key, bool required) const {
  const toml::node* node = document_->find(*place_, key, required);
  if (!node) return {};
  std::vector<std::string> values;
  const toml::array* array = node->as_array();
  bool good = array != nullptr;
  for (std::size_t i = 0; good && i < array->size(); ++i) {
    const auto value = array->get(i)->value_exact<std::string>();
    good = value.has_value();
    if (good) values.push_back(*value);
  }
  if (!good) refuse(key, fmt::format("'{}{}' must be a list of texts in quotes", place_->name, key));
  return values;
}

std::size_t SettingsTable::choice_index(std::string_view key, const std::vector<std::string_view>& names) const {
  constexpr bool required = true;
  const toml::node* node = document_->find(*place_, key, required);
  if (!node) return names.size();
  const auto value = node->value_exact<std::string>();
  const auto found = value ? std::find(names.begin(), names.end(), *value) : names.end();
  if (found == names.end()) {
    refuse(key, fmt::format("'{}{}' must be one of \"{}\"", place_->name, key, fmt::join(names, "\", \"")));
  }
  return static_cast<std::size_t>(found - names.begin());
}

std::optional<SettingsTable> SettingsTable::table(std::string_view key, bool required) const {
  const toml::node* node = document_->find(*place_, key, required);
  if (!node) return std::nullopt;
  const toml::table* inner = node->as_table();
  if (!inner) {
    refuse(key, fmt::format("'{}{}' must be a table", place_->name, key));
    return std::nullopt;
  }
  document_->opened.insert(inner);
  return SettingsTable(document_, std::make_shared<const Place>(Place{inner, fmt::format("{}{}.", place_->name, key)}));
}

std::vector<SettingsTable> SettingsTable::tables(std::string_view key) const {
  constexpr bool required = false;
  const toml::node* node = document_->find(*place_, key, required);
  if (!node) return {};
  std::vector<SettingsTable> tables;
  const toml::array* array = node->as_array();
  bool good = array != nullptr;
  for (std::size_t i = 0; good && i < array->size(); ++i) {
    const toml::table* inner = array->get(i)->as_table();
    good = inner != nullptr;
    if (good) {
      const std::string name = fmt::format("{}{}[{}].", place_->name, key, i + 1);
      document_->opened.insert(inner);
      tables.push_back(SettingsTable(document_, std::make_shared<const Place>(Place{inner, name})));
    }
  }
  if (!good) refuse(key, fmt::format("'{}{}' must be an array of tables, [[{}]]", place_->name, key, key));
  return tables;
}

base::Result<SettingsReader> SettingsReader::parse(std::string_view text, std::string file) {
  if (text.size() > kLongestText) {
    return base::bad_input(fmt::format("longer than {} bytes: this is no settings file", kLongestText), file);
  }
  auto document = std::make_shared<SettingsTable::Document>();
  document->file = std::move(file);
  try {
    document->root = toml::parse(text);
  } catch (const toml::parse_error& error) {
    return base::bad_input(std::string(error.description()),
                           fmt::format("{}:{}", document->file, error.source().begin.line));
  }
  const toml::table* root = &document->root;
  return SettingsReader(
      SettingsTable(std::move(document), std::make_shared<const SettingsTable::Place>(SettingsTable::Place{root, ""})));
}

base::Status SettingsReader::finish() const {
  SettingsTable::Document& document = *root_.document_;
  document.refuse_unknown(document.root);
  std::vector<SettingsTable::Document::Mistake> mistakes = std::move(document.mistakes);
  document.mistakes.clear();
  if (mistakes.empty()) return {};
  std::stable_sort(mistakes.begin(), mistakes.end(), [](const auto& a, const auto& b) { return a.line < b.line; });
  const auto place = [&](std::uint32_t line) {
    return line ? fmt::format("{}:{}", document.file, line) : document.file;
  };
  if (mistakes.size() == 1) return base::bad_input(mistakes.front().text, place(mistakes.front().line));
  std::string text = fmt::format("{} mistakes", mistakes.size());
  for (const auto& mistake : mistakes) text += fmt::format("\n{}: {}", place(mistake.line), mistake.text);
  return base::bad_input(std::move(text), document.file);
}

base::Result<std::string> read_settings_text(const std::string& file) {
  std::ifstream stream(file, std::ios::binary);
  stream.peek();  // a folder can be opened, but not read
  if (stream.fail()) return base::bad_input("cannot read the file", file);
  std::string text(kLongestText + 1, '\0');
  stream.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<std::size_t>(stream.gcount()));
  return text;
}

}  // namespace soak::hal
