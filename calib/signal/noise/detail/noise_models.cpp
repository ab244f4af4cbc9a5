// SPDX-License-Identifier: Apache-2.0
#include "calib/signal/noise/detail/noise_models.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/instruction_set.h"

namespace soak::calib::signal {
namespace {

// Probabilities before the data are seen. They hardly matter where a noise rises above the others by much. Chosen on
// simulated records (tests/signal/mean_error_test.cpp) as a balance: more for the others states white noise larger,
// more for Gauss-Markov processes states flicker and random walk smaller, less states processes that end larger.
constexpr double kWhitePrior = 0.95;
constexpr double kFlickerPrior = 0.025;
constexpr double kWalkPrior = 0.02;
constexpr double kMarkovPrior = 0.005;

/// Strengths against the white noise are told by the averaging time, in parts, at which both have the same Allan
/// variance: from here, where nothing is left of the white noise, in steps of two ..
constexpr double kShortestCrossing = 1.0 / 16.0;
/// .. to this share of the stretch for flicker and random walk; what crosses later does not show.
constexpr double kLongestCrossing = 0.5;

/// Correlation times of Gauss-Markov processes, in parts, in steps of two up to this share of the stretch. One that
/// lasts longer cannot be told from a random walk.
constexpr double kShortestTime = 0.5;
constexpr double kLongestTime = 1.0 / 16.0;

// Generalised autocovariance K(t) of the phase (the integral of the rate) of each noise at unit strength; that of the
// rate is -K''.
double white_phase(double t, double /*time*/) { return -0.5 * t; }
double flicker_phase(double t, double /*time*/) { return t > 0.0 ? t * t * std::log(t) : 0.0; }
double walk_phase(double t, double /*time*/) { return t * t * t / 12.0; }
double markov_phase(double t, double time) { return -time * (time * std::exp(-t / time) + t); }

std::vector<double> steps_of_two(double first, double last) {
  std::vector<double> steps;
  for (double step = first; step <= last; step *= 2.0) steps.push_back(step);
  return steps;
}

void remove_line(std::span<double> values) {
  const auto n = static_cast<double>(values.size());
  const double middle = 0.5 * (n - 1.0);
  double moment = 0.0;
  for (std::size_t i = 0; i < values.size(); ++i) moment += values[i] * (static_cast<double>(i) - middle);
  const double slope = moment / (n * (n * n - 1.0) / 12.0);
  for (std::size_t i = 0; i < values.size(); ++i) values[i] -= slope * (static_cast<double>(i) - middle);
}

/// Covariance of the means of two parts of unit length k apart: K(k-1) - 2 K(k) + K(k+1), negative.
std::vector<double> covariance_of_means(double (*phase)(double, double), double time, std::size_t parts) {
  std::vector<double> covariance(parts);
  for (std::size_t lag = 0; lag < parts; ++lag) {
    const auto k = static_cast<double>(lag);
    covariance[lag] = 2.0 * phase(k, time) - phase(std::abs(k - 1.0), time) - phase(k + 1.0, time);
  }
  return covariance;
}

/// sum_ij c_i c_j R(|i - j|)
SOAK_CLONES
double expected_square(const double* c, const double* covariance, std::size_t n) {
  double power = covariance[0] * product_sum({c, n}, {c, n});
  for (std::size_t lag = 1; lag < n; ++lag) {
    power += 2.0 * covariance[lag] * product_sum({c, n - lag}, {c + lag, n - lag});
  }
  return power;
}

SOAK_CLONES
double power_of(const double* rows, std::size_t count, const double* means, std::size_t parts) {
  double power = 0.0;
  for (std::size_t row = 0; row < count; ++row) {
    const double c = product_sum({rows + row * parts, parts}, {means, parts});
    power += c * c;
  }
  return power;
}

}  // namespace

struct NoiseShape {
  double (*phase)(double t, double time) = nullptr;
  double time = 0.0;
  std::vector<double> band;  ///< mean expected square of the coefficients of each band

