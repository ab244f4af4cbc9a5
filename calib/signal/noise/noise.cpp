// SPDX-License-Identifier: Apache-2.0
#include "calib/signal/noise/noise.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <complex>
#include <numbers>
#include <span>

#include "base/random.h"
#include "calib/signal/spectrum/detail/fourier.h"

namespace soak::calib::signal {
namespace {

/// One stream of random numbers per kind of noise.
enum class Stream : std::uint64_t { white = 1, flicker, walk, gauss_markov, quantization };

base::Random random_of(const NoiseSource& source, Stream stream) {
  return base::Random(source.seed, static_cast<std::uint64_t>(stream));
}

/// s(t) = t^2 ln t: generalised autocovariance of the phase of flicker noise, up to a factor.
double phase_covariance(double t) { return t > 0.0 ? t * t * std::log(t) : 0.0; }

/// r(k) = 6 s(k) - 4 (s(k-1) + s(k+1)) + s(k-2) + s(k+2), the fourth difference of s. It cancels for large k; there its
/// Taylor series  r(k) = -sum_(j>=2) 4 (4^j - 4)/(2j (2j-1)(2j-2)) k^(2-2j)  keeps all digits.
double second_difference_covariance(std::size_t lag) {
  const auto k = static_cast<double>(lag);
  if (lag < 16) {
    return 6.0 * phase_covariance(k) - 4.0 * (phase_covariance(std::abs(k - 1.0)) + phase_covariance(k + 1.0)) +
           phase_covariance(std::abs(k - 2.0)) + phase_covariance(k + 2.0);
  }
  double sum = 0.0;
  double power = 4.0;    // 4^j k^(2-2j) at j = 1; from k = 16 on it falls at least 64-fold from term to term
  double quarter = 1.0;  // 4^(1-j)
  for (double j = 2.0; j < 11.0; j += 1.0) {
    power *= 4.0 / (k * k);
    quarter *= 0.25;
    sum += 4.0 * power * (1.0 - quarter) / (2.0 * j * (2.0 * j - 1.0) * (2.0 * j - 2.0));
  }
  return -sum;
}

/// Second differences of the phase of flicker noise, scaled to s(t) = t^2 ln t. Their covariance becomes the first row
/// of a circulant matrix, whose eigenvalues its Fourier transform gives. None is negative: r(0) is the only positive
/// covariance and the sum over all lags is 0, so that each eigenvalue is at least what the lags left out would add,
/// about 4/length.
std::vector<double> flicker_second_differences(std::size_t count, base::Random random) {
  const std::size_t half = std::bit_ceil(std::max<std::size_t>(count, 4));
  std::vector<double> row(2 * half);
  for (std::size_t k = 0; k <= half; ++k) row[k] = second_difference_covariance(k);
  for (std::size_t k = half + 1; k < row.size(); ++k) row[k] = row[row.size() - k];
  RealFourier fourier(row.size());
  const std::span<const std::complex<double>> eigenvalues = fourier.forward(row);
  // E |Z_j|^2 = n lambda_j makes the inverse transform, (1/n) sum_j Z_j exp(..), a process with covariance r.
  std::vector<std::complex<double>> spectrum(half + 1);
  const auto n = static_cast<double>(row.size());
  for (std::size_t j = 0; j <= half; ++j) {
    const double scale = std::sqrt(n * eigenvalues[j].real());
    const double a = random.gaussian();
    const double b = random.gaussian();
    const bool is_real = j == 0 || j == half;
    spectrum[j] =
        is_real ? std::complex<double>(scale * a, 0.0) : scale * std::numbers::sqrt2 / 2.0 * std::complex<double>(a, b);
  }
  return inverse_fourier(spectrum);
}

}  // namespace

std::vector<double> white_noise(std::size_t count, double angle_random_walk, const NoiseSource& source) {
  base::Random random = random_of(source, Stream::white);
  const double sigma = angle_random_walk * std::sqrt(source.rate_hz);
  std::vector<double> samples(count);
  for (double& sample : samples) sample = sigma * random.gaussian();
  return samples;
}

std::vector<double> flicker_noise(std::size_t count, double bias_instability, const NoiseSource& source) {
  if (count == 0) return {};
  // r(0) = 8 c ln 2 is the variance of y_(i+1) - y_i, twice the Allan variance (2 ln2/pi) B^2: c = B^2/(2 pi).
  const double scale = bias_instability / std::sqrt(2.0 * std::numbers::pi);
  const std::vector<double> differences = flicker_second_differences(count, random_of(source, Stream::flicker));
  std::vector<double> samples(count);
  for (std::size_t i = 1; i < count; ++i) samples[i] = samples[i - 1] + scale * differences[i - 1];
  return samples;
}

std::vector<double> random_walk(std::size_t count, double rate_random_walk, const NoiseSource& source) {
  base::Random random = random_of(source, Stream::walk);
  const double sigma = rate_random_walk / std::sqrt(source.rate_hz);
  std::vector<double> samples(count);
  double walk = 0.0;
  for (double& sample : samples) {
    // Over an interval h the walk gains dW, variance K^2 h; its mean above the start has the variance K^2 h/3 and the
    // covariance K^2 h/2 with dW: mean = dW/2 + K sqrt(h/12) b.
    const double step = sigma * random.gaussian();
    sample = walk + 0.5 * step + sigma / std::sqrt(12.0) * random.gaussian();
    walk += step;
  }
  return samples;
}

std::vector<double> rate_ramp(std::size_t count, double ramp, double rate_hz) {
  std::vector<double> samples(count);
  for (std::size_t i = 0; i < count; ++i) samples[i] = ramp * static_cast<double>(i) / rate_hz;
  return samples;
}

std::vector<double> gauss_markov_noise(std::size_t count, double sigma, double correlation_s,
                                       const NoiseSource& source) {
  base::Random random = random_of(source, Stream::gauss_markov);
  // x_(i+1) = exp(-h/T) x_i + sigma sqrt(1 - exp(-2h/T)) w_i
  const double decay = std::exp(-1.0 / (source.rate_hz * correlation_s));
  const double drive = sigma * std::sqrt(-std::expm1(-2.0 / (source.rate_hz * correlation_s)));
  std::vector<double> samples(count);
  double state = sigma * random.gaussian();
  for (double& sample : samples) {
    sample = state;
    state = decay * state + drive * random.gaussian();
  }
  return samples;
}

std::vector<double> quantization_noise(std::size_t count, double quantization, const NoiseSource& source) {
  base::Random random = random_of(source, Stream::quantization);
  const double half_step = std::numbers::sqrt3 * quantization;
  std::vector<double> samples(count);
  double error = random.uniform(-half_step, half_step);
  for (double& sample : samples) {
    const double next = random.uniform(-half_step, half_step);
    sample = (next - error) * source.rate_hz;
    error = next;
  }
  return samples;
}

}  // namespace soak::calib::signal
