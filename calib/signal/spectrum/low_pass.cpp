// SPDX-License-Identifier: Apache-2.0
#include "calib/signal/spectrum/low_pass.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>
#include <vector>

#include "base/statistics.h"
#include "calib/signal/samples/sample_grid.h"
#include "calib/signal/spectrum/spectrum.h"

namespace soak::calib::signal {
namespace {

constexpr double kSection_s = 16.0;
constexpr std::size_t kShortestCornerSection = 64;
constexpr std::size_t kFewestSections = 8;
/// Lowest frequency that is looked at, and in bins of the spectrum: below, drift leaks in.
constexpr double kLowest_hz = 0.2;
constexpr double kLowestBin = 3.0;
constexpr double kBandRatio = 1.09;
constexpr std::size_t kFewestBands = 12;
/// A density is believed to this share of itself: sampled noises are no textbook power laws.
constexpr double kDensityError = 0.005;
/// Evidence that makes a filter.
constexpr double kCornerEvidence = 12.0;
/// No filter is exactly of one of the forms, and the depth of the stop band must not rule the shape about the corner.
/// Share of the density in the pass band that is added throughout, relative error of a form's density per neper that it
/// attenuates, and by how much the corners of forms that come near one another differ.
constexpr double kStopBand = 0.01;
constexpr double kFormError = 0.1;
constexpr double kFormRange = 1.6;
constexpr double kCoarse = 1.2;
constexpr double kFine = 1.03;
constexpr double kFinest = 1.004;
constexpr double kHighestCorner = 1.5;  ///< of the rate

struct Form {
  LowPassForm form;
  int order;
};
constexpr std::array<Form, 10> kForms = {{{LowPassForm::butterworth, 1},
                                          {LowPassForm::butterworth, 2},
                                          {LowPassForm::butterworth, 3},
                                          {LowPassForm::butterworth, 4},
                                          {LowPassForm::equal_poles, 2},
                                          {LowPassForm::equal_poles, 3},
                                          {LowPassForm::equal_poles, 4},
                                          {LowPassForm::equal_poles, 8},
                                          {LowPassForm::means, 1},
                                          {LowPassForm::means, 2}}};

/// Half of the power behind one mean and behind two: sinc(b)^2 = 1/2, sinc(b)^4 = 1/2.
constexpr std::array<double, 2> kMeansAtCorner = {0.442946, 0.318944};

double form_gain(LowPassForm form, int order, double x) {
  const double n = order;
  if (form == LowPassForm::butterworth) return 1.0 / (1.0 + std::pow(x * x, n));
  if (form == LowPassForm::equal_poles) return std::pow(1.0 + x * x * (std::exp2(1.0 / n) - 1.0), -n);
  const double phase = std::numbers::pi * kMeansAtCorner[static_cast<std::size_t>(order - 1)] * x;
  return phase < 1e-6 ? 1.0 : std::pow(std::sin(phase) / phase, 2.0 * n);
}

/// Of the sampled noise: what lies beyond half the rate comes back.
double sampled_gain(LowPassForm form, int order, double corner_hz, double rate_hz, double frequency_hz) {
  constexpr int kFolds = 3;
  double sum = 0.0;
  for (int k = -kFolds; k <= kFolds; ++k) {
    sum += form_gain(form, order, std::abs(frequency_hz + k * rate_hz) / corner_hz);
  }
  return sum;
}

/// Median densities of bands, with their relative variances.
struct Bands {
  std::vector<double> frequency_hz;
  std::vector<double> density;
  std::vector<double> variance;
};

/// Sections of about kSection_s, shorter ones where the record or its gaps leave too few of these.
std::optional<Spectrum> spectrum_of(std::span<const double> samples, double rate_hz) {
  std::size_t longest = 0;
  for (const SampleRange& range : stretches_of(samples)) longest = std::max(longest, range.count());
  auto section = static_cast<std::size_t>(std::exp2(std::round(std::log2(kSection_s * rate_hz))));
  for (; section >= kShortestCornerSection; section /= 2) {
    if (section > longest) continue;
    auto spectrum = welch(samples, rate_hz, {.section = section, .detrend = Detrend::line});
    if (spectrum && spectrum->sections >= kFewestSections) return *std::move(spectrum);
  }
  return std::nullopt;
}

Bands bands_of(const Spectrum& spectrum) {
  const double spacing_hz = spectrum.frequency_hz[1];
  const double dof = spectrum.degrees_of_freedom;
  const double median_of_chi = std::pow(1.0 - 2.0 / (9.0 * dof), 3);
  Bands bands;
  auto first = static_cast<std::size_t>(std::ceil(std::max(kLowest_hz / spacing_hz, kLowestBin)));
  const std::size_t end = spectrum.density.size() - 1;
  while (first < end) {
    const double next = static_cast<double>(first) * kBandRatio;
    const std::size_t last = std::clamp(static_cast<std::size_t>(std::ceil(next)), first + 1, end);
    const auto count = static_cast<double>(last - first);
    const std::span<const double> densities = std::span(spectrum.density).subspan(first, last - first);
    const bool is_median = last - first > 2;
    bands.frequency_hz.push_back(0.5 * spacing_hz * static_cast<double>(first + last - 1));
    bands.density.push_back(base::median(densities) / (is_median ? median_of_chi : 1.0));
    // Neighbours of a Hann window correlate by 4/9 and 1/36: 1 + 2 (4/9 + 1/36) = 1.94; a median has pi/2 the variance.
    const double efficiency = is_median ? 1.94 * 0.5 * std::numbers::pi : std::min(1.5, count);
    bands.variance.push_back(2.0 / dof * efficiency / count + kDensityError * kDensityError);
    first = last;
  }
  return bands;
}

/// Non-negative sum of densities, each a row over the bands.
using Columns = std::vector<std::vector<double>>;

/// Minimises the weighted squares by turns, one coefficient after the other.
std::vector<double> non_negative_sum(const Columns& columns, const std::vector<double>& density,
                                     const std::vector<double>& weight) {
  constexpr int kTurns = 100;
  const std::size_t p = columns.size();
  std::vector<double> gram(p * p), moment(p), x(p, 0.0);
  for (std::size_t a = 0; a < p; ++a) {
    for (std::size_t i = 0; i < density.size(); ++i) moment[a] += weight[i] * columns[a][i] * density[i];
    for (std::size_t b = 0; b <= a; ++b) {
      double sum = 0.0;
      for (std::size_t i = 0; i < density.size(); ++i) sum += weight[i] * columns[a][i] * columns[b][i];
      gram[a * p + b] = gram[b * p + a] = sum;
    }
  }
  for (int turn = 0; turn < kTurns; ++turn) {
    for (std::size_t a = 0; a < p; ++a) {
      double rest = moment[a];
      for (std::size_t b = 0; b < p; ++b) rest -= b == a ? 0.0 : gram[a * p + b] * x[b];
      x[a] = gram[a * p + a] > 0.0 ? std::max(0.0, rest / gram[a * p + a]) : 0.0;
    }
  }
  return x;
}

struct SumFit {
  double deviance = std::numeric_limits<double>::infinity();
  std::vector<double> coefficient;
};

/// The sum that makes Whittle's likelihood large: squares weighted by the sum itself, a few times over.
SumFit fit_sum(const Columns& columns, const Bands& bands) {
  constexpr int kReweightings = 4;
  const std::size_t n = bands.density.size();
  std::vector<double> model = bands.density;
  SumFit fit;
  for (int k = 0; k < kReweightings; ++k) {
    std::vector<double> weight(n);
    for (std::size_t i = 0; i < n; ++i) weight[i] = 1.0 / (bands.variance[i] * model[i] * model[i]);
    fit.coefficient = non_negative_sum(columns, bands.density, weight);
    std::fill(model.begin(), model.end(), 0.0);
    for (std::size_t a = 0; a < columns.size(); ++a) {
      for (std::size_t i = 0; i < n; ++i) model[i] += fit.coefficient[a] * columns[a][i];
    }
    for (std::size_t i = 0; i < n; ++i) model[i] = std::max(model[i], 1e-6 * bands.density[i]);
  }
  fit.deviance = 0.0;
  for (std::size_t i = 0; i < n; ++i) {
    const double ratio = bands.density[i] / model[i];
    fit.deviance += 2.0 / bands.variance[i] * (ratio - 1.0 - std::log(ratio));
  }
  return fit;
}

/// Corners of slow Gauss-Markov processes over kLeastCorner_hz.
constexpr std::array<double, 4> kSlow = {0.1, 0.2, 0.4, 0.8};
/// So many behind a filter: faster ones would bend the pass band of the slowest filters.
constexpr std::size_t kSlowFiltered = 2;

/// What a filter acts on: white noise first, then flicker, random walk and slow Gauss-Markov processes.
Columns noises(const Bands& bands, std::size_t slow) {
  Columns columns(3 + slow);
  for (const double f : bands.frequency_hz) {
    columns[0].push_back(1.0);
    columns[1].push_back(1.0 / f);
    columns[2].push_back(1.0 / (f * f));
    for (std::size_t k = 0; k < slow; ++k) {
      const double x = f / (kSlow[k] * kLeastCorner_hz);
      columns[3 + k].push_back(1.0 / (1.0 + x * x));
    }
  }
  return columns;
}

/// Of the integral of the rate: it rises with frequency.
std::vector<double> quantization(const Bands& bands, double rate_hz) {
  std::vector<double> density;
  for (const double f : bands.frequency_hz) density.push_back(std::pow(std::sin(std::numbers::pi * f / rate_hz), 2));
  return density;
}

/// Median of the densities where every filter still passes and most drift has ended.
double passed_density(const Bands& bands) {
  std::vector<double> passed;
  for (std::size_t i = 0; i < bands.density.size(); ++i) {
    const double x = bands.frequency_hz[i] / kLeastCorner_hz;
    if (x > 0.5 && x < 1.0) passed.push_back(bands.density[i]);
  }
  return base::median(passed.empty() ? bands.density : passed);
}

struct Candidate {
  LowPass filter;
  double deviance = std::numeric_limits<double>::infinity();
};

class Search {
 public:
  /// `added`: density that is in the bands and not in the samples.
  Search(const Bands& bands, double rate_hz, double added)
      : bands_(bands), rate_hz_(rate_hz), added_(added), noises_(noises(bands, kSlowFiltered)) {}

