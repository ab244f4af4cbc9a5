// SPDX-License-Identifier: Apache-2.0
// The driver against the real usbfs of a kernel, in a machine of its own (tools/prove/usb-qemu): there is a controller
// with a gadget (gadget_unit, an Xsens) and, behind a hub, an FT232 with a Crossbow at its end, which the kernel's own
// driver holds. No udev runs there.
#include <gtest/gtest.h>
#include <poll.h>

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <string>
#include <thread>
#include <vector>

#include "hal/devices/unit_power.h"
#include "hal/imu/imu.h"
#include "hal/links/addresses.h"
#include "hal/usb/usb_devices.h"

namespace soak::hal::usb {
namespace {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

const std::filesystem::path kController = "/sys/kernel/config/usb_gadget/unit/UDC";
const std::filesystem::path kSerialPort = "/dev/ttyUSB0";
constexpr auto kPatience = 60s;  // an emulated processor is slow

class RealUsb : public testing::Test {
 protected:
  void SetUp() override {
    if (std::getenv("SOAK_REAL_USB") == nullptr) GTEST_SKIP() << "skipped: ./run prove usb-qemu";
  }
};

bool wait_until(const std::function<bool()>& holds) {
  const auto give_up = Clock::now() + kPatience;
  while (!holds() && Clock::now() < give_up) std::this_thread::sleep_for(20ms);
  return holds();
}

void bind(const std::string& controller) { std::ofstream(kController) << controller << '\n'; }

base::Status follow(Imu& imu, std::vector<ImuSample>& samples, const std::function<bool()>& until) {
  const auto give_up = Clock::now() + kPatience;
  base::Status status;
  while (status && !until() && Clock::now() < give_up) {
    pollfd waiting{imu.wait_fd(), POLLIN, 0};
    ::poll(&waiting, 1, 20);
    status = imu.poll(samples);
  }
  return status;
}

constexpr UsbAddress kXsens{.vendor = 0x2639, .product = 0x0013};

/// As a station does: every so often, until the device is there again.
bool open_again(Imu& imu, const Imu::Settings& settings) {
  return wait_until([&] { return imu.open(settings).has_value(); });
}

TEST_F(RealUsb, DevicesAreListedWithSocketAndSerialNumber) {
  const auto unit = find_usb_device(kXsens);
  ASSERT_TRUE(unit) << unit.error().message;
  EXPECT_EQ(unit->serial, "0380ABCD");
  EXPECT_EQ(unit->name, "MTi-300");
  EXPECT_FALSE(unit->path.empty());
  EXPECT_TRUE(std::filesystem::exists(unit->node));
  const auto chip = find_usb_device({.vendor = 0x0403, .product = 0x6001});
  ASSERT_TRUE(chip) << chip.error().message;
  EXPECT_NE(chip->path, unit->path);
}

TEST_F(RealUsb, AnXsensStreams1000PacketsASecondWithoutALoss) {
  const auto imu = make_imu({.address = kXsens, .decoder = UnitDecoder::xsens});
  ASSERT_TRUE(imu->open({.rate_hz = 1000.0}));
  std::vector<ImuSample> samples;
  const auto status = follow(*imu, samples, [&] { return samples.size() >= 5000; });
  ASSERT_TRUE(status) << status.error().message;
  ASSERT_GE(samples.size(), 5000U);
  for (std::uint32_t i = 0; i < 5000; ++i) ASSERT_EQ(samples[i].packet, i);
  EXPECT_EQ(imu->identity()->serial, "0380ABCD");
  EXPECT_EQ(imu->statistics().lost_packets, 0U);
  EXPECT_EQ(imu->statistics().garbage_bytes, 0U);
}

TEST_F(RealUsb, AnXsensThatIsUnpluggedInMidStreamFailsAndComesBackAsANewPowerOn) {
  const auto imu = make_imu({.address = kXsens, .decoder = UnitDecoder::xsens});
  ASSERT_TRUE(open_again(*imu, {.rate_hz = 1000.0}));
  std::vector<ImuSample> samples;
  ASSERT_TRUE(follow(*imu, samples, [&] { return samples.size() >= 500; }));
  bind("");
  const auto ended = follow(*imu, samples, [] { return false; });
  ASSERT_FALSE(ended);
  EXPECT_EQ(ended.error().kind, base::ErrorKind::device);
  EXPECT_FALSE(imu->open({.rate_hz = 1000.0}));
  const std::size_t before = samples.size();
  bind("dummy_udc.0");
  ASSERT_TRUE(open_again(*imu, {.rate_hz = 1000.0}));
  ASSERT_TRUE(follow(*imu, samples, [&] { return samples.size() >= before + 500; }));
  ASSERT_GE(samples.size(), before + 500);
  EXPECT_EQ(samples[before - 1].power_on, 0U);
  EXPECT_EQ(samples.back().power_on, 1U);
  EXPECT_EQ(imu->statistics().restarts, 1U);
}

TEST_F(RealUsb, APortOfAHubTakesTheSupplyOfItsDeviceAwayAndGivesItBack) {
  const UsbAddress chip{.vendor = 0x0403, .product = 0x6001};
  const auto device = find_usb_device(chip);
  ASSERT_TRUE(device) << device.error().message;
  const auto dot = device->path.rfind('.');
  ASSERT_NE(dot, std::string::npos) << "not behind a hub: " << device->path;
  const UsbHubs hubs{{device->path.substr(0, dot)}};
  const int port = std::stoi(device->path.substr(dot + 1));
  const auto power = make_usb_hub_power(hubs);
  ASSERT_TRUE(power->connect());
  EXPECT_TRUE(may_switch(hubs, port));
  EXPECT_TRUE(power->read({port})->at(port).on);

  const auto off = power->set(port, false);
  ASSERT_TRUE(off) << off.error().message;
  EXPECT_FALSE(power->read({port})->at(port).on);
  EXPECT_TRUE(wait_until([&] { return !find_usb_device(chip); }));
  std::this_thread::sleep_for(2s);  // the kernel does not switch it on again by itself
  EXPECT_FALSE(find_usb_device(chip));
  EXPECT_TRUE(find_usb_device(kXsens)) << "nor does it take others with it";

  ASSERT_TRUE(power->set(port, true));
  EXPECT_TRUE(power->read({port})->at(port).on);
  EXPECT_TRUE(wait_until([&] { return find_usb_device(chip).has_value(); }));
  EXPECT_FALSE(power->set(31, false)) << "no such port";
}

TEST_F(RealUsb, AChipOfFtdiIsTakenFromTheKernelsDriverAndGivenBack) {
  ASSERT_TRUE(wait_until([] { return std::filesystem::exists(kSerialPort); })) << "ftdi_sio does not hold the chip";
  const auto imu = make_imu({.address = UsbAddress{.vendor = 0x0403, .product = 0x6001, .baud = 38400},
                             .decoder = UnitDecoder::ahrs400,
                             .ranges = {100.0, 2.0}});
  const auto opened = imu->open({.rate_hz = 60.0});
  ASSERT_TRUE(opened) << opened.error().message;
  EXPECT_FALSE(std::filesystem::exists(kSerialPort));
  std::vector<ImuSample> samples;
  const auto status = follow(*imu, samples, [&] { return samples.size() >= 150; });
  ASSERT_TRUE(status) << status.error().message;
  ASSERT_GE(samples.size(), 150U);
  EXPECT_EQ(imu->identity()->serial, "9911750");
  EXPECT_NEAR(samples[149].t_s - samples[0].t_s, 149 * 0.0155, 1e-3);
  EXPECT_NEAR(samples[100].accel_mps2[2], -9.80665, 1e-3);
  imu->close();
  EXPECT_TRUE(wait_until([] { return std::filesystem::exists(kSerialPort); }));
}

}  // namespace
}  // namespace soak::hal::usb
