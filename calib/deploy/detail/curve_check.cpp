// SPDX-License-Identifier: Apache-2.0
// What float32 makes of a curve, and the spline that stands in for a fuzzy model that it cannot hold.
#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "anfis/model/one_input.h"
#include "base/text.h"
#include "calib/deploy/detail/sections.h"
#include "calib/runtime/soak_runtime.h"

namespace soak::calib::file {
namespace {

// ---- samples ----

constexpr int kIntervals = 2048;
// The flank of a rule, where rounding shows most: this many points to each side of its middle, from -8 to 8 (see
// flank()).
constexpr int kFlankSteps = 32;
constexpr double kFlankReach = 8.0;
// A step of the curve is resolved until neighbours differ by less than this part of the span, or so many halvings.
constexpr double kLargestStep = 1.0 / 512.0;
constexpr int kHalvings = 10;

constexpr double kLeastStrength = 1e-30;
constexpr double kLargestScale_ppm = 500000.0;

// docs/blob-format.md 0x0030; the samples do not hit the very worst temperature, therefore something is kept in hand.
constexpr double kAllowedPerSpan = 1e-6;
constexpr double kFloatStep = 0x1p-23;
constexpr double kInHand = 0.75;

double largest_strength(const anfis::Model& model, double temp_c) {
  const anfis::Input& input = model.inputs[0];
  const double u = input.scale.scaled(std::clamp(temp_c, input.min, input.max));
  double largest = 0.0;
  for (const anfis::Rule& rule : model.rules) {
    largest = std::max(largest, anfis::degree(input.memberships[static_cast<std::size_t>(rule.premise[0])], u));
  }
  return largest;
}

/// Distances from a rule's centre, in widths, over which its strength falls from nearly 1 to nearly 0.
std::vector<double> flank(anfis::Shape shape, double slope) {
  std::vector<double> distances;
  for (int i = -kFlankSteps; i <= kFlankSteps; ++i) {
    const double x = kFlankReach * i / kFlankSteps;
    // bell: ln |z|^(2b) from -8 to 8; Gaussian: z from 0 to 8
    distances.push_back(shape == anfis::Shape::bell ? std::exp(x / (2.0 * slope)) : 0.5 * (x + kFlankReach));
  }
  return distances;
}

/// A curve in double precision on temperatures that float32 represents: evenly spaced over the valid range, closer
/// where the curve is steep.
struct SampledCurve {
  std::vector<float> temp_c;
  std::vector<double> value;
  double least = 0.0;
  double largest = 0.0;

  [[nodiscard]] double span() const { return largest - least; }
};

class Sampler {
 public:
  Sampler(const Curve& curve, const SensorCalibration& sensor) : curve_(curve), sensor_(sensor) {}

  SampledCurve run() {
    std::vector<double> start = evenly();
    if (const auto* model = std::get_if<anfis::Model>(&curve_)) add_flanks(*model, start);
    std::sort(start.begin(), start.end());
    add_all(start);
    const std::size_t coarse = out_.temp_c.size();
    for (std::size_t i = 1; i < coarse; ++i) refine(i - 1, i, kHalvings);
    return std::move(out_);
  }

 private:
  [[nodiscard]] std::vector<double> evenly() const {
    std::vector<double> temps;
    const double width = sensor_.temp_max_c - sensor_.temp_min_c;
    for (int i = 0; i <= kIntervals; ++i) temps.push_back(sensor_.temp_min_c + width * i / kIntervals);
    return temps;
  }

  void add_flanks(const anfis::Model& model, std::vector<double>& temps) const {
    const anfis::Scale& scale = model.inputs[0].scale;
    for (const anfis::CurveRule& rule : anfis::curve_rules(model)) {
      const double centre = scale.unscaled(rule.centre);
      for (const double distance : flank(anfis::curve_shape(model), rule.slope)) {
        for (const double side : {-1.0, 1.0}) {
          const double temp_c = centre + side * distance * rule.width * scale.half_range;
          if (temp_c > sensor_.temp_min_c && temp_c < sensor_.temp_max_c) temps.push_back(temp_c);
        }
      }
    }
  }

