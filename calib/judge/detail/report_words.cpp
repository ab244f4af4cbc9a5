// SPDX-License-Identifier: Apache-2.0
#include "calib/judge/detail/report_words.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>

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
      return fmt::format("Neither pass nor fail in {}: {} lies within the guard band of the limit.", runs_text(runs),
                         worst_text(verification, Verdict::marginal));
    case Verdict::fail:
      return fmt::format("The unit fails in {}: {}.", runs_text(runs), worst_text(verification, Verdict::fail));
    default:
      return fmt::format("Not judged as a whole, although limits were given: in {} {}.", runs_text(runs),
                         unjudged_text(verification));
  }
}

// ---- remedies ----

struct Remedy {
  std::string_view code;
  std::string_view text;
};

constexpr std::string_view kRecordAgain =
    "Record those segments again; where a label was wrong, correct it and import into a new campaign.";
constexpr std::string_view kNothing = "No action needed.";
constexpr std::string_view kFitAgain = "Fit again, then make this report again.";

constexpr std::array kRemedies = {
    // of the data gate
    Remedy{"moved", kRecordAgain},
    Remedy{"knocked", kRecordAgain},
    Remedy{"wrong_position", kRecordAgain},
    Remedy{"spike", "No action needed, they are left out; many of them point at the cable or the adapter."},
    Remedy{"lost_packets", "Check cable, adapter and the rate that the unit sends at."},
    Remedy{"saturated", kRecordAgain},
    Remedy{"stuck", "Check the sensor and its connection, then record those segments again."},
    Remedy{"dropouts", "Check cable and logger for lost samples, then record those segments again."},
    Remedy{"irregular_sampling", "Check the logger's clock; standard errors assume equally spaced samples."},
    Remedy{"coarse_thermometer", "Record a thermometer with finer steps, if the unit has one."},
    // of the fit
    Remedy{"runs_left_since", "Search the gap again: is the effect still found without them?"},
    Remedy{"copied_runs", "No action needed, they count once; the copies may be voided."},
    Remedy{"unit_type_unknown", "Write the type's file in procedures/units, then fit again."},
    Remedy{"term_not_evaluated", "Record the column that the effect needs, or take the effect out of the model."},
    Remedy{"few_runs", "Record more runs: at least three power-ons are needed for an error on unseen runs."},
    Remedy{"one_way",
           "Record a procedure that goes both ways (sweep = \"up_down\", such as six-position-both-ways), or state the "
           "hysteresis in the unit's type."},
    Remedy{"one_run", "Record more runs: at least three power-ons."},
    Remedy{"few_temperatures", "Record more plateaus."},
    Remedy{"baseline_deployed",
           "No action needed: the file has the better curve, by unseen runs or, of few runs, by expected error."},
    Remedy{"one_temperature",
           "State in the unit's type how far constants hold, or record three temperatures or more for curves."},
    Remedy{"misalignment_not_seen", "Record attitudes on edges and corners too."},
    Remedy{"turns_not_seen",
           "Log the gyros while the unit is moved to nine attitudes or more, or turn it by known angles."},
    Remedy{"turns_without_angle", "State the angle of the turns: 'turn_deg'."},
    Remedy{"turns_saturated", "Move the unit more slowly, within the range of its gyros."},
    Remedy{"turns_with_gaps", "Log without a break while the unit is moved."},
    Remedy{"unnamed_attitudes_excluded", "Fit those sessions in a campaign of their own."},
    Remedy{"hysteresis", "Use slower ramps, a longer soak or a better placed thermometer; expect errors of that size."},
    Remedy{"missing_position", "Record the missing positions."},
    Remedy{"cut_short_visit", "Void that visit of this part, then fit again: the other part has it whole."},
    Remedy{"scale_range", "Record the missing positions at those temperatures if the unit is used there."},
    Remedy{"own_thermometer", "Give the temperature of that sensor's own thermometer when you evaluate the curve."},
    Remedy{"scale_left_out", "No action needed; for its scale record rates at three plateaus or more."},
    Remedy{"scale_not_measured", "Record the missing positions at those temperatures if the unit is used there."},
    Remedy{"even_order",
           "Check that the fixture's faces are square to each other: a fixture out of square looks the same."},
    Remedy{"heading_incomplete", "Give the missing azimuths and import into a new campaign, or do without them."},
    Remedy{"rate_positions", kNothing},
    Remedy{"check_standard_out_of_control",
           "Find what changed in the station before you ship: the charts of the check standards show when."},
    Remedy{"reference_retired", "Check whether the reason also affects what was measured with it before."},
    Remedy{"reference_withdrawn", "Enter the correct certificate, then fit again."},
    Remedy{"reference_expired",
           "Have it calibrated and enter the certificate; if its value has changed, void what was measured with it."},
    Remedy{"waiver_signature", "Compare with the laboratory's records; sign a new waiver, then fit and export again."},
    Remedy{"gravity_assumed", "Void these runs and import them again with latitude and height, or with gravity."},
    Remedy{"one_attitude", "Record six positions if you need absolute accelerometer bias and scale."},
    Remedy{"runs_without_plateaus", "Give plateau_c in those recordings, or fit them in a campaign of their own."},
    // of a verification
    Remedy{"not_verified", "Record or import the verification runs with that sensor."},
    Remedy{"gravity_differs", "Import the verification runs with the gravity that the file was made with."},
    Remedy{"partial_range", "Verify over the whole temperature range."},
    Remedy{"out_of_range", "Verify inside the valid range."},
    Remedy{"band_too_narrow",
           "Rely on the errors of the fresh runs, not on the bands; find what changed since the fit, or record more "
           "runs."},
    // of a report
    Remedy{"simulated", "Do not deploy this to a real unit."},
    Remedy{"voided_since", kFitAgain},
    Remedy{"not_in_model", kFitAgain},
    Remedy{"run_missing", "Restore the run, or fit again with the remaining runs."},
    Remedy{"rows_missing", "Restore or record the runs, then fit again."},
    Remedy{"older_epoch", "Record the unit as it is now, and fit again."},
    Remedy{"older_model", "Make the report of the newest version, unless you want this one."},
    Remedy{"verification_failed", "Record or import verification runs that cover the model's temperatures."},
};

