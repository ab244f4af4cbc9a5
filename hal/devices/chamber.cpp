// SPDX-License-Identifier: Apache-2.0
#include "hal/devices/chamber.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "hal/devices/detail/controller.h"
#include "hal/maps/detail/device_needs.h"

namespace soak::hal {
namespace {

constexpr double kLowestCredible_c = -150.0;
constexpr double kHighestCredible_c = 400.0;
/// 23.25 °C with its words exchanged is 2e-41: it must not pass for a temperature of 0.
constexpr double kNoTemperature_c = 1e-20;
constexpr int kMostOutputs = 64;  ///< of a controller that switches units as well

class MappedChamber final : public Chamber {
 public:
  explicit MappedChamber(const DeviceMap& map)
      : controller_(std::make_shared<Controller>(map)),
        mode_(controller_->has("actual_mode") ? "actual_mode" : "control_mode") {
    names_ = {"air_c", "set_point_c", mode_};
    for (const char* name : {"working_set_point_c", "output_percent", "air_rh_percent"}) {
      if (controller_->has(name)) names_.emplace_back(name);
    }
    range_ = map_range_ = controller_->range("set_point_c");
    if (switches_units()) power_ = make_mapped_power(controller_, kChamberOutput);
  }

  base::Status connect() override {
    if (auto connected = controller_->connect(); !connected) return connected;
    return read_limits();
  }

  base::Result<ChamberReading> read() override {
    const auto values = controller_->read_all(names_);
    if (!values) return base::forward_error(values);
    if (auto credible = check_credible(*values); !credible) return base::forward_error(credible);
    auto alarms = controller_->active_alarms();
    if (!alarms) return base::forward_error(alarms);
    ChamberReading reading;
    reading.air_c = values->at("air_c");
    reading.set_point_c = values->at("set_point_c");
    reading.working_set_point_c = optional_value(*values, "working_set_point_c");
    reading.output_percent = optional_value(*values, "output_percent");
    reading.air_rh_percent = optional_value(*values, "air_rh_percent");
    reading.running = controller_->code(mode_, "auto") == values->at(mode_);
    reading.alarms = *std::move(alarms);
    return reading;
  }

  base::Status set_temperature(double temp_c) override {
    if (temp_c < range_.min.value_or(temp_c) || temp_c > range_.max.value_or(temp_c)) {
      return base::bad_input(fmt::format("set point {} °C is beyond the chamber's limits", temp_c), description());
    }
    return controller_->write("set_point_c", temp_c);
  }

  base::Status set_ramp_rate(std::optional<double> rate_kpmin) override {
    if (!can_ramp()) {
      if (!rate_kpmin) return {};
      return base::bad_input("the map has no ramp: 'ramp_rate', 'ramp_on' and 'ramp_off'", description());
    }
    if (!rate_kpmin) return controller_->run("ramp_off");
    if (auto written = controller_->write("ramp_rate", *rate_kpmin); !written) return written;
    return controller_->run("ramp_on");
  }

  base::Status start() override { return switch_control("start", "auto", Controller::Held::by_policy); }
  // A register that says "off" is no proof that heating is: the command may have been lost behind it.
  base::Status stop() override { return switch_control("stop", "off", Controller::Held::write_anyway); }

  std::optional<double> min_set_point_c() const override { return range_.min; }
  std::optional<double> max_set_point_c() const override { return range_.max; }
  bool can_ramp() const override {
    return controller_->has("ramp_rate") && controller_->has_action("ramp_on") && controller_->has_action("ramp_off");
  }
  UnitPower* unit_power() override { return power_.get(); }
  bool answers() const override { return controller_->answers(); }
  std::string description() const override { return controller_->description(); }

 private:
  bool switches_units() const {
    for (int output = 1; output <= kMostOutputs; ++output) {
      if (controller_->has(fmt::format("{}{}", kChamberOutput, output))) return true;
    }
    return false;
  }

  base::Status switch_control(const char* action, const char* mode, Controller::Held held) {
    if (controller_->has_action(action)) return controller_->run(action, held);
    return controller_->write("control_mode", controller_->code("control_mode", mode).value(), held);
  }

  /// The controller's own limits, set at its front, narrow those of the map.
  base::Status read_limits() {
    std::vector<std::string> names;
    for (const char* name : {"min_set_point_c", "max_set_point_c"}) {
      if (controller_->has(name)) names.emplace_back(name);
    }
    if (names.empty()) return {};
    const auto values = controller_->read_all(names);
    if (!values) return base::forward_error(values);
    if (auto credible = check_credible(*values); !credible) return credible;
    if (const auto low = optional_value(*values, "min_set_point_c")) {
      range_.min = std::max(*low, map_range_.min.value_or(*low));
    }
    if (const auto high = optional_value(*values, "max_set_point_c")) {
      range_.max = std::min(*high, map_range_.max.value_or(*high));
    }
    return {};
  }

  static std::optional<double> optional_value(const Values& values, std::string_view name) {
    const auto found = values.find(name);
    return found == values.end() ? std::nullopt : std::optional(found->second);
  }

  /// A broken sensor, a wrong word order and a wrong register all show as a number that no chamber has.
  base::Status check_credible(const Values& values) const {
    for (const auto& [name, value] : values) {
      if (is_credible(name, value)) continue;
      return controller_->fail(
          fmt::format("{} ({}) reads {}, which is impossible for a chamber: check sensor, word order and map", name,
                      controller_->place(name), value));
    }
    return {};
  }

  std::shared_ptr<Controller> controller_;
  std::unique_ptr<UnitPower> power_;
  std::string mode_;
  std::vector<std::string> names_;  ///< read at every reading
  Controller::Range map_range_;
  Controller::Range range_;  ///< of map and controller
};

}  // namespace

bool is_credible(std::string_view quantity, double value) {
  if (!std::isfinite(value)) return false;
  if (!quantity.ends_with("_c")) return true;
  const bool swapped = value != 0.0 && std::abs(value) < kNoTemperature_c;
  return !swapped && std::clamp(value, kLowestCredible_c, kHighestCredible_c) == value;
}

base::Result<std::unique_ptr<Chamber>> make_chamber(const DeviceMap& map) {
  if (auto able = require_device(map, "chamber"); !able) return base::forward_error(able);
  return std::make_unique<MappedChamber>(map);
}

}  // namespace soak::hal