  /// Where the curve is evaluated for a float32 temperature.
  [[nodiscard]] double within_range(float temp_c) const {
    return std::clamp(static_cast<double>(temp_c), sensor_.temp_min_c, sensor_.temp_max_c);
  }

  void add_all(const std::vector<double>& temps_c) {
    std::vector<double> at;
    for (const double temp_c : temps_c) at.push_back(within_range(static_cast<float>(temp_c)));
    std::vector<double> values(at.size());
    evaluate(curve_, at, values);
    for (std::size_t i = 0; i < at.size(); ++i) add(static_cast<float>(temps_c[i]), values[i]);
  }

  void add(float temp_c, double value) {
    out_.least = out_.temp_c.empty() ? value : std::min(out_.least, value);
    out_.largest = out_.temp_c.empty() ? value : std::max(out_.largest, value);
    out_.temp_c.push_back(temp_c);
    out_.value.push_back(value);
  }

  void refine(std::size_t a, std::size_t b, int halvings) {
    if (halvings == 0 || !(std::abs(out_.value[b] - out_.value[a]) > kLargestStep * out_.span())) return;
    const float middle = 0.5F * (out_.temp_c[a] + out_.temp_c[b]);
    if (middle == out_.temp_c[a] || middle == out_.temp_c[b]) return;
    const std::size_t m = out_.temp_c.size();
    add(middle, evaluate(curve_, within_range(middle)));
    refine(a, m, halvings - 1);
    refine(m, b, halvings - 1);
  }

