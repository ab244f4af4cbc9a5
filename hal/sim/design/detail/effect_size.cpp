// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/design/detail/effect_size.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <utility>

#include "hal/sim/unit/attitude.h"

namespace soak::hal::sim {
namespace {

using calib::Sensor;

/// Less than this of an effect is left by the base: it cannot be seen at all.
constexpr double kAbsorbed = 1e-6;
/// An amplitude is found when the magnitude is met as closely as this.
constexpr double kTolerance = 1e-3;
constexpr int kMostTrials = 40;
constexpr double kLargestAmplitude = 7200.0;  ///< in its unit: two hours of lag
constexpr double kSharePerMagnitude = 0.1;
constexpr double kShareNearG = 1.0 / 3.0;  ///< of the rows an accelerometer's axis is vertical

/// Trigamma function at n/2: ψ′(x) = 1/x² + ψ′(x + 1), from ψ′(1) = π²/6 or ψ′(1/2) = π²/2 (DLMF 5.15).
double trigamma_of_half(int n) {
  constexpr double kPi2 = 9.869604401089358;
  double value = n % 2 == 0 ? kPi2 / 6.0 : kPi2 / 2.0;
  for (double x = n % 2 == 0 ? 1.0 : 0.5; x < 0.5 * n - 0.25; x += 1.0) value -= 1.0 / (x * x);
  return value;
}

double mean_of(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double value : values) sum += value;
  return sum / static_cast<double>(values.size());
}

double squares_of(const std::vector<double>& values, double centre) {
  double sum = 0.0;
  for (const double value : values) sum += (value - centre) * (value - centre);
  return sum;
}

/// Mean of the values of each run.
std::vector<double> run_means(const std::vector<PlannedBlock>& blocks, const std::vector<double>& values,
                              std::size_t runs) {
  std::vector<double> means(runs, 0.0);
  std::vector<double> counts(runs, 0.0);
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    means[static_cast<std::size_t>(blocks[i].run)] += values[i];
    counts[static_cast<std::size_t>(blocks[i].run)] += 1.0;
  }
  for (std::size_t run = 0; run < runs; ++run) means[run] /= std::max(counts[run], 1.0);
  return means;
}

/// Where a magnitude that rises with the amplitude is met: in proportion to the last trial until there is one on either
/// side, then on the straight line between the logarithms. All effects but the lag are proportional: the second
/// trial ends their search.
class AmplitudeSearch {
 public:
  explicit AmplitudeSearch(double magnitude) : magnitude_(magnitude) {}

  [[nodiscard]] double amplitude() const { return amplitude_; }
  /// The magnitude of amplitude(), above 0; the next trial becomes amplitude().
  void reached(double magnitude) {
    (magnitude < magnitude_ ? below_ : above_) = Trial{amplitude_, magnitude};
    if (below_.magnitude > 0.0 && above_.magnitude > 0.0) {
      const double part = std::log(magnitude_ / below_.magnitude) / std::log(above_.magnitude / below_.magnitude);
      amplitude_ = below_.amplitude * std::pow(above_.amplitude / below_.amplitude, part);
    } else {
      amplitude_ *= magnitude_ / magnitude;
    }
  }

 private:
  struct Trial {
    double amplitude = 0.0;
    double magnitude = 0.0;  ///< 0 = none yet
  };

  double magnitude_;
  double amplitude_ = 1.0;
  Trial below_;
  Trial above_;
};

/// A column that keeps less than this of its length is a combination of those before it.
constexpr double kDependent = 1e-8;

double product_sum(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += a[i] * b[i];
  return sum;
}

template <class Value>
std::vector<double> column_of(const std::vector<PlannedBlock>& blocks, Value value) {
  std::vector<double> column;
  column.reserve(blocks.size());
  for (const PlannedBlock& block : blocks) column.push_back(value(block));
  return column;
}

}  // namespace

std::vector<PlannedBlock> planned_blocks(const CampaignTimeline& timeline) {
  std::vector<PlannedBlock> blocks;
  std::size_t rows = 0;
  for (std::size_t i = 0; i < timeline.moments.size(); ++i) {
    const Moment& moment = timeline.moments[i];
    if (moment.block < 0) continue;
    const Conditions& now = moment.conditions;
    if (rows++ % kRowsPerBlock == 0) blocks.push_back({i, now.run, moment.set_point, 0.0, now.up});
    blocks.back().temp_c += now.thermometer_c / kRowsPerBlock;
  }
  return blocks;
}