/// What speaks against handing a unit over at all.
constexpr std::array<std::string_view, 9> kGrave = {"check_standard_out_of_control",
                                                    "older_epoch",
                                                    "voided_since",
                                                    "reference_withdrawn",
                                                    "reference_expired",
                                                    "waiver_signature",
                                                    "run_missing",
                                                    "band_too_narrow",
                                                    "simulated"};

}  // namespace

VerdictSentence verdict_sentence(const json& fit, bool limits_given, const std::optional<Verification>& verification,
                                 const std::vector<std::string>& fresh_runs) {
  if (!limits_given) {
    return {"info",
            fmt::format("Not judged: no limits are set for this type of unit. For information: {}.", expectation(fit))};
  }
  if (!verification) {
    return {"not_measured",
            fmt::format("Not measured: limits were given, but there is no verification run that tests them; {}.",
                        expectation(fit))};
  }
  return {std::string(name_of(verification->verdict)), judged_sentence(*verification, fresh_runs)};
}

std::string_view remedy_of(std::string_view code) {
  const auto* found =
      std::find_if(kRemedies.begin(), kRemedies.end(), [&](const Remedy& remedy) { return remedy.code == code; });
  return found == kRemedies.end() ? std::string_view() : found->text;
}

Urgency urgency_of(std::string_view code) {
  if (std::ranges::find(kGrave, code) != kGrave.end()) return Urgency::grave;
  return remedy_of(code).starts_with("No action needed") ? Urgency::none : Urgency::act;
}

std::string_view name_of(Urgency urgency) {
  constexpr std::array<std::string_view, 3> kNames = {"grave", "act", "none"};
  return kNames.at(static_cast<std::size_t>(urgency));
}

}  // namespace soak::calib