  const Curve& curve_;
  const SensorCalibration& sensor_;
  SampledCurve out_;
};

/// The least power of two that is not below a positive number; 0 for 0. Coarse on purpose: the same on every machine.
double power_of_two_above(double value) { return value > 0.0 ? std::exp2(std::ceil(std::log2(value))) : 0.0; }

/// Middle and half of the sampled values as float32 numbers.
OutputScale output_scale(const SampledCurve& samples) {
  const auto centre = static_cast<float>(0.5 * (samples.least + samples.largest));
  const auto half_range = static_cast<float>(0.5 * samples.span());
  return {static_cast<double>(centre), std::isnormal(half_range) ? static_cast<double>(half_range) : 1.0};
}

base::Status check_coverage(const anfis::Model& model, const SampledCurve& samples, const std::string& where) {
  const auto gap = std::find_if(samples.temp_c.begin(), samples.temp_c.end(), [&](float temp_c) {
    return largest_strength(model, static_cast<double>(temp_c)) < kLeastStrength;
  });
  if (gap == samples.temp_c.end()) return {};
  return base::bad_input("no rule of the model covers " + base::shortest(*gap) + " °C; use wider or more rules", where);
}

/// Largest difference of the runtime's evaluation of a curve's section from the samples; NaN if it is not finite.
double largest_error(const Section& section, const SampledCurve& samples) {
  const soak_curve curve{section.payload.data(), section.type};
  double worst = 0.0;
  for (std::size_t i = 0; i < samples.temp_c.size(); ++i) {
    const double error = std::abs(static_cast<double>(soak_eval_curve(&curve, samples.temp_c[i])) - samples.value[i]);
    if (!std::isfinite(error)) return error;
    worst = std::max(worst, error);
  }
  return worst;
}

/// Refuses a curve that is not finite in the valid range, or is a scale factor error beyond ±500,000 ppm.
base::Result<SampledCurve> sample_curve(const Curve& curve, const SensorCalibration& sensor, Quantity quantity) {
  const std::string where = place(sensor.sensor, quantity);
  SampledCurve samples = Sampler(curve, sensor).run();
  if (!std::all_of(samples.value.begin(), samples.value.end(), fits_float)) {
    return base::bad_input("the curve is not finite everywhere in the valid range", where);
  }
  if (quantity == Quantity::scale_ppm && std::max(-samples.least, samples.largest) > kLargestScale_ppm) {
    return base::bad_input("the scale factor error exceeds 500,000 ppm; check the units of the recording", where);
  }
  return samples;
}

/// The section of a curve in the form that it has, and how far the runtime is off its samples with it.
base::Result<CheckedCurve> checked_form(const Curve& curve, const SampledCurve& samples, Sensor sensor,
                                        Quantity quantity) {
  const std::string where = place(sensor, quantity);
  if (const auto* model = std::get_if<anfis::Model>(&curve)) {
    if (auto status = check_coverage(*model, samples, where); !status) return base::forward_error(status);
  }
  auto section = curve_section(sensor, quantity, curve, output_scale(samples));
  if (!section) return base::forward_error(section);
  const double worst = largest_error(*section, samples);
  const double magnitude = std::max(std::abs(samples.least), std::abs(samples.largest));
  const double allowed = std::max(kAllowedPerSpan * samples.span(), kFloatStep * magnitude);
  if (!(worst <= kInHand * allowed)) {
    return base::bad_input(
        "in float32 the curve is off by " + base::shortest(worst / samples.span()) +
            " of its span, too near 1e-6: its terms cancel or it is too steep; use fewer rules, or a smoother curve",
        where);
  }
  base::ByteWriter out = payload_of(sensor, quantity);
  out.write(std::uint16_t{0});
  write_floats(out, {power_of_two_above(worst), samples.span()});
  return CheckedCurve{*std::move(section), Section{SOAK_SECTION_ERROR_BOUND, false, out.take()}};
}

// ---- the spline form ----

constexpr double kSplineErrorPerSpan = 1e-7;
constexpr int kFirstPieces = 32;

/// The cubic through the curve at both ends and both thirds, in powers of T - left.
std::array<double, 4> through_four_points(const Curve& curve, double left, double right) {
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

class SplineRefinement {
 public:
  SplineRefinement(const Curve& curve, double tolerance) : curve_(curve), tolerance_(tolerance) {}

  /// Adds pieces over left..right; false if there are too many.
  bool add(double left, double right) {
    const std::array<double, 4> cubic = through_four_points(curve_, left, right);
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
  [[nodiscard]] bool fits(const std::array<double, 4>& c, double left, double right) const {
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

/// The curve as a cubic spline from temp_min_c to temp_max_c that differs by less than 1e-7 of `span`. Each piece is
/// the cubic through four points of the curve; pieces are halved where the curve is steep. Nothing if the file's limit
/// of pieces does not suffice.
std::optional<SplineCurve> spline_form(const Curve& curve, double temp_min_c, double temp_max_c, double span) {
  SplineRefinement refinement(curve, kSplineErrorPerSpan * span);
  const auto knot = [&](int i) {
    return static_cast<double>(static_cast<float>(temp_min_c + (temp_max_c - temp_min_c) * i / kFirstPieces));
  };
  for (int i = 0; i < kFirstPieces; ++i) {
    if (!(knot(i) < knot(i + 1)) || !refinement.add(knot(i), knot(i + 1))) return std::nullopt;
  }
  return refinement.finish(knot(kFirstPieces));
}

}  // namespace

base::Result<CheckedCurve> checked_curve(const Curve& curve, const SensorCalibration& sensor, Quantity quantity) {
  if (auto status = check_curve(curve, place(sensor.sensor, quantity)); !status) return base::forward_error(status);
  const auto samples = sample_curve(curve, sensor, quantity);
  if (!samples) return base::forward_error(samples);
  auto own = checked_form(curve, *samples, sensor.sensor, quantity);
  if (own || !std::holds_alternative<anfis::Model>(curve)) return own;
  const auto [low_c, high_c] = domain_of(curve);
  const auto spline =
      spline_form(curve, std::max(low_c, sensor.temp_min_c), std::min(high_c, sensor.temp_max_c), samples->span());
  if (!spline) return own;
  auto other = checked_form(*spline, *samples, sensor.sensor, quantity);
  return other ? other : own;
}

}  // namespace soak::calib::file
