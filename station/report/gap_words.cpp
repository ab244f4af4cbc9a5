// SPDX-License-Identifier: Apache-2.0
#include "station/report/gap_words.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <optional>
#include <utility>

#include "station/report/term_text.h"

namespace soak::station {
namespace {

using calib::gap::Conclusion;
using calib::gap::GapReport;
using calib::gap::JudgedOn;
using calib::gap::NamedEffect;
using calib::gap::ResidualStructure;
using calib::gap::StructureKind;

constexpr double kHardlyAny = 1e-6;  ///< chance below which nobody asks for the figure
constexpr double kSecondsPerHour = 3600.0;

/// What a unit does that has the effect.
constexpr std::array<std::pair<std::string_view, std::string_view>, 19> kEffects = {{
    {"thermal_hysteresis", "readings differ between heating and cooling, and keep differing after the soak"},
    {"temperature_rate", "readings shift with how fast the temperature moves"},
    {"sensor_lag", "the sensing elements follow the thermometer late"},
    {"warmup_transient", "readings move after power-on and then settle"},
    {"g_sensitivity", "the gyros' bias depends on how the unit lies: they feel acceleration"},
    {"earth_rate", "the rotation of the Earth is still in the gyros' readings"},
    {"cross_axis", "the sensing axes turn as the temperature changes"},
    {"fixture_tilt", "the fixture stood at another angle from run to run"},
    {"scale_nonlinearity", "the accelerometers do not read in proportion"},
    {"vibration_rectification", "readings shift while the compressor runs"},
    {"supply_sensitivity", "readings follow the supply voltage"},
    {"temperature_gradient", "readings shift while the air is warmer or colder than the unit"},
    {"position_memory", "the unit remembers the position before"},
    {"moisture", "readings move while the unit dries"},
    {"narrow_bump", "the curve has a narrow bump at one temperature"},
    {"aging_drift", "readings drift from run to run, as a unit that ages does"},
    {"noise_vs_temperature", "the noise depends on the temperature"},
    {"quantization", "readings come in coarse steps"},
    {"saturation", "readings stop at the end of their range"},
}};

/// "… (sensor_lag: 312 s, tau 320 s, all sensors)"
std::string with_size(const NamedEffect& effect) {
  return fmt::format("{} ({})", effect_words(effect.effect->name),
                     size_text(effect.effect->name, effect.magnitude.value, effect.magnitude.unit,
                               effect.candidate.shape, sensors_text(effect.sensors)));
}

std::string with_sizes(const std::vector<NamedEffect>& effects) {
  std::vector<std::string> list;
  for (const NamedEffect& effect : effects) list.push_back(with_size(effect));
  return fmt::format("{}", fmt::join(list, "; and "));
}

/// "temperature_rate (odds 1 to 40) or moisture"; empty without rivals.
std::string rivals_text(const NamedEffect& effect) {
  std::vector<std::string> rivals;
  for (const calib::gap::Rival& rival : effect.rivals) rivals.push_back(rival_text(rival));
  return fmt::format("{}", fmt::join(rivals, " or "));
}

/// Whether a rival has a chance beside the effect.
bool is_open(const NamedEffect& effect) { return std::ranges::any_of(effect.rivals, calib::gap::has_chance); }

/// How sure names are, and what they cannot be told from.
std::string certainty(const std::vector<NamedEffect>& effects) {
  const bool certain = std::ranges::all_of(effects, [](const NamedEffect& e) { return e.p_adjusted < kHardlyAny; });
  const std::string_view chance = certain ? "This is no chance" : "Chance very seldom looks like this";
  std::vector<std::string> doubts;
  std::vector<std::string> decided;
  for (const NamedEffect& effect : effects) {
    if (effect.rivals.empty()) continue;
    (is_open(effect) ? doubts : decided)
        .push_back(fmt::format("{} explains nearly as much as {}", rivals_text(effect), effect.effect->name));
  }
  if (doubts.empty() && decided.empty()) {
    return fmt::format("{}, and no other known effect explains it nearly as well.", chance);
  }
  if (doubts.empty()) {
    return fmt::format("{}. {}, but these runs tell them apart.", chance, fmt::join(decided, ", and "));
  }
  return fmt::format("{}; but {}: these runs do not surely tell them apart.", chance, fmt::join(doubts, ", and "));
}

/// What to do about effects that were named: those that the model has already, and the others.
std::string what_to_accept(const GapReport& report, const std::vector<calib::ModelTerm>& carried) {
  const auto is_carried = [&](std::string_view name) {
    return std::ranges::find(carried, name, &calib::ModelTerm::name) != carried.end();
  };
  std::string known;
  std::string open;
  bool any_new = false;
  for (std::size_t e = 0; e < report.effects.size(); ++e) {
    const std::string_view name = report.effects[e].effect->name;
    if (is_carried(name)) {
      known = name;
      continue;
    }
    any_new = true;
    if (open.empty() && is_open(report.effects[e])) open = report.next.at(e).text;
  }
  if (!any_new) {
    return fmt::format(
        "the model contains {0} already, but the runs show more of it: 'soak gap withdraw --unit {1} --effect {0} "
        "--reason TEXT', then find and accept it again",
        known, report.unit);
  }
  if (!open.empty()) {
    return fmt::format("before you accept it, record this run: {}; then 'soak gap find --unit {}' again", open,
                       report.unit);
  }
  return fmt::format(
      "'soak gap accept --unit {0}'{1}, then record a run that no fit has seen and look with 'soak gap show --unit "
      "{0}'",
      report.unit, known.empty() ? "" : fmt::format(" (it leaves out {}, which the model contains already)", known));
}

ThreeSentences sentences_of_named(const GapReport& report, const std::vector<calib::ModelTerm>& carried) {
  return {fmt::format("Unit {}, model {}: {}.", report.unit, report.model, with_sizes(report.effects)),
          certainty(report.effects), fmt::format("Next: {}.", what_to_accept(report, carried))};
}

/// "0.0011 to 0.0014 deg/s in a gyro": the sizes at the gate.
std::string limits_text(const GapReport& report, bool gyros) {
  std::vector<double> limits;
  for (const calib::Sensor sensor : calib::kSensors) {
    const auto& limit = report.detection_limit[calib::index_of(sensor)];
    if (limit && calib::is_gyro(sensor) == gyros) limits.push_back(*limit * calib::printed_per_si(sensor));
  }
  if (limits.empty()) return {};
  const auto [least, most] = std::ranges::minmax(limits);
  return fmt::format("{:.2g} to {:.2g} {} in {}", least, most,
                     calib::printed_unit(gyros ? calib::Sensor::gyro_x : calib::Sensor::accel_x),
                     gyros ? "a gyro" : "an accelerometer");
}

ThreeSentences sentences_of_none(const GapReport& report) {
  std::vector<std::string> limits;
  for (const bool gyros : {true, false}) {
    if (std::string text = limits_text(report, gyros); !text.empty()) limits.push_back(std::move(text));
  }
  const std::string seen = limits.empty() ? "Smaller effects than these runs scatter may be there unseen."
                                          : fmt::format(
                                                "Smaller effects may be there unseen: one would be named in "
                                                "half of such campaigns from {}.",
                                                fmt::join(limits, ", from "));
  return {
      fmt::format("Unit {}, model {}: the model lacks nothing that these runs can show.", report.unit, report.model),
      seen,
      fmt::format("Next: nothing is to be accepted; judge the model on a run that no fit has seen: 'soak verify "
                  "--unit {} --campaign NAME'.",
                  report.unit)};
}

/// "3.21 to 3.76 h"
std::string when_text(const calib::gap::BiasStep& step) {
  return step.since_s < 2.0 * kSecondsPerHour
             ? fmt::format("{:.0f} to {:.0f} min", step.before_s / 60.0, step.since_s / 60.0)
             : fmt::format("{:.2f} to {:.2f} h", step.before_s / kSecondsPerHour, step.since_s / kSecondsPerHour);
}

/// Where and when a bias steps: the largest step against what its sensor would read.
std::string steps_text(const GapReport& report, const ResidualStructure& structure) {
  const auto in_gaps = [&](const calib::gap::BiasStep& step) {
    const auto& gap = report.gap[calib::index_of(step.sensor)];
    return std::abs(step.size) / (gap && gap->floor_rms > 0.0 ? gap->floor_rms : 1.0);
  };
  const auto& step = *std::ranges::max_element(structure.steps, {}, in_gaps);
  const std::size_t more = structure.steps.size() - 1;
  return fmt::format(
      "the bias of {} steps by {:.2g} {} in run {}, {} after its first reading at a plateau, at {:.0f} °C{}",
      calib::name_of(step.sensor), step.size * calib::printed_per_si(step.sensor), calib::printed_unit(step.sensor),
      step.run, when_text(step), step.temp_c, more == 0 ? "" : fmt::format(" ({} more below)", more));
}

/// "RMS 0.0031 deg/s in gyro_y, where noise alone leaves 0.0012", of the sensor that stands out most.
std::string gap_text(const GapReport& report, const std::vector<calib::Sensor>& sensors) {
  const calib::Sensor* most = nullptr;
  double largest = 0.0;
  for (const calib::Sensor& sensor : sensors) {
    const auto& gap = report.gap[calib::index_of(sensor)];
    if (!gap || gap->floor_rms <= 0.0 || gap->before_rms / gap->floor_rms <= largest) continue;
    largest = gap->before_rms / gap->floor_rms;
    most = &sensor;
  }
  if (most == nullptr) return {};
  const auto& gap = *report.gap[calib::index_of(*most)];
  const double factor = calib::printed_per_si(*most);
  return fmt::format("; the gap of {} is {:.3g} {} (RMS), noise alone leaves {:.3g}", calib::name_of(*most),
                     gap.before_rms * factor, calib::printed_unit(*most), gap.floor_rms * factor);
}

std::string what_is_unknown(const GapReport& report) {
  const auto& structure = report.residual_structure;
  if (!structure) {
    std::vector<calib::Sensor> sensors;
    for (const NamedEffect& suspect : report.suspects)
      sensors.insert(sensors.end(), suspect.sensors.begin(), suspect.sensors.end());
    return fmt::format("{} read something that is not surely explained{}", sensors_text(sensors),
                       gap_text(report, sensors));
  }
  if (!structure->steps.empty() && structure->kind != StructureKind::telegraph_noise) {
    return steps_text(report, *structure);
  }
  const std::string_view follows = structure->kind == StructureKind::telegraph_noise
                                       ? "the bias jumps to and fro while the unit runs"
                                       : "readings follow ";
  const std::string axis = structure->kind == StructureKind::telegraph_noise ? "" : structure->axis;
  return fmt::format("{}{}, and no known effect explains that, in {}{}", follows, axis,
                     sensors_text(structure->sensors), gap_text(report, structure->sensors));
}

std::string what_it_may_be(const GapReport& report) {
  const auto& structure = report.residual_structure;
  const std::string usual = structure ? fmt::format("such readings usually come from {}",
                                                    words_of(structure->kind, structure->recorded).usual)
                                      : std::string();
  if (report.suspects.empty()) return fmt::format("Nothing is named on a guess; {}.", usual);
  std::vector<std::string> suspects;
  for (const NamedEffect& suspect : report.suspects) {
    const std::string rivals = rivals_text(suspect);
    suspects.push_back(with_size(suspect) + (rivals.empty() ? "" : ", or " + rivals));
  }
  return fmt::format("Suspected, but not surely enough to be named: {}{}.", fmt::join(suspects, "; "),
                     usual.empty() ? "" : "; else " + usual);
}

std::string what_to_record(const GapReport& report) {
  const auto& structure = report.residual_structure;
  if (report.judged_on == JudgedOn::halves) {
    return "record a third branch: heat or cool once more over the same temperatures";
  }
  if (structure && structure->recorded.on_ramps && structure->kind == StructureKind::drift_in_run) {
    return "record the same cycle once more";
  }
  if (structure && structure->closer_plateaus_k) {
    return fmt::format("record a campaign with plateaus {:g} K apart", *structure->closer_plateaus_k);
  }
  return structure ? fmt::format("look at {}; then record again", words_of(structure->kind, structure->recorded).look)
                   : std::string("record the same procedure again");
}

ThreeSentences sentences_of_unknown(const GapReport& report) {
  return {fmt::format("Unit {}, model {}: {}.", report.unit, report.model, what_is_unknown(report)),
          what_it_may_be(report),
          fmt::format("Next: {}, and ask again: 'soak gap find --unit {}'.", what_to_record(report), report.unit)};
}

ThreeSentences sentences_of_no_judgement(const GapReport& report) {
  return {
      fmt::format("Unit {}, model {}: these runs cannot show whether the model lacks something.", report.unit,
                  report.model),
      fmt::format("Why: {}.", plain_reason(report)),
      fmt::format("Next: record what is missing, mostly a second run of the same procedure, or take out the run that "
                  "is named ('soak runs void RUN --unit {0} --reason TEXT'); then 'soak gap find --unit {0}' again.",
                  report.unit)};
}

}  // namespace

std::string effect_words(std::string_view name) {
  const auto known = std::ranges::find(kEffects, name, &std::pair<std::string_view, std::string_view>::first);
  return std::string(known == kEffects.end() ? name : known->second);
}

std::string rival_text(const calib::gap::Rival& rival) {
  if (!rival.odds) return std::string(rival.effect->name);
  if (*rival.odds < kHardlyAny) return fmt::format("{} (odds below 1 to a million)", rival.effect->name);
  if (*rival.odds > 1.0) return fmt::format("{} (odds {:.2g} to 1)", rival.effect->name, *rival.odds);
  return fmt::format("{} (odds 1 to {:.2g})", rival.effect->name, 1.0 / *rival.odds);
}

std::string plain_reason(const GapReport& report) {
  std::string reason = report.reason;
  for (const calib::Warning& note : report.notes) {
    const std::size_t at = reason.find("; " + note.text);
    if (at != std::string::npos) reason.erase(at, note.text.size() + 2);
  }
  return reason;
}

ThreeSentences sentences_of(const GapReport& report, const std::vector<calib::ModelTerm>& carried) {
  switch (report.conclusion) {
    case Conclusion::named:
      return sentences_of_named(report, carried);
    case Conclusion::none:
      return sentences_of_none(report);
    case Conclusion::unknown:
      return sentences_of_unknown(report);
    case Conclusion::cannot_judge:
      break;
  }
  return sentences_of_no_judgement(report);
}

}  // namespace soak::station
