// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>
#include <poll.h>

#include <atomic>
#include <chrono>
#include <functional>
#include <thread>

#include "hal/imu/imu.h"
#include "hal/links/addresses.h"
#include "tests/hal/xsens_peer.h"
#include "tests/hal/xsens_wires.h"

namespace soak::hal::imu::test {
namespace {

using namespace std::chrono_literals;

/// False if the station has gone.
bool send_all(int fd, const Bytes& bytes) {
  for (std::size_t done = 0; done < bytes.size();) {
    const ssize_t sent = ::write(fd, bytes.data() + done, bytes.size() - done);
    if (sent <= 0) return false;
    done += static_cast<std::size_t>(sent);
  }
  return true;
}

/// Obeys the station until `until` holds.
void serve(int fd, ScriptedUnit& unit, const std::function<bool()>& until) {
  std::array<std::uint8_t, 512> buffer;
  const auto give_up = std::chrono::steady_clock::now() + 20s;
  while (!until() && std::chrono::steady_clock::now() < give_up) {
    pollfd waiting{fd, POLLIN, 0};
    if (::poll(&waiting, 1, 10) != 1) continue;
    const ssize_t got = ::read(fd, buffer.data(), buffer.size());
    if (got > 0) send_all(fd, unit.take(std::span(buffer).first(static_cast<std::size_t>(got))));
  }
}

/// A run of the unit: it is configured, sends packets with garbage between, restarts, is configured again, sends more.
void play(int fd, const std::atomic<bool>& finish) {
  ScriptedUnit unit;
  send_all(fd, unit.packets(20));  // as it was configured before
  serve(fd, unit, [&] { return unit.measuring; });
  for (int i = 0; i < 2000; ++i) send_all(fd, unit.packet() + hex("00 FA 13"));
  send_all(fd, unit.restart());
  serve(fd, unit, [&] { return unit.measuring; });
  send_all(fd, unit.packets(1000));
  serve(fd, unit, [&] { return finish.load(); });
}

/// Polls as a station does until `until` holds or the driver fails.
base::Status follow(Imu& imu, std::vector<ImuSample>& samples, const std::function<bool()>& until) {
  const auto give_up = std::chrono::steady_clock::now() + 20s;
  base::Status status;
  while (status && !until() && std::chrono::steady_clock::now() < give_up) {
    pollfd waiting{imu.wait_fd(), POLLIN, 0};
    ::poll(&waiting, 1, 50);
    status = imu.poll(samples);
  }
  return status;
}

void expect_the_whole_play(const Imu& imu, const std::vector<ImuSample>& samples) {
  ASSERT_EQ(samples.size(), 3000U);
  for (std::uint32_t i = 0; i < samples.size(); ++i) {
    const bool first = i < 2000;
    ASSERT_EQ(samples[i].power_on, first ? 0U : 1U) << i;
    ASSERT_EQ(samples[i].packet, first ? i + 20 : i - 2000) << i;
    ASSERT_DOUBLE_EQ(samples[i].t_s, 0.01 * samples[i].packet) << i;
  }
  EXPECT_EQ(imu.statistics().restarts, 1U);
  EXPECT_EQ(imu.statistics().lost_packets, 0U);
  EXPECT_EQ(imu.statistics().garbage_bytes, 6000U);
  EXPECT_EQ(imu.identity()->serial, "0380ABCD");
}

TEST(XsensOverTcp, StreamsThroughARestartAndFailsWhenThePeerCloses) {
  const TcpListener listener;
  std::atomic<bool> finish = false;
  std::thread unit([&] {
    const base::FileDescriptor peer = listener.accept();
    play(peer.get(), finish);
  });
  const auto imu = make_imu({.address = TcpAddress{"127.0.0.1", listener.port()}});
  const auto opened = imu->open({});
  std::vector<ImuSample> samples;
  const auto followed = follow(*imu, samples, [&] { return samples.size() >= 3000; });
  finish = true;
  const auto ended = follow(*imu, samples, [] { return false; });
  unit.join();
  EXPECT_TRUE(opened);
  EXPECT_TRUE(followed);
  expect_the_whole_play(*imu, samples);
  ASSERT_FALSE(ended);
  EXPECT_EQ(ended.error().kind, base::ErrorKind::device);
  EXPECT_EQ(imu->state(), ImuState::failed);
}

TEST(XsensOverSerial, StreamsThroughARestartAndFailsWhenUnplugged) {
  PseudoTerminal terminal;
  const auto imu = make_imu({.address = SerialAddress{terminal.name(), 921600}});
  ASSERT_TRUE(imu->open({}));  // raw from here on: nothing that the unit sends is echoed
  std::atomic<bool> finish = false;
  std::thread unit([&] {
    play(terminal.master(), finish);
    terminal.unplug();
  });
  std::vector<ImuSample> samples;
  const auto followed = follow(*imu, samples, [&] { return samples.size() >= 3000; });
  finish = true;
  const auto ended = follow(*imu, samples, [] { return false; });
  unit.join();
  EXPECT_TRUE(followed);
  expect_the_whole_play(*imu, samples);
  ASSERT_FALSE(ended);
  EXPECT_EQ(ended.error().kind, base::ErrorKind::device);
}

TEST(XsensOverTcp, OpeningWithoutAPeerIsADeviceErrorAndMayBeTriedAgain) {
  int port = 0;
  {
    const TcpListener gone;
    port = gone.port();
  }
  const auto imu = make_imu({.address = TcpAddress{"127.0.0.1", port}});
  for (int attempt = 0; attempt < 2; ++attempt) {
    const auto opened = imu->open({});
    ASSERT_FALSE(opened);
    EXPECT_EQ(opened.error().kind, base::ErrorKind::device);
    EXPECT_EQ(imu->state(), ImuState::closed);
  }
}

}  // namespace
}  // namespace soak::hal::imu::test
