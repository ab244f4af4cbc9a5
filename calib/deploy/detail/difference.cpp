// SPDX-License-Identifier: Apache-2.0
#include "calib/deploy/detail/difference.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "calib/deploy/detail/enclosure.h"

namespace soak::calib::table {
namespace {

constexpr double kExcess = 1.01;
constexpr double kLeastPerSpan = 1e-9;
// Where they are used up the bound is still one, but may exceed the difference by more than 1 %.
constexpr int kMostHalvings = 200000;
// Samples per piece before the halving: the better the largest difference is known, the fewer stretches are halved.
constexpr int kSamples = 4;
// Rounding of double precision in some hundred operations.
constexpr double kRounding = 1e-13;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// A stretch on which both the curve and the table are smooth, the table being offset + slope (T − at_c).
struct Stretch {
  const Piece& curve;
  double at_c;
  double offset;
  double slope;
};

/// e = curve − table
Enclosure difference(const Stretch& stretch, Interval temp_c) {
  const Enclosure curve = stretch.curve.enclose(temp_c);
  const Interval table = stretch.slope * (temp_c - stretch.at_c) + stretch.offset;
  return {curve.value - table, curve.slope - stretch.slope};
}

double magnitude_at(const Stretch& stretch, double temp_c) {
  return difference(stretch, {temp_c, temp_c}).value.magnitude();
}

class Search {
 public:
  /// found: the largest |e| that samples have shown. enough: a bound that needs no halving.
  Search(double found, double enough) : found_(found), enough_(enough) {}

  /// A bound of |e| on a part of a stretch.
  double bound(const Stretch& stretch, Interval temp_c) {
    const double middle = 0.5 * (temp_c.low + temp_c.high);
    const double half_width = 0.5 * (temp_c.high - temp_c.low);
    const double at_middle = magnitude_at(stretch, middle);
    if (!std::isfinite(at_middle)) return kInfinity;
    found_ = std::max(found_, at_middle);
    const Enclosure e = difference(stretch, temp_c);
    const double mean_value = at_middle + half_width * e.slope.magnitude();
    const double own_range = e.value.magnitude();
    const double here = own_range < mean_value ? own_range : mean_value;
    const bool splits = temp_c.low < middle && middle < temp_c.high && halvings_ < kMostHalvings;
    if (here <= std::max(kExcess * found_, enough_) || !splits) return std::isnan(here) ? kInfinity : here;
    ++halvings_;
    const double left = bound(stretch, {temp_c.low, middle});
    const double right = bound(stretch, {middle, temp_c.high});
    return std::max(left, right);
  }

 private:
  double found_;
  double enough_;
  int halvings_ = 0;
};

double left_of(const Piece& curve, const Piece& table) { return std::max(curve.from_c, table.from_c); }
double right_of(const Piece& curve, const Piece& table) { return std::min(curve.to_c, table.to_c); }

/// Calls visit(curve's piece, table's piece) for every two that overlap.
template <class Visit>
void for_each_overlap(const std::vector<Piece>& curve, const std::vector<Piece>& table, Visit visit) {
  for (std::size_t i = 0, j = 0; i < curve.size() && j < table.size();) {
    if (left_of(curve[i], table[j]) < right_of(curve[i], table[j])) visit(curve[i], table[j]);
    curve[i].to_c < table[j].to_c ? ++i : ++j;
  }
}

Stretch stretch_of(const Piece& curve, const Piece& table) {
  const double at = left_of(curve, table);
  const Enclosure line = table.enclose({at, at});
  return {curve, at, line.value.low, line.slope.low};
}

}  // namespace

double largest_difference(const TableCurve& table, const Curve& curve, double from_c, double to_c) {
  const Curve other(table);
  const std::vector<Piece> of_curve = pieces_of(curve, from_c, to_c);
  const std::vector<Piece> of_table = pieces_of(other, from_c, to_c);
  const auto [least, largest] = std::ranges::minmax(table.values);
  double found = std::abs(evaluate(other, from_c) - evaluate(curve, from_c));
  for_each_overlap(of_curve, of_table, [&](const Piece& a, const Piece& b) {
    const Stretch stretch = stretch_of(a, b);
    const double left = left_of(a, b);
    const double width = right_of(a, b) - left;
    for (int i = 0; i <= kSamples; ++i) found = std::max(found, magnitude_at(stretch, left + width * i / kSamples));
  });
  double bound = found;
  Search search(found, kLeastPerSpan * (largest - least));
  for_each_overlap(of_curve, of_table, [&](const Piece& a, const Piece& b) {
    bound = std::max(bound, search.bound(stretch_of(a, b), {left_of(a, b), right_of(a, b)}));
  });
  return bound + kRounding * std::max(std::abs(least), std::abs(largest));
}

}  // namespace soak::calib::table
