// SPDX-License-Identifier: Apache-2.0
#include "calib/signal/spectrum/spectral_lines.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "base/statistics.h"

namespace soak::calib::signal {
namespace {

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
