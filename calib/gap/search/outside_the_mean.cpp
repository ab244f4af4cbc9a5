// SPDX-License-Identifier: Apache-2.0
#include "calib/gap/search/outside_the_mean.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <span>
#include <string>
#include <utility>

#include "base/statistics.h"
#include "calib/gap/effects/columns.h"
#include "calib/gap/search/score.h"

namespace soak::calib::gap {
namespace {

constexpr int kLeastAgingRuns = 4;
constexpr double kHours = 3600.0;
constexpr double kPer1000h = 1000.0;
constexpr double kLeastChange = 0.02;  ///< of the variance over the range of temperature, relative
constexpr double kLogVariance = 2.0;   ///< log variance over log standard deviation
constexpr double kCoarseStep = 0.1;    ///< of the noise, from which a lattice matters
constexpr double kEffects = 2.0;       ///< that are looked for in slopes
/// Chance from which a sensor of a set that stands out is counted in: ageing is small in each, noise is well known.
constexpr double kAgingSensorGate = 0.05;
constexpr double kNoiseSensorGate = 0.01;
/// Size beside the largest slope, found or carried, from which a sensor's is counted in.
constexpr double kLeastOfLargest = 0.1;
/// Times the step that the model carries: more than it says.
constexpr double kCoarser = 1.5;

Effect described(std::string_view name, std::string_view physics, std::vector<std::string_view> twins,
                 std::string_view experiment) {
  Effect effect;
  effect.name = name;
  effect.physics = physics;
  effect.twins = std::move(twins);
  effect.experiment = experiment;
  return effect;
}

const Effect& aging() {
  static const Effect effect =
      described("aging_drift", "the bias moves on from run to run, with age and not by chance", {"supply_sensitivity"},
                "a reference plateau at the start and the end of each run, over weeks");
  return effect;
}

const Effect& noise_slope() {
  static const Effect effect = described("noise_vs_temperature", "the noise itself grows or shrinks with temperature",
                                         {"saturation"}, "an hour at rest at both ends of the range");
  return effect;
}

const Effect& quantization() {
  static const Effect effect = described("quantization", "the output moves in steps that its noise does not blur", {},
                                         "a finer output format, or dither");
  return effect;
}

const Effect& saturation() {
  static const Effect effect = described("saturation", "the output stops at the end of its range", {},
                                         "a wider range, or a position with less input");
  return effect;
}

/// A slope that runs (or their offsets) agree on, by sensor.
struct Slope {
  Sensor sensor = Sensor::gyro_x;
  double value = 0.0;
  double variance = 0.0;
  double f = 0.0;
  double dof = 0.0;
};

/// Sensors of the set whose slopes stand out together. With so few runs a set cannot be judged by pooled F ratios, of
/// which one small residual by chance decides the mean: chances are pooled instead.
struct Chosen {
  std::vector<Slope> slopes;
  double p = 1.0;  ///< least chance, adjusted for all sets that are looked at
};

/// `sensor_gate`: chance from which a sensor of the set is counted in.
Chosen choose(const std::vector<Slope>& all, double sensor_gate) {
  std::map<Sensor, std::pair<Slope, double>> known;
  std::vector<Sensor> sensors;
  for (const Slope& slope : all) {
    if (slope.dof <= 0.0) continue;
    known[slope.sensor] = {slope, base::f_upper_tail(slope.f, 1.0, slope.dof)};
    sensors.push_back(slope.sensor);
  }
  const auto sets = sensor_sets(sensors);
  Chosen chosen;
  for (const auto& set : sets) {
    std::vector<double> chances;
    for (const Sensor sensor : set) chances.push_back(known.at(sensor).second);
    const double p = std::min(1.0, chance_together(chances) * static_cast<double>(sets.size()) * kEffects);
    if (p >= chosen.p) continue;
    chosen = {{}, p};
    for (const Sensor sensor : set) {
      if (known.at(sensor).second <= sensor_gate) chosen.slopes.push_back(known.at(sensor).first);
    }
  }
  return chosen;
}

/// The part of a term that the model carries already in a sensor; null where it carries none.
const TermPart* carried(const LoggedCampaign& campaign, const Effect& effect, Sensor sensor) {
  for (const ModelTerm& term : campaign.carried) {
    if (term.name == effect.name && term.part_of(sensor) != nullptr) return term.part_of(sensor);
  }
  return nullptr;
}

/// `factor` and `unit` of the magnitude by sensor; `meaning` of the slope.
template <class Factor, class Unit, class Means>
NamedEffect named(const Effect& effect, const Chosen& chosen, Factor factor, Unit unit, Means meaning) {
  NamedEffect result;
  result.effect = &effect;
  result.p_adjusted = chosen.p;
  double strongest = 0.0;
  for (const Slope& slope : chosen.slopes) {
    result.sensors.push_back(slope.sensor);
    result.parameters[index_of(slope.sensor)] = Eigen::VectorXd::Constant(1, slope.value);
    result.covariance[index_of(slope.sensor)] = Eigen::MatrixXd::Constant(1, 1, slope.variance);
    result.meaning[index_of(slope.sensor)] = meaning(slope.sensor);
    if (slope.f <= strongest) continue;
    strongest = slope.f;
    result.magnitude = {slope.value * factor(slope.sensor), unit(slope.sensor)};
  }
  return result;
}

/// Straight line through `y` over `x`.
Slope line(std::span<const double> x, std::span<const double> y) {
  const auto n = static_cast<double>(x.size());
  double mean_x = 0.0;
  double mean_y = 0.0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    mean_x += x[i] / n;
    mean_y += y[i] / n;
  }
  double xx = 0.0;
  double xy = 0.0;
  double yy = 0.0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    xx += (x[i] - mean_x) * (x[i] - mean_x);
    xy += (x[i] - mean_x) * (y[i] - mean_y);
    yy += (y[i] - mean_y) * (y[i] - mean_y);
  }
  Slope slope;
  slope.dof = n - 2.0;
  if (xx <= 0.0 || slope.dof <= 0.0) return slope;
  slope.value = xy / xx;
  slope.variance = std::max(0.0, yy - slope.value * xy) / slope.dof / xx;
  slope.f = slope.variance > 0.0 ? slope.value * slope.value / slope.variance : 0.0;
  return slope;
}

}  // namespace

