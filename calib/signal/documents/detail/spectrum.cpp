// SPDX-License-Identifier: Apache-2.0
#include "calib/signal/spectrum/spectrum.h"

#include <fmt/format.h>

#include <algorithm>

#include "calib/signal/documents/detail/common.h"
#include "calib/signal/documents/detail/record_checks.h"
#include "calib/signal/spectrum/spectral_lines.h"

namespace soak::calib {
namespace {

using nlohmann::json;
using namespace signal_json;

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

}  // namespace

base::Result<json> psd_json(const SignalRecord& record, const PsdRequest& request) {
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

}  // namespace soak::calib
