// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "hal/devices/detail/text_codec.h"
#include "hal/devices/fixture.h"
#include "hal/maps/detail/registers.h"
#include "hal/maps/device_map.h"
#include "tests/fuzz/targets.h"

namespace soak::fuzz {
namespace {

constexpr int kLastRegister = 65535;

/// What a register holds must come back when its value is written.
void check_round_trip(const hal::RegisterPlace& place) {
  constexpr std::array<std::uint16_t, 2> content = {0x1234, 0x4321};
  const auto words = std::span(content).first(static_cast<std::size_t>(hal::word_count(place.type)));
  const double value = hal::decode_value(place, words, 0);
  if (!std::isfinite(value)) return;
  const auto again = hal::encode_value(place, value, 0);
  if (!again) return;
  require(hal::same_value(place, words, *again) || place.type == hal::RegisterType::f32,
          "a value is written as it was read");
}

void check_registers(const hal::Quantity& quantity) {
  const hal::RegisterPlace& place = quantity.modbus;
  const int last = place.address + hal::word_count(place.type) - 1;
  require(place.address >= 0 && last <= kLastRegister, "a quantity lies within the registers");
  require(std::isfinite(place.scale) && place.scale != 0.0, "a scale is a number");
  require(!quantity.command || place.write_function, "a command is written");
  check_round_trip(place);
}

void check_commands(const hal::TextPlace& place) {
  const auto printable = [](std::string_view line) {
    return std::all_of(line.begin(), line.end(), [](char c) { return c >= ' ' && c <= '~'; });
  };
  require(!place.from.ask.empty() && printable(place.from.ask), "a command is a line of text");
  if (place.write.empty()) return;
  const auto spelt = hal::spell(place, 0.0);
  require(spelt && printable(hal::write_command(place, *spelt)), "what is written is a line of text");
}

void check_actions(const hal::DeviceMap& map) {
  for (const auto& [name, steps] : map.actions) {
    require(!steps.empty(), "an action has steps");
    for (const hal::ActionStep& step : steps) {
      require(map.quantities.contains(step.quantity), "a step writes a quantity of the map");
      require(std::isfinite(step.value) && step.delay_s >= 0.0 && step.delay_s <= 10.0,
              "a step has a value and a delay");
    }
  }
}

void check_axes(const hal::DeviceMap& map) {
  if (!map.axes) return;
  const std::size_t count = map.positions.size();
  require(count > 0 && map.azimuths_deg.size() == count && map.axes->angles_deg.size() == count &&
              map.axes->spin_sign.size() == count,
          "each position has its angles");
  for (const hal::AxisAngles& angles : map.axes->angles_deg) {
    const hal::Quantity& outer = map.quantities.at("outer_request");
    const hal::Quantity& inner = map.quantities.at("inner_request");
    require(angles.outer_deg >= *outer.min && angles.outer_deg <= *outer.max && angles.inner_deg >= *inner.min &&
                angles.inner_deg <= *inner.max,
            "the cables bear every position");
  }
  require(hal::make_fixture(map).has_value(), "a map with axes makes a fixture");
}

}  // namespace

bool controller_map(Input input) {
  const auto map = hal::parse_device_map(as_text(input), "fuzz.toml");
  const auto device = hal::parse_device_map(as_text(input), "fuzz.toml", hal::MapUse::device);
  require(map || !device, "what a device needs refuses maps and allows none");
  if (!map) {
    require(!map.error().message.empty() && !map.error().where.empty(), "a refusal says what and where");
    return false;
  }
  const bool modbus = map->protocol == hal::MapProtocol::modbus;
  for (const auto& [name, quantity] : map->quantities) {
    modbus ? check_registers(quantity) : check_commands(quantity.text);
  }
  check_actions(*map);
  check_axes(*map);
  require(map->link.max_block >= 2 && map->link.response_timeout_s > 0.0, "a link has its limits");
  for (const hal::AlarmRule& rule : map->alarms) {
    require(!modbus || !rule.modbus.addresses.empty(), "an alarm has registers");
    (void)hal::says_alarm(rule.modbus, 0);
  }
  require(!hal::begins_with_any("", map->refusals), "silence refuses nothing");
  return true;
}

}  // namespace soak::fuzz
