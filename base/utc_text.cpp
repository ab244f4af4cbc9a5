// SPDX-License-Identifier: Apache-2.0
#include "base/utc_text.h"

#include <array>
#include <cstddef>
#include <cstdint>

#include "base/text.h"

namespace soak::calib::file {
namespace {

constexpr std::int64_t kSecondsPerDay = 86400;
constexpr double kEndOfYear9999_s = 253402300800.0;

bool is_leap(int year) { return (year % 4 == 0 && year % 100 != 0) || year % 400 == 0; }

std::string two_digits(std::int64_t number) {
  std::string text = std::to_string(number);
  if (text.size() < 2) text.insert(0, 1, '0');
  return text;
}

}  // namespace

std::string utc_text(double unix_s) {
  if (!(unix_s >= 0.0) || unix_s >= kEndOfYear9999_s) return base::shortest(unix_s);
  const auto seconds = static_cast<std::int64_t>(unix_s);
  std::int64_t days = seconds / kSecondsPerDay;
  int year = 1970;
  while (days >= (is_leap(year) ? 366 : 365)) {
    days -= is_leap(year) ? 366 : 365;
    ++year;
  }
  const std::array<int, 12> month_days = {31, is_leap(year) ? 29 : 28, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31};
  std::size_t month = 0;
  while (days >= month_days[month]) days -= month_days[month++];
  const std::int64_t of_day = seconds % kSecondsPerDay;
  std::string text = std::to_string(year);
  text += '-' + two_digits(static_cast<std::int64_t>(month) + 1) + '-' + two_digits(days + 1);
  text += 'T' + two_digits(of_day / 3600) + ':' + two_digits(of_day / 60 % 60) + ':' + two_digits(of_day % 60) + 'Z';
  return text;
}

}  // namespace soak::calib::file
