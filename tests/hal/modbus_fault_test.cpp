// SPDX-License-Identifier: Apache-2.0
// What a bad line does to the driver. Whatever happens to an answer: a value is right or there is an error, never the
// value of another register, and the link comes back by itself. The server is pymodbus, the proxy spoils its answers.
#include <fcntl.h>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <memory>
#include <thread>

#include "hal/devices/detail/controller.h"
#include "hal/links/detail/modbus_link.h"
#include "modbus_fault_proxy.h"
#include "modbus_peer.h"
#include "tests/errors.h"

namespace soak::hal {
namespace {

using test::Fault;
using test::FaultProxy;
using Clock = std::chrono::steady_clock;

// Every quantity has its own value and most answers have one length: a mix-up would show.
const char* const kMap = R"(
name = "rig"
kind = "chamber"
[link]
tcp = "127.0.0.1:502"
response_timeout_s = 0.3
max_block = 2
[quantity]
air_c = { address = 10, type = "f32" }
output_percent = { address = 20, type = "f32" }
actual_mode = { address = 30, type = "u16" }
control_mode = { address = 40, type = "u16", write_function = 6 }
[[probe]]
name = "identification"
address = 50
expected = [4711]
otherwise = "this is another controller"
)";

const std::vector<std::string> kRegisters = {"f32lo:10:11.5", "f32lo:20:-22.5", "u16:30:333",
                                             "u16:40:444",    "u16:50:4711",    "stuck:30:0"};
const Values kTruth = {{"air_c", 11.5}, {"output_percent", -22.5}, {"actual_mode", 333.0}, {"control_mode", 444.0}};

DeviceMap rig_map(int port) {
  DeviceMap map = test::parsed_map(kMap);
  map.link.address = TcpAddress{"127.0.0.1", port};
  return map;
}

base::Result<double> read_one(Controller& controller, const std::string& name) {
  return controller.read_all({name}).map([&](const Values& values) { return values.at(name); });
}

/// Reads until all values came, for 20 s at most. Each value on the way must be right.
void expect_recovery(Controller& controller) {
  const auto deadline = Clock::now() + std::chrono::seconds(20);
  for (std::size_t good = 0; good < kTruth.size();) {
    ASSERT_LT(Clock::now(), deadline) << "the link did not come back";
    good = 0;
    for (const auto& [name, truth] : kTruth) {
      const auto value = read_one(controller, name);
      if (!value) break;
      ASSERT_EQ(*value, truth) << name;
      ++good;
    }
    if (good < kTruth.size()) std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
}

/// Spoils one answer after the other: that of the probe, of a, of b...
void expect_truth_or_error(Controller& controller, FaultProxy& proxy, Fault fault) {
  for (int after = 0; after < 4; ++after) {
    SCOPED_TRACE(fmt::format("after {} good answers", after));
    proxy.spoil(fault, after);
    expect_recovery(controller);
    if (::testing::Test::HasFatalFailure()) return;
  }
}

class ModbusFaultTest : public ::testing::TestWithParam<Fault> {};

TEST_P(ModbusFaultTest, GivesTheTruthOrAnErrorAndRecovers) {
  SOAK_START_PYMODBUS(server, "tcp", kRegisters);
  FaultProxy proxy(server->port(), FaultProxy::Framing::tcp, 600);
  Controller controller(rig_map(proxy.port()));
  expect_recovery(controller);
  expect_truth_or_error(controller, proxy, GetParam());
}

INSTANTIATE_TEST_SUITE_P(Kinds, ModbusFaultTest,
                         ::testing::Values(Fault::late, Fault::exception, Fault::busy, Fault::wrong_unit,
                                           Fault::wrong_function, Fault::truncated, Fault::garbage, Fault::byte_by_byte,
                                           Fault::reset, Fault::silence, Fault::stale, Fault::twice));

TEST(ModbusFault, ReadsAnAnswerThatComesByteByByte) {
  SOAK_START_PYMODBUS(server, "tcp", kRegisters);
  FaultProxy proxy(server->port(), FaultProxy::Framing::tcp, 600);
  Controller controller(rig_map(proxy.port()));
  proxy.spoil(Fault::byte_by_byte, 0, 5);
  for (const auto& [name, truth] : kTruth) {
    const auto value = read_one(controller, name);
    ASSERT_TRUE(value) << value.error().message;
    EXPECT_EQ(*value, truth);
  }
}

TEST(ModbusFault, AsksABusyControllerAgain) {
  SOAK_START_PYMODBUS(server, "tcp", kRegisters);
  FaultProxy proxy(server->port(), FaultProxy::Framing::tcp, 600);
  Controller controller(rig_map(proxy.port()));
  ASSERT_TRUE(controller.connect());
  proxy.spoil(Fault::busy, 0, 3);
  EXPECT_EQ(read_one(controller, "air_c").value_or(0.0), 11.5);
  proxy.spoil(Fault::busy, 0, 4);
  const auto value = read_one(controller, "air_c");
  ASSERT_FALSE(value);
  EXPECT_TRUE(names(value.error(), {"air_c (registers 10 to 11)"}));
  EXPECT_EQ(read_one(controller, "air_c").value_or(0.0), 11.5) << "the link is sound, there is no pause";
}

TEST(ModbusFault, AsksAgainAfterAnAcknowledge) {
  SOAK_START_PYMODBUS(server, "tcp", kRegisters);
  FaultProxy proxy(server->port(), FaultProxy::Framing::tcp, 600);
  Controller controller(rig_map(proxy.port()));
  ASSERT_TRUE(controller.connect());
  proxy.spoil(Fault::acknowledge, 0, 3);
  EXPECT_EQ(read_one(controller, "air_c").value_or(0.0), 11.5);
}

// libmodbus' own recovery would connect again within the call, and for ever if nobody listens.
TEST(ModbusFault, DoesNotReconnectWithinACall) {
  SOAK_START_PYMODBUS(server, "tcp", kRegisters);
  FaultProxy proxy(server->port(), FaultProxy::Framing::tcp, 600);
  Controller controller(rig_map(proxy.port()));
  ASSERT_TRUE(controller.connect());
  for (const Fault fault : {Fault::reset, Fault::silence, Fault::truncated}) {
    const int before = proxy.connections();
    proxy.spoil(fault);
    EXPECT_FALSE(read_one(controller, "air_c"));
    EXPECT_FALSE(read_one(controller, "air_c")) << "in the pause";
    EXPECT_EQ(proxy.connections(), before);
    expect_recovery(controller);
    EXPECT_EQ(proxy.connections(), before + 1);
  }
}

TEST(ModbusFault, AsksAgainOverTheSameConnectionAfterASpoiltAnswer) {
  SOAK_START_PYMODBUS(server, "tcp", kRegisters);
  FaultProxy proxy(server->port(), FaultProxy::Framing::tcp, 600);
  Controller controller(rig_map(proxy.port()));
  ASSERT_TRUE(controller.connect());
  const int before = proxy.connections();
  for (const Fault fault : {Fault::garbage, Fault::exception}) {
    proxy.spoil(fault, 0, 2);
    EXPECT_EQ(read_one(controller, "air_c").value_or(0.0), 11.5);
  }
  EXPECT_EQ(proxy.connections(), before);
  proxy.spoil(Fault::garbage, 0, 3);
  EXPECT_FALSE(read_one(controller, "air_c")) << "three spoilt answers are a broken link";
  expect_recovery(controller);
}

TEST(ModbusLink, BelongsToTheThreadThatOpensIt) {
  SOAK_START_PYMODBUS(server, "tcp", kRegisters);
  ModbusLink link(rig_map(server->port()).link);
  ASSERT_TRUE(link.open());
  std::array<std::uint16_t, 1> words{};
  bool refused = false;
  std::thread([&] { refused = !link.read(3, 30, words); }).join();
  EXPECT_TRUE(refused);
  ASSERT_TRUE(link.read(3, 30, words)) << "its owner goes on";
  EXPECT_EQ(words[0], 333);
}

TEST(ModbusFault, FailsAtOnceUntilTheNextTry) {
  SOAK_START_PYMODBUS(server, "tcp", kRegisters);
  FaultProxy proxy(server->port(), FaultProxy::Framing::tcp, 600);
  Controller controller(rig_map(proxy.port()));
  ASSERT_TRUE(controller.connect());
  proxy.spoil(Fault::silence);
  const auto lost = read_one(controller, "air_c");
  ASSERT_FALSE(lost);
  EXPECT_EQ(lost.error().kind, base::ErrorKind::device);
  EXPECT_TRUE(names(lost.error(), {"air_c (registers 10 to 11)"}));
  EXPECT_EQ(lost.error().where, fmt::format("rig at 127.0.0.1:{}", proxy.port()));
  const auto refused = read_one(controller, "air_c");
  EXPECT_TRUE(is_device_error(refused));
}

TEST(ModbusFault, ProvesTheControllerAnewAfterReconnecting) {
  SOAK_START_PYMODBUS(server, "tcp", kRegisters);
  FaultProxy proxy(server->port(), FaultProxy::Framing::tcp, 600);
  Controller controller(rig_map(proxy.port()));
  ASSERT_TRUE(controller.connect());
  ASSERT_TRUE(test::mbpoll_write(server->port(), 50, "4", "4712"));
  EXPECT_EQ(read_one(controller, "air_c").value_or(0.0), 11.5);
  proxy.spoil(Fault::reset);
  EXPECT_FALSE(read_one(controller, "air_c"));
  const auto deadline = Clock::now() + std::chrono::seconds(20);
  std::string message;
  while (Clock::now() < deadline && message.find("4712") == std::string::npos) {
    const auto value = read_one(controller, "air_c");
    ASSERT_FALSE(value);
    message = value.error().message;
  }
  EXPECT_TRUE(base::mentions(message, {"identification (register 50)", "4712", "4711"}));
}

TEST(ModbusFault, WritesAgainAfterReconnectingToAControllerThatForgot) {
  SOAK_START_PYMODBUS(server, "tcp", kRegisters);
  FaultProxy proxy(server->port(), FaultProxy::Framing::tcp, 600);
  Controller controller(rig_map(proxy.port()));
  ASSERT_TRUE(controller.write("control_mode", 500.0));
  proxy.spoil(Fault::reset);
  EXPECT_FALSE(read_one(controller, "air_c"));
  ASSERT_TRUE(test::mbpoll_write(server->port(), 40, "4", "444"));
  expect_recovery(controller);
  ASSERT_TRUE(controller.write("control_mode", 500.0));
  EXPECT_EQ(test::mbpoll_read(server->port(), 40, "4"), "500");
}

TEST(ModbusFault, ComesBackAfterThePeerHasRestarted) {
  auto peer = test::PymodbusServer::start("tcp", kRegisters);
  if (!peer) GTEST_SKIP() << "skipped: python3-pymodbus is not installed";
  const int port = peer->port();
  Controller controller(rig_map(port));
  expect_recovery(controller);
  peer.reset();
  const auto lost = read_one(controller, "air_c");
  ASSERT_FALSE(lost);
  EXPECT_EQ(lost.error().kind, base::ErrorKind::device);
  peer = test::PymodbusServer::start("tcp", kRegisters, port);
  expect_recovery(controller);
}

TEST(ModbusFault, EndsACallWhoseAnswersAllComeLateButInTime) {
  std::vector<std::string> registers = kRegisters;
  DeviceMap map = test::parsed_map(kMap);
  AlarmRule alarm;
  alarm.name = "spread";
  alarm.modbus.inactive = {0};
  for (int address = 100; address < 400; address += 10) {
    alarm.modbus.addresses.push_back(address);
    registers.push_back(fmt::format("u16:{}:0", address));
  }
  map.alarms = {alarm};
  map.link.response_timeout_s = 0.5;
  SOAK_START_PYMODBUS(server, "tcp", registers);
  FaultProxy proxy(server->port(), FaultProxy::Framing::tcp, 300);
  map.link.address = TcpAddress{"127.0.0.1", proxy.port()};
  Controller controller(map);
  ASSERT_TRUE(controller.connect());
  proxy.spoil(Fault::late, 0, 1000);  // thirty answers would take 9 s
  const auto active = controller.active_alarms();
  ASSERT_FALSE(active);
  EXPECT_EQ(active.error().kind, base::ErrorKind::device);
  proxy.spoil(Fault::none);
  expect_recovery(controller);
}

TEST(ModbusFault, AsksOnlyTheProbesOfItsLink) {
  SOAK_START_PYMODBUS(server, "tcp", kRegisters);
  DeviceMap map = rig_map(server->port());
  map.probes.push_back({.name = "units",
                        .otherwise = "no",
                        .link = LinkKind::serial,
                        .modbus = {.address = 40, .type = RegisterType::u16, .expected = {1}}});
  EXPECT_TRUE(Controller(map).connect());
  map.probes.back().link = LinkKind::tcp;
  EXPECT_FALSE(Controller(map).connect());
}

TEST(ModbusLink, PausesBeforeARequestOnASerialLineUnlessTheMapSaysOtherwise) {
  LinkSettings settings;
  settings.address = TcpAddress{"127.0.0.1", 502};
  EXPECT_EQ(request_gap_s(settings), 0.0);
  settings.address = SerialAddress{.device = "/dev/ttyS0"};
  EXPECT_EQ(request_gap_s(settings), 0.03);
  settings.gap_s = 0.1;
  EXPECT_EQ(request_gap_s(settings), 0.1);
  settings.address = TcpAddress{"127.0.0.1", 502};
  EXPECT_EQ(request_gap_s(settings), 0.1);
}

TEST(ModbusLink, SaysThatAHostIsNotKnown) {
  ModbusLink link({.address = TcpAddress{"no-such-host.invalid", 502}});
  const LinkResult opened = link.open();
  ASSERT_FALSE(opened);
  EXPECT_TRUE(base::mentions(opened.error().text, {"no-such-host.invalid"}));
}

TEST(ModbusFault, ReadsBlocksWithoutHolesWhereTheControllerRefusesThem) {
  SOAK_START_PYMODBUS(server, "tcp", kRegisters);
  DeviceMap map = rig_map(server->port());
  map.link.max_block = 60;  // one block over registers that the server does not have
  Controller controller(map);
  const auto values = controller.read_all({"air_c", "output_percent", "actual_mode", "control_mode"});
  ASSERT_TRUE(values) << values.error().message;
  EXPECT_EQ(*values, kTruth);
}

TEST(ModbusLink, LengthensItsPauses) {
  ModbusLink link({.address = TcpAddress{"127.0.0.1", 1}, .response_timeout_s = 0.3});
  for (const double expected_s : {1.0, 2.0, 5.0, 10.0, 10.0}) {
    link.give_up("lost");
    const LinkResult refused = link.open();
    ASSERT_FALSE(refused);
    EXPECT_TRUE(base::mentions(refused.error().text, {"lost"})) << "the reason stays known";
    // On a slow machine a little of the pause is over already.
    const double left_s = std::chrono::duration<double>(link.next_try() - Clock::now()).count();
    EXPECT_NEAR(left_s, expected_s, 0.9);
  }
}

TEST(ModbusLink, RefusesADescriptorThatLibmodbusCannotUse) {
  rlimit limit{};
  ASSERT_EQ(::getrlimit(RLIMIT_NOFILE, &limit), 0);
  if (limit.rlim_max < 2000) GTEST_SKIP() << "skipped: no more than " << limit.rlim_max << " open files allowed";
  const rlimit raised{2000, limit.rlim_max};
  ASSERT_EQ(::setrlimit(RLIMIT_NOFILE, &raised), 0);
  std::vector<int> taken;
  for (int fd = 0; fd >= 0 && fd < 1030;) {
    fd = ::open("/dev/null", O_RDONLY | O_CLOEXEC);
    taken.push_back(fd);
  }
  ModbusLink link({.address = TcpAddress{"127.0.0.1", 1}});
  const LinkResult opened = link.open();
  for (const int fd : taken) ::close(fd);
  ::setrlimit(RLIMIT_NOFILE, &limit);
  ASSERT_FALSE(opened);
  EXPECT_TRUE(base::mentions(opened.error().text, {"1023"}));
}

class ModbusRtuFaultTest : public ::testing::TestWithParam<Fault> {
 protected:
  static DeviceMap rig_map_rtu(const std::string& device) {
    DeviceMap map = test::parsed_map(kMap);
    map.link.address = SerialAddress{.device = device, .baud = 38400};
    map.link.gap_s = 0.005;
    return map;
  }
};

TEST_P(ModbusRtuFaultTest, GivesTheTruthOrAnErrorAndRecovers) {
  SOAK_START_PYMODBUS(server, "rtu", kRegisters);
  SOAK_NEED_SOCAT();
  // A late answer comes when the link is open again and asks its probe.
  FaultProxy proxy(server->port(), FaultProxy::Framing::rtu, 1500);
  const test::SerialLine line(proxy.port());
  Controller controller(rig_map_rtu(line.path()));
  expect_recovery(controller);
  expect_truth_or_error(controller, proxy, GetParam());
  ASSERT_TRUE(controller.write("control_mode", 445.0));
  EXPECT_EQ(read_one(controller, "control_mode").value_or(0.0), 445.0);
}

INSTANTIATE_TEST_SUITE_P(Kinds, ModbusRtuFaultTest,
                         ::testing::Values(Fault::none, Fault::late, Fault::exception, Fault::busy, Fault::wrong_unit,
                                           Fault::wrong_function, Fault::truncated, Fault::garbage, Fault::byte_by_byte,
                                           Fault::silence, Fault::stale, Fault::twice));

// On a serial line a reset is an adapter that was pulled: the device goes, and comes back.
TEST(ModbusRtuFault, ComesBackAfterTheAdapterWasPulledAndPluggedInAgain) {
  SOAK_START_PYMODBUS(server, "rtu", kRegisters);
  SOAK_NEED_SOCAT();
  auto line = std::make_unique<test::SerialLine>(server->port());
  DeviceMap map = test::parsed_map(kMap);
  map.link.address = SerialAddress{.device = line->path(), .baud = 38400};
  Controller controller(map);
  expect_recovery(controller);
  line.reset();
  const auto lost = read_one(controller, "air_c");
  ASSERT_FALSE(lost);
  EXPECT_EQ(lost.error().kind, base::ErrorKind::device);
  line = std::make_unique<test::SerialLine>(server->port());
  expect_recovery(controller);
}

}  // namespace
}  // namespace soak::hal
