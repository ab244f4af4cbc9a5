// SPDX-License-Identifier: Apache-2.0
#include "station/nav/solution_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <optional>
#include <string>
#include <string_view>

#include "base/text.h"
#include "base/units.h"
#include "station/io/csv_scanner.h"
#include "station/io/text_file.h"

namespace soak::station {
namespace {

using base::kRadPerDeg;

constexpr std::size_t kColumns = 12;
constexpr std::array<std::string_view, kColumns> kRtklib = {"latitude(deg)", "longitude(deg)", "height(m)", "sdn(m)",
                                                            "sde(m)",        "sdu(m)",         "vn(m/s)",   "ve(m/s)",
                                                            "vu(m/s)",       "sdvn",           "sdve",      "sdvu"};
constexpr std::array<std::string_view, kColumns> kCsv = {
    "latitude_deg", "longitude_deg", "height_m", "sd_north_m",     "sd_east_m",     "sd_up_m",
    "v_north_mps",  "v_east_mps",    "v_up_mps", "sd_v_north_mps", "sd_v_east_mps", "sd_v_up_mps"};

/// The cells of a line: between commas, or between blanks.
std::vector<std::string_view> cells_of(std::string_view line, bool blanks) {
  std::vector<std::string_view> cells;
  std::size_t first = 0;
  while (first <= line.size()) {
    const std::size_t last = std::min(line.find_first_of(blanks ? " \t" : ",", first), line.size());
    const std::string_view cell = trimmed(line.substr(first, last - first));
    if (!blanks || !cell.empty()) cells.push_back(cell);
    first = last + 1;
  }
  return cells;
}

/// "2025/07/08" and "19:34:18.499" in seconds since 1970-01-01.
std::optional<double> seconds_of(std::string_view date, std::string_view time) {
  if (date.size() != 10 || date[4] != '/' || date[7] != '/' || time.size() < 8) return std::nullopt;
  const auto year = base::parse_int(date.substr(0, 4));
  const auto month = base::parse_int(date.substr(5, 2));
  const auto day = base::parse_int(date.substr(8, 2));
  const auto hours = base::parse_int(time.substr(0, 2));
  const auto minutes = base::parse_int(time.substr(3, 2));
  const auto seconds = base::parse_double(time.substr(6));
  if (!year || !month || !day || !hours || !minutes || !seconds) return std::nullopt;
  const std::chrono::year_month_day ymd(std::chrono::year(static_cast<int>(*year)),
                                        std::chrono::month(static_cast<unsigned>(*month)),
                                        std::chrono::day(static_cast<unsigned>(*day)));
  if (!ymd.ok()) return std::nullopt;
  const auto days = std::chrono::sys_days(ymd).time_since_epoch().count();
  return 86400.0 * static_cast<double>(days) + 3600.0 * static_cast<double>(*hours) +
         60.0 * static_cast<double>(*minutes) + *seconds;
}

/// What the header says of a file.
struct Layout {
  bool rtklib = false;
  std::array<std::size_t, kColumns> at{};  ///< index of each column
  std::size_t time = 0;
  std::size_t cells = 0;
};

base::Result<Layout> layout_of(std::string_view header, const std::string& path) {
  Layout layout;
  layout.rtklib = header.starts_with('%');
  if (layout.rtklib) header.remove_prefix(1);
  const auto names = cells_of(header, layout.rtklib);
  layout.cells = names.size();
  const auto index_of = [&](std::string_view name) -> base::Result<std::size_t> {
    const auto found = std::ranges::find(names, name);
    if (found != names.end()) return static_cast<std::size_t>(found - names.begin());
    return base::bad_input(fmt::format("the header has no column '{}'", name), path);
  };
  const auto time = index_of(layout.rtklib ? "GPST" : "t_s");
  if (!time) return base::forward_error(time);
  layout.time = *time;
  for (std::size_t i = 0; i < kColumns; ++i) {
    const auto at = index_of(layout.rtklib ? kRtklib[i] : kCsv[i]);
    if (!at) return base::forward_error(at);
    layout.at[i] = *at;
  }
  return layout;
}

base::Result<nav::GnssFix> fix_of(const std::vector<std::string_view>& cells, const Layout& layout,
                                  const std::string& where) {
  // Date and time are two cells under one name.
  const bool dated = layout.rtklib && cells.size() == layout.cells + 1;
  if (cells.size() != layout.cells + (dated ? 1 : 0)) {
    return base::bad_input(fmt::format("the row has {} cells, the header {}", cells.size(), layout.cells), where);
  }
  const auto t_s =
      dated ? seconds_of(cells[layout.time], cells[layout.time + 1]) : base::parse_double(cells[layout.time]);
  if (!t_s) return base::bad_input(fmt::format("'{}' is no time", cells[layout.time]), where);
  std::array<double, kColumns> v{};
  for (std::size_t i = 0; i < kColumns; ++i) {
    const std::string_view cell = cells[layout.at[i] + (dated && layout.at[i] > layout.time ? 1 : 0)];
    const auto value = base::parse_double(cell);
    if (!value) return base::bad_input(fmt::format("'{}' is no number", cell), where);
    v[i] = *value;
  }
  return nav::GnssFix{
      *t_s, {v[0] * kRadPerDeg, v[1] * kRadPerDeg, v[2]}, {v[4], v[3], v[5]}, {v[7], v[6], v[8]}, {v[10], v[9], v[11]}};
}

}  // namespace

base::Result<std::vector<nav::GnssFix>> read_solutions(const std::filesystem::path& path) {
  const auto text = read_text_file(path);
  if (!text) return base::forward_error(text);
  std::vector<nav::GnssFix> fixes;
  std::optional<Layout> layout;
  std::size_t number = 0;
  for (std::size_t first = text->starts_with(kByteOrderMark) ? kByteOrderMark.size() : 0; first < text->size();) {
    const std::size_t last = std::min(text->find('\n', first), text->size());
    std::string_view line = trimmed(std::string_view(*text).substr(first, last - first));
    if (line.ends_with('\r')) line.remove_suffix(1);
    first = last + 1;
    ++number;
    const bool is_remark = line.starts_with('%') && line.find("latitude") == std::string_view::npos;
    if (line.empty() || is_remark) continue;
    if (!layout) {
      const auto read = layout_of(line, path.string());
      if (!read) return base::forward_error(read);
      layout = *read;
      continue;
    }
    const auto fix = fix_of(cells_of(line, layout->rtklib), *layout, fmt::format("{}, line {}", path.string(), number));
    if (!fix) return base::forward_error(fix);
    fixes.push_back(*fix);
  }
  if (!fixes.empty()) return fixes;
  return base::bad_input("the file has no rows below a header", path.string());
}

}  // namespace soak::station
