// SPDX-License-Identifier: Apache-2.0
#include "settings/sections.h"

#include <algorithm>

#include "settings/text_edits.h"

namespace soak::settings {
namespace {

using Keys = std::vector<std::pair<std::string, std::string>>;

const std::string* value_in(const Keys& keys, const std::string& key) {
  const auto found = std::ranges::find(keys, key, &std::pair<std::string, std::string>::first);
  return found == keys.end() ? nullptr : &found->second;
}

const Section* same_in(const std::vector<Section>& sections, const Section& section) {
  const auto found = std::ranges::find_if(
      sections, [&](const Section& one) { return one.table == section.table && one.index == section.index; });
  return found == sections.end() ? nullptr : &*found;
}

base::Result<toml::table> parsed(std::string_view text) {
  try {
    return toml::parse(text);
  } catch (const toml::parse_error& error) {
    return base::bad_input(std::string(error.description()), "");
  }
}

/// The table that a section is about; null where the text has none.
template <class Node>
auto table_of(Node& root, const Section& section) -> decltype(root.as_table()) {
  auto node = root.at_path(section.table);
  if (!section.index) return node.as_table();
  auto* list = node.as_array();
  if (list == nullptr || *section.index >= list->size()) return nullptr;
  return list->get(*section.index)->as_table();
}

/// The table of a section in `root`, made where it is not there yet; null where something else stands in its place.
toml::table* make_table(toml::table& root, const Section& section) {
  if (auto* there = table_of(root, section)) return there;
  toml::table* inside = &root;
  std::string_view rest = section.table;
  for (std::size_t dot = rest.find('.'); dot != std::string_view::npos; dot = rest.find('.')) {
    inside = inside->insert(rest.substr(0, dot), toml::table{}).first->second.as_table();
    if (inside == nullptr) return nullptr;
    rest.remove_prefix(dot + 1);
  }
  if (!section.index) return inside->insert(rest, toml::table{}).first->second.as_table();
  toml::array* list = inside->insert(rest, toml::array{}).first->second.as_array();
  if (list == nullptr) return nullptr;
  list->push_back(toml::table{});
  return list->back().as_table();
}

/// Takes a table out, and of what it stood in what is then empty.
void drop_table(toml::table& root, const Section& section) {
  const std::size_t dot = section.table.rfind('.');
  const std::string last = section.table.substr(dot == std::string::npos ? 0 : dot + 1);
  toml::table* inside = dot == std::string::npos ? &root : root.at_path(section.table.substr(0, dot)).as_table();
  if (inside == nullptr) return;
  if (auto* list = section.index ? inside->get_as<toml::array>(last) : nullptr) {
    list->erase(list->begin() + static_cast<std::ptrdiff_t>(*section.index));
    if (!list->empty()) return;
  }
  inside->erase(last);
  if (inside != &root && inside->empty()) root.erase(section.table.substr(0, dot));
}

/// Edits of one text, and the table that it shall read back as.
class Changes {
 public:
  Changes(std::string_view text, toml::table root) : text_(text), root_(std::move(root)), wanted_(root_) {}

  /// Whether it can be.
  bool change(const Section& section, const Keys& before) {
    toml::table* wanted = make_table(wanted_, section);
    const toml::table* table = table_of(root_, section);
    if (wanted == nullptr || (table != nullptr && !begins_with_header(section, *table))) return false;
    std::string more;
    for (const auto& [key, value] : section.keys) {
      const std::string* old = value_in(before, key);
      if (old != nullptr && *old == value) continue;
      set(*wanted, key, value);
      if (table == nullptr || !table->contains(key)) {
        more.append(key).append(" = ").append(value).append("\n");
      } else {
        replace(*table, key, value);
      }
    }
    for (const auto& [key, value] : before) {
      if (value_in(section.keys, key) != nullptr) continue;
      wanted->erase(key);
      if (table != nullptr && table->contains(key)) take_out(*table, key);
    }
    if (table == nullptr) {
      add_section(section, more);
    } else if (!more.empty()) {
      const std::size_t at = end_of(*table);
      edits_.push_back({at, at, more});
    }
    return true;
  }

  bool drop(const Section& section) {
    const toml::table* table = table_of(root_, section);
    if (table == nullptr) return true;
    const bool is_whole = std::ranges::all_of(
        *table, [&](const auto& entry) { return value_in(section.keys, std::string(entry.first.str())) != nullptr; });
    Section rest{section.table, section.index, {}};
    if (!is_whole) return change(rest, section.keys);
    if (!begins_with_header(section, *table)) return false;
    drop_table(wanted_, section);
    std::size_t begin = header_at(*table);
    if (text_.substr(0, begin).ends_with("\n\n")) --begin;  // the empty line above it
    edits_.push_back({begin, end_of(*table), ""});
    return true;
  }

