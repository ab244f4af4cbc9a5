// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "hal/devices.h"
#include "hal/modbus/controller.h"
#include "hal/modbus/map_check.h"

namespace soak::hal {
namespace {

class ModbusFixture final : public Fixture {
 public:
  explicit ModbusFixture(const RegisterMap& map) : controller_(map), labels_(map.positions) {
    const auto& codes = map.quantities.at("status").codes;
    moving_ = codes.at("moving");
    standing_ = codes.at("standing");
    fault_ = codes.at("fault");
  }

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
    const auto status = static_cast<int>(values->at("status"));
    if (status == fault_) return controller_.fail("the fixture reports a fault");
    if (status == moving_) return FixtureReading{true, std::nullopt};
    if (status != standing_) return controller_.fail(fmt::format("unknown status {}", status));
    return standing_at(static_cast<int>(values->at("position")));
  }

  std::string description() const override { return controller_.description(); }

 private:
  /// Position code 0 is between the positions.
  base::Result<FixtureReading> standing_at(int code) const {
    if (code == 0) return FixtureReading{};
    if (code < 0 || static_cast<std::size_t>(code) > labels_.size()) {
      return controller_.fail(fmt::format("unknown position {}", code));
    }
    return FixtureReading{false, labels_[static_cast<std::size_t>(code) - 1]};
  }

  Controller controller_;
  std::vector<std::string> labels_;
  int moving_ = 0;
  int standing_ = 0;
  int fault_ = 0;
};

}  // namespace

base::Result<std::unique_ptr<Fixture>> make_modbus_fixture(const RegisterMap& map) {
  if (auto status = require_kind(map, "fixture"); !status) return base::forward_error(status);
  if (auto status = require_writable(map, "request"); !status) return base::forward_error(status);
  if (auto status = require_quantity(map, "position"); !status) return base::forward_error(status);
  for (const char* code : {"standing", "moving", "fault"}) {
    if (auto status = require_code(map, "status", code); !status) return base::forward_error(status);
  }
  return std::make_unique<ModbusFixture>(map);
}

}  // namespace soak::hal
