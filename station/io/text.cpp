// SPDX-License-Identifier: Apache-2.0
#include "station/io/text.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>

#include "base/text.h"

namespace soak::station {
namespace {

using std::chrono::sys_days;
using std::chrono::year_month_day;

constexpr int kFirstYear = 1970;
constexpr double kEndOfYear9999_s = 253402300800.0;

/// The number that `text` spells in digits alone.
std::optional<int> digits(std::string_view text) {
  const auto is_digit = [](char c) { return c >= '0' && c <= '9'; };
  if (!std::all_of(text.begin(), text.end(), is_digit)) return std::nullopt;
  const auto number = base::parse_int(text);
  return number ? std::optional(static_cast<int>(*number)) : std::nullopt;
}

bool is_plain(char c) {
  return (c >= '0' && c <= '9') || (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || c == '.' || c == '-' || c == '_';
}

}  // namespace

base::Status check_text_line(std::string_view text, std::string_view where) {
  if (base::is_blank(text)) return base::bad_input("must not be empty", std::string(where));
  if (base::is_plain_line(text)) return {};
  return base::bad_input(
      "must be one line of plain text without control characters, line separators or marks that change its direction",
      std::string(where));
}

base::Status check_carried_line(std::string_view text, std::string_view where) {
  if (auto plain = check_text_line(text, where); !plain) return plain;
  if (text.size() <= kLongestCarried) return {};
  return base::bad_input(
      fmt::format("has {} bytes: at most {} fit into a calibration file", text.size(), kLongestCarried),
      std::string(where));
}

std::optional<double> parse_iso_date(std::string_view text) {
  if (text.size() != 10 || text[4] != '-' || text[7] != '-') return std::nullopt;
  const auto year = digits(text.substr(0, 4));
  const auto month = digits(text.substr(5, 2));
  const auto day = digits(text.substr(8, 2));
  if (!year || !month || !day || *year < kFirstYear) return std::nullopt;
  const year_month_day date(std::chrono::year(*year), std::chrono::month(static_cast<unsigned>(*month)),
                            std::chrono::day(static_cast<unsigned>(*day)));
  if (!date.ok()) return std::nullopt;
  return std::chrono::duration<double>(sys_days(date).time_since_epoch()).count();
}

std::string iso_date(double utc_s) {
  if (!(utc_s >= 0.0) || utc_s >= kEndOfYear9999_s) return base::shortest(utc_s);
  const auto days = std::chrono::floor<std::chrono::days>(std::chrono::duration<double>(utc_s));
  const year_month_day date{sys_days(days)};
  return fmt::format("{:04}-{:02}-{:02}", static_cast<int>(date.year()), static_cast<unsigned>(date.month()),
                     static_cast<unsigned>(date.day()));
}

std::string plain_file_name(std::string_view text) {
  std::string name(text);
  for (char& c : name) c = is_plain(c) ? c : '_';
  if (name.empty() || name.front() == '.' || name.front() == '-') name.insert(0, 1, '_');
  return name;
}

std::string lower_case(std::string text) {
  for (char& c : text) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  return text;
}

}  // namespace soak::station
