// SPDX-License-Identifier: Apache-2.0
#include "calib/estimate/detail/row_collector.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/units.h"
#include "calib/estimate/attitude_fit.h"
#include "calib/estimate/branches.h"
#include "calib/estimate/detail/parts_of_run.h"

namespace soak::calib {
namespace {

constexpr double kSignificant = 4.0;  ///< standard errors from which an even-order term is told
constexpr double kReversal_c = 3.0;   ///< that ends a branch of a run without plateaus

/// Drops the names of runs that gave no row and renumbers.
void drop_empty_runs(std::optional<CurveData>& data) {
  if (!data) return;
  std::vector<int> number(data->runs.size(), -1);
  std::vector<std::string> kept;
  for (const CurveRow& row : data->rows) number[static_cast<std::size_t>(row.run)] = 0;
  for (std::size_t r = 0; r < number.size(); ++r) {
    if (number[r] < 0) continue;
    number[r] = static_cast<int>(kept.size());
    kept.push_back(data->runs[r]);
  }
  for (CurveRow& row : data->rows) row.run = number[static_cast<std::size_t>(row.run)];
  data->runs = std::move(kept);
  if (data->rows.empty()) data.reset();
}

/// What a sensor reads at rest beyond its bias in a segment whose position is known.
double known_input(const Segment& segment, Sensor sensor, const Place& place, const UnitType& type) {
  if (!segment.position) return 0.0;
  const std::size_t axis = axis_of(sensor);
  const double up = segment.position->up[axis];
  if (!is_gyro(sensor)) return place.gravity.mps2 * type.sign_at_rest * up;
  const double vertical = place.earth.vertical_rps * up;
  if (place.earth.horizontal_rps == 0.0) return vertical;
  return vertical + place.earth.horizontal_rps * frame_of(*segment.position, *place.azimuth_deg).north[axis];
}

std::vector<CurveRow> block_rows(const GatedRun& run, int index, Sensor sensor, const UnitType& type) {
  const std::size_t s = index_of(sensor);
  std::vector<CurveRow> rows;
  for (const Segment& segment : run.segments) {
    if (turns(segment)) continue;
    const double known = known_input(segment, sensor, run.place, type);
    for (const Block& block : segment.blocks) {
      if (block.sensor[s].count == 0) continue;
      rows.push_back({index, 0, Sweep::unknown, block.t_s, block.sensor_temp_c[s], block.sensor[s].mean - known,
                      block.sensor[s].standard_error});
    }
  }
  return rows;
}

// Averages over runs of what a run's six-position estimation finds constant. Only standard errors: type B is added by
// whoever knows the circumstances.

/// Whether a constant is 0 in every run by the choice of the axes.
bool is_zero_by_choice(std::span<const Estimate> estimates) {
  return !estimates.empty() && std::ranges::all_of(estimates, [](const Estimate& estimate) {
    return estimate.value == 0.0 && estimate.standard_error == 0.0;
  });
}

/// Weighted mean, its error inflated where the runs scatter by more than theirs.
std::optional<StatedValue> average_over_runs(std::vector<Estimate> estimates) {
  if (is_zero_by_choice(estimates)) {
    StatedValue zero;
    zero.by_choice = true;
    return zero;
  }
  std::erase_if(estimates, [](const Estimate& estimate) { return estimate.standard_error <= 0.0; });
  if (estimates.empty()) return std::nullopt;
  double weight = 0.0;
  double sum = 0.0;
  for (const Estimate& estimate : estimates) {
    const double w = std::pow(estimate.standard_error, -2);
    weight += w;
    sum += w * estimate.value;
  }
  const double mean = sum / weight;
  double scatter = 0.0;
  for (const Estimate& estimate : estimates) {
    scatter += std::pow((estimate.value - mean) / estimate.standard_error, 2);
  }
  const auto freedoms = static_cast<double>(estimates.size()) - 1.0;
  const double inflation = freedoms > 0.0 ? std::max(1.0, scatter / freedoms) : 1.0;
  StatedValue stated;
  stated.value = mean;
  stated.standard_error = std::sqrt(inflation / weight);
  if (estimates.size() == 1) stated.freedoms = estimates.front().freedoms;
  return stated;
}

/// Misalignment of the accelerometers, or g-sensitivity of the gyros; absent unless all three sensors have all entries.
std::optional<Coupling> coupling_of(std::span<const SixPositionEstimate> estimates, bool gyros) {
  Coupling mean;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      if (!gyros && i == j) continue;
      std::vector<Estimate> entries;
      for (const SixPositionEstimate& estimate : estimates) {
        const SensorEstimate& sensor = estimate.sensor[gyros ? i : i + 3];
        if (sensor.coupling[j]) {
          entries.push_back({*sensor.coupling[j], sensor.coupling_se[j], sensor.coupling_freedoms});
        }
      }
      const auto entry = average_over_runs(entries);
      if (!entry) return std::nullopt;
      mean[i][j] = *entry;
    }
  }
  return mean;
}

