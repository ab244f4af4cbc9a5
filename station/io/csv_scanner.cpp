// SPDX-License-Identifier: Apache-2.0
#include "station/io/csv_scanner.h"

#include <fmt/format.h>

#include <cstring>

namespace soak::station {

base::Result<bool> CsvScanner::next(std::vector<std::string_view>& cells) {
  cells.clear();
  unquoted_.clear();
  while (offset_ < text_.size()) {
    line_ = next_line_;
    const std::size_t start = offset_;
    const std::string_view line = plain_line();
    if (line.empty()) continue;
    if (std::memchr(line.data(), '"', line.size()) == nullptr) {
      split_plain(line, cells);
      return true;
    }
    offset_ = start;
    next_line_ = line_;
    return next_quoted(cells);
  }
  return false;
}

std::string_view CsvScanner::plain_line() {
  const std::string_view rest = text_.substr(offset_);
  const std::size_t end = rest.find('\n');
  row_was_ended_ = end != std::string_view::npos;
  std::string_view line = rest.substr(0, end);
  offset_ += line.size() + (row_was_ended_ ? 1 : 0);
  ++next_line_;
  if (line.ends_with('\r')) line.remove_suffix(1);
  return line;
}

void CsvScanner::split_plain(std::string_view line, std::vector<std::string_view>& cells) const {
  std::size_t start = 0;
  for (std::size_t end = line.find(separator_); end != std::string_view::npos; end = line.find(separator_, start)) {
    cells.push_back(line.substr(start, end - start));
    start = end + 1;
  }
  cells.push_back(line.substr(start));
}

base::Result<bool> CsvScanner::next_quoted(std::vector<std::string_view>& cells) {
  while (true) {
    if (offset_ < text_.size() && text_[offset_] == '"') {
      std::string& cell = unquoted_.emplace_back();
      if (!read_quoted_cell(cell)) {
        return base::bad_input("a cell begins with a double quote that is never closed: close it or double it",
                               fmt::format("line {}", line_));
      }
      cells.push_back(cell);
    } else {
      const std::size_t start = offset_;
      while (offset_ < text_.size() && text_[offset_] != separator_ && text_[offset_] != '\n') ++offset_;
      cells.push_back(text_.substr(start, offset_ - start));
    }
    if (offset_ < text_.size() && text_[offset_] == separator_) {
      ++offset_;
      continue;
    }
    row_was_ended_ = offset_ < text_.size();
    if (row_was_ended_) {
      ++offset_;
      ++next_line_;
    }
    if (cells.back().ends_with('\r')) cells.back().remove_suffix(1);
    return true;
  }
}

// Reads from the opening quote to the separator or line end after the closing one.
bool CsvScanner::read_quoted_cell(std::string& cell) {
  for (++offset_; offset_ < text_.size(); ++offset_) {
    const char c = text_[offset_];
    if (c == '\n') ++next_line_;
    if (c != '"') {
      cell += c;
      continue;
    }
    const bool doubled = offset_ + 1 < text_.size() && text_[offset_ + 1] == '"';
    if (!doubled) break;
    cell += c;
    ++offset_;
  }
  if (offset_ >= text_.size()) return false;
  ++offset_;
  while (offset_ < text_.size() && text_[offset_] != separator_ && text_[offset_] != '\n') {
    if (text_[offset_] != '\r') cell += text_[offset_];
    ++offset_;
  }
  return true;
}

std::string_view trimmed(std::string_view text) {
  const auto blank = [](char c) { return c == ' ' || c == '\t'; };
  while (!text.empty() && blank(text.front())) text.remove_prefix(1);
  while (!text.empty() && blank(text.back())) text.remove_suffix(1);
  return text;
}

std::string csv_cell(std::string_view text) {
  if (text.find_first_of(",\"\r\n") == std::string_view::npos) return std::string(text);
  std::string cell = "\"";
  for (const char c : text) {
    if (c == '"') cell += '"';
    cell += c;
  }
  cell += '"';
  return cell;
}

}  // namespace soak::station
