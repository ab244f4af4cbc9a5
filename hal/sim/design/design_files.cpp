// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/design/design_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <iterator>
#include <map>
#include <utility>
#include <vector>

#include "hal/sim/campaign/campaign_files.h"
#include "hal/sim/campaign/truth_writer.h"
#include "hal/sim/design/detail/designed_campaign.h"

namespace soak::hal::sim {
namespace {

using calib::Sensor;

std::string visit_json(const CampaignTimeline& timeline, const PlannedVisit& visit) {
  if (visit.pass < 0) return "null";
  std::string position;
  if (visit.position >= 0) {
    const auto& positions = timeline.passes[static_cast<std::size_t>(visit.pass)].positions;
    position = fmt::format(", \"true_position\": \"{}\"", positions[static_cast<std::size_t>(visit.position)].label);
  }
  return fmt::format("{{\"pass\": {}, \"visit\": {}{}}}", visit.pass, visit.visit, position);
}

/// Largest half of the difference between a sensor's mean contributions on the way up and on the way down at the same
/// set point, of all runs; 0 where no set point is reached both ways.
double largest_half_gap(const CampaignTimeline& timeline, const std::vector<PlannedBlock>& blocks,
                        const std::vector<double>& contributions) {
  struct Mean {
    double sum = 0.0;
    double count = 0.0;
  };
  std::map<int, std::array<Mean, 2>> means;  // by set point; up, down
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    const bool up = timeline.moments[blocks[i].first_moment].sweep == calib::Sweep::up;
    Mean& mean = means[blocks[i].set_point][up ? 0 : 1];
    mean.sum += contributions[i];
    mean.count += 1.0;
  }
  double largest = 0.0;
  for (const auto& [set_point, ways] : means) {
    if (ways[0].count == 0.0 || ways[1].count == 0.0) continue;
    const double gap = ways[0].sum / ways[0].count - ways[1].sum / ways[1].count;
    largest = std::max(largest, 0.5 * std::abs(gap));
  }
  return largest;
}

/// Size of an effect on a sensor, in the unit of its name: what its amplitude comes to.
double size_on(const CampaignTimeline& timeline, const std::vector<PlannedBlock>& blocks, const SizedEffect& effect,
               Sensor sensor) {
  if (effect.drawn.entry->name == "thermal_hysteresis") {
    const std::vector<double>& values = effect.contributions[calib::index_of(sensor)];
    return calib::printed_per_si(sensor) * largest_half_gap(timeline, blocks, values);
  }
  return amplitude_of(effect.drawn, sensor, effect.amplitude);
}

std::string sensors_json(const CampaignTimeline& timeline, const std::vector<PlannedBlock>& blocks,
                         const SizedEffect& effect) {
  std::string text = "{";
  for (const Sensor sensor : effect.drawn.sensors) {
    text += fmt::format("{}\"{}\": {{\"amplitude\": {:.7g}, \"size\": {:.7g}, \"unit\": \"{}\"}}",
                        text.size() > 1 ? ", " : "", calib::name_of(sensor),
                        amplitude_of(effect.drawn, sensor, effect.amplitude), size_on(timeline, blocks, effect, sensor),
                        unit_of(*effect.drawn.entry, sensor));
  }
  return text + "}";
}

/// One list of six per block that is written: printed units, 0 where a sensor is not hit.
std::string contributions_json(const CampaignConfig& config, const CampaignTimeline& timeline,
                               const std::vector<PlannedBlock>& blocks, const SizedEffect& effect) {
  std::string text = "[";
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    if (!is_written(timeline, *config.design, timeline.moments[blocks[i].first_moment])) continue;
    text += text.size() > 1 ? ", [" : "[";
    for (const Sensor sensor : calib::kSensors) {
      const std::vector<double>& values = effect.contributions[calib::index_of(sensor)];
      const double value = values.empty() ? 0.0 : calib::printed_per_si(sensor) * values[i];
      fmt::format_to(std::back_inserter(text), "{}{:.5g}", sensor == Sensor::gyro_x ? "" : ", ", value);
    }
    text += "]";
  }
  return text + "]";
}

