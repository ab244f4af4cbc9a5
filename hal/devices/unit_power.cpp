// SPDX-License-Identifier: Apache-2.0
#include "hal/devices/unit_power.h"

#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "hal/devices/detail/controller.h"
#include "hal/maps/detail/device_needs.h"

namespace soak::hal {
namespace {

/// SCPI spells "not a number" as 9.91E37 and infinity as 9.9E37.
constexpr double kNoNumber = 9e37;

class MappedPower final : public UnitPower {
 public:
  MappedPower(std::shared_ptr<Controller> controller, std::string request)
      : controller_(std::move(controller)), request_(std::move(request)) {}

  base::Status connect() override { return controller_->connect(); }

  base::Status check(int output, const SupplySettings& settings) const override {
    if (!controller_->has(numbered(request_.c_str(), output))) {
      return base::bad_input(
          fmt::format("there is no output {}: the map has no '{}'", output, numbered(request_.c_str(), output)),
          description());
    }
    if (auto able = check_setting(output, kSetVoltage, "voltage", settings.voltage_v); !able) return able;
    return check_setting(output, kCurrentLimit, "current limit", settings.limit_a);
  }

  base::Status prepare(int output, const SupplySettings& settings) override {
    if (auto able = check(output, settings); !able) return able;
    if (settings.voltage_v) {
      const auto given = controller_->write(numbered(kSetVoltage, output), *settings.voltage_v);
      if (!given) return given;
    }
    return settings.limit_a ? controller_->write(numbered(kCurrentLimit, output), *settings.limit_a) : base::Status{};
  }

  base::Status set(int output, bool on) override {
    if (auto known = check(output, {}); !known) return known;
    const std::string request = numbered(request_.c_str(), output);
    if (auto written = controller_->write(request, value_of(request, on)); !written) return written;
    // The request says what the device was told, the state what it did.
    const std::string state = numbered(kState, output);
    return controller_->has(state) ? controller_->expect(state, value_of(state, on)) : base::Status{};
  }

  base::Result<std::map<int, OutputReading>> read(const std::vector<int>& outputs) override {
    std::vector<std::string> names;
    for (const int output : outputs) {
      if (auto known = check(output, {}); !known) return base::forward_error(known);
      names.push_back(state_of(output));
      for (const char* kind : {kCurrentTrip, kVoltageTrip, kVoltage, kCurrent, kCurrentLimit}) {
        if (controller_->has(numbered(kind, output))) names.push_back(numbered(kind, output));
      }
    }
    const auto values = controller_->read_all(names);
    if (!values) return base::forward_error(values);
    std::map<int, OutputReading> readings;
    for (const int output : outputs) readings[output] = reading_of(output, *values);
    return readings;
  }

  bool measures(int output) const override {
    return controller_->has(numbered(kVoltage, output)) || controller_->has(numbered(kCurrent, output));
  }

  std::string description() const override { return controller_->description(); }

 private:
  static std::string numbered(const char* kind, int output) { return fmt::format("{}{}", kind, output); }

  /// Where the device says whether the output is on.
  std::string state_of(int output) const {
    const std::string state = numbered(kState, output);
    return controller_->has(state) ? state : numbered(request_.c_str(), output);
  }

  /// The code `on` or `off` of the quantity; 1 or 0 where it has no codes.
  double value_of(const std::string& quantity, bool on) const {
    const char* code = on ? "on" : "off";
    return controller_->code(quantity, code).value_or(on ? 1.0 : 0.0);
  }

  base::Status check_setting(int output, const char* kind, const char* what, const std::optional<double>& value) const {
    if (!value) return {};
    const std::string quantity = numbered(kind, output);
    if (!controller_->has(quantity)) {
      return base::bad_input(
          fmt::format("the {} of output {} cannot be set: the map has no '{}'", what, output, quantity), description());
    }
    const auto range = controller_->range(quantity);
    if (*value >= range.min.value_or(*value) && *value <= range.max.value_or(*value)) return {};
    return base::bad_input(fmt::format("the {} of output {} cannot be {}: the map allows {} to {}", what, output,
                                       *value, range.min ? fmt::format("{}", *range.min) : "any",
                                       range.max ? fmt::format("{}", *range.max) : "any"),
                           description());
  }

  static std::optional<double> number(const Values& values, const std::string& quantity) {
    const auto found = values.find(quantity);
    const bool known = found != values.end() && std::abs(found->second) < kNoNumber;
    return known ? std::optional(found->second) : std::nullopt;
  }

  OutputReading reading_of(int output, const Values& values) const {
    const auto raised = [&](const char* kind) { return number(values, numbered(kind, output)).value_or(0.0) != 0.0; };
    const std::string state = state_of(output);
    OutputReading reading;
    reading.on = values.at(state) != value_of(state, false);
    reading.tripped = raised(kCurrentTrip) || raised(kVoltageTrip);
    reading.voltage_v = number(values, numbered(kVoltage, output));
    reading.current_a = number(values, numbered(kCurrent, output));
    reading.limit_a = number(values, numbered(kCurrentLimit, output));
    return reading;
  }

  std::shared_ptr<Controller> controller_;
  std::string request_;
};

}  // namespace

std::unique_ptr<UnitPower> make_mapped_power(std::shared_ptr<Controller> controller, std::string request) {
  return std::make_unique<MappedPower>(std::move(controller), std::move(request));
}

base::Result<std::unique_ptr<UnitPower>> make_unit_power(const DeviceMap& map) {
  if (auto able = require_device(map, "power"); !able) return base::forward_error(able);
  return make_mapped_power(std::make_shared<Controller>(map), kOutput);
}

}  // namespace soak::hal
