// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <fstream>
#include <string>

#include "hal/maps/device_map.h"
#include "tests/errors.h"

/// What the tests of device maps share, whatever protocol a map is for.
namespace soak::hal::test {

/// "where: message" of the refusal, "" = accepted. A map that is wrong is bad input.
inline std::string refusal(const std::string& text) {
  const auto map = parse_device_map(text, "m.toml");
  if (map) return "";
  EXPECT_EQ(map.error().kind, base::ErrorKind::bad_input);
  return map.error().where + ": " + map.error().message;
}

/// What a map whose format is right lacks for making a device, "" = nothing.
inline std::string lacks_for_a_device(const std::string& text) {
  const auto map = parse_device_map(text, "m.toml", MapUse::device);
  return map ? "" : map.error().message;
}

/// Lines that make a mistake when they follow a map without one.
struct Mistake {
  const char* more;
  int line;           ///< that is blamed
  const char* named;  ///< in the refusal
};

inline ::testing::AssertionResult is_refused_with_its_line(const std::string& map, const Mistake& mistake) {
  return base::mentions(refusal(map + mistake.more), {fmt::format("m.toml:{}: ", mistake.line), mistake.named});
}

/// What the maps with every key say alike: names, the serial line, the limits of the set point, the policy of writing.
inline void expect_common_keys(const DeviceMap& map) {
  EXPECT_EQ(map.name, "full");
  EXPECT_EQ(map.kind, "chamber");
  EXPECT_EQ(map.file, "full.toml");
  const auto& line = std::get<SerialAddress>(map.link.address);
  EXPECT_EQ(line.device, "/dev/ttyUSB0");
  EXPECT_EQ(line.baud, 19200);
  EXPECT_EQ(map.quantities.at("set_point_c").min, -40.0);
  EXPECT_EQ(map.quantities.at("set_point_c").max, 150.0);
  EXPECT_FALSE(map.write_policy.only_on_change);
  EXPECT_FALSE(map.write_policy.read_back);
}

/// What holds of a map that says only what it must.
inline void expect_common_defaults(const DeviceMap& map) {
  EXPECT_EQ(std::get<TcpAddress>(map.link.address).host, "chamber.lab");
  EXPECT_EQ(map.link.poll_s, 1.0);
  EXPECT_TRUE(map.write_policy.only_on_change);
  EXPECT_TRUE(map.write_policy.read_back);
}

/// The map that a section of docs/register-maps.md shows: its indented lines.
inline std::string example_of(const std::string& heading) {
  std::ifstream page(SOAK_TEST_FOLDER "/../docs/register-maps.md");
  std::string example;
  bool inside = false;
  for (std::string line; std::getline(page, line);) {
    if (line.starts_with("## ")) inside = line == heading;
    if (inside && line.starts_with("    ")) example += line + "\n";
  }
  return example;
}

}  // namespace soak::hal::test
