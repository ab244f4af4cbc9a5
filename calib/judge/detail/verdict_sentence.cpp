// SPDX-License-Identifier: Apache-2.0
#include "calib/judge/detail/verdict_sentence.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <string_view>

namespace soak::calib {
namespace {

using nlohmann::json;

/// Widest band of a fresh power-on over the sensors of one kind, in printed units; absent where a sensor has none.
std::optional<double> widest_pi95(const json& fit, std::string_view kind) {
  std::optional<double> widest;
  for (const auto& [name, sensor] : fit.at("sensors").items()) {
    if (!name.starts_with(kind)) continue;
    for (const json& point : sensor.at("curve")) {
      if (point.at("pi95").is_null()) return std::nullopt;
      widest = std::max(widest.value_or(0.0), point.at("pi95").get<double>());
    }
  }
  return widest;
}

/// How near to the curves a fresh power-on is expected.
std::string expectation(const json& fit) {
  const auto gyro = widest_pi95(fit, "gyro");
  const auto accel = widest_pi95(fit, "accel");
  std::vector<std::string> parts;
  if (gyro) parts.push_back(fmt::format("±{:.3g} deg/s (gyros)", *gyro));
  if (accel) parts.push_back(fmt::format("±{:.3g} m/s² (accelerometers)", *accel));
  if (parts.empty()) return "how far a fresh power-on is from the curves is not known";
  return fmt::format("95 % of fresh power-ons are expected within {} of the curves", fmt::join(parts, " and "));
}

std::string runs_text(const std::vector<std::string>& runs) {
  return fmt::format("{} fresh run{} ({})", runs.size(), runs.size() == 1 ? "" : "s", fmt::join(runs, ", "));
}

/// A curve of a sensor with the verdict that is looked for.
struct Judged {
  std::string name;
  const CurveVerification* curve;
  double factor;
  std::string_view unit;

  [[nodiscard]] double share() const { return curve->worst_abs / curve->limit.value_or(1.0); }
};

/// The curves with this verdict, that with the largest error measured by its limit first.
std::vector<Judged> curves_with(const Verification& verification, Verdict verdict) {
  std::vector<Judged> found;
  for (const Sensor sensor : kSensors) {
    const auto& result = verification.sensors[index_of(sensor)];
    if (!result) continue;
    const std::string name(name_of(sensor));
    if (result->bias_verdict == verdict) {
      found.push_back({name, &*result, printed_per_si(sensor), is_gyro(sensor) ? "deg/s" : "m/s²"});
    }
    if (result->scale && result->scale->verdict == verdict) {
      found.push_back({name + " scale", &*result->scale, 1.0, "ppm"});
    }
  }
  std::stable_sort(found.begin(), found.end(), [](const Judged& a, const Judged& b) { return a.share() > b.share(); });
  return found;
}

/// "gyro_x is 0.06 deg/s off at 34.2 °C, its limit is 0.05 deg/s (and 2 more curves)"
std::string worst_text(const Verification& verification, Verdict verdict) {
  const std::vector<Judged> curves = curves_with(verification, verdict);
  if (curves.empty()) return "no curve";
  const Judged& worst = curves.front();
  const std::size_t more = curves.size() - 1;
  return fmt::format("{} is {:.3g} {} off at {:.1f} °C, its limit is {:.3g} {}{}", worst.name,
                     worst.curve->worst_abs * worst.factor, worst.unit, worst.curve->worst_temp_c,
                     worst.curve->limit.value_or(0.0) * worst.factor, worst.unit,
                     more == 0 ? "" : fmt::format(" (and {} more curve{})", more, more == 1 ? "" : "s"));
}

/// The sensors that kept a unit with limits from being judged, and why.
std::string unjudged_text(const Verification& verification) {
  std::vector<std::string> parts;
  for (const Sensor sensor : kSensors) {
    const auto& result = verification.sensors[index_of(sensor)];
    if (!result || result->verdict == Verdict::pass) continue;
    parts.push_back(fmt::format("{} {}", name_of(sensor),
                                result->verdict == Verdict::info ? "has no limit" : "was not measured enough"));
  }
  return fmt::format("{}", fmt::join(parts, ", "));
}

std::string judged_sentence(const Verification& verification, const std::vector<std::string>& runs) {
  switch (verification.verdict) {
    case Verdict::pass:
      return fmt::format("In {} every error, with its guard band, is within its limit.", runs_text(runs));
    case Verdict::marginal:
      return fmt::format("Too close to call in {}: {}; with the guard band it could be on either side.",
                         runs_text(runs), worst_text(verification, Verdict::marginal));
    case Verdict::fail:
      return fmt::format("The unit fails in {}: {}.", runs_text(runs), worst_text(verification, Verdict::fail));
    default:
      return fmt::format("Not judged as a whole, although limits were given: in {} {}.", runs_text(runs),
                         unjudged_text(verification));
  }
}

}  // namespace

VerdictSentence verdict_sentence(const json& fit, bool limits_given, const std::optional<Verification>& verification,
                                 const std::vector<std::string>& fresh_runs) {
  if (!limits_given) {
    return {"info", fmt::format("Not judged: no limits were given. For your information: {}.", expectation(fit))};
  }
  if (!verification) {
    return {"not_measured",
            fmt::format("Not measured: limits were given, but no fresh run, which no fit has seen, tests them; {}.",
                        expectation(fit))};
  }
  return {std::string(name_of(verification->verdict)), judged_sentence(*verification, fresh_runs)};
}

}  // namespace soak::calib
