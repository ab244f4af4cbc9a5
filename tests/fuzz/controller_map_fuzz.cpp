// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "hal/devices/detail/answer.h"
#include "hal/devices/detail/registers.h"
#include "hal/devices/devices.h"
#include "hal/maps/device_map.h"
#include "hal/maps/text_map.h"
#include "tests/fuzz/targets.h"

namespace soak::fuzz {
namespace {

constexpr int kLastRegister = 65535;

/// What a register holds must come back when its value is written.
void check_round_trip(const hal::Quantity& quantity) {
  constexpr std::array<std::uint16_t, 2> content = {0x1234, 0x4321};
  const auto words = std::span(content).first(static_cast<std::size_t>(hal::word_count(quantity.type)));
  const double value = hal::decode_value(quantity, words, 0);
  if (!std::isfinite(value)) return;
  const auto again = hal::encode_value(quantity, value, 0);
  if (!again) return;
  require(hal::same_value(quantity, words, *again) || quantity.type == hal::RegisterType::f32,
          "a value is written as it was read");
}

void check_quantity(const hal::Quantity& quantity) {
  const int last = quantity.address + hal::word_count(quantity.type) - 1;
  require(quantity.address >= 0 && last <= kLastRegister, "a quantity lies within the registers");
  require(std::isfinite(quantity.scale) && quantity.scale != 0.0, "a scale is a number");
  require(!quantity.command || quantity.write_function, "a command is written");
  check_round_trip(quantity);
}

template <class Map>
void check_actions(const Map& map) {
  for (const auto& [name, steps] : map.actions) {
    require(!steps.empty(), "an action has steps");
    for (const hal::ActionStep& step : steps) {
      require(map.quantities.contains(step.quantity), "a step writes a quantity of the map");
      require(std::isfinite(step.value) && step.delay_s >= 0.0 && step.delay_s <= 10.0,
              "a step has a value and a delay");
    }
  }
}

void check_axes(const hal::RegisterMap& map) {
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
  require(hal::make_modbus_fixture(map).has_value(), "a map with axes makes a fixture");
}

bool check_register_map(std::string_view text) {
  const auto map = hal::parse_register_map(text, "fuzz.toml");
  const auto device = hal::parse_register_map(text, "fuzz.toml", hal::MapUse::device);
  require(map || !device, "what a device needs refuses maps and allows none");
  if (!map) {
    require(!map.error().message.empty() && !map.error().where.empty(), "a refusal says what and where");
    return false;
  }
  for (const auto& [name, quantity] : map->quantities) check_quantity(quantity);
  check_actions(*map);
  check_axes(*map);
  require(map->link.max_block >= 2 && map->link.response_timeout_s > 0.0, "a link has its limits");
  for (const hal::AlarmRule& rule : map->alarms) {
    require(!rule.addresses.empty(), "an alarm has registers");
    (void)hal::says_alarm(rule, 0);
  }
  return true;
}

bool check_text_map(std::string_view text) {
  const auto map = hal::parse_text_map(text, "fuzz.toml");
  const auto device = hal::parse_text_map(text, "fuzz.toml", hal::MapUse::device);
  require(map || !device, "what a device needs refuses maps and allows none");
  if (!map) {
    require(!map.error().message.empty() && !map.error().where.empty(), "a refusal says what and where");
    return false;
  }
  const auto printable = [](std::string_view line) {
    return std::all_of(line.begin(), line.end(), [](char c) { return c >= ' ' && c <= '~'; });
  };
  for (const auto& [name, quantity] : map->quantities) {
    require(!quantity.from.ask.empty() && printable(quantity.from.ask), "a command is a line of text");
    if (quantity.write.empty()) continue;
    const auto spelt = hal::spell(quantity, 0.0);
    require(spelt && printable(hal::write_command(quantity, *spelt)), "what is written is a line of text");
  }
  check_actions(*map);
  require(!hal::is_refusal(*map, ""), "silence refuses nothing");
  return true;
}

}  // namespace

bool controller_map(Input input) {
  const bool is_register_map = check_register_map(as_text(input));
  const bool is_text_map = check_text_map(as_text(input));
  require(!(is_register_map && is_text_map), "a map is of one kind");
  return is_register_map || is_text_map;
}

}  // namespace soak::fuzz
