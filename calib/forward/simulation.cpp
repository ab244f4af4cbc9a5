// SPDX-License-Identifier: Apache-2.0
#include "calib/forward/simulation.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "calib/estimate/site.h"
#include "calib/forward/mechanisms.h"
#include "calib/gap/observations/observations.h"
#include "calib/segments/data_gate.h"

namespace soak::calib::forward {
namespace {

void subtract_terms(const Mechanisms& mechanisms, Segment& segment) {
  // Kept apart: the blocks' mechanisms look at the segment as it was recorded.
  const Segment recorded = segment;
  const double middle_s = 0.5 * (recorded.t_start_s + recorded.t_end_s);
  for (const Sensor sensor : kSensors) {
    const std::size_t s = index_of(sensor);
    double samples = 0.0;
    double added = 0.0;
    double temp_c = 0.0;
    for (Block& block : segment.blocks) {
      const Moment moment{&recorded, block.t_s, 0.5 * block.duration_s, block.sensor_temp_c[s]};
      const double here = mechanisms.contribution(sensor, moment);
      const double behind_c = mechanisms.element_temp_c(sensor, moment) - moment.temp_c;
      block.sensor[s].mean -= here;
      block.sensor_temp_c[s] += behind_c;
      const auto count = static_cast<double>(block.sensor[s].count);
      samples += count;
      added += count * here;
      temp_c += count * behind_c;
    }
    const Moment whole{&recorded, middle_s, 0.5 * (recorded.t_end_s - recorded.t_start_s), recorded.sensor_temp_c[s]};
    segment.sensor[s].mean -= samples > 0.0 ? added / samples : mechanisms.contribution(sensor, whole);
    segment.sensor_temp_c[s] +=
        samples > 0.0 ? temp_c / samples : mechanisms.element_temp_c(sensor, whole) - whole.temp_c;
  }
}

constexpr double kPpm = 1e-6;

/// The terms that the curves of a model do not hold.
std::vector<ModelTerm> beside_curves(std::vector<ModelTerm> terms) {
  std::erase_if(terms, [](const ModelTerm& term) { return term.name == "narrow_bump"; });
  return terms;
}

/// A model in one run.
class RunSimulation {
 public:
  RunSimulation(const SimulatedModel& model, const gap::LoggedRun& run, int sign_at_rest)
      : model_(model),
        run_(run),
        sign_at_rest_(sign_at_rest),
        gravity_mps2_(gravity_at(run.run.site).mps2),
        earth_(place_of(run.run.segments, run.run.site).earth),
        terms_(beside_curves(model.terms)),
        mechanisms_(terms_, run, sign_at_rest) {}

  [[nodiscard]] const std::vector<std::string>& not_evaluated() const { return mechanisms_.not_evaluated(); }

  [[nodiscard]] double reading(const SensorCalibration& sensor, const Moment& moment) const {
    const double temp_c = mechanisms_.element_temp_c(sensor.sensor, moment);
    const double truth = is_gyro(sensor.sensor) ? rotation_rps(sensor.sensor, *moment.segment)
                                                : force(*moment.segment)[axis_of(sensor.sensor)];
    const double scale = sensor.scale_ppm ? kPpm * evaluate(*sensor.scale_ppm, temp_c) : 0.0;
    return (1.0 + scale) * truth + evaluate(sensor.bias, temp_c) + coupling(sensor.sensor, *moment.segment) +
           mechanisms_.contribution(sensor.sensor, moment);
  }

 private:
  [[nodiscard]] Vector3 force(const Segment& segment) const {
    return force_mps2(segment, gravity_mps2_, sign_at_rest_);
  }

  [[nodiscard]] double rotation_rps(Sensor gyro, const Segment& segment) const {
    if (!segment.position) return 0.0;
    const Frame frame = frame_of(*segment.position, run_.run.site.azimuth_deg.value_or(0.0));
    return earth_.vertical_rps * frame.up[axis_of(gyro)] + earth_.horizontal_rps * frame.north[axis_of(gyro)];
  }

  [[nodiscard]] double coupling(Sensor sensor, const Segment& segment) const {
    if (is_gyro(sensor) || !model_.calibration.accel_misalignment) return 0.0;
    const Vector3& row = (*model_.calibration.accel_misalignment)[axis_of(sensor)];
    const Vector3 f = force(segment);
    return row[0] * f[0] + row[1] * f[1] + row[2] * f[2];
  }