/// Misalignment of the gyros, over the runs whose movements show it.
std::optional<Coupling> gyro_misalignment_of(std::span<const SixPositionEstimate> estimates) {
  Coupling mean;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      std::vector<Estimate> entries;
      for (const SixPositionEstimate& estimate : estimates) {
        if (estimate.sensor[i].rate_coupling) entries.push_back((*estimate.sensor[i].rate_coupling)[j]);
      }
      const auto entry = average_over_runs(entries);
      if (!entry) return std::nullopt;
      mean[i][j] = *entry;
    }
  }
  return mean;
}

std::optional<StatedValue> even_order_of_runs(std::span<const SixPositionEstimate> estimates, Sensor accel) {
  std::vector<Estimate> terms;
  for (const SixPositionEstimate& estimate : estimates) {
    if (const auto& term = estimate.sensor[index_of(accel)].even_order) terms.push_back(*term);
  }
  return average_over_runs(terms);
}

/// Level error: mean over the runs that show it; the reason of the first where none does.
LevelStatement level_of(std::span<const SixPositionEstimate> estimates) {
  LevelStatement level;
  std::vector<Estimate> north;
  std::vector<Estimate> east;
  const std::string* reason = nullptr;
  for (const SixPositionEstimate& estimate : estimates) {
    level.with_headings = level.with_headings || estimate.with_headings;
    if (!estimate.level_error) {
      if (reason == nullptr) reason = &estimate.no_level_error;
      continue;
    }
    north.push_back(estimate.level_error->north);
    east.push_back(estimate.level_error->east);
    // The faces are the same in all runs: no mean lessens what they do.
    for (std::size_t k = 0; k < 2; ++k) {
      level.per_face_tilt[k] = std::max(level.per_face_tilt[k], estimate.level_error->per_face_tilt[k]);
    }
  }
  const auto to_north = average_over_runs(north);
  const auto to_east = average_over_runs(east);
  if (to_north && to_east) {
    level.to_north_east = {*to_north, *to_east};
    level.in_every_run = north.size() == estimates.size();
  } else {
    level.reason = reason != nullptr ? *reason
                   : north.empty()   ? "no run has plateaus"
                                     : "the standard errors of the readings are not known";
  }
  return level;
}

}  // namespace

base::Status RowCollector::add(const GatedRun& run, int index, const UnitType& type) {
  add_gravity(run.place.gravity);
  if (by_plateau_) {
    auto added = add_plateaus(run, index, type);
    if (!added) added.error().message = fmt::format("run {}: {}", name(index), added.error().message);
    return added;
  }
  add_blocks(run, index, type);
  return {};
}

base::Status RowCollector::add_plateaus(const GatedRun& run, int index, const UnitType& type) {
  base::Result<SixPositionEstimate> estimated = run.in_found_attitudes()
                                                    ? estimate_attitudes(run.segments, run.place, type)
                                                    : estimate_six_positions(run.segments, run.place, type);
  if (!estimated) return base::forward_error(estimated);
  SixPositionEstimate& estimate = estimates_.emplace_back(*std::move(estimated));
  estimated_.push_back(name(index));
  if (auto added = add_gains(run.segments, run.recorded->moves, type, estimate); !added) return added;
  for (const Sensor sensor : kSensors) {
    const std::size_t s = index_of(sensor);
    for (const PlateauEstimate& plateau : estimate.sensor[s].plateaus) {
      const std::string branch = fmt::format("{} {}", name(index), name_of(plateau.sweep));
      CurveRow row{index,           branch_of(rows_.bias[s], branch),
                   plateau.sweep,   plateau.t_s,
                   plateau.temp_c,  plateau.bias,
                   plateau.bias_se, plateau.bias_freedoms};
      table(rows_.bias[s]).rows.push_back(row);
      if (!plateau.scale_ppm) continue;
      row.branch = branch_of(rows_.scale[s], branch);
      row.value = *plateau.scale_ppm;
      row.standard_error = *plateau.scale_se_ppm;
      row.freedoms = plateau.scale_freedoms;
      table(rows_.scale[s]).rows.push_back(row);
    }
  }
  return {};
}

void RowCollector::add_blocks(const GatedRun& run, int index, const UnitType& type) {
  for (const Sensor sensor : kSensors) {
    std::vector<CurveRow> rows = block_rows(run, index, sensor, type);
    if (rows.empty()) continue;
    auto& target = rows_.bias[index_of(sensor)];
    number_branches(rows, index, target);
    auto& all = table(target).rows;
    all.insert(all.end(), rows.begin(), rows.end());
  }
}

void RowCollector::finish() {
  for (auto& data : rows_.bias) drop_empty_runs(data);
  for (auto& data : rows_.scale) drop_empty_runs(data);
  rows_.accel_misalignment = coupling_of(estimates_, false);
  rows_.gyro_misalignment = gyro_misalignment_of(estimates_);
  rows_.g_sensitivity = coupling_of(estimates_, true);
  for (std::size_t i = 0; i < 3; ++i) rows_.even_order[i] = even_order_of_runs(estimates_, kSensors[i + 3]);
  rows_.level = level_of(estimates_);
  state_warnings();
}