std::string effect_json(const CampaignConfig& config, const CampaignTimeline& timeline, const DesignedUnit& designed,
                        const SizedEffect& effect) {
  const ActiveEffect active(effect.drawn, effect.amplitude, design_surroundings(config));
  const Sensor first = effect.drawn.sensors.front();
  std::string strengths = "[";
  for (std::size_t pass = 0; pass < timeline.passes.size(); ++pass) {
    strengths += fmt::format("{}{:.4f}", pass > 0 ? ", " : "", active.strength(static_cast<int>(pass)));
  }
  std::string text = fmt::format(
      "{{\"name\": \"{}\", \"nameable\": {}, \"magnitude\": {:.5g},\n     \"size\": {{\"value\": {:.7g}, "
      "\"unit\": \"{}\"}},\n     \"sensors\": {},\n     \"strength_of_pass\": {}], \"shape\": {}",
      effect.drawn.entry->name, effect.drawn.entry->nameable, effect.magnitude,
      size_on(timeline, designed.blocks, effect, first), unit_of(*effect.drawn.entry, first),
      sensors_json(timeline, designed.blocks, effect), strengths, shape_json(active.shape()));
  if (config.design->contributions) {
    text += ",\n     \"contributions\": " + contributions_json(config, timeline, designed.blocks, effect);
  }
  return text + "}";
}

std::string designed_unit_json(const CampaignConfig& config, const CampaignTimeline& timeline,
                               const DesignedUnit& designed) {
  const auto list = [&](const std::vector<SizedEffect>& effects) {
    return json_list(
        effects, [&](const SizedEffect& effect) { return "\n    " + effect_json(config, timeline, designed, effect); });
  };
  return fmt::format("\n  {{\"unit\": \"{}\", \"effects\": {},\n   \"candidates\": {}}}", designed.unit.serial,
                     list(designed.effects), list(designed.candidates));
}

/// What scatters in the recording of one kind of sensor, printed units; visits and placements with their drift factor.
std::string noise_json(const DesignConfig& design, Sensor sensor) {
  const DesignNoise& noise = design.noise(sensor);
  const double printed = calib::printed_per_si(sensor);
  return fmt::format(
      "{{\"unit\": \"{}\", \"block_sigma\": {:.6g}, \"placement_sigma\": {:.6g}, \"visit_sigma\": {:.6g}, "
      "\"run_sigma\": {:.6g}}}",
      calib::printed_unit(sensor), printed * noise.block_sigma, printed * design.drift_factor * noise.placement_sigma,
      printed * design.drift_factor * noise.visit_sigma, printed * noise.run_sigma);
}

/// Run, visit, position as it is, ordinal and true temperature of each block that is written.
std::string blocks_json(const CampaignConfig& config, const CampaignTimeline& timeline,
                        const std::vector<PlannedBlock>& blocks) {
  std::string text = "[";
  for (const PlannedBlock& block : blocks) {
    const Moment& moment = timeline.moments[block.first_moment];
    if (!is_written(timeline, *config.design, moment)) continue;
    const auto& positions = timeline.passes[static_cast<std::size_t>(moment.conditions.mounting)].positions;
    fmt::format_to(std::back_inserter(text), "{}[\"{}\", {}, \"{}\", {}, {:.4f}]", text.size() > 1 ? ", " : "",
                   timeline.runs[static_cast<std::size_t>(block.run)].label, moment.visit,
                   positions[static_cast<std::size_t>(moment.position)].label, moment.block, block.temp_c);
  }
  return text + "]";
}