  const SimulatedModel& model_;
  const gap::LoggedRun& run_;
  int sign_at_rest_;
  double gravity_mps2_;
  EarthRate earth_;
  std::vector<ModelTerm> terms_;
  Mechanisms mechanisms_;
};

SimulatedBlock simulate_block(const RunSimulation& simulation, const Calibration& calibration, const Segment& segment,
                              const Block& block) {
  SimulatedBlock result;
  result.t_s = block.t_s;
  result.temp_c = block.temp_c;
  result.sweep = segment.sweep;
  result.visit = segment.key.visit;
  for (const SensorCalibration& sensor : calibration.sensors) {
    const std::size_t s = index_of(sensor.sensor);
    const Moment moment{&segment, block.t_s, 0.5 * block.duration_s, block.sensor_temp_c[s]};
    result.simulated[s] = simulation.reading(sensor, moment);
    if (block.sensor[s].count == 0 || is_rejected(segment, sensor.sensor)) continue;
    result.measured[s] = block.sensor[s].mean;
    result.noise[s] = block.sensor[s].standard_error;
  }
  return result;
}

/// Sums over one run of one sensor.
struct Sums {
  double count = 0.0;
  double sum = 0.0;
  double squares = 0.0;
  double noise_squares = 0.0;

  [[nodiscard]] double about_mean() const { return std::max(0.0, squares - sum * sum / count); }
};

}  // namespace

std::vector<std::string> subtract_terms(const std::vector<ModelTerm>& terms, gap::LoggedCampaign& campaign) {
  std::vector<std::string> not_evaluated;
  if (terms.empty()) return not_evaluated;
  campaign.carried = terms;
  for (gap::LoggedRun& run : campaign.runs) {
    const Mechanisms mechanisms(terms, run, campaign.type.sign_at_rest);
    not_evaluated.insert(not_evaluated.end(), mechanisms.not_evaluated().begin(), mechanisms.not_evaluated().end());
    for (Segment& segment : run.run.segments) subtract_terms(mechanisms, segment);
  }
  return not_evaluated;
}

SimulatedCampaign simulate(const SimulatedModel& model, const gap::LoggedCampaign& campaign) {
  SimulatedCampaign result;
  const bool ramp = !gap::has_plateaus(campaign);
  for (std::size_t r = 0; r < campaign.runs.size(); ++r) {
    const gap::LoggedRun& run = campaign.runs[r];
    const RunSimulation simulation(model, run, campaign.type.sign_at_rest);
    result.not_evaluated.insert(result.not_evaluated.end(), simulation.not_evaluated().begin(),
                                simulation.not_evaluated().end());
    for (std::size_t k = 0; k < run.run.segments.size(); ++k) {
      const Segment& segment = run.run.segments[k];
      if (ramp ? turns(segment) || is_rejected(segment) : !gap::is_observed(segment)) continue;
      for (const Block& block : segment.blocks) {
        result.blocks.push_back(simulate_block(simulation, model.calibration, segment, block));
        result.blocks.back().run = static_cast<int>(r);
        result.blocks.back().segment = k;
      }
    }
  }
  return result;
}

std::array<std::optional<Disagreement>, kSensorCount> compare(const SimulatedCampaign& campaign) {
  std::array<std::optional<Disagreement>, kSensorCount> result;
  if (campaign.blocks.empty()) return result;
  const auto runs = static_cast<std::size_t>(campaign.blocks.back().run) + 1;
  for (std::size_t s = 0; s < kSensorCount; ++s) {
    std::vector<Sums> sums(runs);
    for (const SimulatedBlock& block : campaign.blocks) {
      if (!block.measured[s] || !block.simulated[s]) continue;
      const double off = *block.measured[s] - *block.simulated[s];
      Sums& run = sums[static_cast<std::size_t>(block.run)];
      run.count += 1.0;
      run.sum += off;
      run.squares += off * off;
      run.noise_squares += block.noise[s] * block.noise[s];
    }
    Sums all;
    Disagreement disagreement;
    double squares = 0.0;
    for (const Sums& run : sums) {
      disagreement.runs.push_back(run.count > 0.0 ? std::sqrt(run.about_mean() / run.count)
                                                  : std::numeric_limits<double>::quiet_NaN());
      if (run.count == 0.0) continue;
      all.count += run.count;
      all.noise_squares += run.noise_squares;
      squares += run.about_mean();
    }
    if (all.count == 0.0) continue;
    disagreement.rms = std::sqrt(squares / all.count);
    disagreement.noise_rms = std::sqrt(all.noise_squares / all.count);
    result[s] = disagreement;
  }
  return result;
}

}  // namespace soak::calib::forward
