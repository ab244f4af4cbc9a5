// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/config/design_config.h"

#include <fmt/format.h>

#include <array>
#include <cmath>

#include "base/units.h"
#include "hal/sim/config/config_reader.h"

namespace soak::hal::sim {
namespace {

constexpr std::array<std::string_view, 5> kKindNames = {"identical", "mixed", "three", "one", "missing_logs"};

constexpr ConfigReader::Limits kTemperature_c = {-200.0, 300.0};
constexpr ConfigReader::Limits kSigma = {0.0, 1e3};

/// Reads keys of [design] that may be absent.
class DesignReader {
 public:
  explicit DesignReader(ConfigReader& reader) : reader_(reader) {}

  void number(const std::string& name, ConfigReader::Limits limits, double factor, double& target) {
    if (const auto value = reader_.optional_number("design." + name, limits)) target = factor * *value;
  }
  void whole(const std::string& name, double low, double high, int& target) {
    const std::string key = "design." + name;
    const auto value = reader_.optional_number(key, {low, high});
    if (!value) return;
    if (*value != std::floor(*value)) reader_.refuse(key, fmt::format("'{}' must be whole", key));
    target = static_cast<int>(*value);
  }
  void flag(const std::string& name, bool& target) {
    if (const auto value = reader_.optional_flag("design." + name)) target = *value;
  }

 private:
  ConfigReader& reader_;
};

void read_noise(DesignReader& reader, const std::string& sensor, const std::string& unit, double si,
                DesignNoise& noise) {
  const ConfigReader::Limits positive = {1e-9, 1e3};
  reader.number(sensor + "_block_sigma_" + unit, positive, si, noise.block_sigma);
  reader.number(sensor + "_placement_sigma_" + unit, kSigma, si, noise.placement_sigma);
  reader.number(sensor + "_visit_sigma_" + unit, kSigma, si, noise.visit_sigma);
  reader.number(sensor + "_run_sigma_" + unit, positive, si, noise.run_sigma);
}

DesignKind read_kind(ConfigReader& reader) {
  const auto name = reader.optional_text("design.kind");
  if (!name) return DesignKind::identical;
  const auto kind = design_kind_named(*name);
  if (!kind) {
    reader.refuse("design.kind",
                  fmt::format("'design.kind' must be {}, not '{}'", fmt::join(kKindNames, " | "), *name));
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

std::optional<DesignConfig> read_design(ConfigReader& reader) {
  if (!reader.has("design")) return std::nullopt;
  DesignConfig design = default_design(read_kind(reader));
  DesignReader keys(reader);
  keys.whole("runs", 1, kMaxDesignRuns, design.runs);
  keys.number("start_c", kTemperature_c, 1.0, design.start_c);
  keys.number("step_c", {0.1, 200.0}, 1.0, design.step_c);
  keys.whole("set_points", 2, kMaxDesignSetPoints, design.set_points);
  keys.whole("blocks", 1, kMaxDesignBlocks, design.blocks);
  keys.number("ramp_kpmin", {0.01, 100.0}, 1.0 / 60.0, design.ramp_kps);
  keys.number("soak_s", {0.0, 1e6}, 1.0, design.soak_s);
  keys.number("ramp_row_interval_s", {10.0, 30.0}, 1.0, design.ramp_row_interval_s);
  read_noise(keys, "gyro", "dps", base::kRadPerDeg, design.gyro);
  read_noise(keys, "accel", "mps2", 1.0, design.accel);
  keys.number("drift_factor", {0.0, 100.0}, 1.0, design.drift_factor);
  keys.number("amplitude_spread", {0.0, 1.0}, 1.0, design.amplitude_spread);
  keys.flag("dropped_visit", design.dropped_visit);
  keys.flag("wrong_position", design.wrong_position);
  keys.number("thermometer_step_c", {0.0, 10.0}, 1.0, design.thermometer_step_c);
  keys.flag("known_effects", design.known_effects);
  keys.flag("contributions", design.contributions);
  return design;
}

}  // namespace soak::hal::sim