  [[nodiscard]] double deviance_without() const {
    Columns columns = noises(bands_, kSlow.size());
    columns.push_back(quantization(bands_, rate_hz_));
    return fit_sum(columns, bands_).deviance;
  }

  /// The best over all forms and corners in the range.
  [[nodiscard]] Candidate best(double least_hz, double most_hz) const {
    Candidate best;
    for (const Form& form : kForms) {
      const Candidate coarse =
          scan(form, std::max(kLeastCorner_hz, least_hz), std::min(kHighestCorner * rate_hz_, most_hz), kCoarse);
      const Candidate fine = around(form, coarse.filter.corner_hz, kCoarse, kFine);
      const Candidate finest = around(form, fine.filter.corner_hz, kFine, kFinest);
      if (finest.deviance < best.deviance) best = finest;
    }
    return best;
  }

 private:
  [[nodiscard]] Candidate around(const Form& form, double corner_hz, double range, double ratio) const {
    return scan(form, std::max(kLeastCorner_hz, corner_hz / range),
                std::min(kHighestCorner * rate_hz_, corner_hz * range), ratio);
  }

  [[nodiscard]] Candidate scan(const Form& form, double from_hz, double to_hz, double ratio) const {
    Candidate best;
    for (double corner_hz = from_hz; corner_hz <= to_hz * (1.0 + 1e-9); corner_hz *= ratio) {
      const Candidate candidate = with({corner_hz, rate_hz_, form.form, form.order, 0.0});
      if (candidate.deviance < best.deviance) best = candidate;
    }
    return best;
  }