/// The unit's gravity is the mean over its runs, as each was reduced with its own, and as uncertain as the worst.
void RowCollector::add_gravity(const Gravity& gravity) {
  ++gravity_count_;
  Gravity& mean = rows_.gravity;
  const bool first = gravity_count_ == 1.0;
  const bool worse =
      !gravity.standard_uncertainty_mps2 ||
      (mean.standard_uncertainty_mps2 && *gravity.standard_uncertainty_mps2 > *mean.standard_uncertainty_mps2);
  if (first || worse) {
    mean.standard_uncertainty_mps2 = gravity.standard_uncertainty_mps2;
    mean.basis = gravity.basis;
  }
  mean.mps2 += (gravity.mps2 - mean.mps2) / gravity_count_;
  mean.assumed = mean.assumed || gravity.assumed;
}

CurveData& RowCollector::table(std::optional<CurveData>& data) {
  if (!data) {
    data.emplace();
    data->runs = names_;
    data->by_plateau = by_plateau_;
  }
  return *data;
}

int RowCollector::branch_of(std::optional<CurveData>& data, const std::string& branch) {
  auto& branches = table(data).branches;
  const auto found = std::find(branches.begin(), branches.end(), branch);
  if (found != branches.end()) return static_cast<int>(found - branches.begin());
  branches.push_back(branch);
  return static_cast<int>(branches.size()) - 1;
}

void RowCollector::number_branches(std::vector<CurveRow>& rows, int index, std::optional<CurveData>& target) {
  std::vector<double> temps;
  for (const CurveRow& row : rows) temps.push_back(row.temp_c);
  std::map<Sweep, int> count;
  for (const Branch& branch : find_branches(temps, kReversal_c)) {
    const std::string_view word = branch.sweep == Sweep::up     ? "heating"
                                  : branch.sweep == Sweep::down ? "cooling"
                                                                : "steady";
    const int id = branch_of(target, fmt::format("{} {} {}", name(index), word, ++count[branch.sweep]));
    for (std::size_t i = branch.first; i < branch.last; ++i) {
      rows[i].branch = id;
      rows[i].sweep = branch.sweep;
    }
  }
}

/// A warning of one part of a run about positions that the others have: what it still asks for, if anything.
std::optional<Warning> RowCollector::without_other_parts(const Warning& warning, std::size_t part) const {
  if (warning.code != "missing_position" || warning.text.find("do not determine") == std::string::npos) return warning;
  const auto sensor = std::ranges::find_if(
      kSensors, [&](Sensor s) { return warning.text.starts_with(fmt::format("{}: ", name_of(s))); });
  if (sensor == kSensors.end() || !shown_by_other_parts(estimated_, estimates_, part, *sensor)) return warning;
  if (warning.text.find("stays in the bias") == std::string::npos) return std::nullopt;
  return Warning{"cut_short_visit", warning.text + "; another part of this run has them"};
}

void RowCollector::note_warnings() {
  for (std::size_t part = 0; part < estimates_.size(); ++part) {
    for (const Warning& stated : estimates_[part].warnings) {
      const auto warning = without_other_parts(stated, part);
      if (!warning) continue;
      if (++seen_in_[{warning->code, warning->text}] == 1) first_seen_.push_back({*warning, estimated_[part]});
    }
  }
}

void RowCollector::state_warnings() {
  note_warnings();
  for (const auto& [warning, run] : first_seen_) {
    const std::size_t more = seen_in_.at({warning.code, warning.text}) - 1;
    rows_.warnings.push_back({warning.code, fmt::format("run {}: {}{}", run, warning.text, more_runs_text(more))});
  }
  for (const Sensor sensor : {Sensor::accel_x, Sensor::accel_y, Sensor::accel_z}) warn_of_even_order(sensor);
}

/// Tells a significant even-order term, mean over runs: it is the difference between bias at ±g and at 0 g.
void RowCollector::warn_of_even_order(Sensor sensor) const {
  const auto& term = rows_.even_order[axis_of(sensor)];
  if (!term || std::abs(term->value) < kSignificant * term->standard_error) return;
  constexpr double kPerG = 1e6 * base::kStandardGravity_mps2;  // 1/(m/s²) to µg/g²
  const double g = rows_.gravity.mps2;
  rows_.warnings.push_back(
      {"even_order",
       fmt::format("{}: even-order term of {:.4g} ± {:.2g} µg/g² (one standard error); its bias is that at ±1 g, and "
                   "that at 0 g is {:.3g} m/s2 {}. Faces of the fixture that are not square look the same",
                   name_of(sensor), kPerG * term->value, kPerG * term->standard_error, std::abs(term->value) * g * g,
                   term->value > 0.0 ? "lower" : "higher")});
}

}  // namespace soak::calib
