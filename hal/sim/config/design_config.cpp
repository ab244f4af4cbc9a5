// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/config/design_config.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <array>

#include "base/units.h"
#include "hal/sim/config/range.h"

namespace soak::hal::sim {
namespace {

using settings::Limits;
using settings::Table;

constexpr std::array<std::string_view, 5> kKindNames = {"identical", "mixed", "three", "one", "missing_logs"};

constexpr Limits kDesignSigma = {0.0, 1e3};

/// Replaces `target` by `factor` times the number under a key, where the section has that key.
void read_scaled(const Table& section, const std::string& key, Limits limits, double factor, double& target) {
  if (const auto value = section.optional_number(key, limits)) target = factor * *value;
}

void read_design_noise(const Table& section, const std::string& sensor, const std::string& unit, double si,
                       DesignNoise& noise) {
  const Limits positive = {1e-9, 1e3};
  read_scaled(section, sensor + "_block_sigma_" + unit, positive, si, noise.block_sigma);
  read_scaled(section, sensor + "_placement_sigma_" + unit, kDesignSigma, si, noise.placement_sigma);
  read_scaled(section, sensor + "_visit_sigma_" + unit, kDesignSigma, si, noise.visit_sigma);
  read_scaled(section, sensor + "_run_sigma_" + unit, positive, si, noise.run_sigma);
}

DesignKind read_design_kind(const Table& section) {
  const std::string name = section.text("kind", std::string(kKindNames[0]));
  const auto kind = design_kind_named(name);
  if (!kind) {
    section.refuse("kind", fmt::format("'design.kind' must be {}, not '{}'", fmt::join(kKindNames, " | "), name));
  }
  return kind.value_or(DesignKind::identical);
}

}  // namespace

std::optional<DesignKind> design_kind_named(std::string_view name) {
  for (std::size_t i = 0; i < kKindNames.size(); ++i) {
    if (kKindNames[i] == name) return static_cast<DesignKind>(i);
  }
  return std::nullopt;
}

std::string_view name_of(DesignKind kind) { return kKindNames[static_cast<std::size_t>(kind)]; }

int usual_runs(DesignKind kind) { return kind == DesignKind::three ? 3 : kind == DesignKind::one ? 1 : 6; }

DesignConfig default_design(DesignKind kind) {
  constexpr double kDps = base::kRadPerDeg;
  DesignConfig design;
  design.kind = kind;
  design.runs = usual_runs(kind);
  design.gyro = {0.004 * kDps, 0.002 * kDps, 0.002 * kDps, 0.02 * kDps};
  design.accel = {0.002, 0.001, 0.001, 0.01};
  return design;
}

double mps2_per_dps(const DesignConfig& design) {
  return design.accel.block_sigma / (design.gyro.block_sigma * base::kDegPerRad);
}

std::optional<DesignConfig> read_design(const Table& root) {
  const auto section = root.table("design");
  if (!section) return std::nullopt;
  DesignConfig design = default_design(read_design_kind(*section));
  design.runs = section->whole("runs", {1, kMaxDesignRuns}, design.runs);
  design.start_c = section->number("start_c", kAnyTemperature_c, design.start_c);
  design.step_c = section->number("step_c", {0.1, 200.0}, design.step_c);
  design.set_points = section->whole("set_points", {2, kMaxDesignSetPoints}, design.set_points);
  design.blocks = section->whole("blocks", {1, kMaxDesignBlocks}, design.blocks);
  read_scaled(*section, "ramp_kpmin", {0.01, 100.0}, 1.0 / 60.0, design.ramp_kps);
  design.soak_s = section->number("soak_s", {0.0, 1e6}, design.soak_s);
  design.ramp_row_interval_s = section->number("ramp_row_interval_s", {10.0, 30.0}, design.ramp_row_interval_s);
  read_design_noise(*section, "gyro", "dps", base::kRadPerDeg, design.gyro);
  read_design_noise(*section, "accel", "mps2", 1.0, design.accel);
  design.drift_factor = section->number("drift_factor", {0.0, 100.0}, design.drift_factor);
  design.amplitude_spread = section->number("amplitude_spread", {0.0, 1.0}, design.amplitude_spread);
  design.dropped_visit = section->flag("dropped_visit", design.dropped_visit);
  design.wrong_position = section->flag("wrong_position", design.wrong_position);
  design.thermometer_step_c = section->number("thermometer_step_c", {0.0, 10.0}, design.thermometer_step_c);
  design.known_effects = section->flag("known_effects", design.known_effects);
  design.contributions = section->flag("contributions", design.contributions);
  return design;
}

}  // namespace soak::hal::sim
