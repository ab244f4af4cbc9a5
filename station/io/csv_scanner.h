// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <deque>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"

namespace soak::station {

/// The bytes with which some programs begin a UTF-8 file.
inline constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";

/// Splits text into the rows and cells of RFC 4180: cells in double quotes may hold separators, doubled quotes and line
/// ends. Accepts LF and CRLF. Lines without any character are passed over. Does not own the text.
class CsvScanner {
 public:
  CsvScanner(std::string_view text, char separator) : text_(text), separator_(separator) {}

  /// The next row; false at the end of the text. The cells point into the text or into this object and stay valid until
  /// the next call. Refuses a quoted cell that does not end (where = "line N").
  [[nodiscard]] base::Result<bool> next(std::vector<std::string_view>& cells);

  /// Number of the line, from 1, at which the last row began.
  [[nodiscard]] std::size_t line() const { return line_; }
  /// Characters passed so far.
  [[nodiscard]] std::size_t offset() const { return offset_; }
  /// Whether a line end followed the last row.
  [[nodiscard]] bool row_was_ended() const { return row_was_ended_; }

 private:
  std::string_view plain_line();
  void split_plain(std::string_view line, std::vector<std::string_view>& cells) const;
  base::Result<bool> next_quoted(std::vector<std::string_view>& cells);
  bool read_quoted_cell(std::string& cell);

  std::string_view text_;
  char separator_;
  std::size_t offset_ = 0;
  std::size_t line_ = 0;
  std::size_t next_line_ = 1;
  bool row_was_ended_ = true;
  std::deque<std::string> unquoted_;
};

/// `text` without the blanks around it.
[[nodiscard]] std::string_view trimmed(std::string_view text);

/// `text` as one cell of a comma-separated row: in quotes where it needs them to be read back verbatim.
[[nodiscard]] std::string csv_cell(std::string_view text);

}  // namespace soak::station
