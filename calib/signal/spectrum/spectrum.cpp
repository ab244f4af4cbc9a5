// SPDX-License-Identifier: Apache-2.0
#include "calib/signal/spectrum/spectrum.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <functional>
#include <numbers>
#include <numeric>
#include <span>

#include "base/statistics.h"
#include "calib/signal/samples/sample_grid.h"
#include "calib/signal/spectrum/detail/fourier.h"

namespace soak::calib::signal {
namespace {

constexpr std::size_t kShortestSection = 8;
constexpr double kMostOverlap = 0.95;

base::Status check_welch(std::span<const double> samples, double rate_hz, const WelchOptions& options) {
  if (auto status = check_rate(rate_hz); !status) return status;
  if (!(options.overlap >= 0.0 && options.overlap <= kMostOverlap)) {
    return base::bad_input(
        fmt::format("the overlap is {}; it must lie within 0 and {}", options.overlap, kMostOverlap));
  }
  if (options.section < kShortestSection || samples.size() < kShortestSection) {
    return base::bad_input(fmt::format("{} samples in sections of {}; a spectrum needs at least {} of both",
                                       samples.size(), options.section, kShortestSection));
  }
  return check_none_infinite(samples);
}

std::vector<double> hann(std::size_t n) {
  std::vector<double> window(n);
  for (std::size_t i = 0; i < n; ++i) {
    window[i] = 0.5 - 0.5 * std::cos(2.0 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(n));
  }
  return window;
}

double squares(const std::vector<double>& values) {
  return std::inner_product(values.begin(), values.end(), values.begin(), 0.0);
}

/// Numbers j of the sections, from j*step on, that lack no sample.
std::vector<std::size_t> whole_sections(std::span<const double> samples, std::size_t length, std::size_t step) {
  std::vector<std::size_t> whole;
  for (std::size_t j = 0; j * step + length <= samples.size(); ++j) {
    const std::span<const double> section = samples.subspan(j * step, length);
    if (std::none_of(section.begin(), section.end(), [](double v) { return std::isnan(v); })) whole.push_back(j);
  }
  return whole;
}

void remove_trend(std::vector<double>& section, Detrend detrend) {
  if (detrend == Detrend::none) return;
  const auto n = static_cast<double>(section.size());
  const double middle = 0.5 * (n - 1.0);
  const double mean = std::accumulate(section.begin(), section.end(), 0.0) / n;
  double moment = 0.0;
  for (std::size_t i = 0; i < section.size(); ++i) moment += (section[i] - mean) * (static_cast<double>(i) - middle);
  // sum_i (i - middle)^2 = n (n^2 - 1)/12
  const double slope = detrend == Detrend::line ? moment / (n * (n * n - 1.0) / 12.0) : 0.0;
  for (std::size_t i = 0; i < section.size(); ++i) section[i] -= mean + slope * (static_cast<double>(i) - middle);
}

/// sum over the sections of |X_k|^2 of the windowed samples
std::vector<double> summed_powers(std::span<const double> samples, const std::vector<std::size_t>& sections,
                                  std::size_t step, const std::vector<double>& window, Detrend detrend) {
  RealFourier fourier(window.size());
  std::vector<double> powers(window.size() / 2 + 1);
  for (const std::size_t j : sections) {
    const auto first = samples.begin() + static_cast<std::ptrdiff_t>(j * step);
    std::vector<double> section(first, first + static_cast<std::ptrdiff_t>(window.size()));
    remove_trend(section, detrend);
    std::transform(section.begin(), section.end(), window.begin(), section.begin(), std::multiplies<>());
    const std::span<const std::complex<double>> spectrum = fourier.forward(section);
    for (std::size_t k = 0; k < powers.size(); ++k) powers[k] += std::norm(spectrum[k]);
  }
  return powers;
}

/// Correlation rho of the periodograms of two sections `shift` samples apart.
double section_correlation(const std::vector<double>& window, std::size_t shift) {
  const auto from = window.begin() + static_cast<std::ptrdiff_t>(shift);
  const double product = std::inner_product(from, window.end(), window.begin(), 0.0);
  return std::pow(product / squares(window), 2);
}

double effective_degrees_of_freedom(const std::vector<std::size_t>& sections, std::size_t step,
                                    const std::vector<double>& window) {
  const auto count = static_cast<double>(sections.size());
  double sum = 0.0;
  for (std::size_t distance = 1; distance * step < window.size(); ++distance) {
    std::size_t pairs = 0;
    for (const std::size_t j : sections) {
      pairs += std::binary_search(sections.begin(), sections.end(), j + distance) ? 1U : 0U;
    }
    sum += static_cast<double>(pairs) / count * section_correlation(window, distance * step);
  }
  return 2.0 * count / (1.0 + 2.0 * sum);
}

constexpr std::size_t kFewestBins = 64;
constexpr std::size_t kSide = 16;
constexpr std::size_t kWidth = 3;  ///< bins on either side that a Hann window spreads a sine over, with room
constexpr std::size_t kFirst = 6;
constexpr std::size_t kMost = 8;
constexpr double kFalseAlarm = 0.001;  ///< per spectrum
/// A median of 13 bins scatters itself.
constexpr double kFloorScatter = 1.3;

/// The larger of the median densities below and above bin i, without the bins next to it: on the slope of a coloured
/// spectrum only what stands above the steeper side is a line.
double floor_at(const Spectrum& spectrum, std::size_t i) {
  const std::span<const double> density = spectrum.density;
  const std::size_t below = i > kSide ? i - kSide : 1;
  const std::size_t above = std::min(density.size(), i + kSide + 1);
  double floor = base::median(density.subspan(below, i - kWidth - below));
  if (above > i + kWidth + 1)
    floor = std::max(floor, base::median(density.subspan(i + kWidth + 1, above - i - kWidth - 1)));
  return floor;
}

bool is_peak(std::span<const double> density, std::size_t i) {
  for (std::size_t k = i - kWidth; k <= std::min(density.size() - 1, i + kWidth); ++k) {
    if (density[k] > density[i]) return false;
  }
  return true;
}

SpectralLine line_at(const Spectrum& spectrum, std::size_t i, double floor) {
  const double spacing_hz = spectrum.frequency_hz[1];
  double power = 0.0;
  double moment = 0.0;
  for (std::size_t k = i - kWidth; k <= std::min(spectrum.density.size() - 1, i + kWidth); ++k) {
    const double above = std::max(0.0, spectrum.density[k] - floor);
    power += above * spacing_hz;
    moment += above * spacing_hz * spectrum.frequency_hz[k];
  }
  return {moment / power, std::sqrt(2.0 * power)};
}

}  // namespace

base::Result<Spectrum> welch(std::span<const double> samples, double rate_hz, const WelchOptions& options) {
  if (auto status = check_welch(samples, rate_hz, options); !status) return base::forward_error(status);
  const std::size_t length = std::min(options.section, samples.size());
  const auto repeated = static_cast<std::size_t>(options.overlap * static_cast<double>(length));
  const std::size_t step = length - repeated;
  const std::vector<std::size_t> sections = whole_sections(samples, length, step);
  if (sections.empty()) {
    return base::bad_input(fmt::format("no {} samples in a row without a gap; choose shorter sections", length));
  }
  const std::vector<double> window = hann(length);
  Spectrum spectrum;
  spectrum.sections = sections.size();
  spectrum.degrees_of_freedom = effective_degrees_of_freedom(sections, step, window);
  spectrum.density = summed_powers(samples, sections, step, window, options.detrend);
  // One side carries the power of both, but 0 and (where the length is even) rate/2 have no other side.
  const double scale = 1.0 / (rate_hz * squares(window) * static_cast<double>(sections.size()));
  for (std::size_t k = 0; k < spectrum.density.size(); ++k) {
    spectrum.density[k] *= k == 0 || 2 * k == length ? scale : 2.0 * scale;
    spectrum.frequency_hz.push_back(static_cast<double>(k) * rate_hz / static_cast<double>(length));
  }
  return spectrum;
}

std::vector<SpectralLine> spectral_lines(const Spectrum& spectrum) {
  std::vector<SpectralLine> lines;
  const std::size_t bins = spectrum.density.size();
  if (bins < kFewestBins) return lines;
  // Density over its expectation is chi-squared over its degrees of freedom; so is the median that it is compared with.
  const double dof = spectrum.degrees_of_freedom;
  const double chance = 1.0 - kFalseAlarm / static_cast<double>(bins);
  const double factor = kFloorScatter * base::chi_squared_quantile(chance, dof) / base::chi_squared_quantile(0.5, dof);
  for (std::size_t i = kFirst; i < bins; ++i) {
    if (!is_peak(spectrum.density, i)) continue;
    const double floor = floor_at(spectrum, i);
    if (spectrum.density[i] > factor * floor && spectrum.density[i] > 0.0) lines.push_back(line_at(spectrum, i, floor));
  }
  std::sort(lines.begin(), lines.end(),
            [](const SpectralLine& a, const SpectralLine& b) { return a.amplitude > b.amplitude; });
  if (lines.size() > kMost) lines.resize(kMost);
  return lines;
}

}  // namespace soak::calib::signal
