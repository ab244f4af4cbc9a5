// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/wires/detail/eurotherm_registers.h"

#include <cmath>
#include <cstdint>
#include <functional>
#include <utility>

namespace soak::hal::sim {
namespace {

constexpr int kProcessValue = 1;
constexpr int kTargetSetPoint = 2;
constexpr int kOutputPower = 3;
constexpr int kWorkingSetPoint = 5;
constexpr int kStatusWord = 75;
constexpr int kSetPointHigh = 111;
constexpr int kSetPointLow = 112;
constexpr int kInstrumentMode = 199;
constexpr int kAutoManual = 273;
constexpr int kDecimalPlaces = 525;

constexpr int kDecimals = 1;
constexpr double kIntegersPerUnit = 10.0;
constexpr int kNormal = 0;
constexpr int kStandby = 1;
constexpr int kAlarm1 = 1 << 0;
constexpr int kAlarm2 = 1 << 1;
/// What stands where nothing is.
constexpr std::uint16_t kUndefined = 0x5A5A;

constexpr int float_address(int parameter) { return 0x8000 + 2 * parameter; }

/// A value in both areas.
void add_parameter(RegisterTable& registers, int parameter, const std::function<double()>& read,
                   const RegisterTable::ValueWriter& write = {}) {
  registers.add_value(float_address(parameter), read, write, RegisterTable::FirstWord::high);
  RegisterTable::NumberWriter integer;
  if (write.takes) {
    const auto value_of = [](int number) { return static_cast<std::int16_t>(number) / kIntegersPerUnit; };
    integer = {[takes = write.takes, value_of](int number) { return takes(value_of(number)); },
               [store = write.store, value_of](int number) { store(value_of(number)); }};
  }
  registers.add_number(
      parameter, 1, [read] { return static_cast<int>(std::lround(read() * kIntegersPerUnit)); }, std::move(integer));
}

}  // namespace

RegisterTable eurotherm_registers(SimulatedChamber& chamber) {
  RegisterTable registers;
  SimulatedChamber* const it = &chamber;
  add_parameter(registers, kProcessValue, [it] { return it->process_value_c(); });
  add_parameter(
      registers, kTargetSetPoint, [it] { return it->controller().set_point_c(); },
      {[it](double value) { return it->takes_set_point(value); }, [it](double value) { it->set_set_point_c(value); }});
  add_parameter(registers, kOutputPower, [it] { return 100.0 * it->applied_output(); });
  add_parameter(registers, kWorkingSetPoint, [it] { return it->controller().working_set_point_c(); });
  add_parameter(registers, kSetPointHigh, [it] { return it->set_point_high_c(); });
  add_parameter(registers, kSetPointLow, [it] { return it->set_point_low_c(); });
  registers.add_number(kStatusWord, 1,
                       [it] { return (it->alarm_is_on() ? kAlarm1 : 0) | (it->limit_is_tripped() ? kAlarm2 : 0); });
  registers.add_number(kInstrumentMode, 1, [it] { return it->controller().is_on() ? kNormal : kStandby; },
                       {[](int mode) { return mode == kNormal || mode == kStandby; },
                        [it](int mode) { it->switch_control(mode == kNormal); }});
  registers.add_number(kAutoManual, 1, [] { return 0; }, {[](int mode) { return mode == 0; }, [](int) {}});
  registers.add_number(kDecimalPlaces, 1, [] { return kDecimals; });
  registers.pretend_everywhere(kUndefined);
  return registers;
}

}  // namespace soak::hal::sim