void OutsideTheMean::add(OutsideTheMean&& other) {
  std::move(other.effects.begin(), other.effects.end(), std::back_inserter(effects));
  std::move(other.not_testable.begin(), other.not_testable.end(), std::back_inserter(not_testable));
}

OutsideTheMean look_for_aging(const LoggedCampaign& campaign, const CampaignModel& model) {
  OutsideTheMean result;
  const Observations& observations = model.regressor_inputs().observations;
  if (observations.run_count() < kLeastAgingRuns) {
    result.not_testable.push_back({"aging_drift", "fewer than four runs"});
    return result;
  }
  std::vector<double> hours;
  for (const std::size_t number : observations.logged) {
    const LoggedRun& run = campaign.runs[number];
    if (!run.start_utc_s) {
      result.not_testable.push_back(
          {"aging_drift", "the recordings hold no clock time beside their samples (column utc_s)"});
      return result;
    }
    hours.push_back(*run.start_utc_s / kHours);
  }
  const auto [first, last] = std::minmax_element(hours.begin(), hours.end());
  if (*last - *first < 1.0) {
    result.not_testable.push_back({"aging_drift", "all runs have the same time (utc_s)"});
    return result;
  }
  std::vector<Slope> slopes;
  for (const Sensor sensor : kSensors) {
    if (!model.residuals().sensor[index_of(sensor)]) continue;
    const std::vector<double> offsets = model.run_offsets(sensor);
    slopes.push_back(line(hours, offsets));
    slopes.back().sensor = sensor;
  }
  const Chosen chosen = choose(slopes, kAgingSensorGate);
  if (chosen.p > kOutsideMeanGate || chosen.slopes.empty()) return result;
  result.effects.push_back(named(
      aging(), chosen, [](Sensor sensor) { return kPer1000h * printed_per_si(sensor); },
      [](Sensor sensor) { return std::string(printed_unit(sensor)) + " per 1000 h"; },
      [&](Sensor sensor) {
        return Meaning{{{"per_s", si_unit(sensor) + "/s", 1.0 / kHours}},
                       {{"reference_utc_s", 0.5 * (*first + *last) * kHours, "s"}}};
      }));
  const Eigen::ArrayXd utc_s = as_vector(model.regressor_inputs().history.utc_s()).array();
  result.effects.back().candidate = for_all("", {}, ((utc_s - utc_s.mean()) / kHours).matrix());
  return result;
}