/// What is hidden in a designed campaign. Its format stands in hal/sim/README.md. Rows are not read.
std::string design_truth_json(const CampaignConfig& config, const CampaignTimeline& timeline,
                              const std::vector<DesignedUnit>& units) {
  const DesignConfig& design = *config.design;
  std::string text = fmt::format(
      "{{\"seed\": {}, \"design\": \"{}\", \"drift_factor\": {}, \"amplitude_spread\": {}, "
      "\"thermometer_step_c\": {},\n \"dropped_visit\": {}, \"wrong_position\": {},\n",
      config.seed, name_of(design.kind), design.drift_factor, design.amplitude_spread, design.thermometer_step_c,
      visit_json(timeline, timeline.mistakes.dropped), visit_json(timeline, timeline.mistakes.wrongly_labelled));
  text += fmt::format(" \"noise\": {{\"gyro\": {}, \"accel\": {}}},\n", noise_json(design, Sensor::gyro_x),
                      noise_json(design, Sensor::accel_x));
  text += fmt::format(" \"runs\": {},\n", json_list(timeline.runs, [](const TimelineRun& run) {
                        return fmt::format("{{\"run\": \"{}\", \"pass\": {}, \"utc_s\": {:.0f}}}", run.label, run.pass,
                                           run.utc_s);
                      }));
  if (design.contributions && !units.empty()) {
    text += fmt::format(" \"blocks\": {},\n", blocks_json(config, timeline, units.front().blocks));
  }
  return text + fmt::format(" \"units\": {}}}\n", json_list(units, [&](const DesignedUnit& unit) {
                              return designed_unit_json(config, timeline, unit);
                            }));
}

/// All rows of a unit in a designed campaign, in the format that `soak import` reads. `t_s` and `t_since_power_s` count
/// from each power-on. Where logs are missing there are no columns chamber_c, compressor and supply_v.
std::string design_csv(const CampaignConfig& config, const CampaignTimeline& timeline, const DesignedUnit& designed) {
  const bool logs = config.design->kind != DesignKind::missing_logs;
  std::string csv = fmt::format(
      "t_s,run,phase,sweep,plateau_c,position,{}temp_c,gx_dps,gy_dps,gz_dps,ax_mps2,ay_mps2,az_mps2,{}t_since_power_s,"
      "utc_s\n",
      logs ? "chamber_c," : "", logs ? "compressor,supply_v," : "");
  auto out = std::back_inserter(csv);
  for (const DesignedRow& row : designed.rows) {
    const Moment& moment = timeline.moments[row.moment];
    const Conditions& now = moment.conditions;
    fmt::format_to(out, "{:.10g},{},{},{},{:.10g},{},", now.since_power_on_s,
                   timeline.runs[static_cast<std::size_t>(now.run)].label,
                   moment.phase == calib::Phase::ramp ? "ramp" : "soak", calib::name_of(moment.sweep),
                   config.design->set_point_c(moment.set_point), position_label(timeline, moment));
    if (logs) fmt::format_to(out, "{:.2f},", row.chamber_c);
    fmt::format_to(out, "{:.3f}", row.temp_c);
    for (const calib::Sensor sensor : calib::kSensors) {
      fmt::format_to(out, ",{:.5f}", row.sensor[calib::index_of(sensor)] * calib::printed_per_si(sensor));
    }
    if (logs) fmt::format_to(out, ",{},{:.4f}", now.compressor, now.supply_v);
    fmt::format_to(out, ",{:.10g},{:.0f}\n", now.since_power_on_s, now.utc_s);
  }
  return csv;
}

}  // namespace

base::Status write_designed_campaign(const CampaignConfig& config, const std::string& folder,
                                     const std::optional<std::string>& truth_file) {
  const std::filesystem::path campaign = std::filesystem::path(folder) / "campaign";
  const CampaignTimeline timeline = campaign_timeline(config);
  std::vector<DesignedUnit> units;
  for (int number = 1; number <= config.units; ++number) {
    auto unit = simulate_designed_unit(config, timeline, number);
    if (!unit) return base::forward_error(unit);
    if (base::Status made = make_folder(campaign); !made) return made;
    const std::string csv = design_csv(config, timeline, *unit);
    if (base::Status written = write_file(campaign / (unit->unit.serial + ".csv"), csv); !written) return written;
    unit->rows.clear();
    units.push_back(*std::move(unit));
  }
  if (!truth_file) return {};
  return write_file(*truth_file, design_truth_json(config, timeline, units));
}

}  // namespace soak::hal::sim