  /// Nothing where the lines do not give what is wanted.
  [[nodiscard]] std::optional<std::string> take() {
    std::string by_lines = edited(text_, std::move(edits_));
    return reads_as(by_lines, wanted_) ? std::optional(std::move(by_lines)) : std::nullopt;
  }

 private:
  [[nodiscard]] std::size_t header_at(const toml::table& table) const {
    return begin_of_line(text_, offset_of(text_, table.source().begin));
  }

  /// Its keys can be lines of their own then.
  [[nodiscard]] bool begins_with_header(const Section& section, const toml::table& table) const {
    const std::size_t begin = header_at(table);
    std::string_view line = text_.substr(begin, end_of_line(text_, begin) - begin);
    line.remove_prefix(std::min(line.size(), line.find_first_not_of(" \t")));
    return line.starts_with(header_of(section));
  }

  /// Behind the line of its last key.
  [[nodiscard]] std::size_t end_of(const toml::table& table) const {
    std::size_t end = end_of_line(text_, header_at(table));
    for (const auto& [key, node] : table) end = std::max(end, end_of_line(text_, offset_of(text_, node.source().end)));
    return end;
  }

  static void set(toml::table& table, const std::string& key, const std::string& value) {
    table.erase(key);
    const toml::table one = toml::parse(key + " = " + value);
    one.get(key)->visit([&](const auto& node) { table.insert(key, node); });
  }

  void replace(const toml::table& table, const std::string& key, const std::string& value) {
    const toml::source_region& place = table.get(key)->source();
    edits_.push_back({offset_of(text_, place.begin), offset_of(text_, place.end), value});
  }

  void take_out(const toml::table& table, const std::string& key) {
    const auto found = table.find(key);
    const std::size_t begin = begin_of_line(text_, offset_of(text_, found->first.source().begin));
    edits_.push_back({begin, end_of_line(text_, offset_of(text_, found->second.source().end)), ""});
  }

  void add_section(const Section& section, const std::string& lines) {
    std::size_t at = text_.size();
    if (section.index) {
      const auto* list = root_.at_path(section.table).as_array();
      const toml::table* last = list == nullptr || list->empty() ? nullptr : list->back().as_table();
      if (last != nullptr) at = end_of(*last);
    }
    edits_.push_back({at, at, "\n" + header_of(section) + "\n" + lines});
  }

  std::string_view text_;
  toml::table root_;
  toml::table wanted_;
  std::vector<Edit> edits_;
};

}  // namespace

std::string header_of(const Section& section) {
  return section.index ? "[[" + section.table + "]]" : "[" + section.table + "]";
}

std::vector<std::string> keys_beyond(std::string_view text, const Section& section) {
  const base::Result<toml::table> root = parsed(text);
  const toml::table* table = root ? table_of(*root, section) : nullptr;
  std::vector<std::string> keys;
  if (table == nullptr) return keys;
  for (const auto& [key, value] : *table) {
    std::string name(key.str());
    if (value_in(section.keys, name) == nullptr) keys.push_back(std::move(name));
  }
  return keys;
}

base::Result<std::string> with_sections(std::string_view text, const std::string& file,
                                        const std::vector<Section>& before, const std::vector<Section>& after) {
  std::string whole(text);
  auto root = parsed(text);
  if (!root) return base::bad_input(root.error().message, file);
  const auto is_changed = [&](const Section& section) {
    const Section* old = same_in(before, section);
    return old == nullptr || old->keys != section.keys;
  };
  const bool is_same = before.size() == after.size() && std::ranges::none_of(after, is_changed);
  if (is_same) return whole;
  if (!whole.empty() && whole.back() != '\n') whole += '\n';
  Changes changes(whole, *std::move(root));
  bool can = true;
  for (const Section& section : after) {
    const Section* old = same_in(before, section);
    if (is_changed(section)) can = can && changes.change(section, old == nullptr ? Keys{} : old->keys);
  }
  // From the end on: what stands before keeps its place.
  for (auto section = before.rbegin(); section != before.rend(); ++section) {
    if (same_in(after, *section) == nullptr) can = can && changes.drop(*section);
  }
  auto changed = can ? changes.take() : std::nullopt;
  if (!changed) {
    return base::bad_input("it is written in a way in which no change of single lines does that: change it there",
                           file);
  }
  return *std::move(changed);
}

}  // namespace soak::settings