  [[nodiscard]] Candidate with(LowPass filter) const {
    Columns columns = noises_;
    for (std::size_t i = 0; i < bands_.density.size(); ++i) {
      const double gain = filter.gain(bands_.frequency_hz[i]);
      for (std::vector<double>& column : columns) column[i] *= gain;
    }
    columns.emplace_back(bands_.density.size(), 1.0);
    const SumFit fit = fit_sum(columns, bands_);
    const double behind = std::max(0.0, fit.coefficient.back() - added_);
    const double white = fit.coefficient.front() + behind;
    filter.floor = white > 0.0 ? behind / white : 0.0;
    return {filter, fit.deviance};
  }

  const Bands& bands_;
  double rate_hz_;
  double added_;
  Columns noises_;
};

}  // namespace

double LowPass::gain(double frequency_hz) const {
  const double through =
      sampled_gain(form, order, corner_hz, rate_hz, frequency_hz) / sampled_gain(form, order, corner_hz, rate_hz, 0.0);
  return floor + (1.0 - floor) * through;
}

std::optional<double> LowPass::half_power_hz() const {
  constexpr double kSteps = 2000.0;
  for (double i = 1.0; i <= kSteps; ++i) {
    const double frequency_hz = 0.5 * rate_hz * i / kSteps;
    if (gain(frequency_hz) <= 0.5) return frequency_hz;
  }
  return std::nullopt;
}

std::optional<LowPass> find_low_pass(std::span<const double> samples, double rate_hz) {
  if (!(rate_hz >= 4.0 * kLeastCorner_hz)) return std::nullopt;
  const std::optional<Spectrum> spectrum = spectrum_of(samples, rate_hz);
  if (!spectrum) return std::nullopt;
  Bands bands = bands_of(*spectrum);
  const bool is_noise = std::all_of(bands.density.begin(), bands.density.end(), [](double d) { return d > 0.0; });
  if (bands.density.size() < kFewestBands || !is_noise) return std::nullopt;
  const double added = kStopBand * passed_density(bands);
  for (double& density : bands.density) density += added;
  const Search search(bands, rate_hz, added);
  const double without = search.deviance_without();
  const Candidate found = search.best(kLeastCorner_hz, kHighestCorner * rate_hz);
  if (without - found.deviance < kCornerEvidence || found.filter.corner_hz <= kLeastCorner_hz) return std::nullopt;
  for (std::size_t i = 0; i < bands.density.size(); ++i) {
    const double error = -kFormError * std::log(std::max(kStopBand, found.filter.gain(bands.frequency_hz[i])));
    bands.variance[i] += error * error;
  }
  return search.best(found.filter.corner_hz / kFormRange, found.filter.corner_hz * kFormRange).filter;
}

}  // namespace soak::calib::signal
