// SPDX-License-Identifier: Apache-2.0
#include "calib/forward/mechanisms.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <string_view>
#include <utility>

#include "calib/estimate/site.h"

namespace soak::calib::forward {

namespace {

/// All that a mechanism may look at.
struct Inputs {
  const TermPart& part;
  const gap::LoggedRun& run;
  const Moment& moment;
  Vector3 force{};                                    ///< m/s²
  const std::map<double, Vector3>* memory = nullptr;  ///< memory_at_starts()
  double regressor = 0.0;
  std::size_t axis = 0;

  [[nodiscard]] double number(std::string_view name, double otherwise = 0.0) const {
    return part.value(name).value_or(otherwise);
  }
  /// A parameter that may have a slope against temperature.
  [[nodiscard]] double at_temperature(std::string_view name) const {
    const double slope = number(std::string(name) + "_per_c");
    return number(name) + slope * (moment.temp_c - number("reference_c", moment.temp_c));
  }
};

/// Of recordings without plateaus the mean is taken of every so many kelvins.
constexpr double kGrid_c = 5.0;

double nearest_grid_c(double temp_c) { return kGrid_c * std::round(temp_c / kGrid_c); }

double centre_at(const TermPart& part, double temp_c) {
  if (part.centre.empty()) return 0.0;
  const auto above = std::lower_bound(part.centre.begin(), part.centre.end(), temp_c,
                                      [](const auto& point, double c) { return point.first < c; });
  if (above == part.centre.begin()) return part.centre.front().second;
  if (above == part.centre.end()) return part.centre.back().second;
  const auto below = above - 1;
  return std::lerp(below->second, above->second, (temp_c - below->first) / (above->first - below->first));
}

constexpr std::array<std::string_view, 3> kAxes = {"x", "y", "z"};

Series temperature(const gap::LoggedRun& run) { return series_of(run.log, run.log.temp_c); }

/// The chamber's air less the unit's own thermometer, whichever thermometer a sensor has.
Series air_less_unit(const gap::LoggedRun& run) {
  const Series unit = temperature(run);
  Series across = series_of(run.log, run.log.chamber_c);
  for (std::size_t k = 0; k < across.values.size(); ++k)
    across.values[k] -= unit.empty() ? 0.0 : unit.at(across.t_s[k]);
  return across;
}

Series times(double factor, Series series) {
  for (double& value : series.values) value *= factor;
  return series;
}

/// How far the thermometer is ahead of an element that follows it, K, times a factor.
Series ahead_of_follower(const TermPart& part, const gap::LoggedRun& run, double factor) {
  const bool under_way = part.value("starts_under_way").value_or(0.0) > 0.0;
  Series ahead = temperature(run);
  const Series element = follower_of(ahead, part.value("tau_s").value_or(1.0), under_way);
  for (std::size_t k = 0; k < ahead.values.size(); ++k) ahead.values[k] -= element.values[k];
  return times(factor, std::move(ahead));
}

double even_order(const Inputs& in) {
  const double f = in.force[in.axis];
  const double g = in.number("gravity");
  return in.number("even_order") * (f * f - g * g);
}

double g_sensitivity(const Inputs& in) {
  double sum = 0.0;
  for (std::size_t j = 0; j < 3; ++j) sum += in.number(kAxes[j]) * in.force[j];
  return sum;
}

/// Half as high a width beside its centre.
double narrow_bump(const Inputs& in) {
  const double width = in.number("width_c", 1.0);
  const double square = width * width;
  const double off = in.moment.temp_c - in.number("centre_c");
  return in.number("height") * square / (square + off * off);
}

/// Angle of a run about the mean of all that are listed: that mean is misalignment. 0 for a run that is not.
double tilt_angle(const Inputs& in, std::size_t axis) {
  const std::string prefix = std::string(kAxes[axis]) + "@";
  const auto own = in.part.value(prefix + in.run.run.run_id);
  if (!own) return 0.0;
  double mean = 0.0;
  double count = 0.0;
  for (const TermParameter& parameter : in.part.parameters) {
    if (!parameter.name.starts_with(prefix)) continue;
    count += 1.0;
    mean += (parameter.value - mean) / count;
  }
  return *own - mean;
}

/// A rotation of the unit on its fixture turns the force that it feels: f + f × angle.
double fixture_tilt(const Inputs& in) {
  const auto angle = [&](std::size_t axis) { return tilt_angle(in, axis); };
  const std::size_t next = (in.axis + 1) % 3;
  const std::size_t last = (in.axis + 2) % 3;
  return in.force[next] * angle(last) - in.force[last] * angle(next);
}

double earth_rate(const Inputs& in) {
  if (!in.moment.segment->position || turns(*in.moment.segment)) return 0.0;
  const Frame frame = frame_of(*in.moment.segment->position, 0.0);
  return in.number("up") * frame.up[in.axis] + in.number("north") * frame.north[in.axis] +
         in.number("east") * frame.east[in.axis];
}

constexpr double kNeverFades_s = 1e6;

/// What a memory of the position holds when each placement of a run begins, by its start: from the first on it goes
/// over to the force of each with the time constant. One that never fades holds the placement before.
std::map<double, Vector3> memory_at_starts(const TermPart& part, const gap::LoggedRun& run, double gravity_mps2,
                                           int sign_at_rest) {
  std::map<double, Vector3> forces;
  for (const Segment& segment : run.run.segments) {
    if (segment.position && !turns(segment) && segment.phase == Phase::soak)
      forces[segment.t_start_s] = force_mps2(segment, gravity_mps2, sign_at_rest);
  }
  const double tau_s = part.value("tau_s").value_or(1.0);
  std::map<double, Vector3> memory;
  for (auto here = forces.begin(); here != forces.end(); ++here) {
    if (here == forces.begin()) {
      memory[here->first] = tau_s < kNeverFades_s ? here->second : Vector3{};
      continue;
    }
    const auto before = std::prev(here);
    const double left = tau_s < kNeverFades_s ? std::exp(-(here->first - before->first) / tau_s) : 0.0;
    for (std::size_t j = 0; j < 3; ++j)
      memory[here->first][j] = before->second[j] + (memory[before->first][j] - before->second[j]) * left;
  }
  return memory;
}

double position_memory(const Inputs& in) {
  const auto kept = in.memory->find(in.moment.segment->t_start_s);
  if (kept == in.memory->end()) return 0.0;
  const double tau_s = in.number("tau_s", 1.0);
  const bool fades = tau_s < kNeverFades_s;
  double sum = 0.0;
  for (std::size_t j = 0; j < 3; ++j) sum += in.number(kAxes[j]) * (kept->second[j] - (fades ? in.force[j] : 0.0));
  return fades ? sum * std::exp(-(in.moment.t_s - in.moment.segment->t_start_s) / tau_s) : sum;
}

double aging(const Inputs& in) {
  return in.number("per_s") * (*in.run.start_utc_s + in.moment.t_s - in.number("reference_utc_s"));
}

}  // namespace

/// What an effect's name means.
struct Mechanism {
  std::string_view name;
  std::string_view needs;  ///< what must have been logged, for people; empty = nothing
  bool (*missing)(const gap::LoggedRun&);
  Series (*regressor)(const TermPart&, const gap::LoggedRun&);
  double (*contribution)(const Inputs&);
  bool mean = false;  ///< the regressor counts by its mean over the stretch, not by its value in the middle
};

namespace {

constexpr std::string_view kCourse = "the temperature between the plateaus was not logged";

bool nothing_missing(const gap::LoggedRun&) { return false; }
bool no_temperature(const gap::LoggedRun& run) { return temperature(run).empty(); }
Series no_regressor(const TermPart&, const gap::LoggedRun&) { return {}; }
double nothing(const Inputs&) { return 0.0; }

const std::array kMechanisms = {
    Mechanism{"thermal_hysteresis", kCourse, no_temperature,
              [](const TermPart& part, const gap::LoggedRun& run) {
                return branch_memory_of(temperature(run), part.value("width_c").value_or(1.0),
                                        part.value("starts_along"));
              },
              [](const Inputs& in) { return in.at_temperature("amplitude") * in.regressor; }},
    Mechanism{"temperature_rate", kCourse, no_temperature,
              [](const TermPart& part, const gap::LoggedRun& run) {
                const double tau_s = part.value("tau_s").value_or(0.0);
                return tau_s > 0.0 ? ahead_of_follower(part, run, 1.0 / tau_s) : rate_of(temperature(run));
              },
              [](const Inputs& in) { return in.at_temperature("per_kps") * in.regressor; }},
    Mechanism{"sensor_lag", kCourse, no_temperature,
              [](const TermPart& part, const gap::LoggedRun& run) {
                const double tau_s = part.value("tau_s").value_or(1.0);
                return tau_s > 0.0 ? ahead_of_follower(part, run, -1.0) : times(-tau_s, rate_of(temperature(run)));
              },
              nothing},
    Mechanism{
        "warmup_transient", "the time since power-on is not known",
        [](const gap::LoggedRun& run) { return series_of(run.log, run.log.t_since_power_s).empty(); },
        [](const TermPart&, const gap::LoggedRun& run) { return series_of(run.log, run.log.t_since_power_s); },
        [](const Inputs& in) { return in.number("amplitude") * std::exp(-in.regressor / in.number("tau_s", 1.0)); }},
    Mechanism{"moisture", kCourse, no_temperature,
              [](const TermPart& part, const gap::LoggedRun& run) {
                return water_of(temperature(run), part.value("tau_s").value_or(1.0),
                                part.value("activation_k").value_or(0.0));
              },
              [](const Inputs& in) { return in.number("amplitude") * in.regressor; }},
    Mechanism{"temperature_gradient", "the chamber's air was not logged",
              [](const gap::LoggedRun& run) { return series_of(run.log, run.log.chamber_c).empty(); },
              [](const TermPart&, const gap::LoggedRun& run) { return air_less_unit(run); },
              [](const Inputs& in) { return in.at_temperature("per_k") * in.regressor; }, true},
    Mechanism{"position_memory", "", nothing_missing, no_regressor, position_memory},
    Mechanism{"vibration_rectification", "the compressor's duty was not logged",
              [](const gap::LoggedRun& run) { return series_of(run.log, run.log.compressor).empty(); },
              [](const TermPart&, const gap::LoggedRun& run) { return series_of(run.log, run.log.compressor); },
              [](const Inputs& in) { return in.number("per_duty") * in.regressor; }, true},
    Mechanism{"supply_sensitivity", "the supply voltage was not logged",
              [](const gap::LoggedRun& run) { return series_of(run.log, run.log.supply_v).empty(); },
              [](const TermPart&, const gap::LoggedRun& run) { return series_of(run.log, run.log.supply_v); },
              [](const Inputs& in) { return in.number("per_v") * (in.regressor - in.number("reference_v")); }, true},
    Mechanism{"aging_drift", "the time of the run is not known (utc_s)",
              [](const gap::LoggedRun& run) { return !run.start_utc_s; }, no_regressor, aging},
    Mechanism{"g_sensitivity", "", nothing_missing, no_regressor, g_sensitivity},
    Mechanism{"earth_rate", "", nothing_missing, no_regressor, earth_rate},
    Mechanism{"cross_axis", "", nothing_missing, no_regressor,
              [](const Inputs& in) { return g_sensitivity(in) * (in.moment.temp_c - in.number("reference_c")); }},
    Mechanism{"fixture_tilt", "", nothing_missing, no_regressor, fixture_tilt},
    Mechanism{"scale_nonlinearity", "", nothing_missing, no_regressor, even_order},
    Mechanism{"narrow_bump", "", nothing_missing, no_regressor, narrow_bump},
    Mechanism{"noise_vs_temperature", "", nothing_missing, no_regressor, nothing},
    Mechanism{"quantization", "", nothing_missing, no_regressor, nothing},
    Mechanism{"saturation", "", nothing_missing, no_regressor, nothing},
};

}  // namespace

double Mechanisms::Prepared::at(const Moment& moment) const {
  return mechanism->mean ? regressor.mean(moment.t_s - moment.half_s, moment.t_s + moment.half_s)
                         : regressor.at(moment.t_s);
}

Mechanisms::Mechanisms(const std::vector<ModelTerm>& terms, const gap::LoggedRun& run, int sign_at_rest)
    : run_(run), sign_at_rest_(sign_at_rest), gravity_mps2_(gravity_at(run.run.site).mps2) {
  for (const ModelTerm& term : terms) {
    const auto found = std::find_if(kMechanisms.begin(), kMechanisms.end(),
                                    [&](const Mechanism& mechanism) { return mechanism.name == term.name; });
    if (found == kMechanisms.end() || found->missing(run)) {
      not_evaluated_.push_back(
          fmt::format("{} is not evaluated in run {}: {}", term.name, run.run.label,
                      found == kMechanisms.end() ? "this program does not know it" : found->needs));
      continue;
    }
    for (const TermPart& part : term.parts) {
      prepared_.push_back({&*found, &part, found->regressor(part, run), {}});
      if (found->name == "position_memory")
        prepared_.back().memory = memory_at_starts(part, run, gravity_mps2_, sign_at_rest_);
    }
  }
}

double Mechanisms::contribution(Sensor sensor, const Moment& moment) const {
  double sum = 0.0;
  for (const Prepared& prepared : prepared_) {
    if (!prepared.part->acts_on(sensor)) continue;
    Inputs in{*prepared.part, run_, moment};
    in.force = force_mps2(*moment.segment, gravity_mps2_, sign_at_rest_);
    in.memory = &prepared.memory;
    in.axis = axis_of(sensor);
    if (!prepared.regressor.empty()) in.regressor = prepared.at(moment);
    sum += prepared.mechanism->contribution(in) - centre_at(*prepared.part, moment.temp_c);
  }
  return sum;
}

double Mechanisms::element_temp_c(Sensor sensor, const Moment& moment) const {
  double temp_c = moment.temp_c;
  for (const Prepared& prepared : prepared_) {
    if (prepared.mechanism->name != "sensor_lag" || !prepared.part->acts_on(sensor)) continue;
    temp_c += prepared.part->value("factor").value_or(1.0) * prepared.at(moment);
  }
  return temp_c;
}

namespace {

/// Terms of a unit's past, or of what only a chamber knows, that act at rest on a plateau.
constexpr std::array<std::string_view, 4> kOfThePast = {"thermal_hysteresis", "warmup_transient", "moisture",
                                                        "temperature_gradient"};

bool at_plateau(const Segment& segment) { return segment.phase == Phase::soak && segment.plateau_c; }

}  // namespace

void centre(const gap::LoggedCampaign& campaign, std::vector<ModelTerm>& terms) {
  const bool with_plateaus = gap::has_plateaus(campaign);
  for (ModelTerm& term : terms) {
    if (std::find(kOfThePast.begin(), kOfThePast.end(), term.name) == kOfThePast.end()) continue;
    const std::vector<ModelTerm> alone = {term};
    for (TermPart& part : term.parts) {
      std::map<double, std::array<double, 3>> plateaus;  // set point: blocks, sums of temperature and of what is added
      for (const gap::LoggedRun& run : campaign.runs) {
        const Mechanisms mechanisms(alone, run, campaign.type.sign_at_rest);
        for (const Segment& segment : run.run.segments) {
          if (with_plateaus && !at_plateau(segment)) continue;
          for (const Block& block : segment.blocks) {
            auto& [blocks, temp_c, added] = plateaus[segment.plateau_c.value_or(nearest_grid_c(block.temp_c))];
            const double here_c = block.sensor_temp_c[index_of(part.sensors.front())];
            const Moment moment{&segment, block.t_s, 0.5 * block.duration_s, here_c};
            blocks += 1.0;
            temp_c += here_c;
            added += mechanisms.contribution(part.sensors.front(), moment);
          }
        }
      }
      for (const auto& [set_c, sums] : plateaus) part.centre.emplace_back(sums[1] / sums[0], sums[2] / sums[0]);
      std::sort(part.centre.begin(), part.centre.end());
    }
  }
}

Vector3 force_mps2(const Segment& segment, double gravity_mps2, int sign_at_rest) {
  Vector3 force{};
  if (!segment.position) return force;
  for (std::size_t axis = 0; axis < 3; ++axis) force[axis] = sign_at_rest * gravity_mps2 * segment.position->up[axis];
  return force;
}

}  // namespace soak::calib::forward
