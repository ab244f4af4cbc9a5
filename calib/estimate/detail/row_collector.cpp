// SPDX-License-Identifier: Apache-2.0
#include "calib/estimate/detail/row_collector.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/units.h"
#include "calib/estimate/body_frame.h"
#include "calib/estimate/detail/branches.h"

namespace soak::calib {
namespace {

constexpr double kSignificant = 4.0;  ///< standard errors from which an even-order term is told

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
double known_input(const Segment& segment, Sensor sensor, const Site& site, const EarthRate& earth,
                   const UnitType& type) {
  if (!segment.position) return 0.0;
  const std::size_t axis = axis_of(sensor);
  const double up = segment.position->up[axis];
  if (!is_gyro(sensor)) return gravity_at(site).mps2 * type.sign_at_rest * up;
  const double vertical = earth.vertical_rps * up;
  if (earth.horizontal_rps == 0.0) return vertical;
  return vertical + earth.horizontal_rps * frame_of(*segment.position, *site.azimuth_deg).north[axis];
}

std::vector<CurveRow> block_rows(const RunInput& run, int index, Sensor sensor, const UnitType& type) {
  const std::size_t s = index_of(sensor);
  const auto earth = known_earth_rate(run.segments, run.site);
  std::vector<CurveRow> rows;
  for (const Segment& segment : run.segments) {
    if (turns(segment)) continue;
    const double known = known_input(segment, sensor, run.site, earth, type);
    for (const Block& block : segment.blocks) {
      if (block.sensor[s].count == 0) continue;
      rows.push_back({index, 0, Sweep::unknown, block.t_s, block.sensor_temp_c[s], block.sensor[s].mean - known,
                      block.sensor[s].standard_error});
    }
  }
  return rows;
}

}  // namespace

void RowCollector::add_plateaus(const RunInput& run, int index, const UnitType& type) {
  const SixPositionEstimate estimate = estimate_six_positions(run.segments, run.site, type);
  add_gravity(estimate.gravity);
  note(estimate.warnings, index);
  shared_.add(estimate);
  for (const Sensor sensor : kSensors) {
    const std::size_t s = index_of(sensor);
    for (const PlateauEstimate& plateau : estimate.sensor[s].plateaus) {
      const std::string branch = fmt::format("{} {}", name(index), name_of(plateau.sweep));
      CurveRow row{
          index,          branch_of(rows_.bias[s], branch), plateau.sweep, plateau.t_s, plateau.temp_c, plateau.bias,
          plateau.bias_se};
      table(rows_.bias[s]).rows.push_back(row);
      if (!plateau.scale_ppm) continue;
      row.branch = branch_of(rows_.scale[s], branch);
      row.value = *plateau.scale_ppm;
      row.standard_error = *plateau.scale_se_ppm;
      table(rows_.scale[s]).rows.push_back(row);
    }
  }
}

void RowCollector::add_blocks(const RunInput& run, int index, const UnitType& type) {
  add_gravity(gravity_at(run.site));
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
  rows_.accel_misalignment = shared_.coupling(false);
  rows_.g_sensitivity = shared_.coupling(true);
  for (std::size_t i = 0; i < 3; ++i) rows_.even_order[i] = shared_.even_order(kSensors[i + 3]);
  rows_.level = shared_.level();
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
  for (const Branch& branch : find_branches(temps)) {
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

void RowCollector::note(const std::vector<Warning>& warnings, int index) {
  for (const Warning& warning : warnings) {
    if (++seen_in_[{warning.code, warning.text}] == 1) first_seen_.push_back({warning, name(index)});
  }
}

void RowCollector::state_warnings() const {
  for (const auto& [warning, run] : first_seen_) {
    const std::size_t more = seen_in_.at({warning.code, warning.text}) - 1;
    rows_.warnings.push_back(
        {warning.code, fmt::format("run {}: {}{}", run, warning.text,
                                   more > 0 ? fmt::format(" (and so in {} more runs)", more) : "")});
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
