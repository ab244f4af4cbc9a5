// SPDX-License-Identifier: Apache-2.0
#include "settings/reader.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <toml++/toml.h>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <set>
#include <system_error>

namespace soak::settings {

struct Table::Place {
  const toml::table* table;   ///< null = the section is absent
  std::string name;           ///< for messages: "" for the root, else "stability."
  bool told_missing = false;  ///< an absent one that is a mistake already: what follows from it is none
};

struct Table::Document {
  struct Mistake {
    std::uint32_t line;
    std::string text;
  };

  toml::table root;
  std::string file;
  std::set<const toml::node*> asked;
  std::set<const toml::table*> opened;  ///< tables whose keys were to be read
  std::set<const toml::node*> refused;
  std::set<std::string> missing;
  std::set<std::string, std::less<>> wanted_at_top;  ///< keys above the first section that were looked for
  std::vector<Mistake> mistakes;

  void mistake(const toml::source_region& source, std::string text) {
    mistakes.push_back({source.begin.line, std::move(text)});
  }

  /// The node under a key, from now on a known one; an absent one is a mistake if `required`, once.
  const toml::node* find(const Place& place, std::string_view key, bool required) {
    if (!place.table) return nullptr;
    const toml::node* node = place.table->get(key);
    if (node) asked.insert(node);
    if (!node && place.table == &root) wanted_at_top.emplace(key);
    if (!node && required && missing.insert(fmt::format("{}{}", place.name, key)).second) {
      mistake(place.table->source(), fmt::format("key '{}{}' is missing", place.name, key));
    }
    return node;
  }

  /// The value under a key as `convert` makes it of a node, where it can; `wanted` says what it must be.
  template <class T, class Convert>
  static T scalar(const Table& table, std::string_view key, const std::optional<T>& fallback, Convert convert,
                  const std::string& wanted) {
    const toml::node* node = table.document_->find(*table.place_, key, !fallback);
    if (!node) return fallback.value_or(T{});
    const std::optional<T> value = convert(*node);
    if (!value) table.refuse(key, fmt::format("'{}{}' must be {}", table.place_->name, key, wanted));
    return value.value_or(fallback.value_or(T{}));
  }

  template <class T, class Convert>
  static std::vector<T> list(const Table& table, std::string_view key, bool required, Convert convert,
                             const std::string& wanted) {
    const toml::node* node = table.document_->find(*table.place_, key, required);
    if (!node) return {};
    std::vector<T> values;
    const toml::array* array = node->as_array();
    bool good = array != nullptr;
    for (std::size_t i = 0; good && i < array->size(); ++i) {
      const std::optional<T> value = convert(*array->get(i));
      good = value.has_value();
      if (good) values.push_back(*value);
    }
    if (!good) table.refuse(key, fmt::format("'{}{}' must be a list of {}", table.place_->name, key, wanted));
    return values;
  }

  /// Where a key stands that belongs above the first section: `wanted` has those that were looked for there.
  [[nodiscard]] std::string place_of(const toml::table& table, std::string_view key) const {
    if (&table == &root || !wanted_at_top.contains(std::string(key))) return {};
    return " here: it belongs above the first [section] of the file";
  }

