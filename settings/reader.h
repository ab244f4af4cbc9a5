// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "base/result.h"

/// TOML files whose mistakes are all told at once, each with its line.
namespace soak::settings {

/// Limits that a number keeps, both ends allowed.
struct Limits {
  double low;
  double high;
};

/// For calls that take `required`.
inline constexpr bool kRequired = true;

/// What stands under a key; `other`: a date, a time.
enum class Kind : std::uint8_t { absent, text, whole, real, flag, list, table, other };

/// One table of a TOML text that is being read. Every call that finds a mistake (a key missing, of another type, out of
/// its limits) records it with its line and returns the fallback or a zero, so that a reader can ask for all keys in a
/// row and report all mistakes at once. Copies are cheap and read the same text.
class Table {
 public:
  [[nodiscard]] bool has(std::string_view key) const { return kind(key) != Kind::absent; }
  [[nodiscard]] Kind kind(std::string_view key) const;
  /// Keys in the order of the text. Asking for them does not count as reading them.
  [[nodiscard]] std::vector<std::string> keys() const;

  /// Without `fallback` the key is required.
  [[nodiscard]] double number(std::string_view key, Limits limits, std::optional<double> fallback = {}) const;
  [[nodiscard]] int whole(std::string_view key, Limits limits, std::optional<int> fallback = {}) const;
  /// A whole number beyond the range of int, as a seed; required.
  [[nodiscard]] std::int64_t large_whole(std::string_view key, Limits limits) const;
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
  [[nodiscard]] std::optional<Table> table(std::string_view key, bool required = false) const;
  /// As table(), but in place of an absent one a table in which every key has its fallback and none is missing.
  [[nodiscard]] Table section(std::string_view key, bool required = false) const;
  /// An array of tables ([[key]]); an absent one is empty.
  [[nodiscard]] std::vector<Table> tables(std::string_view key) const;

  /// Records a mistake at the line of `key`, or of the table where it has no such key. Each key has one mistake: what
  /// is said of it later follows from the first.
  void refuse(std::string_view key, std::string message) const;
  /// Refuses every key but these and says which are known. Without it an unread key is refused by its name alone.
  void allow_only(const std::vector<std::string_view>& known, std::string_view hint = "") const;

 private:
  friend class Reader;
  struct Document;
  struct Place;
  Table(std::shared_ptr<Document> document, std::shared_ptr<const Place> place);
  [[nodiscard]] std::size_t choice_index(std::string_view key, const std::vector<std::string_view>& names) const;

  std::shared_ptr<Document> document_;
  std::shared_ptr<const Place> place_;
};

/// Longest text that is read where nothing else is said: many times what anyone writes by hand. The length also bounds
/// how deep keys may be nested, and with it the stack that the parser needs.
inline constexpr std::size_t kLongestText = 32768;

/// Reads a TOML text: parse(), ask root() for everything that the format knows, then finish(). read() and read_file()
/// do all three.
class Reader {
 public:
  /// Refuses (bad_input) a syntax error with "`file`:line": the first one.
  [[nodiscard]] static base::Result<Reader> parse(std::string_view text, std::string file,
                                                  std::size_t longest = kLongestText);

  [[nodiscard]] const Table& root() const { return root_; }
  /// Success, or all mistakes in the order of lines, one per line of the message as "file:line: what is wrong". A key
  /// that nobody asked for is one. With one mistake, the message has no place in it; `where` is "file:line".
  [[nodiscard]] base::Status finish() const;

 private:
  explicit Reader(Table root) : root_(std::move(root)) {}
  Table root_;
};

/// The content of a text file, up to one byte more than `longest`; one that cannot be read is bad_input.
[[nodiscard]] base::Result<std::string> read_text(const std::string& file, std::size_t longest = kLongestText);

/// A file or folder that Soak comes with: share/soak/`name` beside the bin/ in which the running program lies, as a
/// package has installed it; where there is none, `in_checkout`.
[[nodiscard]] std::string shipped(const std::string& name, const std::string& in_checkout);

/// What `read_root` makes of the root table, or all mistakes. It sees a table with mistakes as well.
template <class ReadRoot>
[[nodiscard]] auto read(std::string_view text, const std::string& file, ReadRoot&& read_root,
                        std::size_t longest = kLongestText)
    -> base::Result<std::invoke_result_t<ReadRoot, const Table&>> {
  const auto reader = Reader::parse(text, file, longest);
  if (!reader) return base::forward_error(reader);
  auto value = read_root(reader->root());
  if (const auto status = reader->finish(); !status) return base::forward_error(status);
  return value;
}

/// As read(), of a file.
template <class ReadRoot>
[[nodiscard]] auto read_file(const std::string& file, ReadRoot&& read_root, std::size_t longest = kLongestText)
    -> base::Result<std::invoke_result_t<ReadRoot, const Table&>> {
  const auto text = read_text(file, longest);
  if (!text) return base::forward_error(text);
  return read(*text, file, std::forward<ReadRoot>(read_root), longest);
}

}  // namespace soak::settings