BaseFit::BaseFit(const std::vector<PlannedBlock>& blocks, calib::Sensor sensor, Temperature temperature) {
  int set_points = 0;
  int runs = 0;
  for (const PlannedBlock& block : blocks) {
    set_points = std::max(set_points, block.set_point + 1);
    runs = std::max(runs, block.run + 1);
  }
  const std::size_t axis = calib::axis_of(sensor);
  for (int point = 0; point < set_points; ++point) {
    const auto here = [point](const PlannedBlock& block) { return block.set_point == point ? 1.0 : 0.0; };
    if (temperature == Temperature::levels) add_column(column_of(blocks, here));
    if (calib::is_gyro(sensor)) continue;
    add_column(column_of(blocks, [&](const PlannedBlock& block) { return here(block) * block.up[axis]; }));
  }
  for (int power = 0; power < 4 && temperature == Temperature::cubic; ++power) {
    add_column(column_of(blocks, [power](const PlannedBlock& block) { return std::pow(block.temp_c / 50.0, power); }));
  }
  for (int run = 0; run < runs; ++run) {
    add_column(column_of(blocks, [run](const PlannedBlock& block) { return block.run == run ? 1.0 : 0.0; }));
  }
  for (std::size_t other = 0; other < 3 && !calib::is_gyro(sensor); ++other) {
    if (other != axis) add_column(column_of(blocks, [other](const PlannedBlock& block) { return block.up[other]; }));
  }
}

// Gram-Schmidt, twice: once leaves rounding errors along earlier columns.
void BaseFit::add_column(std::vector<double> column) {
  const double length = std::sqrt(product_sum(column, column));
  column = residual(residual(std::move(column)));
  const double left = std::sqrt(product_sum(column, column));
  if (left <= kDependent * length) return;
  for (double& value : column) value /= left;
  columns_.push_back(std::move(column));
}

std::vector<double> BaseFit::residual(std::vector<double> values) const {
  for (const std::vector<double>& column : columns_) {
    const double part = product_sum(column, values);
    for (std::size_t i = 0; i < values.size(); ++i) values[i] -= part * column[i];
  }
  return values;
}

EffectSurroundings design_surroundings(const CampaignConfig& config) {
  return {config.earth, design_set_points_c(*config.design), config.design->amplitude_spread};
}

EffectSizer::EffectSizer(const CampaignConfig& config, const CampaignTimeline& timeline, const SimulatedUnit& unit)
    : config_(config),
      design_(*config.design),
      timeline_(timeline),
      unit_(unit),
      surroundings_(design_surroundings(config)),
      blocks_(planned_blocks(timeline)) {
  for (const Sensor sensor : calib::kSensors) {
    levels_.emplace_back(blocks_, sensor, BaseFit::Temperature::levels);
    cubics_.emplace_back(blocks_, sensor, BaseFit::Temperature::cubic);
    for (const Moment& moment : timeline_.moments) {
      if (moment.block < 0) continue;
      readings_[calib::index_of(sensor)].push_back(reading(sensor, moment, moment.conditions.thermometer_c));
    }
  }
}

double EffectSizer::reading(Sensor sensor, const Moment& moment, double element_c) const {
  return ideal_reading(unit_, sensor, element_c, force_at_rest_mps2(moment.conditions.up), moment.rate_rps);
}

BlockValues EffectSizer::contributions(const DrawnEffect& drawn, double amplitude) const {
  HiddenEffects effects;
  effects.add(drawn, amplitude, surroundings_);
  BlockValues values;
  for (const Sensor sensor : drawn.sensors) values[calib::index_of(sensor)].assign(blocks_.size(), 0.0);
  std::size_t row = 0;
  for (const Moment& moment : timeline_.moments) {
    effects.advance_to(moment.conditions);
    if (moment.block < 0) continue;
    const double element_c = effects.element_c();
    for (const Sensor sensor : drawn.sensors) {
      const double plain = readings_[calib::index_of(sensor)][row];
      const double shifted = element_c == moment.conditions.thermometer_c ? plain : reading(sensor, moment, element_c);
      const double word = effects.output(sensor, effects.sensed(sensor, shifted, 0.0));
      values[calib::index_of(sensor)][row / kRowsPerBlock] += (word - plain) / kRowsPerBlock;
    }
    ++row;
  }
  return values;
}

BlockValues EffectSizer::log_variances(const DrawnEffect& drawn, double amplitude) const {
  HiddenEffects effects;
  effects.add(drawn, amplitude, surroundings_);
  BlockValues values;
  std::size_t row = 0;
  for (const Moment& moment : timeline_.moments) {
    effects.advance_to(moment.conditions);
    if (moment.block < 0 || row++ % kRowsPerBlock != 0) continue;
    for (const Sensor sensor : drawn.sensors) {
      values[calib::index_of(sensor)].push_back(2.0 * std::log(effects.effect(0).noise_factor(sensor)));
    }
  }
  return values;
}

