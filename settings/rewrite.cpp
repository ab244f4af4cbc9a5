// SPDX-License-Identifier: Apache-2.0
#include "settings/rewrite.h"

#include <fmt/format.h>

#include <toml++/toml.h>
#include <algorithm>
#include <cstddef>
#include <sstream>
#include <type_traits>
#include <utility>

#include "settings/text_edits.h"

namespace soak::settings {
namespace {

/// As TOML has it; a list in one line, a text with line ends over several.
std::string text_of(const Value& value) {
  constexpr auto kFlags = toml::format_flags::allow_multi_line_strings | toml::format_flags::allow_unicode_strings;
  const auto one = [](const auto& item) {
    std::ostringstream out;
    out << toml::toml_formatter{toml::value{item}, kFlags};
    return out.str();
  };
  if (const auto* list = std::get_if<std::vector<double>>(&value)) {
    std::string text;
    for (const double item : *list) text += (text.empty() ? "" : ", ") + one(item);
    return "[" + text + "]";
  }
  return std::visit(
      [&](const auto& item) -> std::string {
        if constexpr (std::is_same_v<std::decay_t<decltype(item)>, std::vector<double>>) {
          return {};
        } else {
          return one(item);
        }
      },
      value);
}

/// What the text shall read back as. Fails where a name that shall be a table is none.
bool apply(toml::table& root, const KeyChange& change) {
  if (!change.table.empty() && !root.contains(change.table)) {
    if (!change.value) return true;
    root.insert(change.table, toml::table{});
  }
  toml::table* table = change.table.empty() ? &root : root.get_as<toml::table>(change.table);
  if (table == nullptr) return false;
  table->erase(change.key);
  if (!change.value) return true;
  std::visit(
      [&](const auto& item) {
        if constexpr (std::is_same_v<std::decay_t<decltype(item)>, std::vector<double>>) {
          toml::array list;
          for (const double number : item) list.push_back(number);
          table->insert(change.key, std::move(list));
        } else {
          table->insert(change.key, item);
        }
      },
      *change.value);
  return true;
}

/// Where a key is put that a table has not yet: below its header, at the top above the first key.
std::size_t place_for_key(std::string_view text, const toml::table& table, bool is_root) {
  if (!is_root) return end_of_line(text, offset_of(text, table.source().begin));
  std::size_t first = text.size();
  for (const auto& [key, node] : table) first = std::min(first, offset_of(text, key.source().begin));
  return begin_of_line(text, first);
}

/// The edit for a change; nothing where there is nothing to do.
std::optional<Edit> edit_for(std::string_view text, const toml::table& root, const KeyChange& change) {
  const bool is_root = change.table.empty();
  const toml::table* table = is_root ? &root : root.get_as<toml::table>(change.table);
  const auto found = table ? table->find(change.key) : toml::table::const_iterator{};
  if (table && found != table->cend()) {
    const std::size_t begin = offset_of(text, found->second.source().begin);
    const std::size_t end = offset_of(text, found->second.source().end);
    if (change.value) return Edit{begin, end, text_of(*change.value)};
    return Edit{begin_of_line(text, offset_of(text, found->first.source().begin)), end_of_line(text, end), ""};
  }
  if (!change.value) return std::nullopt;
  const std::string line = change.key + " = " + text_of(*change.value) + "\n";
  if (!table) return Edit{text.size(), text.size(), "\n[" + change.table + "]\n" + line};
  const std::size_t at = place_for_key(text, *table, is_root);
  return Edit{at, at, line};
}

}  // namespace

base::Result<std::string> rewritten(std::string_view text, const std::string& file,
                                    const std::vector<KeyChange>& changes) {
  toml::table root;
  try {
    root = toml::parse(text);
  } catch (const toml::parse_error& error) {
    return base::bad_input(std::string(error.description()), file);
  }
  std::string whole(text);
  if (!whole.empty() && whole.back() != '\n') whole += '\n';
  toml::table wanted = root;
  std::vector<Edit> edits;
  for (const KeyChange& change : changes) {
    if (!apply(wanted, change)) return base::bad_input(fmt::format("'{}' is no table", change.table), file);
    if (auto edit = edit_for(whole, root, change)) edits.push_back(*std::move(edit));
  }
  std::string by_lines = edited(whole, std::move(edits));
  if (reads_as(by_lines, wanted)) return by_lines;
  std::ostringstream anew;
  anew << wanted << '\n';
  return anew.str();
}

}  // namespace soak::settings
