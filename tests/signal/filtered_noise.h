// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <optional>
#include <random>
#include <string>
#include <vector>

// Noise of a unit behind its own low-pass, made apart from calib and hal/sim: random numbers of the standard library,
// analogue prototypes as sections by the bilinear transform at a multiple of the sample rate, or running means, then
// every k-th value.
namespace soak::filtered_noise {

using Complex = std::complex<double>;

/// One section of a digital filter, direct form II transposed, gain 1 at frequency 0.
struct Section {
  double b0 = 1.0, b1 = 0.0, b2 = 0.0, a1 = 0.0, a2 = 0.0;
  double s1 = 0.0, s2 = 0.0;

  double step(double x) {
    const double y = b0 * x + s1;
    s1 = b1 * x - a1 * y + s2;
    s2 = b2 * x - a2 * y;
    return y;
  }
  [[nodiscard]] Complex response(Complex z) const {
    return (b0 + b1 / z + b2 / (z * z)) / (1.0 + a1 / z + a2 / (z * z));
  }
};

/// Mean of the last n values.
struct RunningMean {
  std::vector<double> last;
  std::size_t at = 0;
  double sum = 0.0;

  explicit RunningMean(std::size_t n) : last(n, 0.0) {}
  double step(double x) {
    sum += x - last[at];
    last[at] = x;
    at = (at + 1) % last.size();
    return sum / static_cast<double>(last.size());
  }
  [[nodiscard]] Complex response(Complex z) const {
    Complex total = 0.0, power = 1.0;
    for (std::size_t i = 0; i < last.size(); ++i, power /= z) total += power;
    return total / static_cast<double>(last.size());
  }
};

/// s = c (z - 1)/(z + 1), c such that 1 rad/s of the prototype comes to `corner` cycles per sample.
inline Section real_pole(double pole, double corner) {
  const double c = 1.0 / std::tan(std::numbers::pi * corner);
  const double p = -pole;
  return {p / (c + p), p / (c + p), 0.0, (p - c) / (c + p), 0.0};
}

inline Section pole_pair(Complex pole, double corner) {
  const double c = 1.0 / std::tan(std::numbers::pi * corner);
  const double w2 = std::norm(pole), d = -2.0 * pole.real();
  const double a0 = c * c + d * c + w2;
  return {w2 / a0, 2.0 * w2 / a0, w2 / a0, 2.0 * (w2 - c * c) / a0, (c * c - d * c + w2) / a0};
}

inline const std::vector<std::string>& filters() {
  static const std::vector<std::string> names = {"pole1",   "pole2",   "pole3",   "pole4",   "butter2", "butter3",
                                                 "butter4", "bessel2", "bessel3", "bessel4", "mean",    "bartlett"};
  return names;
}

/// A filter that halves the power at `corner` cycles per sample.
struct Filter {
  std::vector<Section> sections;
  std::vector<RunningMean> means;