namespace {

/// Variance of a slope through points at `x` that scatter with `variances`.
double slope_variance(std::span<const double> x, std::span<const double> variances) {
  double mean = 0.0;
  for (const double value : x) mean += value / static_cast<double>(x.size());
  double squares = 0.0;
  double weighted = 0.0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    squares += (x[i] - mean) * (x[i] - mean);
    weighted += (x[i] - mean) * (x[i] - mean) * variances[i];
  }
  return squares > 0.0 ? weighted / (squares * squares) : 0.0;
}

/// Slope of the logarithm of the blocks' variances against temperature, its error from the scatter of the runs' own
/// slopes: but not less than that of white noise, as a few runs may agree by chance better than samples allow.
std::optional<Slope> noise_slope_of(const Observations& observations, Sensor sensor) {
  std::vector<double> of_runs;
  double white = 0.0;  // sum of the slopes' variances if the samples were white
  for (int run = 0; run < observations.run_count(); ++run) {
    std::vector<double> temp_c;
    std::vector<double> log_variance;
    std::vector<double> scatter;
    for (const Observation& row : observations.rows) {
      const SensorStatistics& statistics = row.sensor[index_of(sensor)];
      if (row.run != run || statistics.count < 3 || statistics.variance <= 0.0) continue;
      temp_c.push_back(row.temp_c);
      log_variance.push_back(std::log(statistics.variance));
      scatter.push_back(2.0 / (static_cast<double>(statistics.count) - 1.0));
    }
    if (temp_c.size() < 10) return std::nullopt;
    of_runs.push_back(line(temp_c, log_variance).value);
    white += slope_variance(temp_c, scatter);
  }
  const auto n = static_cast<double>(of_runs.size());
  if (n < 3.0) return std::nullopt;
  Slope slope;
  slope.sensor = sensor;
  for (const double value : of_runs) slope.value += value / n;
  double squares = 0.0;
  for (const double value : of_runs) squares += (value - slope.value) * (value - slope.value);
  slope.dof = n - 1.0;
  slope.variance = std::max(squares / slope.dof, white / n) / n;
  slope.f = slope.variance > 0.0 ? slope.value * slope.value / slope.variance : 0.0;
  return slope;
}

/// Slope of the logarithm of the variance that the model carries in a sensor.
double carried_slope(const LoggedCampaign& campaign, Sensor sensor) {
  const TermPart* part = carried(campaign, noise_slope(), sensor);
  return part != nullptr ? kLogVariance * part->value("relative_per_c").value_or(0.0) : 0.0;
}

