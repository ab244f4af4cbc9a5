// SPDX-License-Identifier: Apache-2.0
#include "calib/signal/allan.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include "calib/signal/allan_fit.h"
#include "calib/signal_json/common.h"

namespace soak::calib {
namespace {

using nlohmann::json;
using namespace signal_json;

constexpr std::size_t kPerDecade = 12;
constexpr double kDoubtfulFit = 0.001;

/// The unit U of the rate together with what a coefficient has beside it.
std::string with(const std::string& unit, std::string_view suffix) {
  return (unit.empty() ? "1" : unit) + std::string(suffix);
}

/// Unit of the integral of a rate in `unit`.
std::string integral_unit(const std::string& unit) {
  if (unit == "m/s2") return "m/s";
  if (unit.ends_with("/s")) return unit.substr(0, unit.size() - 2);
  return unit.empty() ? "s" : unit + "*s";
}

std::string derivative_unit(const std::string& unit) {
  if (unit == "m") return "m/s";
  return unit.empty() ? "1/s" : unit + "/s";
}

json coefficient(const signal::AllanCoefficient& c, const std::string& unit) {
  return {{"value", c.value}, {"ci95", {c.low, c.high}}, {"unit", unit}, {"found", c.found}};
}

json coefficients(const signal::AllanFit& fit, const std::string& unit) {
  return {{"quantization", coefficient(fit.quantization, integral_unit(unit))},
          {"angle_random_walk", coefficient(fit.angle_random_walk, with(unit, "/sqrt(Hz)"))},
          {"bias_instability", coefficient(fit.bias_instability, unit)},
          {"rate_random_walk", coefficient(fit.rate_random_walk, with(unit, "/sqrt(s)"))},
          {"rate_ramp", coefficient(fit.rate_ramp, with(unit, "/s"))},
          {"markov_sigma", coefficient(fit.markov_sigma, unit)},
          {"markov_time", coefficient(fit.markov_time_s, "s")}};
}

base::Result<std::vector<std::size_t>> asked_multiples(const std::vector<double>& taus_s, double rate_hz,
                                                       std::size_t longest) {
  std::vector<std::size_t> multiples;
  for (const double tau_s : taus_s) {
    const double multiple = std::max(1.0, std::round(tau_s * rate_hz));
    if (!(tau_s > 0.0) || multiple > static_cast<double>(longest)) {
      return base::bad_input(fmt::format("an averaging time of {:g} s: the record carries {:g} to {:g} s", tau_s,
                                         1.0 / rate_hz, static_cast<double>(longest) / rate_hz),
                             "--taus");
    }
    multiples.push_back(static_cast<std::size_t>(multiple));
  }
  std::sort(multiples.begin(), multiples.end());
  multiples.erase(std::unique(multiples.begin(), multiples.end()), multiples.end());
  return multiples;
}

std::vector<double> deviations(const signal::PhaseRecord& record, signal::AllanKind kind,
                               const std::vector<std::size_t>& multiples) {
  std::vector<double> result;
  for (const signal::AllanPoint& point : signal::allan_points(record, kind, multiples)) {
    result.push_back(point.deviation);
  }
  return result;
}

signal::AllanCurve curve_of(const signal::PhaseRecord& record, const std::vector<std::size_t>& multiples) {
  signal::AllanCurve curve;
  curve.interval_s = record.interval_s();
  for (const signal::Stretch& stretch : record.stretches()) curve.stretches.push_back(stretch.count);
  curve.multiples = multiples;
  curve.deviation = deviations(record, signal::AllanKind::overlapping, multiples);
  return curve;
}

/// Adds what the fit says of the averaging times in `shown`.
void add_fit(json& document, const signal::AllanFit& fit, const std::vector<std::size_t>& multiples,
             const std::vector<std::size_t>& shown, const std::string& unit) {
  for (const std::size_t multiple : shown) {
    const auto i =
        static_cast<std::size_t>(std::lower_bound(multiples.begin(), multiples.end(), multiple) - multiples.begin());
    document["ci95"].push_back({fit.ci95[i][0], fit.ci95[i][1]});
    document["degrees_of_freedom"].push_back(fit.degrees_of_freedom[i]);
    document["fitted"].push_back(fit.deviation[i]);
  }
  document["coefficients"] = coefficients(fit, unit);
  document["bias_instability_tau_s"] = fit.bias_instability_tau_s;
  document["p_value"] = fit.p_value;
  if (fit.p_value < kDoubtfulFit) {
    document["warnings"].push_back(
        {{"code", "poor_fit"},
         {"text",
          fmt::format("no sum of the noise terms makes this curve (p = {:.1e}): look for vibration, swings of the "
                      "temperature or steps; the intervals are widened accordingly",
                      fit.p_value)}});
  }
}

}  // namespace

base::Result<json> allan_json(const SignalRecord& record, const AllanRequest& request) {
  const auto phase = request.phase ? signal::PhaseRecord::from_phase(record.values, record.rate_hz)
                                   : signal::PhaseRecord::from_rate(record.values, record.rate_hz);
  if (!phase) return base::forward_error(phase);
  const std::size_t longest = phase->longest(signal::AllanKind::overlapping);
  if (longest == 0) return base::bad_input("no stretch of the record has the three samples in a row that are needed");
  // The last two thirds of the possible averaging times rest on a difference or two.
  const auto standard = signal::log_spaced_multiples(std::max<std::size_t>(1, 2 * longest / 3), kPerDecade);
  const auto asked = asked_multiples(request.taus_s, record.rate_hz, longest);
  if (!asked) return base::forward_error(asked);
  const std::vector<std::size_t>& shown = asked->empty() ? standard : *asked;
  std::vector<std::size_t> multiples;
  std::set_union(standard.begin(), standard.end(), shown.begin(), shown.end(), std::back_inserter(multiples));

  const std::string unit = request.phase ? derivative_unit(record.unit) : record.unit;
  json document = header(record);
  document["unit"] = unit;
  document["bridged"] = phase->gaps().bridged;
  document["gaps"] = phase->gaps().gaps;
  std::vector<double> taus_s;
  for (const std::size_t multiple : shown) taus_s.push_back(static_cast<double>(multiple) * phase->interval_s());
  document["tau_s"] = taus_s;
  document["adev"] = numbers(deviations(*phase, signal::AllanKind::plain, shown));
  document["oadev"] = numbers(deviations(*phase, signal::AllanKind::overlapping, shown));
  document["mdev"] = numbers(deviations(*phase, signal::AllanKind::modified, shown));
  document["ohdev"] = numbers(deviations(*phase, signal::AllanKind::overlapping_hadamard, shown));
  for (const char* key : {"ci95", "degrees_of_freedom", "fitted", "warnings"}) document[key] = json::array();
  document["coefficients"] = json::object();
  if (const auto fit = signal::fit_allan(curve_of(*phase, multiples))) {
    add_fit(document, *fit, multiples, shown, unit);
  } else {
    document["warnings"].push_back({{"code", "no_fit"}, {"text", "no noise terms: " + fit.error().message}});
  }
  return document;
}

}  // namespace soak::calib
