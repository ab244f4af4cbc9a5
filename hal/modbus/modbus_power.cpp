// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "hal/devices.h"
#include "hal/modbus/controller.h"
#include "hal/modbus/map_check.h"

namespace soak::hal {
namespace {

std::string output_name(int output) { return fmt::format("output_{}", output); }
std::string state_name(int output) { return fmt::format("state_{}", output); }

class ModbusPower final : public UnitPower {
 public:
  explicit ModbusPower(const RegisterMap& map) : controller_(map) {}

  base::Status connect() override { return controller_.connect(); }

  base::Status set(int output, bool on) override {
    if (auto known = check(output); !known) return known;
    const double value = on ? 1.0 : 0.0;
    if (auto written = controller_.write(output_name(output), value); !written) return written;
    // The request says what the relay was told, its state what it did.
    return controller_.has(state_name(output)) ? controller_.expect(state_name(output), value) : base::Status{};
  }

  base::Result<bool> is_on(int output) override {
    if (auto known = check(output); !known) return base::forward_error(known);
    const auto value = controller_.read(controller_.has(state_name(output)) ? state_name(output) : output_name(output));
    if (!value) return base::forward_error(value);
    return *value != 0.0;
  }

  std::string description() const override { return controller_.description(); }

 private:
  base::Status check(int output) const {
    if (controller_.has(output_name(output))) return {};
    return base::bad_input(fmt::format("the relay has no output {}", output), description());
  }

  Controller controller_;
};

}  // namespace

base::Result<std::unique_ptr<UnitPower>> make_modbus_power(const RegisterMap& map) {
  if (auto status = require_kind(map, "power"); !status) return base::forward_error(status);
  if (auto status = require_writable(map, output_name(1)); !status) return base::forward_error(status);
  for (const auto& [name, quantity] : map.quantities) {
    if (!name.starts_with("output_")) continue;
    if (auto status = require_writable(map, name); !status) return base::forward_error(status);
  }
  return std::make_unique<ModbusPower>(map);
}

}  // namespace soak::hal
