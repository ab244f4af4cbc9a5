// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "hal/devices/detail/controller.h"
#include "hal/devices/detail/fixture_status.h"
#include "hal/devices/detail/two_axis_fixture.h"
#include "hal/devices/devices.h"
#include "hal/maps/detail/device_needs.h"
#include "hal/maps/detail/map_check.h"

namespace soak::hal {
namespace {

class ModbusFixture final : public Fixture {
 public:
  explicit ModbusFixture(const RegisterMap& map) : controller_(map), status_(map), labels_(map.positions) {}

  base::Status connect() override { return controller_.connect(); }
  std::vector<std::string> positions() const override { return labels_; }

  base::Status move_to(std::string_view label) override {
    const auto found = std::find(labels_.begin(), labels_.end(), label);
    if (found == labels_.end()) {
      return base::bad_input(fmt::format("the fixture has no position '{}', only {}", label, fmt::join(labels_, ", ")),
                             description());
    }
    return controller_.write("request", static_cast<double>(found - labels_.begin() + 1));
  }

  base::Result<FixtureReading> read() override {
    const auto values = controller_.read_all({"status", "position"});
    if (!values) return base::forward_error(values);
    const auto moving = status_.moving(controller_, values->at("status"));
    if (!moving) return base::forward_error(moving);
    if (!*moving) return standing_at(static_cast<int>(values->at("position")));
    FixtureReading reading;
    reading.moving = true;
    return reading;
  }

  std::string description() const override { return controller_.description(); }

 private:
  /// Position code 0 is between the positions.
  base::Result<FixtureReading> standing_at(int code) const {
    if (code == 0) return FixtureReading{};
    if (code < 0 || static_cast<std::size_t>(code) > labels_.size()) {
      return controller_.fail(fmt::format("position ({}) is {}: the map names {} positions, 0 is between them",
                                          controller_.place("position"), code, labels_.size()));
    }
    FixtureReading reading;
    reading.position = labels_[static_cast<std::size_t>(code) - 1];
    return reading;
  }

  Controller controller_;
  FixtureStatus status_;
  std::vector<std::string> labels_;
};

}  // namespace

base::Status Fixture::can_spin(std::string_view /*label*/, double /*rate_dps*/) const {
  return base::bad_input("the fixture cannot turn at a rate", description());
}

base::Result<std::unique_ptr<Fixture>> make_modbus_fixture(const RegisterMap& map) {
  if (auto status = require_kind(map, "fixture"); !status) return base::forward_error(status);
  if (map.axes) return make_two_axis_fixture(map);
  if (const auto needs = device_needs(map); !needs.empty()) {
    return base::bad_input(fmt::format("{}", fmt::join(needs, "; ")), map.file);
  }
  return std::make_unique<ModbusFixture>(map);
}

}  // namespace soak::hal