  void refuse_unknown(const toml::table& table) {
    for (const auto& [key, node] : table) {
      if (!asked.contains(&node)) {
        mistake(key.source(), fmt::format("unknown key '{}'{}", key.str(), place_of(table, key.str())));
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

auto number_in(Limits limits) {
  return [limits](const toml::node& node) -> std::optional<double> {
    const auto value = node.is_number() ? node.value<double>() : std::nullopt;
    if (!value || !std::isfinite(*value) || *value < limits.low || *value > limits.high) return std::nullopt;
    return value;
  };
}

template <class T>
auto whole_in(Limits limits) {
  return [limits](const toml::node& node) -> std::optional<T> {
    const auto value = node.value_exact<std::int64_t>();
    if (!value || static_cast<double>(*value) < limits.low || static_cast<double>(*value) > limits.high) {
      return std::nullopt;
    }
    return static_cast<T>(*value);
  };
}

template <class T>
std::optional<T> exactly(const toml::node& node) {
  return node.value_exact<T>();
}

}  // namespace

Table::Table(std::shared_ptr<Document> document, std::shared_ptr<const Place> place)
    : document_(std::move(document)), place_(std::move(place)) {}

Kind Table::kind(std::string_view key) const {
  const toml::node* node = place_->table ? place_->table->get(key) : nullptr;
  if (!node) return Kind::absent;
  switch (node->type()) {
    case toml::node_type::string:
      return Kind::text;
    case toml::node_type::integer:
      return Kind::whole;
    case toml::node_type::floating_point:
      return Kind::real;
    case toml::node_type::boolean:
      return Kind::flag;
    case toml::node_type::array:
      return Kind::list;
    case toml::node_type::table:
      return Kind::table;
    default:
      return Kind::other;
  }
}

std::vector<std::string> Table::keys() const {
  std::vector<std::pair<toml::source_position, std::string>> found;
  if (place_->table) {
    for (const auto& [key, node] : *place_->table) found.emplace_back(key.source().begin, std::string(key.str()));
  }
  std::sort(found.begin(), found.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<std::string> names;
  for (auto& [position, name] : found) names.push_back(std::move(name));
  return names;
}

void Table::refuse(std::string_view key, std::string message) const {
  if (!place_->table) {
    if (!place_->told_missing) document_->mistake({}, std::move(message));
    return;
  }
  const toml::node* node = place_->table->get(key);
  if (node && !document_->refused.insert(node).second) return;
  if (node) document_->asked.insert(node);
  document_->mistake(node ? node->source() : place_->table->source(), std::move(message));
}

void Table::allow_only(const std::vector<std::string_view>& known, std::string_view hint) const {
  for (const std::string& key : keys()) {
    if (std::find(known.begin(), known.end(), key) != known.end()) continue;
    refuse(key, fmt::format("unknown key '{}{}': known are {}{}", place_->name, key, fmt::join(known, ", "), hint));
  }
}

double Table::number(std::string_view key, Limits limits, std::optional<double> fallback) const {
  return Document::scalar<double>(*this, key, fallback, number_in(limits), "a number " + range_text(limits));
}

int Table::whole(std::string_view key, Limits limits, std::optional<int> fallback) const {
  return Document::scalar<int>(*this, key, fallback, whole_in<int>(limits), "a whole number " + range_text(limits));
}

std::int64_t Table::large_whole(std::string_view key, Limits limits) const {
  return Document::scalar<std::int64_t>(*this, key, {}, whole_in<std::int64_t>(limits),
                                        "a whole number " + range_text(limits));
}

std::string Table::text(std::string_view key, const std::optional<std::string>& fallback) const {
  return Document::scalar<std::string>(*this, key, fallback, exactly<std::string>, "a text in quotes");
}

bool Table::flag(std::string_view key, std::optional<bool> fallback) const {
  return Document::scalar<bool>(*this, key, fallback, exactly<bool>, "true or false");
}

std::optional<double> Table::optional_number(std::string_view key, Limits limits) const {
  return has(key) ? std::optional(number(key, limits)) : std::nullopt;
}

std::optional<int> Table::optional_whole(std::string_view key, Limits limits) const {
  return has(key) ? std::optional(whole(key, limits)) : std::nullopt;
}

std::vector<double> Table::numbers(std::string_view key, Limits limits, bool required) const {
  return Document::list<double>(*this, key, required, number_in(limits), "numbers " + range_text(limits));
}

std::vector<int> Table::wholes(std::string_view key, Limits limits, bool required) const {
  return Document::list<int>(*this, key, required, whole_in<int>(limits), "whole numbers " + range_text(limits));
}

std::vector<std::string> Table::texts(std::string_view key, bool required) const {
  return Document::list<std::string>(*this, key, required, exactly<std::string>, "texts in quotes");
}

std::size_t Table::choice_index(std::string_view key, const std::vector<std::string_view>& names) const {
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

std::optional<Table> Table::table(std::string_view key, bool required) const {
  const toml::node* node = document_->find(*place_, key, required);
  if (!node) return std::nullopt;
  const toml::table* inner = node->as_table();
  if (!inner) {
    refuse(key, fmt::format("'{}{}' must be a table", place_->name, key));
    return std::nullopt;
  }
  document_->opened.insert(inner);
  return Table(document_, std::make_shared<const Place>(Place{inner, fmt::format("{}{}.", place_->name, key)}));
}

Table Table::section(std::string_view key, bool required) const {
  if (auto found = table(key, required)) return *std::move(found);
  return Table(document_, std::make_shared<const Place>(
                              Place{nullptr, fmt::format("{}{}.", place_->name, key), required || has(key)}));
}

std::vector<Table> Table::tables(std::string_view key) const {
  constexpr bool required = false;
  const toml::node* node = document_->find(*place_, key, required);
  if (!node) return {};
  std::vector<Table> tables;
  const toml::array* array = node->as_array();
  bool good = array != nullptr;
  for (std::size_t i = 0; good && i < array->size(); ++i) {
    const toml::table* inner = array->get(i)->as_table();
    good = inner != nullptr;
    if (good) {
      const std::string name = fmt::format("{}{}[{}].", place_->name, key, i + 1);
      document_->opened.insert(inner);
      tables.push_back(Table(document_, std::make_shared<const Place>(Place{inner, name})));
    }
  }
  if (!good) refuse(key, fmt::format("'{}{}' must be an array of tables, [[{}]]", place_->name, key, key));
  return tables;
}

base::Result<Reader> Reader::parse(std::string_view text, std::string file, std::size_t longest) {
  if (text.size() > longest) {
    return base::bad_input(fmt::format("longer than {} bytes: this is not a settings file", longest), file);
  }
  auto document = std::make_shared<Table::Document>();
  document->file = std::move(file);
  try {
    document->root = toml::parse(text);
  } catch (const toml::parse_error& error) {
    return base::bad_input(std::string(error.description()),
                           fmt::format("{}:{}", document->file, error.source().begin.line));
  }
  const toml::table* root = &document->root;
  return Reader(Table(std::move(document), std::make_shared<const Table::Place>(Table::Place{root, ""})));
}

base::Status Reader::finish() const {
  Table::Document& document = *root_.document_;
  document.refuse_unknown(document.root);
  std::vector<Table::Document::Mistake> mistakes = std::move(document.mistakes);
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

base::Result<std::string> read_text(const std::string& file, std::size_t longest) {
  std::ifstream stream(file, std::ios::binary);
  stream.peek();  // a folder can be opened, but not read
  if (stream.fail()) return base::bad_input("cannot read the file", file);
  std::string text(longest + 1, '\0');
  stream.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<std::size_t>(stream.gcount()));
  return text;
}

std::string shipped(const std::string& name, const std::string& in_checkout) {
  std::error_code none;
  const auto program = std::filesystem::read_symlink("/proc/self/exe", none);
  const auto installed = program.parent_path().parent_path() / "share/soak" / name;
  return std::filesystem::exists(installed, none) ? installed.string() : in_checkout;
}

}  // namespace soak::settings
