// SPDX-License-Identifier: Apache-2.0
#include "calib/signal/documents/signal_json.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "calib/signal/documents/detail/record.h"
#include "calib/signal/samples/sample_grid.h"
#include "calib/signal/spectrum/autocorrelation.h"
#include "calib/signal/spectrum/spectrum.h"

namespace soak::calib::signal_json {
namespace {

using nlohmann::json;

constexpr std::size_t kSection = 4096;
constexpr std::size_t kSmallestSection = 64;

std::string squared_per_hz(const std::string& unit) { return unit.empty() ? "1/Hz" : fmt::format("({})^2/Hz", unit); }

/// Largest power of two that is at most `limit`.
std::size_t power_of_two_below(std::size_t limit) {
  std::size_t power = 1;
  while (2 * power <= limit) power *= 2;
  return power;
}

json spectrum_json(const signal::Spectrum& spectrum, const std::string& unit) {
  const double spacing_hz = spectrum.frequency_hz.size() > 1 ? spectrum.frequency_hz[1] : 0.0;
  double variance = 0.0;
  for (const double density : spectrum.density) variance += density * spacing_hz;
  json lines = json::array();
  for (const signal::SpectralLine& line : signal::spectral_lines(spectrum)) {
    lines.push_back({{"frequency_hz", line.frequency_hz}, {"amplitude", line.amplitude}});
  }
  return {{"frequency_hz", spectrum.frequency_hz},
          {"psd", spectrum.density},
          {"psd_unit", squared_per_hz(unit)},
          {"sections", spectrum.sections},
          {"degrees_of_freedom", spectrum.degrees_of_freedom},
          {"variance", variance},
          {"lines", std::move(lines)}};
}

json process_json(const base::Result<signal::GaussMarkov>& process) {
  if (!process) return {};
  return {{"sigma", process->sigma},
          {"correlation_s", process->correlation_s},
          {"beta_per_s", process->beta_per_s},
          {"white_sigma", process->white_sigma},
          {"rms_misfit", process->rms_misfit}};
}

base::Result<json> correlation_json(std::vector<double> values, double rate_hz, std::size_t longest) {
  signal::remove_stretch_means(values);
  const auto acf = signal::autocorrelation(values, longest);
  if (!acf) return base::forward_error(acf);
  std::vector<double> lags_s;
  for (std::size_t k = 0; k < acf->correlation.size(); ++k) lags_s.push_back(static_cast<double>(k) / rate_hz);
  return json{{"lag_s", lags_s},
              {"acf", acf->correlation},
              {"variance", acf->variance},
              {"correlation_time_s", number(signal::correlation_time_s(*acf, rate_hz))},
              {"gauss_markov_1", process_json(signal::fit_gauss_markov_1(*acf, rate_hz))},
              {"gauss_markov_2", process_json(signal::fit_gauss_markov_2(*acf, rate_hz))}};
}

}  // namespace

}  // namespace soak::calib::signal_json

namespace soak::calib {

base::Result<WmraResult> wmra(const SignalRecord& record, const WmraRequest& request) {
  using namespace signal_json;
  const auto wavelet = signal::wavelet_named(request.wavelet);
  if (!wavelet) return base::forward_error(wavelet);
  const std::vector<double> values = bridged_values(record);
  WmraResult result;
  std::size_t longest = 0;
  for (const signal::SampleRange& range : signal::stretches_of(values)) {
    const std::span<const double> stretch(values.data() + range.first, range.count());
    auto split = signal::denoise(stretch, *wavelet, request.options);
    if (!split) return base::forward_error(split);
    for (std::size_t i = 0; i < stretch.size(); ++i) {
      if (std::isnan(record.values[range.first + i])) continue;
      result.t_s.push_back(record.t_s[range.first + i]);
      result.raw.push_back(stretch[i]);
      result.denoised.push_back(split->signal[i]);
      result.trend.push_back(split->trend[i]);
    }
    if (range.count() > longest) {
      longest = range.count();
      result.useful_levels = signal::useful_levels(longest, *wavelet);
      result.sigma = std::move(split->sigma);
      result.thresholds = std::move(split->thresholds);
    }
    ++result.stretches;
  }
  if (result.stretches == 0) return base::bad_input("the record has no samples");
  return result;
}

base::Result<nlohmann::json> psd_json(const SignalRecord& record, const PsdRequest& request) {
  using namespace signal_json;
  if (auto status = check_changes(record.values); !status) return base::forward_error(status);
  const std::vector<double> values = bridged_values(record);
  const std::size_t room = longest_stretch(values);
  if (room < 8) return base::bad_input(fmt::format("the longest stretch has {} samples: at least 8 are needed", room));
  signal::WelchOptions options;
  // Eight half-overlapping sections at least where the stretch has room for them.
  const std::size_t comfortable =
      std::max(std::min(kSmallestSection, power_of_two_below(room)), power_of_two_below(room / 4));
  options.section = request.section.value_or(std::min(kSection, comfortable));
  const auto spectrum = signal::welch(values, record.rate_hz, options);
  if (!spectrum) return base::forward_error(spectrum);
  json document = header(record);
  document.update(spectrum_json(*spectrum, record.unit));
  document["section"] = std::min(options.section, values.size());
  document["after_wmra"] = nullptr;
  if (!request.after) return document;
  const auto denoised = denoised_values(record, *request.after);
  if (!denoised) return base::forward_error(denoised);
  const auto after = signal::welch(*denoised, record.rate_hz, options);
  if (!after) return base::forward_error(after);
  document["after_wmra"] = spectrum_json(*after, record.unit);
  return document;
}

base::Result<nlohmann::json> acf_json(const SignalRecord& record, const AcfRequest& request) {
  using namespace signal_json;
  const std::vector<double> values = bridged_values(record);
  const std::size_t room = longest_stretch(values);
  const double lag_s = request.longest_lag_s.value_or(0.1 * static_cast<double>(room) / record.rate_hz);
  const double lag = std::max(4.0, std::round(lag_s * record.rate_hz));
  if (!(lag_s > 0.0) || lag >= static_cast<double>(room)) {
    return base::bad_input(fmt::format("a longest lag of {:g} s: the longest stretch of the record lasts {:g} s", lag_s,
                                       static_cast<double>(room) / record.rate_hz),
                           "--max-lag-s");
  }
  const auto longest = static_cast<std::size_t>(lag);
  const auto before = correlation_json(values, record.rate_hz, longest);
  if (!before) return base::forward_error(before);
  json document = header(record);
  document.update(*before);
  document["after_wmra"] = nullptr;
  if (!request.after) return document;
  const auto denoised = denoised_values(record, *request.after);
  if (!denoised) return base::forward_error(denoised);
  const auto after = correlation_json(*denoised, record.rate_hz, longest);
  if (!after) return base::forward_error(after);
  document["after_wmra"] = *after;
  return document;
}

}  // namespace soak::calib