double EffectSizer::sum_of_squares(const DrawnEffect& drawn, Sensor sensor, const std::vector<double>& values) const {
  const DesignNoise& noise = design_.noise(sensor);
  const auto blocks = static_cast<double>(blocks_.size());
  switch (drawn.entry->measure) {
    case Measure::runs: {
      const std::vector<double> means = run_means(blocks_, values, timeline_.runs.size());
      const double squares = squares_of(means, mean_of(means)) / static_cast<double>(means.size());
      return blocks * squares / (noise.run_sigma * noise.run_sigma);
    }
    case Measure::block_noise:
      return squares_of(values, mean_of(values)) / trigamma_of_half(kRowsPerBlock - 1);
    default: {
      const auto& fits = drawn.entry->measure == Measure::curve ? cubics_ : levels_;
      const double left = squares_of(fits[calib::index_of(sensor)].residual(values), 0.0);
      const double all = squares_of(values, 0.0);
      return left <= kAbsorbed * kAbsorbed * all ? 0.0 : left / (noise.block_sigma * noise.block_sigma);
    }
  }
}

double EffectSizer::clipped_share(const DrawnEffect& drawn, double rail) const {
  double clipped = 0.0;
  double rows = 0.0;
  for (const Sensor sensor : drawn.sensors) {
    for (const double value : readings_[calib::index_of(sensor)]) clipped += std::abs(value) > rail ? 1.0 : 0.0;
    rows += static_cast<double>(readings_[calib::index_of(sensor)].size());
  }
  return clipped / rows;
}

double EffectSizer::rail_for(const DrawnEffect& drawn, double share) const {
  std::vector<double> sizes;
  for (const Sensor sensor : drawn.sensors) {
    for (const double value : readings_[calib::index_of(sensor)]) sizes.push_back(std::abs(value));
  }
  std::sort(sizes.begin(), sizes.end(), std::greater<>());
  const auto clipped = static_cast<std::size_t>(std::llround(share * static_cast<double>(sizes.size())));
  const std::size_t first_free = std::min(clipped, sizes.size() - 1);
  return first_free == 0 ? sizes[0] : 0.5 * (sizes[first_free - 1] + sizes[first_free]);
}

double EffectSizer::magnitude_of(const DrawnEffect& drawn, double amplitude) const {
  const Sensor first = drawn.sensors.front();
  const double size = std::abs(amplitude_of(drawn, first, amplitude));
  switch (drawn.entry->measure) {
    case Measure::row_noise:
      return size / (design_.noise(first).block_sigma * std::sqrt(kRowsPerBlock) * calib::printed_per_si(first));
    case Measure::clipped_share:
      return clipped_share(drawn, size) / kSharePerMagnitude;
    default:
      break;
  }
  const bool of_noise = drawn.entry->measure == Measure::block_noise;
  const BlockValues values = of_noise ? log_variances(drawn, amplitude) : contributions(drawn, amplitude);
  double sum = 0.0;
  for (const Sensor sensor : drawn.sensors) sum += sum_of_squares(drawn, sensor, values[calib::index_of(sensor)]);
  return std::sqrt(sum / static_cast<double>(blocks_.size() * drawn.sensors.size()));
}

base::Result<double> EffectSizer::amplitude_for(const DrawnEffect& drawn, double magnitude) const {
  const bool of_rails = drawn.entry->measure == Measure::clipped_share;
  const double share = kSharePerMagnitude * magnitude;
  if (of_rails && share <= kShareNearG) return rail_for(drawn, share);
  AmplitudeSearch search(magnitude);
  for (int trial = 0; trial < kMostTrials && !of_rails; ++trial) {
    const double reached = magnitude_of(drawn, search.amplitude());
    if (std::abs(reached - magnitude) <= kTolerance * magnitude) return search.amplitude();
    if (reached <= 0.0 || search.amplitude() > kLargestAmplitude) break;
    search.reached(reached);
  }
  return base::bad_input(
      fmt::format("hidden effect '{}' cannot reach magnitude {} at any amplitude in this design: use a smaller "
                  "magnitude or more runs, or give its 'amplitude'",
                  drawn.entry->name, magnitude));
}

base::Result<SizedEffect> EffectSizer::sized(const HiddenSpec& spec, int number) const {
  SizedEffect effect;
  effect.drawn = draw_effect(spec, number, mps2_per_dps(design_));
  if (spec.amplitude) {
    effect.amplitude = *spec.amplitude;
  } else {
    const auto amplitude = amplitude_for(effect.drawn, *spec.magnitude);
    if (!amplitude) return base::forward_error(amplitude);
    effect.amplitude = *amplitude;
  }
  effect.magnitude = magnitude_of(effect.drawn, effect.amplitude);
  effect.contributions = contributions(effect.drawn, effect.amplitude);
  return effect;
}

}  // namespace soak::hal::sim
