// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>
#include <vector>

namespace soak::station::html {

/// The text as HTML shows it verbatim, in elements and in quoted attributes; control characters become U+FFFD.
[[nodiscard]] std::string escaped(std::string_view text);

/// Three significant digits, with a power of ten below 1e-5 and from 1e9 on, and a true minus sign.
[[nodiscard]] std::string number_text(double value);

/// `<data value="exact">0.0123</data>`: three digits for people, all of them for scripts. A dash where the value is
/// null.
[[nodiscard]] std::string number(const nlohmann::json& value);
[[nodiscard]] std::string number(double value);

/// The same with so many decimals.
[[nodiscard]] std::string number(double value, int decimals);

/// A member of an object as escaped text; a dash where it is absent or null. Numbers are written shortest.
[[nodiscard]] std::string text_of(const nlohmann::json& object, std::string_view key);

/// The member of an object; null where it is absent.
[[nodiscard]] const nlohmann::json& member(const nlohmann::json& object, std::string_view key);

/// "2027-11-22 13:12 UTC"; a dash for null.
[[nodiscard]] std::string date_time(const nlohmann::json& utc_s);

/// "20 h 00 min", "4 min 20 s", "12 s".
[[nodiscard]] std::string duration(double seconds);

/// A unit as people write it: "m/s²" for "m/s2", "°/s" for "deg/s"; also the units in a sentence. Escaped.
[[nodiscard]] std::string unit_text(std::string_view unit);

/// What the station says, for who does not work at it: escaped, with units as people write them and without the
/// commands of a terminal, which stand in brackets: "('soak reference add --kind level')".
[[nodiscard]] std::string said(std::string_view text);

/// A cell of a table; `html` is taken as it is.
struct Cell {
  std::string html{};
  bool number = false;   ///< kept on one line
  bool heading = false;  ///< names its row
  std::string style{};   ///< class
};
[[nodiscard]] Cell text_cell(std::string_view text);          ///< escaped
[[nodiscard]] Cell row_heading(std::string_view text);        ///< escaped
[[nodiscard]] Cell number_cell(const nlohmann::json& value);  ///< number()
[[nodiscard]] Cell html_cell(std::string html, bool number = false);

/// How a table meets a narrow screen: it scrolls, or each row becomes a list in which each cell has its heading.
enum class Narrow { scrolls, stacks };

/// A table with a caption and headed columns. Captions and headings are escaped.
class Table {
 public:
  Table(std::string_view caption, const std::vector<std::string>& headings, Narrow narrow = Narrow::scrolls);
  void row(const std::vector<Cell>& cells);
  [[nodiscard]] std::string html() const;

 private:
  std::vector<std::string> headings_;  ///< escaped
  Narrow narrow_;
  std::string head_;
  std::string rows_;
};

/// A description list: terms (escaped) and what they are (HTML).
[[nodiscard]] std::string facts(const std::vector<std::pair<std::string, std::string>>& list);

}  // namespace soak::station::html