  // (1/2) E (y_2 - y_1)^2 = (3 K(0) - 4 K(m) + K(2 m))/m^2
  [[nodiscard]] double allan_variance(double m) const {
    return (3.0 * phase(0.0, time) - 4.0 * phase(m, time) + phase(2.0 * m, time)) / (m * m);
  }
};

NoiseModels::NoiseModels(std::size_t parts) : parts_(parts) {
  make_cosines();
  make_bands();
  const auto length = static_cast<double>(parts);
  const NoiseShape white = shape_of(white_phase, 0.0);
  add(white, white, 0.0, kWhitePrior);
  add_family(white, shape_of(flicker_phase, 0.0), kLongestCrossing * length, kFlickerPrior);
  add_family(white, shape_of(walk_phase, 0.0), kLongestCrossing * length, kWalkPrior);
  const std::vector<double> times = steps_of_two(kShortestTime, kLongestTime * length);
  for (const double time : times) {
    add_family(white, shape_of(markov_phase, time), time, kMarkovPrior / static_cast<double>(times.size()));
  }
}

void NoiseModels::make_cosines() {
  const auto n = static_cast<double>(parts_);
  cosines_.resize((parts_ - 2) * parts_);
  for (std::size_t k = 2; k < parts_; ++k) {
    const std::span<double> row(cosines_.data() + (k - 2) * parts_, parts_);
    for (std::size_t i = 0; i < parts_; ++i) {
      const double turn = static_cast<double>(k) * (static_cast<double>(i) + 0.5) / n;
      row[i] = std::sqrt(2.0 / n) * std::cos(std::numbers::pi * turn);
    }
    remove_line(row);
  }
}

void NoiseModels::make_bands() {
  for (std::size_t k = 2; k < parts_; k += bands_.back().count) {
    bands_.push_back({k - 2, std::min(std::max<std::size_t>(1, k / 5), parts_ - k)});
  }
}

std::span<const double> NoiseModels::cosine(std::size_t row) const { return {cosines_.data() + row * parts_, parts_}; }

NoiseShape NoiseModels::shape_of(double (*phase)(double t, double time), double time) const {
  NoiseShape shape{phase, time, {}};
  const std::vector<double> covariance = covariance_of_means(phase, time, parts_);
  for (const Band& band : bands_) {
    double power = 0.0;
    for (std::size_t row = band.first; row < band.first + band.count; ++row) {
      power += expected_square(cosine(row).data(), covariance.data(), parts_);
    }
    shape.band.push_back(power / static_cast<double>(band.count));
  }
  return shape;
}

void NoiseModels::add_family(const NoiseShape& white, const NoiseShape& coloured, double longest_crossing,
                             double prior) {
  const std::vector<double> crossings = steps_of_two(kShortestCrossing, longest_crossing);
  for (const double m : crossings) {
    const double ratio = white.allan_variance(m) / coloured.allan_variance(m);
    add(white, coloured, ratio, prior / static_cast<double>(crossings.size()));
  }
}

void NoiseModels::add(const NoiseShape& white, const NoiseShape& coloured, double ratio, double prior) {
  const auto length = static_cast<double>(parts_);
  Model model;
  model.log_evidence = std::log(prior);
  model.allan_deviation = std::sqrt(white.allan_variance(length) + ratio * coloured.allan_variance(length));
  for (std::size_t b = 0; b < bands_.size(); ++b) {
    const double expected = white.band[b] + ratio * coloured.band[b];
    model.weight.push_back(1.0 / expected);
    model.log_evidence -= 0.5 * static_cast<double>(bands_[b].count) * std::log(expected);
  }
  models_.push_back(std::move(model));
}

std::vector<double> NoiseModels::band_powers(std::span<const double> means) const {
  std::vector<double> powers;
  powers.reserve(bands_.size());
  for (const Band& band : bands_) {
    powers.push_back(power_of(cosines_.data() + band.first * parts_, band.count, means.data(), parts_));
  }
  return powers;
}

double NoiseModels::allan_deviation(std::span<const double> means) const {
  const std::vector<double> powers = band_powers(means);
  const auto n = static_cast<double>(parts_ - 2);
  std::vector<double> log_probability;
  std::vector<double> deviation;
  for (const Model& model : models_) {
    // With S = sum_k c_k^2/v_k, the scale's likelihood integrates to  prior * prod_k v_k^(-1/2) * S^(-n/2),
    // and its mean is S/(n - 2).
    const double s = product_sum(model.weight, powers);
    if (!(s > 0.0)) return 0.0;
    log_probability.push_back(model.log_evidence - 0.5 * n * std::log(s));
    deviation.push_back(std::sqrt(s / (n - 2.0)) * model.allan_deviation);
  }
  const double most = *std::max_element(log_probability.begin(), log_probability.end());
  double weights = 0.0;
  double sum = 0.0;
  for (std::size_t i = 0; i < deviation.size(); ++i) {
    const double weight = std::exp(log_probability[i] - most);
    weights += weight;
    sum += weight * deviation[i];
  }
  return sum / weights;
}

}  // namespace soak::calib::signal
