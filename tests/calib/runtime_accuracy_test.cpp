// SPDX-License-Identifier: Apache-2.0
// The float32 runtime against the definition of the curves in double precision, over random curves.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

#include "base/random.h"
#include "calib/deploy/calibration_file.h"
#include "calib/runtime/soak_runtime.h"
#include "tests/calib/calibration_file_samples.h"
#include "tests/long_tests.h"

namespace soak::calib {
namespace {

using samples::with_bias;

constexpr int kTemperatures = 1000;

// ln of a rule's strength, which does not underflow
double log_strength(anfis::Shape shape, double z, double slope) {
  if (shape == anfis::Shape::gaussian) return -z * z / 2.0;
  if (z <= 1.0) return -std::log1p(std::pow(z, 2.0 * slope));
  return -2.0 * slope * std::log(z) - std::log1p(std::pow(z, -2.0 * slope));
}

// [AH05 eq. 5.5-5.11], as the model's header defines it
double plain_fis(const anfis::Model& model, double temp_c) {
  const double u = (temp_c - model.inputs[0].scale.centre) / model.inputs[0].scale.half_range;
  const std::vector<anfis::CurveRule> rules = anfis::curve_rules(model);
  std::vector<double> logs;
  for (const anfis::CurveRule& rule : rules) {
    logs.push_back(log_strength(anfis::curve_shape(model), std::abs(u - rule.centre) / rule.width, rule.slope));
  }
  const double strongest = *std::max_element(logs.begin(), logs.end());
  double numerator = 0.0;
  double denominator = 0.0;
  for (std::size_t i = 0; i < logs.size(); ++i) {
    const double mu = std::exp(logs[i] - strongest);
    numerator += mu * (rules[i].gain * u + rules[i].offset);
    denominator += mu;
  }
  return model.output.centre + model.output.half_range * numerator / denominator;
}

struct Deviation {
  double largest = 0.0;
  double span = 0.0;
  double magnitude = 0.0;
};

/// Largest difference of the runtime from `truth` at random temperatures of the valid range.
Deviation deviation(const base::Bytes& bytes, const std::function<double(double)>& truth, base::Random& random) {
  soak_cal cal;
  EXPECT_EQ(soak_load(&cal, bytes.data(), bytes.size()), SOAK_OK);
  double least = truth(-30.0);
  double largest = least;
  Deviation result;
  for (int i = 0; i < kTemperatures; ++i) {
    const auto temp_c = static_cast<float>(random.uniform(-30.0, 70.0));
    float value = NAN;
    EXPECT_EQ(soak_bias(&cal, SOAK_GYRO_X, temp_c, &value), SOAK_OK);
    const double expected = truth(static_cast<double>(temp_c));
    least = std::min(least, expected);
    largest = std::max(largest, expected);
    result.largest = std::max(result.largest, std::abs(static_cast<double>(value) - expected));
  }
  result.span = largest - least;
  result.magnitude = std::max(std::abs(least), std::abs(largest));
  return result;
}

/// A model but for its rules.
struct Frame {
  anfis::Shape shape;
  anfis::Scale input;
  anfis::Scale output;

  explicit Frame(base::Random& random)
      : shape(random.uniform() < 0.5 ? anfis::Shape::bell : anfis::Shape::gaussian),
        input{random.uniform(15.0, 25.0), random.uniform(45.0, 55.0)},
        output{random.uniform(-0.02, 0.02), random.uniform(0.005, 0.02)} {}