/// What the model carries of it is taken off, as it is off the means.
void look_for_noise_slope(const LoggedCampaign& campaign, const Observations& observations, OutsideTheMean& result) {
  std::vector<Slope> slopes;
  double largest = 0.0;
  for (const Sensor sensor : kSensors) {
    auto slope = noise_slope_of(observations, sensor);
    if (!slope) continue;
    const double known = carried_slope(campaign, sensor);
    slope->value -= known;
    slope->f = slope->variance > 0.0 ? slope->value * slope->value / slope->variance : 0.0;
    largest = std::max(largest, std::abs(known));
    slopes.push_back(*slope);
  }
  if (slopes.empty()) {
    result.not_testable.push_back(
        {"noise_vs_temperature", "fewer than three runs with ten blocks of three samples or more"});
    return;
  }
  const double range_c = observations.level_c.back() - observations.level_c.front();
  std::erase_if(slopes, [&](const Slope& slope) { return std::abs(slope.value) * range_c < kLeastChange; });
  Chosen chosen = choose(slopes, kNoiseSensorGate);
  for (const Slope& slope : chosen.slopes) largest = std::max(largest, std::abs(slope.value));
  std::erase_if(chosen.slopes, [&](const Slope& slope) { return std::abs(slope.value) < kLeastOfLargest * largest; });
  if (chosen.p > kOutsideMeanGate || chosen.slopes.empty()) return;
  result.effects.push_back(named(
      noise_slope(), chosen, [](Sensor) { return 1.0 / kLogVariance; },
      [](Sensor) { return std::string("relative per K"); },
      [&](Sensor) {
        return Meaning{{{"relative_per_c", "relative per K", 1.0 / kLogVariance}},
                       {{"reference_c", middle_c(observations), "degC"}}};
      }));
}

/// A step in LSB of the type's output; in the sensor's unit where the type does not state it.
Magnitude step_magnitude(const UnitType& type, Sensor sensor, double step) {
  const double printed = step * printed_per_si(sensor);
  const auto& lsb = is_gyro(sensor) ? type.gyro_lsb_dps : type.accel_lsb_mps2;
  if (lsb) return {printed / *lsb, "LSB"};
  return {printed, std::string(printed_unit(sensor))};
}

/// Whether samples move in steps that matter, and that the model does not carry.
bool is_coarse(const LoggedCampaign& campaign, Sensor sensor) {
  const SampleFacts& facts = campaign.samples[index_of(sensor)];
  if (!facts.step || facts.noise <= 0.0 || *facts.step <= kCoarseStep * facts.noise) return false;
  const TermPart* part = carried(campaign, quantization(), sensor);
  return part == nullptr || *facts.step > kCoarser * part->value("step").value_or(0.0);
}

void look_at_samples(const LoggedCampaign& campaign, OutsideTheMean& result) {
  NamedEffect coarse;
  coarse.effect = &quantization();
  coarse.p_adjusted = 0.0;
  double coarsest = 0.0;
  NamedEffect clipped;
  clipped.effect = &saturation();
  clipped.p_adjusted = 0.0;
  bool looked = false;
  for (const Sensor sensor : kSensors) {
    const SampleFacts& facts = campaign.samples[index_of(sensor)];
    if (facts.count == 0) continue;
    looked = true;
    if (is_coarse(campaign, sensor)) {
      coarse.sensors.push_back(sensor);
      coarse.meaning[index_of(sensor)].given = {{"step", *facts.step, si_unit(sensor)}};
      const double ratio = *facts.step / facts.noise;
      if (ratio > coarsest) coarse.magnitude = step_magnitude(campaign.type, sensor, *facts.step);
      coarsest = std::max(coarsest, ratio);
    }
    const double share = static_cast<double>(facts.at_rails) / static_cast<double>(facts.count);
    if (facts.at_rails == 0 || carried(campaign, saturation(), sensor) != nullptr) continue;
    clipped.sensors.push_back(sensor);
    clipped.meaning[index_of(sensor)].given = {{"low_rail", facts.low_rail, si_unit(sensor)},
                                               {"high_rail", facts.high_rail, si_unit(sensor)}};
    clipped.magnitude = {std::max(clipped.magnitude.value, share), "share of the samples"};
  }
  if (!looked) {
    for (const char* name : {"quantization", "saturation"}) {
      result.not_testable.push_back({name, "only means are available, no samples"});
    }
  }
  if (!coarse.sensors.empty()) result.effects.push_back(std::move(coarse));
  if (!clipped.sensors.empty()) result.effects.push_back(std::move(clipped));
}

}  // namespace

OutsideTheMean look_outside_the_mean(const LoggedCampaign& campaign, const CampaignModel& model) {
  OutsideTheMean result;
  look_for_noise_slope(campaign, model.regressor_inputs().observations, result);
  look_at_samples(campaign, result);
  return result;
}

}  // namespace soak::calib::gap
