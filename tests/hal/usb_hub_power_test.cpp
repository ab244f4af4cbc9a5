// SPDX-License-Identifier: Apache-2.0
// Ports of USB hubs before folders laid out as the kernel's (Documentation/ABI/testing/sysfs-bus-usb); tests/usb/kernel
// has the same with the kernel itself.
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

#include "hal/devices/unit_power.h"
#include "tests/errors.h"

namespace soak::hal {
namespace {

namespace fs = std::filesystem;

class UsbHubPowerTest : public testing::Test {
 protected:
  /// A port that is on.
  fs::path add_port(const std::string& interface, const std::string& name) {
    const fs::path port = devices_ / interface / name;
    fs::create_directories(port);
    std::ofstream(port / "disable") << "0\n";
    return port;
  }

  static char state(const fs::path& port) {
    std::ifstream file(port / "disable");
    return static_cast<char>(file.get());
  }

  std::unique_ptr<UnitPower> power() const { return make_usb_hub_power(hubs_, devices_); }

  static fs::path make_folder() {
    std::string name = (fs::temp_directory_path() / "soak-hubs-XXXXXX").string();
    EXPECT_NE(::mkdtemp(name.data()), nullptr);
    return name;
  }
  void TearDown() override { fs::remove_all(devices_); }

  fs::path devices_ = make_folder();
  UsbHubs hubs_ = {{"1-4", "usb3"}};
  fs::path first_ = add_port("1-4:1.0", "1-4-port2");
  fs::path second_ = add_port("3-0:1.0", "usb3-port1");
};

TEST_F(UsbHubPowerTest, AnOutputIsAPortAndTheNextHubBeginsAHundredHigher) {
  const auto ports = power();
  ASSERT_TRUE(ports->connect());
  ASSERT_TRUE(ports->set(2, false));
  EXPECT_EQ(state(first_), '1');
  EXPECT_EQ(state(second_), '0');
  ASSERT_TRUE(ports->set(101, false));
  EXPECT_EQ(state(second_), '1');
  ASSERT_TRUE(ports->set(2, true));
  const auto readings = ports->read({2, 101});
  ASSERT_TRUE(readings);
  EXPECT_TRUE(readings->at(2).on);
  EXPECT_FALSE(readings->at(101).on);
  EXPECT_FALSE(ports->measures(2));
}

TEST_F(UsbHubPowerTest, BothHalvesOfASocketOfUsb3AreSwitchedAndItIsOnWhileOneIs) {
  const auto half = add_port("2-4:1.0", "2-4-port2");
  fs::create_directory_symlink(half, first_ / "peer");
  const auto ports = power();
  ASSERT_TRUE(ports->set(2, false));
  EXPECT_EQ(state(first_), '1');
  EXPECT_EQ(state(half), '1');
  EXPECT_FALSE(ports->read({2})->at(2).on);
  std::ofstream(half / "disable") << "0\n";
  EXPECT_TRUE(ports->read({2})->at(2).on);
}

TEST_F(UsbHubPowerTest, WhatAHubCannotDoIsRefusedBeforeItIsAsked) {
  const auto ports = power();
  EXPECT_TRUE(ports->check(31, {}));
  for (const int output : {0, -1, 32, 100, 132, 201}) {
    const auto refused = ports->check(output, {});
    ASSERT_FALSE(refused) << output;
    EXPECT_EQ(refused.error().kind, base::ErrorKind::bad_input);
    EXPECT_TRUE(names(refused.error(), {"1 to 31"}));
  }
  const auto voltage = ports->check(2, {.voltage_v = 5.0});
  ASSERT_FALSE(voltage);
  EXPECT_EQ(voltage.error().kind, base::ErrorKind::bad_input);
}

TEST_F(UsbHubPowerTest, AHubOrPortThatIsNotThereIsAFaultOfTheDevice) {
  const auto no_port = power()->set(3, false);
  ASSERT_FALSE(no_port);
  EXPECT_EQ(no_port.error().kind, base::ErrorKind::device);
  EXPECT_EQ(no_port.error().where, "1-4");
  EXPECT_TRUE(names(no_port.error(), {"port 3"}));
  fs::remove_all(devices_ / "1-4:1.0");
  for (const auto& status : {power()->connect(), power()->set(2, true), may_switch(hubs_, 2, devices_)}) {
    ASSERT_FALSE(status);
    EXPECT_EQ(status.error().kind, base::ErrorKind::device);
    EXPECT_EQ(status.error().where, "1-4");
  }
  EXPECT_TRUE(may_switch(hubs_, 101, devices_));
}

TEST_F(UsbHubPowerTest, AnOlderKernelIsNamed) {
  fs::remove(first_ / "disable");
  const auto status = power()->set(2, false);
  ASSERT_FALSE(status);
  EXPECT_TRUE(names(status.error(), {"Linux 6.0"}));
}

TEST_F(UsbHubPowerTest, AMissingPermissionIsNamed) {
  if (::geteuid() != 0) GTEST_SKIP() << "skipped: only root can become somebody else";
  fs::permissions(devices_, fs::perms(0755));
  ASSERT_EQ(::seteuid(65534), 0);
  const auto status = power()->set(2, false);
  ASSERT_EQ(::seteuid(0), 0);
  EXPECT_TRUE(is_device_error(status, {"1-4", "docs/hardware.md"}));
  EXPECT_EQ(state(first_), '0');
}

}  // namespace
}  // namespace soak::hal