  [[nodiscard]] anfis::Model with(const std::vector<anfis::CurveRule>& rules) const {
    return samples::fis_of(shape, rules, input, output);
  }
};

/// As a fit of a thermal curve gives it: rules that overlap, bells up to slope 4.
anfis::Model usual_model(base::Random& random) {
  const Frame frame(random);
  std::vector<anfis::CurveRule> rules;
  const int count = 2 + static_cast<int>(random.uniform(0.0, 7.0));
  for (int k = 0; k < count; ++k) {
    const double spacing = 2.0 / (count - 1);
    const double slope = frame.shape == anfis::Shape::bell ? random.uniform(1.0, 4.0) : 0.0;
    rules.push_back({spacing * random.uniform(0.4, 0.8), slope, -1.0 + spacing * (k + random.uniform(-0.2, 0.2)),
                     random.uniform(-2.0, 2.0), random.uniform(-1.0, 1.0)});
  }
  return frame.with(rules);
}

/// Anything: needles, walls, consequents that cancel over many decades.
anfis::Model hostile_model(base::Random& random) {
  const Frame frame(random);
  std::vector<anfis::CurveRule> rules;
  const int count = 1 + static_cast<int>(random.uniform(0.0, 12.0));
  const double size = std::pow(10.0, random.uniform(0.0, 5.0));
  for (int k = 0; k < count; ++k) {
    const double slope = frame.shape == anfis::Shape::bell ? std::pow(10.0, random.uniform(-1.0, 2.0)) : 0.0;
    rules.push_back({std::pow(10.0, random.uniform(-2.5, 0.5)), slope, random.uniform(-1.5, 1.5),
                     size * random.gaussian(), size * random.gaussian()});
  }
  return frame.with(rules);
}

// The runtime's own functions, by its header 1.2e-7: two steps of float32 (2^-24 each).
TEST(RuntimeAccuracy, PowersOfTwoAreThoseOfDoublePrecision) {
  double worst = 0.0;
  for (double y = -125.99; y < 126.0; y += 0.00137) {
    const auto x = static_cast<float>(y);
    worst = std::max(worst, std::abs(static_cast<double>(soak_exp2(x)) / std::exp2(static_cast<double>(x)) - 1.0));
  }
  EXPECT_LE(worst, 1.2e-7);
  EXPECT_EQ(soak_exp2(-126.0F), 0.0F);
  EXPECT_EQ(soak_exp2(126.0F), 0x1p126F);
}

TEST(RuntimeAccuracy, LogarithmsAreThoseOfDoublePrecision) {
  double worst = 0.0;
  for (std::uint32_t bits = 0x00800000U; bits < 0x7F800000U; bits += 10007U) {
    const float x = soak_float_of(bits);
    const double truth = std::log2(static_cast<double>(x));
    const double error = std::abs(static_cast<double>(soak_log2(x)) - truth);
    worst = std::max(worst, error / std::max(1.0, std::abs(truth)));
  }
  EXPECT_LE(worst, 1.2e-7);
}

TEST(RuntimeAccuracy, WholePowersAreThoseOfDoublePrecision) {
  for (std::uint32_t exponent = 1; exponent <= 32; ++exponent) {
    for (double y = -3.0; y < 3.0; y += 0.0137) {
      const auto z = static_cast<float>(y);
      const double truth = std::pow(std::abs(static_cast<double>(z)), static_cast<double>(exponent));
      // A power of e takes e - 1 products at most, however they are arranged, each of 2^-24.
      const double error = std::abs(static_cast<double>(soak_whole_power(z, exponent)) - truth);
      ASSERT_LE(error, (exponent - 1) * 0x1p-24 * truth + 0x1p-149) << z << '^' << exponent;
    }
  }
}

/// Bells that overlap, with these slopes.
anfis::Model bells(const std::vector<double>& slopes) {
  std::vector<anfis::CurveRule> rules;
  for (std::size_t k = 0; k < slopes.size(); ++k) {
    const auto n = static_cast<double>(k);
    rules.push_back({0.3, slopes[k], -1.0 + 0.5 * n, 0.3 * n - 0.5, 0.2 * n - 0.1 * n * n});
  }
  return samples::fis_of(anfis::Shape::bell, rules, {20.0, 50.0}, {0.01, 0.004});
}

TEST(RuntimeAccuracy, RulesOfWholeExponentsAloneAreEvaluatedAsAmongOthers) {
  base::Random random(6);
  for (double slope = 0.5; slope <= 17.0; slope += 0.5) {
    // Files differ in the last rule only: once all exponents are whole, once not all are.
    for (const double last : {slope, 1.7}) {
      const anfis::Model model = bells({slope, slope, 2.0, slope, last});
      const auto bytes = encode(with_bias(model));
      ASSERT_TRUE(bytes) << bytes.error().message;
      const auto d = deviation(*bytes, [&](double t) { return plain_fis(model, t); }, random);
      EXPECT_LE(d.largest, 1e-6 * d.span) << slope << ", " << last;
    }
  }
}

TEST(RuntimeAccuracy, UsualModelsStayWithinAMillionthOfTheirSpan) {
  base::Random random(1);
  double worst = 0.0;
  for (int i = 0; i < 600; ++i) {
    const anfis::Model model = usual_model(random);
    const auto bytes = encode(with_bias(model));
    ASSERT_TRUE(bytes) << i << ": " << bytes.error().message;
    const auto d = deviation(*bytes, [&](double t) { return plain_fis(model, t); }, random);
    worst = std::max(worst, d.largest / d.span);
    ASSERT_LE(d.largest, 1e-6 * d.span) << i;
  }
  RecordProperty("worst_per_span", std::to_string(worst));
}

TEST(RuntimeAccuracy, HostileModelsHoldTheBoundOrAreRefused) {
  SOAK_LONG_TEST();
  base::Random random(2);
  int kept = 0;
  for (int i = 0; i < 600; ++i) {
    const anfis::Model model = hostile_model(random);
    const auto bytes = encode(with_bias(model));
    if (!bytes) {
      ASSERT_EQ(bytes.error().where, "gyro_x bias");
      continue;
    }
    ++kept;
    const auto d = deviation(*bytes, [&](double t) { return plain_fis(model, t); }, random);
    // a tenth more: neither the encoder's temperatures nor these need hit the very worst one
    ASSERT_LE(d.largest, 1.1 * std::max(1e-6 * d.span, 0x1p-23 * d.magnitude)) << i;
  }
  EXPECT_GT(kept, 575);  // nearly all have a spline where their own form fails
}

TEST(RuntimeAccuracy, SplinesAndTablesStayWithinAMillionthOfTheirSpan) {
  base::Random random(3);
  for (int i = 0; i < 500; ++i) {
    SplineCurve spline;
    TableCurve table{-30.0, 0.25 * std::floor(random.uniform(1.0, 24.0)), {}};
    double level = random.uniform(-1.0, 1.0);
    for (double knot = -31.0; knot < 70.0; knot += random.uniform(1.0, 40.0)) {
      spline.knots_c.push_back(knot);
      spline.coefficients.push_back(
          {level, random.uniform(-0.1, 0.1), random.uniform(-1e-3, 1e-3), random.uniform(-1e-4, 1e-4)});
    }
    spline.knots_c.push_back(71.0);
    while (table.values.size() < 20) table.values.push_back(level += random.uniform(-0.1, 0.1));
    for (const Curve& curve : {Curve(spline), Curve(table)}) {
      const auto bytes = encode(with_bias(curve));
      // a spline whose pieces jump moves its jump with its rounded knot: refusing it is right
      if (!bytes && curve.index() == 1) continue;
      ASSERT_TRUE(bytes) << i << ": " << bytes.error().message;
      const auto d = deviation(*bytes, [&](double t) { return evaluate(curve, t); }, random);
      ASSERT_LE(d.largest, 1e-6 * d.span) << i << " kind " << curve.index();
    }
  }
}

TEST(RuntimeAccuracy, OneCubicOverTheWholeRangeStaysWithinAMillionthOfItsSpan) {
  base::Random random(4);
  for (int i = 0; i < 1000; ++i) {
    const Curve curve = SplineCurve{{-30.0, 70.0},
                                    {{random.uniform(-1.0, 1.0), random.uniform(-0.1, 0.1), random.uniform(-2e-3, 2e-3),
                                      random.uniform(-2e-5, 2e-5)}}};
    const auto bytes = encode(with_bias(curve));
    ASSERT_TRUE(bytes) << i << ": " << bytes.error().message;
    const auto d = deviation(*bytes, [&](double t) { return evaluate(curve, t); }, random);
    ASSERT_LE(d.largest, 1e-6 * d.span) << i;
  }
}

TEST(RuntimeAccuracy, StatedErrorBoundIsTheMeasuredOne) {
  base::Random random(5);
  for (int i = 0; i < 50; ++i) {
    const anfis::Model model = usual_model(random);
    const base::Bytes bytes = *encode(with_bias(model));
    soak_cal cal;
    ASSERT_EQ(soak_load(&cal, bytes.data(), bytes.size()), SOAK_OK);
    ASSERT_NE(cal.sensor[0].error_bound[0], nullptr);
    const double bound = static_cast<double>(soak_f32(cal.sensor[0].error_bound[0] + 4));
    const double span = static_cast<double>(soak_f32(cal.sensor[0].error_bound[0] + 8));
    const auto d = deviation(bytes, [&](double t) { return plain_fis(model, t); }, random);
    EXPECT_GE(span, (1.0 - 1e-6) * d.span);
    EXPECT_LE(span, 1.05 * d.span);     // the random temperatures do not reach the ends
    EXPECT_LE(d.largest, 1.5 * bound);  // rounding noise on two different grids
    EXPECT_GE(d.largest, bound / 4.0);  // rounded up by a factor of 2 at most
  }
}

}  // namespace
}  // namespace soak::calib