  double step(double x) {
    for (Section& section : sections) x = section.step(x);
    for (RunningMean& mean : means) x = mean.step(x);
    return x;
  }
  [[nodiscard]] double gain(double cycles_per_sample) const {
    const Complex z = std::polar(1.0, 2.0 * std::numbers::pi * cycles_per_sample);
    Complex h = 1.0;
    for (const Section& section : sections) h *= section.response(z);
    for (const RunningMean& mean : means) h *= mean.response(z);
    return std::norm(h);
  }
};

inline Filter make_filter(const std::string& name, double corner) {
  Filter filter;
  const int order = name.back() - '0';
  if (name.starts_with("pole")) {
    const double each = 1.0 / std::sqrt(std::exp2(1.0 / order) - 1.0);
    for (int k = 0; k < order; ++k) filter.sections.push_back(real_pole(-each, corner));
  } else if (name.starts_with("butter")) {
    for (int k = 0; k < order / 2; ++k) {
      const double angle = std::numbers::pi * (0.5 + (2.0 * k + 1.0) / (2.0 * order));
      filter.sections.push_back(pole_pair(std::polar(1.0, angle), corner));
    }
    if (order % 2 == 1) filter.sections.push_back(real_pole(-1.0, corner));
  } else if (name == "bessel2") {  // poles for -3 dB at 1 rad/s, from the reverse Bessel polynomials
    filter.sections = {pole_pair({-1.1016, 0.6360}, corner)};
  } else if (name == "bessel3") {
    filter.sections = {real_pole(-1.3227, corner), pole_pair({-1.0474, 0.9993}, corner)};
  } else if (name == "bessel4") {
    filter.sections = {pole_pair({-1.3700, 0.4102}, corner), pole_pair({-0.9952, 1.2571}, corner)};
  } else {
    const double length = name == "mean" ? 0.442946 : 0.318944;
    const auto n = static_cast<std::size_t>(std::max(1.0, std::round(length / corner)));
    filter.means.assign(name == "mean" ? 1 : 2, RunningMean(n));
  }
  return filter;
}

struct Unit {
  std::string filter = "butter2";  ///< empty: none
  double corner_hz = 42.0;
  double rate_hz = 1000.0;
  double length_s = 1800.0;
  double white = 1.0;         ///< N before the filter, U/sqrt(Hz)
  double flicker = 0.0;       ///< B, U
  double walk = 0.0;          ///< K, U/sqrt(s)
  double markov_sigma = 0.0;  ///< U
  double markov_s = 100.0;
  double step = 0.0;  ///< of the converter, U
};

struct Record {
  std::vector<double> rate;
  double density = 0.0;  ///< N at low frequencies, after sampling and rounding
};

/// Slow noise, 40 values a second. Flicker as a sum of first-order processes whose times are a factor of two apart:
/// PSD B^2/(pi f) = sigma^2/(ln 2 f), to 1 % over five decades.
inline std::vector<double> slow_noise(const Unit& unit, std::mt19937_64& engine) {
  constexpr double kRate = 40.0;
  std::normal_distribution<double> normal;
  std::vector<double> values(static_cast<std::size_t>(unit.length_s * kRate) + 3, 0.0);
  const auto add_markov = [&](double sigma, double time_s) {
    const double keep = std::exp(-1.0 / (kRate * time_s)), drive = sigma * std::sqrt(1.0 - keep * keep);
    double x = sigma * normal(engine);
    for (double& value : values) {
      value += x;
      x = keep * x + drive * normal(engine);
    }
  };
  if (unit.flicker > 0.0) {
    const double sigma = unit.flicker * std::sqrt(std::numbers::ln2 / std::numbers::pi);
    for (double time_s = 0.01; time_s < 100.0 * unit.length_s; time_s *= 2.0) add_markov(sigma, time_s);
  }
  if (unit.markov_sigma > 0.0) add_markov(unit.markov_sigma, unit.markov_s);
  double x = 0.0;
  for (double& value : values) {
    value += x;
    if (unit.walk > 0.0) x += unit.walk / std::sqrt(kRate) * normal(engine);
  }
  return values;
}

/// Values that the filter takes for each that is sampled.
inline std::size_t oversampling(const Unit& unit) {
  return static_cast<std::size_t>(std::ceil(std::max(1.0, 16.0 * unit.corner_hz / unit.rate_hz)));
}

/// Power density of the sampled white noise over that before the filter.
inline double sampled_gain(const Unit& unit, double frequency_hz) {
  const std::size_t k = oversampling(unit);
  const double inner_hz = unit.rate_hz * static_cast<double>(k);
  const Filter filter = make_filter(unit.filter, unit.corner_hz / inner_hz);
  double sum = 0.0;
  for (std::size_t j = 0; j < k; ++j) {
    sum += filter.gain((frequency_hz + static_cast<double>(j) * unit.rate_hz) / inner_hz);
  }
  return sum;
}

/// Where the density of the samples, rounding included, is half of that at frequency 0; nothing without a filter and
/// where it is not so below rate/2.
inline std::optional<double> half_power_hz(const Unit& unit) {
  if (unit.filter.empty()) return std::nullopt;
  const double rounding = unit.step * unit.step / (12.0 * unit.rate_hz) / (unit.white * unit.white);
  const double half = 0.5 * (sampled_gain(unit, 0.0) + rounding);
  for (int i = 1; i <= 1000; ++i) {
    const double frequency_hz = 0.5 * unit.rate_hz * i / 1000.0;
    if (sampled_gain(unit, frequency_hz) + rounding <= half) return frequency_hz;
  }
  return std::nullopt;
}

inline Record make_record(const Unit& unit, std::uint64_t seed) {
  std::mt19937_64 engine(seed);
  std::normal_distribution<double> normal;
  const std::vector<double> slow = slow_noise(unit, engine);
  const bool none = unit.filter.empty();
  const std::size_t k = none ? 1 : oversampling(unit);
  const double inner_hz = unit.rate_hz * static_cast<double>(k);
  Filter filter = none ? Filter{} : make_filter(unit.filter, unit.corner_hz / inner_hz);
  const auto count = static_cast<std::size_t>(unit.length_s * unit.rate_hz);
  const auto settle = none ? std::size_t{0} : static_cast<std::size_t>(10.0 * unit.rate_hz / unit.corner_hz);
  Record record;
  record.rate.reserve(count);
  const double sigma = unit.white * std::sqrt(inner_hz);
  const auto slow_at = [&](double t_s) {
    const double at = std::max(0.0, t_s) * 40.0;
    const auto i = std::min(static_cast<std::size_t>(at), slow.size() - 2);
    const double part = at - static_cast<double>(i);
    return slow[i] + part * (slow[i + 1] - slow[i]);
  };
  for (std::size_t i = 0; i < count + settle; ++i) {
    double y = 0.0;
    const double base = slow_at((static_cast<double>(i) - static_cast<double>(settle)) / unit.rate_hz);
    for (std::size_t j = 0; j < k; ++j) y = filter.step(base + sigma * normal(engine));
    if (unit.step > 0.0) y = unit.step * std::round(y / unit.step);
    if (i >= settle) record.rate.push_back(y);
  }
  const double folded = none ? 1.0 : sampled_gain(unit, 0.0);
  record.density = std::sqrt(unit.white * unit.white * folded + unit.step * unit.step / (12.0 * unit.rate_hz));
  return record;
}

}  // namespace soak::filtered_noise
