// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "calib/curve/calibration.h"

namespace soak::calib::table {

/// A number that |table − curve| exceeds nowhere from from_c to to_c, and that it comes within 1 % of (or 1e-9 of the
/// table's span). Infinite if none can be given: where all strengths of a model's rules underflow.
///
/// Proof by halving [Moore, Kearfott, Cloud: Introduction to Interval Analysis, §6.4]: with E' a range of the slope of
/// the difference e over a stretch of half-width r about m, |e| <= |e(m)| + r max|E'|; likewise |e| is bounded by its
/// own range there. A stretch whose lesser bound exceeds the largest |e| found so far by more than 1 % is halved.
[[nodiscard]] double largest_difference(const TableCurve& table, const Curve& curve, double from_c, double to_c);

}  // namespace soak::calib::table
