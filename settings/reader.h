// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/result.h"

namespace soak::hal {

/// Limits that a number keeps, both ends allowed.
struct Limits {
  double low;
  double high;
};

/// One table of a TOML text that is being read. Every call that finds a mistake (a key missing, of another type, out of
/// its limits) records it with its line and returns the fallback or a zero, so that a reader can ask for all keys in a
/// row and report all mistakes at once. Copies are cheap and read the same text.
class SettingsTable {
 public:
  [[nodiscard]] bool has(std::string_view key) const;
  /// Keys in the order of the text. Asking for them does not count as reading them.
  [[nodiscard]] std::vector<std::string> keys() const;

  /// Without `fallback` the key is required.
  [[nodiscard]] double number(std::string_view key, Limits limits, std::optional<double> fallback = {}) const;
  [[nodiscard]] int whole(std::string_view key, Limits limits, std::optional<int> fallback = {}) const;
  [[nodiscard]] std::string text(std::string_view key, const std::optional<std::string>& fallback = {}) const;
  [[nodiscard]] bool flag(std::string_view key, std::optional<bool> fallback = {}) const;
  [[nodiscard]] std::optional<double> optional_number(std::string_view key, Limits limits) const;
  [[nodiscard]] std::optional<int> optional_whole(std::string_view key, Limits limits) const;
  /// Lists; an absent key gives an empty list unless `required`.
  [[nodiscard]] std::vector<double> numbers(std::string_view key, Limits limits, bool required = false) const;
  [[nodiscard]] std::vector<int> wholes(std::string_view key, Limits limits, bool required = false) const;
  [[nodiscard]] std::vector<std::string> texts(std::string_view key, bool required = false) const;
  /// One of a few words.
  template <class T>
  [[nodiscard]] T choice(std::string_view key, const std::vector<std::pair<std::string_view, T>>& words,
                         std::optional<T> fallback = {}) const {
    if (fallback && !has(key)) return *fallback;
    std::vector<std::string_view> names;
    for (const auto& [name, value] : words) names.push_back(name);
    const std::size_t index = choice_index(key, names);
    return index < words.size() ? words[index].second : T{};
  }

  /// The table under `key`; an absent one is nothing, and a mistake if `required`.
  [[nodiscard]] std::optional<SettingsTable> table(std::string_view key, bool required = false) const;
  /// An array of tables ([[key]]); an absent one is empty.
  [[nodiscard]] std::vector<SettingsTable> tables(std::string_view key) const;

  /// Records a mistake at the line of `key`, or of the table where it has no such key. Each key has one mistake: what
  /// is said of it later follows from the first.
  void refuse(std::string_view key, std::string message) const;

 private:
  friend class SettingsReader;
  struct Document;
  struct Place;
  SettingsTable(std::shared_ptr<Document> document, std::shared_ptr<const Place> place);
  [[nodiscard]] std::size_t choice_index(std::string_view key, const std::vector<std::string_view>& names) const;

  std::shared_ptr<Document> document_;
  std::shared_ptr<const Place> place_;
};

/// Reads a TOML text: parse(), ask root() for everything that the format knows, then finish().
class SettingsReader {
 public:
  /// Refuses (bad_input) a syntax error with "`file`:line": the first one.
  [[nodiscard]] static base::Result<SettingsReader> parse(std::string_view text, std::string file);

  [[nodiscard]] const SettingsTable& root() const { return root_; }
  /// Success, or all mistakes in the order of lines, one per line of the message as "file:line: what is wrong". A key
  /// that nobody asked for is one. With one mistake, the message has no place in it; `where` is "file:line".
  [[nodiscard]] base::Status finish() const;

 private:
  explicit SettingsReader(SettingsTable root) : root_(std::move(root)) {}
  SettingsTable root_;
};

/// The content of a text file; one that cannot be read is bad_input.
[[nodiscard]] base::Result<std::string> read_settings_text(const std::string& file);

}  // namespace soak::hal
