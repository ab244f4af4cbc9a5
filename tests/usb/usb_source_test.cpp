// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>
#include <poll.h>

#include <array>
#include <chrono>
#include <functional>
#include <string>
#include <vector>

#include "hal/links/addresses.h"
#include "hal/links/detail/byte_source.h"
#include "hal/usb/usb_devices.h"
#include "tests/hal/xsens_peer.h"
#include "tests/usb/fake_bus.h"

namespace soak::hal::usb::test {
namespace {

using namespace std::chrono_literals;
using imu::test::Bytes;
using imu::test::hex;
using imu::test::text;

constexpr UsbAddress kXsens{.vendor = 0x2639, .product = 0x0013};
constexpr auto kPatience = 20s;

/// Reads until `enough` or an error.
base::Status read_until(imu::ByteSource& source, Bytes& bytes, const std::function<bool()>& enough) {
  std::array<std::uint8_t, 4096> buffer;
  const auto end = std::chrono::steady_clock::now() + kPatience;
  while (!enough() && std::chrono::steady_clock::now() < end) {
    pollfd waiting{source.fd(), POLLIN, 0};
    ::poll(&waiting, 1, 100);
    const auto got = source.read(buffer);
    if (!got) return base::forward_error(got);
    bytes.insert(bytes.end(), buffer.begin(), buffer.begin() + static_cast<long>(*got));
  }
  return {};
}

class UsbSourceTest : public ::testing::Test {
 protected:
  FakeBus bus;
};

TEST_F(UsbSourceTest, DevicesAreListedWithPathAndSerial) {
  EXPECT_TRUE(usb_devices().empty());
  const Plugged one(bus, "1-4.2", "xsens 77 100");
  const Plugged two(bus, "1-1", "ft232 88 64");
  const auto devices = usb_devices();
  ASSERT_EQ(devices.size(), 2U);
  EXPECT_EQ(devices[0].path, "1-1");
  EXPECT_EQ(devices[0].vendor, 0x0403);
  EXPECT_EQ(devices[0].serial, "88");
  EXPECT_EQ(devices[1].path, "1-4.2");
  EXPECT_EQ(devices[1].product, 0x0013);
  EXPECT_EQ(devices[1].name, "Fake xsens");
}

TEST_F(UsbSourceTest, ADeviceIsFoundBySerialOrPathAndAmbiguityIsAnError) {
  const Plugged one(bus, "1-1", "xsens 1 100");
  const Plugged two(bus, "1-2", "xsens 2 100");
  EXPECT_EQ(find_usb_device({.vendor = 0x2639, .product = 0x0013, .serial = "2"})->path, "1-2");
  EXPECT_EQ(find_usb_device({.vendor = 0x2639, .product = 0x0013, .path = "1-1"})->serial, "1");
  const auto ambiguous = find_usb_device(kXsens);
  ASSERT_FALSE(ambiguous);
  EXPECT_NE(ambiguous.error().message.find("usb_serial"), std::string::npos);
  const auto missing = find_usb_device({.vendor = 0x2639, .product = 0x0013, .serial = "3"});
  ASSERT_FALSE(missing);
  EXPECT_EQ(missing.error().kind, base::ErrorKind::device);
  EXPECT_EQ(missing.error().where, "usb 2639:0013 3");
}

TEST_F(UsbSourceTest, TakesTheDeviceFromTheKernelAndGivesItBack) {
  const Plugged device(bus, "1-1", "xsens 1 100");
  const auto source = imu::make_usb_source(kXsens);
  EXPECT_EQ(source->fd(), -1);
  const auto opened = source->open();
  ASSERT_TRUE(opened) << opened.error().message;
  EXPECT_EQ(device.report("driver"), "none");
  EXPECT_EQ(device.report("claimed"), "1");
  source->close();
  EXPECT_EQ(device.report("driver"), "kernel");
  EXPECT_EQ(device.report("claimed"), "-1");
}

TEST_F(UsbSourceTest, KeepsEightTransfersWaitingAndCarriesBytesBothWays) {
  const Plugged device(bus, "1-1", "xsens 3634 100");
  const auto source = imu::make_usb_source(kXsens);
  ASSERT_TRUE(source->open());
  Bytes bytes;
  device.tell("say", "DE AD BE EF");
  ASSERT_TRUE(read_until(*source, bytes, [&] { return bytes.size() >= 4; }));
  EXPECT_EQ(bytes, hex("DE AD BE EF"));
  EXPECT_EQ(device.report("most_waiting"), "8");
  bytes.clear();
  ASSERT_EQ(source->write(imu::test::frame(0x00)).value(), 5U);
  ASSERT_TRUE(read_until(*source, bytes, [&] { return bytes.size() >= 9; }));
  EXPECT_EQ(bytes, imu::test::frame(0x01, imu::test::u32(3634)));
}

TEST_F(UsbSourceTest, OpeningDropsWhatTheDeviceStillHasFromBefore) {
  const Plugged device(bus, "1-1", "xsens 1 100");
  device.tell("say", "01 02 03");
  const auto source = imu::make_usb_source(kXsens);
  ASSERT_TRUE(source->open());
  device.tell("say", "04");
  Bytes bytes;
  ASSERT_TRUE(read_until(*source, bytes, [&] { return !bytes.empty(); }));
  EXPECT_EQ(bytes, hex("04"));
}

TEST_F(UsbSourceTest, AnUnpluggedDeviceIsAnErrorAfterItsLastBytesAndOpensAgainWhenItIsBack) {
  for (const char* how : {"unplug", "vanish"}) {
    const auto source = imu::make_usb_source(kXsens);
    {
      Plugged device(bus, "1-1", "xsens 1 100");
      ASSERT_TRUE(source->open());
      device.tell("say", "01 02");
      Bytes bytes;
      ASSERT_TRUE(read_until(*source, bytes, [&] { return bytes.size() == 2; }));
      device.unplug(how);
      const auto ended = read_until(*source, bytes, [] { return false; });
      ASSERT_FALSE(ended) << how;
      EXPECT_EQ(ended.error().kind, base::ErrorKind::device);
      EXPECT_EQ(ended.error().where, "usb 2639:0013");
      EXPECT_FALSE(source->write(text("x")));
      source->close();
      const auto gone = source->open();
      ASSERT_FALSE(gone);
      EXPECT_EQ(gone.error().kind, base::ErrorKind::device);
    }
    const Plugged again(bus, "1-1", "xsens 1 100");
    ASSERT_TRUE(source->open()) << how;
    again.tell("say", "03");
    Bytes bytes;
    ASSERT_TRUE(read_until(*source, bytes, [&] { return !bytes.empty(); }));
    EXPECT_EQ(bytes, hex("03"));
  }
}

TEST_F(UsbSourceTest, AWordOfUdevIsEnoughWhereTransfersDoNotTell) {
  const Plugged device(bus, "1-1", "xsens 1 100");
  const auto source = imu::make_usb_source(kXsens);
  ASSERT_TRUE(source->open());
  device.tell("announce", "");
  Bytes bytes;
  const auto ended = read_until(*source, bytes, [] { return false; });
  ASSERT_FALSE(ended);
  EXPECT_EQ(ended.error().kind, base::ErrorKind::device);
}

TEST_F(UsbSourceTest, TwoErrorsPassThreeInARowAreAnUnplugging) {
  const Plugged device(bus, "1-1", "xsens 1 100");
  const auto source = imu::make_usb_source(kXsens);
  ASSERT_TRUE(source->open());
  constexpr const char* kProtocolError = "-71";
  Bytes bytes;
  device.tell("fail", std::string("2 ") + kProtocolError);
  device.tell("say", "01");
  ASSERT_TRUE(read_until(*source, bytes, [&] { return !bytes.empty(); }));
  device.tell("fail", std::string("3 ") + kProtocolError);
  const auto ended = read_until(*source, bytes, [] { return false; });
  ASSERT_FALSE(ended);
  EXPECT_EQ(ended.error().kind, base::ErrorKind::device);
}

TEST_F(UsbSourceTest, StatusCodesOfTransfersBecomeErrorsThatSayWhatHappened) {
  std::vector<std::string> messages;
  for (const char* status : {"-19", "-108", "-32"}) {  // no device, shut down: unplugged; broken pipe: stalled
    const Plugged device(bus, "1-1", "xsens 1 100");
    const auto source = imu::make_usb_source(kXsens);
    ASSERT_TRUE(source->open());
    device.tell("fail", std::string("1 ") + status);
    Bytes bytes;
    const auto ended = read_until(*source, bytes, [] { return false; });
    ASSERT_FALSE(ended) << status;
    EXPECT_EQ(ended.error().kind, base::ErrorKind::device) << status;
    messages.push_back(ended.error().message);
  }
  EXPECT_EQ(messages[0], messages[1]);
  EXPECT_NE(messages[0], messages[2]);
}

TEST_F(UsbSourceTest, AStalledEndpointIsClearedWhenTheDeviceIsOpenedAgain) {
  const Plugged device(bus, "1-1", "xsens 1 100");
  const auto source = imu::make_usb_source(kXsens);
  ASSERT_TRUE(source->open());
  EXPECT_EQ(device.report("halts_cleared"), "0");
  device.tell("fail", "1 -32");
  Bytes bytes;
  ASSERT_FALSE(read_until(*source, bytes, [] { return false; }));
  source->close();
  ASSERT_TRUE(source->open());
  EXPECT_EQ(device.report("halts_cleared"), "2");
}

TEST_F(UsbSourceTest, TransfersThatDoNotComeBackDoNotHoldUpTheStation) {
  const Plugged device(bus, "1-1", "xsens 1 100");
  const auto source = imu::make_usb_source(kXsens);
  ASSERT_TRUE(source->open());
  device.tell("ignore_cancels", "1");
  source->close();
  EXPECT_EQ(source->fd(), -1);
  EXPECT_EQ(device.report("claimed"), "1") << "what is under way cannot be closed";
  device.tell("ignore_cancels", "0");
  const auto end = std::chrono::steady_clock::now() + kPatience;
  while (device.report("claimed") != "-1" && std::chrono::steady_clock::now() < end) ::poll(nullptr, 0, 20);
  EXPECT_EQ(device.report("claimed"), "-1");
}

TEST_F(UsbSourceTest, AChipOfFtdiIsSetUpAsASerialLine) {
  const Plugged device(bus, "1-1", "ft232 9911750 64");
  const auto source = imu::make_usb_source({.vendor = 0x0403, .product = 0x6001, .baud = 38400});
  ASSERT_TRUE(source->open());
  EXPECT_EQ(device.report("controls"),
            "40:00:0000:0000,40:00:0002:0000,40:00:0001:0000,40:04:0008:0000,40:02:0000:0000,40:09:0008:0000,"
            "40:01:0101:0000,40:01:0202:0000,40:03:c04e:0000,");
}

TEST_F(UsbSourceTest, TheStatusOfEveryPacketIsTakenOutAndAnIdleLineSaysNothing) {
  for (const char* packet_size : {"64", "512"}) {
    const Plugged device(bus, "1-1", std::string("ft232 1 ") + packet_size);
    const auto source = imu::make_usb_source({.vendor = 0x0403, .product = 0x6001, .baud = 38400});
    ASSERT_TRUE(source->open());
    Bytes sent;
    std::string digits;
    for (int i = 0; i < 700; ++i) {
      constexpr const char* kDigits = "0123456789ABCDEF";
      sent.push_back(static_cast<std::uint8_t>(i));
      digits += std::string(1, kDigits[i / 16 % 16]) + kDigits[i % 16] + " ";
    }
    ::poll(nullptr, 0, 50);
    device.tell("say", digits);
    Bytes bytes;
    ASSERT_TRUE(read_until(*source, bytes, [&] { return bytes.size() >= sent.size(); }));
    EXPECT_EQ(bytes, sent) << packet_size;
  }
}

TEST_F(UsbSourceTest, ABaudRateThatTheChipDoesNotHaveIsBadInput) {
  const Plugged device(bus, "1-1", "ft232 1 64");
  const auto opened = imu::make_usb_source({.vendor = 0x0403, .product = 0x6001, .baud = 4'000'000})->open();
  ASSERT_FALSE(opened);
  EXPECT_EQ(opened.error().kind, base::ErrorKind::bad_input);
}

}  // namespace
}  // namespace soak::hal::usb::test
