// SPDX-License-Identifier: Apache-2.0
#include "calib/deploy/detail/spline_form.h"

#include <array>
#include <cmath>
#include <cstddef>

#include "calib/runtime/soak_runtime.h"

namespace soak::calib::file {
namespace {

constexpr double kErrorPerSpan = 1e-7;
constexpr int kFirstPieces = 32;

using Cubic = std::array<double, 4>;

/// The cubic through the curve at both ends and both thirds, in powers of T - left.
Cubic through_four_points(const Curve& curve, double left, double right) {
  const double h = (right - left) / 3.0;
  const double y0 = evaluate(curve, left);
  const double y1 = evaluate(curve, left + h);
  const double y2 = evaluate(curve, right - h);
  const double y3 = evaluate(curve, right);
  // Newton's forward differences d1, d2, d3 in u = (T - left)/h: y0 + d1 u + d2 u(u-1)/2 + d3 u(u-1)(u-2)/6
  const double d1 = y1 - y0;
  const double d2 = y2 - 2.0 * y1 + y0;
  const double d3 = y3 - 3.0 * y2 + 3.0 * y1 - y0;
  return {y0, (d1 - d2 / 2.0 + d3 / 3.0) / h, (d2 - d3) / (2.0 * h * h), d3 / (6.0 * h * h * h)};
}

class Refinement {
 public:
  Refinement(const Curve& curve, double tolerance) : curve_(curve), tolerance_(tolerance) {}

  /// Adds pieces over left..right; false if there are too many.
  bool add(double left, double right) {
    const Cubic cubic = through_four_points(curve_, left, right);
    // float32 temperatures: the file then holds these very knots
    const auto middle = static_cast<double>(static_cast<float>(0.5 * (left + right)));
    if (fits(cubic, left, right) || middle <= left || middle >= right) {
      spline_.knots_c.push_back(left);
      spline_.coefficients.push_back(cubic);
      return spline_.coefficients.size() <= SOAK_MAX_PIECES;
    }
    return add(left, middle) && add(middle, right);
  }

  SplineCurve finish(double right) {
    spline_.knots_c.push_back(right);
    return std::move(spline_);
  }

 private:
  /// Whether the cubic follows the curve between the points that it goes through.
  [[nodiscard]] bool fits(const Cubic& c, double left, double right) const {
    for (const double part : {0.05, 0.15, 0.25, 0.5, 0.75, 0.85, 0.95}) {
      const double d = part * (right - left);
      const double value = c[0] + d * (c[1] + d * (c[2] + d * c[3]));
      if (!(std::abs(value - evaluate(curve_, left + d)) <= tolerance_)) return false;
    }
    return true;
  }

  const Curve& curve_;
  double tolerance_;
  SplineCurve spline_;
};

}  // namespace

std::optional<SplineCurve> spline_form(const Curve& curve, double temp_min_c, double temp_max_c, double span) {
  Refinement refinement(curve, kErrorPerSpan * span);
  const auto knot = [&](int i) {
    return static_cast<double>(static_cast<float>(temp_min_c + (temp_max_c - temp_min_c) * i / kFirstPieces));
  };
  for (int i = 0; i < kFirstPieces; ++i) {
    if (!(knot(i) < knot(i + 1)) || !refinement.add(knot(i), knot(i + 1))) return std::nullopt;
  }
  return refinement.finish(knot(kFirstPieces));
}

}  // namespace soak::calib::file
