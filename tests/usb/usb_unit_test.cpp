// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>
#include <poll.h>

#include <chrono>
#include <functional>
#include <string>
#include <vector>

#include "hal/imu/imu.h"
#include "hal/links/addresses.h"
#include "tests/usb/fake_bus.h"

namespace soak::hal::usb::test {
namespace {

using namespace std::chrono_literals;

/// Polls as a station does until `until` holds or the driver fails.
base::Status follow(Imu& imu, std::vector<ImuSample>& samples, const std::function<bool()>& until) {
  const auto give_up = std::chrono::steady_clock::now() + 30s;
  base::Status status;
  while (status && !until() && std::chrono::steady_clock::now() < give_up) {
    pollfd waiting{imu.wait_fd(), POLLIN, 0};
    ::poll(&waiting, 1, 20);
    status = imu.poll(samples);
  }
  return status;
}

std::unique_ptr<Imu> xsens() {
  return make_imu({.address = UsbAddress{.vendor = 0x2639, .product = 0x0013}, .decoder = UnitDecoder::xsens});
}

TEST(UnitOverUsb, AnXsensStreams1000PacketsASecondWithoutALoss) {
  const FakeBus bus;
  const Plugged device(bus, "1-1", "xsens 58764237 1000");
  const auto imu = xsens();
  ASSERT_TRUE(imu->open({.rate_hz = 1000.0}));
  std::vector<ImuSample> samples;
  ASSERT_TRUE(follow(*imu, samples, [&] { return samples.size() >= 3000; }));
  ASSERT_GE(samples.size(), 3000U);
  for (std::uint32_t i = 0; i < 3000; ++i) ASSERT_EQ(samples[i].packet, i);
  EXPECT_NEAR(samples[2999].t_s, 2.999, 1e-9);
  EXPECT_EQ(imu->identity()->serial, "0380ABCD");
  EXPECT_EQ(imu->statistics().lost_packets, 0U);
  EXPECT_EQ(imu->statistics().garbage_bytes, 0U);
}

TEST(UnitOverUsb, AnXsensThatIsUnpluggedInMidRunFailsAndComesBackAsANewPowerOn) {
  for (const char* how : {"unplug", "vanish"}) {
    const FakeBus bus;
    const auto imu = xsens();
    std::vector<ImuSample> samples;
    {
      Plugged device(bus, "1-1", "xsens 58764237 100");
      ASSERT_TRUE(imu->open({.rate_hz = 100.0}));
      ASSERT_TRUE(follow(*imu, samples, [&] { return samples.size() >= 50; }));
      device.unplug(how);
      const auto ended = follow(*imu, samples, [] { return false; });
      ASSERT_FALSE(ended);
      EXPECT_EQ(ended.error().kind, base::ErrorKind::device);
      EXPECT_EQ(imu->state(), ImuState::failed);
      EXPECT_FALSE(imu->open({.rate_hz = 100.0}));
    }
    const std::size_t before = samples.size();
    const Plugged device(bus, "1-1", "xsens 58764237 100");
    ASSERT_TRUE(imu->open({.rate_hz = 100.0})) << how;
    ASSERT_TRUE(follow(*imu, samples, [&] { return samples.size() >= before + 50; }));
    EXPECT_EQ(samples[before - 1].power_on, 0U);
    EXPECT_EQ(samples.back().power_on, 1U);
    EXPECT_EQ(imu->statistics().restarts, 1U);
  }
}

TEST(UnitOverUsb, AnAhrs400BehindAChipOfFtdiIsIdentifiedAndStreams) {
  const FakeBus bus;
  const Plugged device(bus, "1-2", "ft232 9911750 64");
  const auto imu = make_imu({.address = UsbAddress{.vendor = 0x0403, .product = 0x6001, .path = "1-2", .baud = 38400},
                             .decoder = UnitDecoder::ahrs400,
                             .ranges = {100.0, 2.0}});
  ASSERT_TRUE(imu->open({.rate_hz = 60.0}));
  std::vector<ImuSample> samples;
  ASSERT_TRUE(follow(*imu, samples, [&] { return samples.size() >= 150; }));
  ASSERT_GE(samples.size(), 150U);
  EXPECT_EQ(imu->identity()->serial, "9911750");
  EXPECT_NEAR(samples[149].t_s - samples[0].t_s, 149 * 0.0155, 1e-3);
  EXPECT_NEAR(samples[100].accel_mps2[2], -9.80665, 1e-3);
  EXPECT_EQ(imu->statistics().lost_packets, 0U);
  EXPECT_EQ(imu->statistics().garbage_bytes, 0U);
}

TEST(UnitOverUsb, TwoUnitsShareTheEventThread) {
  const FakeBus bus;
  const Plugged one(bus, "1-1", "xsens 1 100");
  const Plugged two(bus, "1-2", "xsens 2 100");
  std::vector<std::unique_ptr<Imu>> units;
  for (const char* path : {"1-1", "1-2"}) {
    units.push_back(make_imu({.address = UsbAddress{.vendor = 0x2639, .product = 0x0013, .path = path}}));
    ASSERT_TRUE(units.back()->open({.rate_hz = 100.0}));
  }
  std::vector<std::vector<ImuSample>> samples(2);
  const auto give_up = std::chrono::steady_clock::now() + 30s;
  while ((samples[0].size() < 100 || samples[1].size() < 100) && std::chrono::steady_clock::now() < give_up) {
    for (std::size_t i = 0; i < 2; ++i)
      ASSERT_TRUE(follow(*units[i], samples[i], [n = 0]() mutable { return n++ > 0; }));
  }
  EXPECT_EQ(units[0]->identity()->serial, "00000001");
  EXPECT_EQ(units[1]->identity()->serial, "00000002");
  for (const auto& unit : units) EXPECT_EQ(unit->statistics().lost_packets, 0U);
}

}  // namespace
}  // namespace soak::hal::usb::test
