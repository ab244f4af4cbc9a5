// SPDX-License-Identifier: Apache-2.0
#include "calib/signal/allan/allan.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "calib/signal/allan/allan_fit.h"
#include "calib/signal/documents/detail/record.h"
#include "calib/signal/samples/sample_grid.h"
#include "calib/signal/spectrum/low_pass.h"

namespace soak::calib::signal_json {
namespace {

using nlohmann::json;

constexpr std::size_t kPerDecade = 12;
constexpr double kDoubtfulFit = 0.001;
/// Below this p_value is 0, or has no digits left.
constexpr double kLeastProbability = 1e-300;
constexpr double kMostBridged = 0.25;

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
  return {{"value", c.value}, {"ci95", {number(c.low), number(c.high)}}, {"unit", unit}, {"found", c.found}};
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
      return base::bad_input(fmt::format("an averaging time of {:g} s: the record allows {:g} to {:g} s", tau_s,
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

void warn(json& document, const char* code, const std::string& text) {
  document["warnings"].push_back({{"code", code}, {"text", text}});
}

double time_at(const SignalRecord& record, std::size_t i) {
  return i < record.t_s.size() ? record.t_s[i] : static_cast<double>(i) / record.rate_hz;
}

std::vector<double> rates_of_phase(const SignalRecord& record) {
  std::vector<double> rates;
  rates.reserve(record.values.size());
  for (std::size_t i = 1; i < record.values.size(); ++i) {
    rates.push_back((record.values[i] - record.values[i - 1]) * record.rate_hz);
  }
  return rates;
}

/// What the curve alone would take for noise. `values`: the rate, short gaps bridged as PhaseRecord does.
void check_record(json& document, const SignalRecord& record, std::vector<double> values, const std::string& unit) {
  const Outliers outside = outliers(values);
  if (!outside.at.empty()) {
    warn(document, "outliers",
         fmt::format("{} outlier{} up to {:.3g} sigma, the first at {:g} s: each adds to the curve like white noise, "
                     "and coefficients and intervals are wrong until they are removed",
                     outside.at.size(), outside.at.size() == 1 ? "" : "s", outside.largest_sigma,
                     time_at(record, outside.at.front())));
  }
  if (const auto found = step(without(std::move(values), outside))) {
    warn(document, "step",
         fmt::format("a step of {:.3g} {} at about {:g} s: it adds to the curve like rate random walk, and "
                     "coefficients and intervals are wrong; analyse the record before or after it",
                     found->height, unit.empty() ? "1" : unit, time_at(record, found->at)));
  }
}

void divide_coefficient(signal::AllanCoefficient& c, double factor) {
  c.value /= factor;
  c.low /= factor;
  c.high /= factor;
}

/// Bridged samples raise the deviation of white noise at all averaging times that are fitted by sqrt(1 + excess), and
/// leave that of slow noise as it is: the coefficient of the one is set right, what may be either stays open.
void allow_for_bridges(signal::AllanFit& fit, double excess) {
  const double factor = std::sqrt(1.0 + excess);
  divide_coefficient(fit.angle_random_walk, factor);
  fit.bias_instability.low /= factor;
  for (auto& [low, high] : fit.ci95) low /= factor;
}

/// The low-pass, and from which averaging time on terms were fitted.
json low_pass_json(const std::optional<signal::LowPass>& filter) {
  const std::optional<double> corner_hz = filter ? filter->half_power_hz() : std::nullopt;
  return {
      {"found", filter.has_value()}, {"corner_hz", corner_hz ? json(*corner_hz) : json()}, {"fitted_from_s", json()}};
}

/// Nothing was fitted at the averaging times shown.
void add_nothing(json& document, std::size_t shown) {
  const json none;
  document["ci95"] = json::array();
  for (std::size_t i = 0; i < shown; ++i) document["ci95"].push_back({none, none});
  document["degrees_of_freedom"] = json(shown, none);
  document["fitted"] = json(shown, none);
  document["coefficients"] = json::object();
}

std::string probability_text(double p) {
  return p < kLeastProbability ? "p below 1e-300" : fmt::format("p = {:.1e}", p);
}

/// Adds what the fit to `multiples` says of those that are shown.
void add_fit(json& document, const signal::AllanFit& fit, const std::vector<std::size_t>& multiples,
             const std::vector<std::size_t>& shown, const std::string& unit) {
  for (std::size_t k = 0; k < shown.size(); ++k) {
    const auto found = std::lower_bound(multiples.begin(), multiples.end(), shown[k]);
    if (found == multiples.end() || *found != shown[k]) continue;
    const auto i = static_cast<std::size_t>(found - multiples.begin());
    document["ci95"][k] = {fit.ci95[i][0], fit.ci95[i][1]};
    document["degrees_of_freedom"][k] = fit.degrees_of_freedom[i];
    document["fitted"][k] = fit.deviation[i];
  }
  document["coefficients"] = coefficients(fit, unit);
  document["low_pass"]["fitted_from_s"] =
      static_cast<double>(multiples[fit.first_fitted]) / document["rate_hz"].get<double>();
  document["bias_instability_tau_s"] = fit.bias_instability_tau_s;
  document["p_value"] = fit.p_value;
  if (fit.p_value < kDoubtfulFit) {
    warn(document, "poor_fit",
         fmt::format("no sum of the noise terms fits this curve ({}): look for vibration, swings of the temperature or "
                     "steps; the intervals are widened accordingly",
                     probability_text(fit.p_value)));
  }
}

std::string bridged_text(const Bridging& bridges, std::size_t first, double interval_s) {
  return fmt::format(
      "{:.2g} % of the samples are bridged by straight lines: below {:g} s the deviations are biased and not fitted; "
      "above it they show white noise {:.2g} % too high, which the coefficients allow for",
      100.0 * bridges.share, static_cast<double>(first) * interval_s, 100.0 * (std::sqrt(1.0 + bridges.excess) - 1.0));
}

/// Fits the noise terms to the averaging times at which the bridged samples do no harm.
base::Result<signal::AllanFit> fit(const signal::PhaseRecord& phase, const Bridging& bridges,
                                   const std::optional<signal::LowPass>& filter,
                                   const std::vector<std::size_t>& multiples) {
  if (bridges.share > kMostBridged) {
    return base::bad_input(fmt::format("{:.0f} % of the samples are missing and bridged; at most {:.0f} % may be",
                                       100.0 * bridges.share, 100.0 * kMostBridged));
  }
  signal::AllanCurve curve = signal::overlapping_curve(phase, multiples);
  curve.low_pass = filter;
  auto fitted = signal::fit_allan(curve);
  if (fitted && !bridges.negligible()) allow_for_bridges(*fitted, bridges.excess);
  return fitted;
}

void add_noise_terms(json& document, const SignalRecord& record, const signal::PhaseRecord& phase,
                     const std::optional<signal::LowPass>& filter, std::vector<std::size_t> multiples,
                     const std::vector<std::size_t>& shown) {
  // Missing points of phase are never bridged.
  const Bridging bridges =
      phase.gaps().bridged > 0 ? bridging(record.values, signal::PhaseRecord::kBridge) : Bridging{};
  if (!bridges.negligible()) {
    const std::size_t first = bridges.first_multiple();
    std::erase_if(multiples, [&](std::size_t multiple) { return multiple < first; });
    if (bridges.share <= kMostBridged) warn(document, "bridged", bridged_text(bridges, first, phase.interval_s()));
  }
  add_nothing(document, shown.size());
  document["low_pass"] = low_pass_json(filter);
  if (const auto fitted = fit(phase, bridges, filter, multiples)) {
    add_fit(document, *fitted, multiples, shown, document["unit"]);
  } else {
    warn(document, "no_fit", "no noise terms: " + fitted.error().message);
  }
}

}  // namespace

}  // namespace soak::calib::signal_json

namespace soak::calib {

base::Result<nlohmann::json> allan_json(const SignalRecord& record, const AllanRequest& request) {
  using namespace signal_json;
  if (auto status = check_changes(record.values); !status) return base::forward_error(status);
  const std::string unit = request.phase ? derivative_unit(record.unit) : record.unit;
  json document = header(record);
  document["unit"] = unit;
  document["warnings"] = json::array();
  // Before the phase is there: copies of the samples come and go one at a time.
  if (auto status = signal::check_none_infinite(record.values); !status) return base::forward_error(status);
  if (auto status = signal::check_rate(record.rate_hz); !status) return base::forward_error(status);
  check_record(document, record, request.phase ? rates_of_phase(record) : bridged_values(record), unit);
  const std::optional<signal::LowPass> filter = request.phase
                                                    ? signal::find_low_pass(rates_of_phase(record), record.rate_hz)
                                                    : signal::find_low_pass(record.values, record.rate_hz);
  const auto phase = request.phase ? signal::PhaseRecord::from_phase(record.values, record.rate_hz)
                                   : signal::PhaseRecord::from_rate(record.values, record.rate_hz);
  if (!phase) return base::forward_error(phase);
  const std::size_t longest = phase->longest(signal::AllanKind::overlapping);
  if (longest == 0) return base::bad_input("no stretch of the record has the three samples in a row that are needed");
  // The last third of the possible averaging times rests on a difference or two.
  const auto standard = signal::log_spaced_multiples(std::max<std::size_t>(1, 2 * longest / 3), kPerDecade);
  const auto asked = asked_multiples(request.taus_s, record.rate_hz, longest);
  if (!asked) return base::forward_error(asked);
  const std::vector<std::size_t>& shown = asked->empty() ? standard : *asked;
  std::vector<std::size_t> multiples;
  std::set_union(standard.begin(), standard.end(), shown.begin(), shown.end(), std::back_inserter(multiples));

  document["bridged"] = phase->gaps().bridged;
  document["gaps"] = phase->gaps().gaps;
  std::vector<double> taus_s;
  for (const std::size_t multiple : shown) taus_s.push_back(static_cast<double>(multiple) * phase->interval_s());
  document["tau_s"] = taus_s;
  document["adev"] = numbers(deviations(*phase, signal::AllanKind::plain, shown));
  document["oadev"] = numbers(deviations(*phase, signal::AllanKind::overlapping, shown));
  document["mdev"] = numbers(deviations(*phase, signal::AllanKind::modified, shown));
  document["ohdev"] = numbers(deviations(*phase, signal::AllanKind::overlapping_hadamard, shown));
  add_noise_terms(document, record, *phase, filter, std::move(multiples), shown);
  return document;
}

}  // namespace soak::calib
