// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "hal/devices.h"
#include "hal/modbus/controller.h"
#include "hal/modbus/map_check.h"

namespace soak::hal {
namespace {

constexpr double kLowestCredible_c = -150.0;
constexpr double kHighestCredible_c = 400.0;

class ModbusChamber final : public Chamber {
 public:
  explicit ModbusChamber(const RegisterMap& map)
      : controller_(map), mode_(controller_.has("actual_mode") ? "actual_mode" : "control_mode") {
    names_ = {"air_c", "set_point_c", mode_};
    for (const char* name : {"working_set_point_c", "output_percent"}) {
      if (controller_.has(name)) names_.emplace_back(name);
    }
    min_set_point_c_ = map.quantities.at("set_point_c").min;
    max_set_point_c_ = map.quantities.at("set_point_c").max;
  }

  base::Status connect() override {
    if (auto connected = controller_.connect(); !connected) return connected;
    return read_limits();
  }

  base::Result<ChamberReading> read() override {
    const auto values = controller_.read_all(names_);
    if (!values) return base::forward_error(values);
    if (auto credible = check(*values); !credible) return base::forward_error(credible);
    const auto alarms = controller_.active_alarms();
    if (!alarms) return base::forward_error(alarms);
    ChamberReading reading;
    reading.air_c = values->at("air_c");
    reading.set_point_c = values->at("set_point_c");
    reading.working_set_point_c = optional_value(*values, "working_set_point_c");
    reading.output_percent = optional_value(*values, "output_percent");
    reading.running = values->at(mode_) == code(mode_, "auto");
    for (const AlarmRule& rule : *alarms) reading.alarms.push_back({rule.name, rule.outputs_off});
    return reading;
  }

  base::Status set_temperature(double temp_c) override {
    if (temp_c < min_set_point_c_.value_or(temp_c) || temp_c > max_set_point_c_.value_or(temp_c)) {
      return base::bad_input(fmt::format("set point {} °C is beyond the chamber's limits", temp_c), description());
    }
    return controller_.write("set_point_c", temp_c);
  }

  base::Status set_ramp_rate(std::optional<double> rate_kpmin) override {
    if (!can_ramp()) {
      if (!rate_kpmin) return {};
      return base::bad_input("the register map has no ramp: 'ramp_rate', 'ramp_on' and 'ramp_off'", description());
    }
    if (!rate_kpmin) return controller_.run("ramp_off");
    if (auto written = controller_.write("ramp_rate", *rate_kpmin); !written) return written;
    return controller_.run("ramp_on");
  }

  base::Status start() override { return switch_control("start", "auto"); }
  base::Status stop() override { return switch_control("stop", "off"); }

  std::optional<double> min_set_point_c() const override { return min_set_point_c_; }
  std::optional<double> max_set_point_c() const override { return max_set_point_c_; }
  bool can_ramp() const override {
    const auto& actions = controller_.map().actions;
    return controller_.has("ramp_rate") && actions.contains("ramp_on") && actions.contains("ramp_off");
  }
  std::string description() const override { return controller_.description(); }

 private:
  int code(const std::string& quantity, const char* name) const {
    return controller_.map().quantities.at(quantity).codes.at(name);
  }

  base::Status switch_control(const char* action, const char* mode) {
    if (controller_.map().actions.contains(action)) return controller_.run(action);
    return controller_.write("control_mode", code("control_mode", mode));
  }

  /// The controller's own limits, set at its front, narrow those of the map.
  base::Status read_limits() {
    std::vector<std::string> names;
    for (const char* name : {"min_set_point_c", "max_set_point_c"}) {
      if (controller_.has(name)) names.emplace_back(name);
    }
    if (names.empty()) return {};
    const auto values = controller_.read_all(names);
    if (!values) return base::forward_error(values);
    if (auto credible = check(*values); !credible) return credible;
    const Quantity& set_point = controller_.map().quantities.at("set_point_c");
    if (const auto low = optional_value(*values, "min_set_point_c")) {
      min_set_point_c_ = std::max(*low, set_point.min.value_or(*low));
    }
    if (const auto high = optional_value(*values, "max_set_point_c")) {
      max_set_point_c_ = std::min(*high, set_point.max.value_or(*high));
    }
    return {};
  }

  static std::optional<double> optional_value(const Values& values, std::string_view name) {
    const auto found = values.find(name);
    return found == values.end() ? std::nullopt : std::optional(found->second);
  }

  /// A broken sensor, a wrong word order and a wrong register all show as a number that no chamber has.
  base::Status check(const Values& values) const {
    for (const auto& [name, value] : values) {
      const bool temperature = name.ends_with("_c");
      const bool credible =
          std::isfinite(value) && (!temperature || std::clamp(value, kLowestCredible_c, kHighestCredible_c) == value);
      if (credible) continue;
      return controller_.fail(fmt::format("{} (register {}) reads {}, which no chamber has: sensor, word order or map",
                                          name, controller_.map().quantities.at(name).address, value));
    }
    return {};
  }

  Controller controller_;
  std::string mode_;
  std::vector<std::string> names_;  ///< read at every reading
  std::optional<double> min_set_point_c_;
  std::optional<double> max_set_point_c_;
};

base::Status check_control(const RegisterMap& map) {
  const bool actual = map.quantities.contains("actual_mode");
  if (auto status = require_code(map, actual ? "actual_mode" : "control_mode", "auto"); !status) return status;
  for (const auto& [action, mode] : {std::pair{"start", "auto"}, std::pair{"stop", "off"}}) {
    if (map.actions.contains(action)) continue;
    if (auto status = require_writable(map, "control_mode"); !status) return status;
    if (auto status = require_code(map, "control_mode", mode); !status) return status;
  }
  return {};
}

}  // namespace

base::Result<std::unique_ptr<Chamber>> make_modbus_chamber(const RegisterMap& map) {
  if (auto status = require_kind(map, "chamber"); !status) return base::forward_error(status);
  if (auto status = require_quantity(map, "air_c"); !status) return base::forward_error(status);
  if (auto status = require_writable(map, "set_point_c"); !status) return base::forward_error(status);
  if (auto status = check_control(map); !status) return base::forward_error(status);
  if (map.quantities.contains("ramp_rate")) {
    if (auto status = require_writable(map, "ramp_rate"); !status) return base::forward_error(status);
  }
  return std::make_unique<ModbusChamber>(map);
}

}  // namespace soak::hal
