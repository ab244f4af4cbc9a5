// SPDX-License-Identifier: Apache-2.0
#include "calib/curve/one_way.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <map>

namespace soak::calib {
namespace {

/// Rows nearer than this are of the same temperature: visits of one plateau, and the noise of the thermometer.
constexpr double kSameVisit_c = 0.5;

/// The way a row was reached by.
struct Visited {
  double temp_c = 0.0;
  Sweep sweep = Sweep::unknown;
};

/// Rising temperatures that were visited on the way up and on the way down.
struct Ways {
  std::vector<double> up;
  std::vector<double> down;

  void add(Sweep sweep, double temp_c) {
    if (sweep == Sweep::up) up.push_back(temp_c);
    if (sweep == Sweep::down) down.push_back(temp_c);
  }
  [[nodiscard]] const std::vector<double>& other_than(Sweep sweep) const { return sweep == Sweep::up ? down : up; }
};

/// The rows of each run in the order of time.
std::map<int, std::vector<const CurveRow*>> rows_in_time(const CurveData& data) {
  std::map<int, std::vector<const CurveRow*>> runs;
  for (const CurveRow& row : data.rows) runs[row.run].push_back(&row);
  for (auto& [run, rows] : runs) std::ranges::stable_sort(rows, {}, &CurveRow::t_s);
  return runs;
}

/// The way a run goes on after row i: the sweep of the next row at another temperature.
Sweep way_on(const std::vector<const CurveRow*>& rows, std::size_t i) {
  for (std::size_t next = i + 1; next < rows.size(); ++next) {
    if (std::abs(rows[next]->temp_c - rows[i]->temp_c) > kSameVisit_c) return rows[next]->sweep;
  }
  return Sweep::unknown;
}

bool is_opposite(Sweep a, Sweep b) { return a != Sweep::unknown && b != Sweep::unknown && a != b; }

/// From a row to where rows of the other way are near, else to the ends of all rows; empty (low above high) where one
/// is near the row itself.
OneWayRange around(const Visited& row, const std::vector<double>& others, double lowest_c, double highest_c) {
  const auto above = std::ranges::lower_bound(others, row.temp_c);
  OneWayRange range{lowest_c, highest_c, row.sweep};
  if (above != others.end()) range.high_c = std::min(range.high_c, *above - kOtherWayWithin_c);
  if (above != others.begin()) range.low_c = std::max(range.low_c, *std::prev(above) + kOtherWayWithin_c);
  if (range.low_c > row.temp_c || range.high_c < row.temp_c) return {1.0, 0.0, row.sweep};
  return range;
}

/// Adds a range to those of its way that it touches.
void merge(std::vector<OneWayRange>& ranges, const OneWayRange& range) {
  for (OneWayRange& known : ranges) {
    if (known.sweep != range.sweep || range.low_c > known.high_c || range.high_c < known.low_c) continue;
    known.low_c = std::min(known.low_c, range.low_c);
    known.high_c = std::max(known.high_c, range.high_c);
    return;
  }
  ranges.push_back(range);
}

}  // namespace

std::vector<OneWayRange> one_way_ranges(const CurveData& data) {
  if (data.rows.empty()) return {};
  Ways ways;
  std::vector<Visited> inner;  // neither at a beginning, an end nor a turn
  for (const auto& [run, rows] : rows_in_time(data)) {
    for (std::size_t i = 0; i < rows.size(); ++i) {
      const CurveRow& row = *rows[i];
      const Sweep on = way_on(rows, i);
      ways.add(row.sweep, row.temp_c);
      if (is_opposite(row.sweep, on)) ways.add(on, row.temp_c);
      const bool at_end = i == 0 || std::abs(row.temp_c - rows.back()->temp_c) <= kSameVisit_c ||
                          std::abs(row.temp_c - rows.front()->temp_c) <= kSameVisit_c;
      if (row.sweep != Sweep::unknown && !at_end && !is_opposite(row.sweep, on))
        inner.push_back({row.temp_c, row.sweep});
    }
  }
  std::ranges::sort(ways.up);
  std::ranges::sort(ways.down);
  std::ranges::sort(inner, {}, &Visited::temp_c);
  const auto [lowest, highest] = std::ranges::minmax_element(data.rows, {}, &CurveRow::temp_c);
  std::vector<OneWayRange> ranges;
  for (const Visited& row : inner) {
    const OneWayRange range = around(row, ways.other_than(row.sweep), lowest->temp_c, highest->temp_c);
    if (range.low_c <= range.high_c) merge(ranges, range);
  }
  std::ranges::sort(ranges, {}, &OneWayRange::low_c);
  // One way may begin before the other is far enough away: they meet in the middle.
  for (std::size_t i = 1; i < ranges.size(); ++i) {
    if (ranges[i].low_c >= ranges[i - 1].high_c) continue;
    ranges[i].low_c = ranges[i - 1].high_c = 0.5 * (ranges[i].low_c + ranges[i - 1].high_c);
  }
  return ranges;
}

std::string one_way_text(const std::vector<OneWayRange>& ranges) {
  std::vector<std::string> parts;
  Sweep told = Sweep::unknown;
  for (const OneWayRange& range : ranges) {
    const char* way = range.sweep == Sweep::up ? "only heating was recorded " : "only cooling was recorded ";
    parts.push_back(
        fmt::format("{}from {:.0f} to {:.0f} °C", range.sweep == told ? "" : way, range.low_c, range.high_c));
    told = range.sweep;
  }
  return fmt::format("{}", fmt::join(parts, " and "));
}

std::string one_way_bands_text(HysteresisSource source) {
  if (source == HysteresisSource::type) return "the bands hold the hysteresis that the unit's type states";
  if (source == HysteresisSource::fleet) return "the bands hold the hysteresis that other units of its type show";
  return "no band holds the unit's thermal hysteresis";
}

Warning one_way_warning(const OneWay& one_way) {
  return {"one_way", fmt::format("{}: what the unit reads on the other way is not known there, and {}; record a "
                                 "procedure that goes both ways (sweep = \"up_down\")",
                                 one_way_text(one_way.ranges), one_way_bands_text(one_way.known.source))};
}

}  // namespace soak::calib
