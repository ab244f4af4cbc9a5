// SPDX-License-Identifier: Apache-2.0
#include <arpa/inet.h>
#include <fcntl.h>
#include <gtest/gtest.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <pty.h>
#include <sys/socket.h>
#include <termios.h>
#include <unistd.h>

#include <array>
#include <vector>

#include "hal/links/detail/byte_source.h"
#include "tests/errors.h"
#include "tests/hal/xsens_peer.h"
#include "tests/hal/xsens_wires.h"

namespace soak::hal::imu::test {
namespace {

constexpr int kPatience_ms = 20'000;

bool wait_readable(int fd) {
  pollfd waiting{fd, POLLIN, 0};
  return ::poll(&waiting, 1, kPatience_ms) == 1;
}

/// Reads until `count` bytes are there or the source fails.
Bytes read_bytes(ByteSource& source, std::size_t count) {
  Bytes bytes;
  std::array<std::uint8_t, 256> buffer;
  while (bytes.size() < count && wait_readable(source.fd())) {
    const auto got = source.read(buffer);
    if (!got) break;
    bytes.insert(bytes.end(), buffer.begin(), buffer.begin() + static_cast<long>(*got));
  }
  return bytes;
}

int option(int fd, int level, int name) {
  int value = -1;
  socklen_t size = sizeof value;
  ::getsockopt(fd, level, name, &value, &size);
  return value;
}

base::Error error_of_read(ByteSource& source) {
  EXPECT_TRUE(wait_readable(source.fd()));
  std::array<std::uint8_t, 16> buffer;
  const auto got = source.read(buffer);
  EXPECT_FALSE(got);
  return got ? base::Error{} : got.error();
}

TEST(TcpSource, CarriesBytesBothWaysWithoutWaiting) {
  TcpListener listener;
  const auto source = make_tcp_source({"127.0.0.1", listener.port()});
  ASSERT_TRUE(source->open());
  const base::FileDescriptor peer = listener.accept();
  std::array<std::uint8_t, 16> buffer;
  EXPECT_EQ(source->read(buffer).value(), 0U);
  ASSERT_EQ(::write(peer.get(), "abc", 3), 3);
  EXPECT_EQ(read_bytes(*source, 3), text("abc"));
  ASSERT_EQ(source->write(text("hello")).value(), 5U);
  std::array<char, 16> received{};
  ASSERT_TRUE(wait_readable(peer.get()));
  EXPECT_EQ(::read(peer.get(), received.data(), received.size()), 5);
  EXPECT_STREQ(received.data(), "hello");
}

TEST(TcpSource, SendsAtOnceAndWatchesTheConnection) {
  TcpListener listener;
  const auto source = make_tcp_source({"127.0.0.1", listener.port()});
  ASSERT_TRUE(source->open());
  EXPECT_EQ(option(source->fd(), IPPROTO_TCP, TCP_NODELAY), 1);
  EXPECT_EQ(option(source->fd(), SOL_SOCKET, SO_KEEPALIVE), 1);
  EXPECT_NE(::fcntl(source->fd(), F_GETFL) & O_NONBLOCK, 0);
  EXPECT_NE(::fcntl(source->fd(), F_GETFD) & FD_CLOEXEC, 0);
}

TEST(TcpSource, AClosedPeerIsADeviceErrorAfterItsLastBytes) {
  TcpListener listener;
  const auto source = make_tcp_source({"127.0.0.1", listener.port()});
  ASSERT_TRUE(source->open());
  {
    const base::FileDescriptor peer = listener.accept();
    ASSERT_EQ(::write(peer.get(), "abc", 3), 3);
  }
  EXPECT_EQ(read_bytes(*source, 3), text("abc"));
  EXPECT_EQ(error_of_read(*source).kind, base::ErrorKind::device);
}

TEST(TcpSource, WritingToAClosedPeerIsADeviceErrorAndNoSignal) {
  TcpListener listener;
  const auto source = make_tcp_source({"127.0.0.1", listener.port()});
  ASSERT_TRUE(source->open());
  {
    const base::FileDescriptor peer = listener.accept();
  }
  bool failed = false;
  for (int i = 0; i < 1000 && !failed; ++i) {
    const auto sent = source->write(text("x"));
    failed = !sent && sent.error().kind == base::ErrorKind::device;
    wait_readable(source->fd());
  }
  EXPECT_TRUE(failed);
}

TEST(TcpSource, ARefusedConnectionIsADeviceErrorThatNamesTheAddress) {
  int port = 0;
  {
    const TcpListener listener;
    port = listener.port();
  }
  const auto source = make_tcp_source({"127.0.0.1", port});
  const auto opened = source->open();
  ASSERT_FALSE(opened);
  EXPECT_EQ(opened.error().kind, base::ErrorKind::device);
  EXPECT_EQ(opened.error().where, "tcp 127.0.0.1:" + std::to_string(port));
  EXPECT_EQ(source->fd(), -1);
}

TEST(TcpSource, AnUnknownHostIsADeviceError) {
  const auto opened = make_tcp_source({"no such host", 1})->open();
  ASSERT_FALSE(opened);
  EXPECT_EQ(opened.error().kind, base::ErrorKind::device);
}

TEST(TcpSource, AConnectionThatIsNotAnsweredTimesOut) {
  TcpListener listener(0);
  std::vector<base::FileDescriptor> crowd;  // fills the queue of the listener: the next one gets no answer
  for (int i = 0; i < 4; ++i) crowd.push_back(listener.begin_connecting());
  const auto opened = make_tcp_source({"127.0.0.1", listener.port()})->open();
  ASSERT_FALSE(opened);
  EXPECT_EQ(opened.error().kind, base::ErrorKind::device);
}

TEST(SerialSource, CarriesEveryByteValueOverAPseudoTerminalUnchanged) {
  const PseudoTerminal terminal;
  const auto source = make_serial_source({terminal.name(), 115200});
  ASSERT_TRUE(source->open());
  Bytes all;
  for (int byte = 0; byte < 256; ++byte) all.push_back(static_cast<std::uint8_t>(byte));
  ASSERT_EQ(::write(terminal.master(), all.data(), all.size()), 256);
  EXPECT_EQ(read_bytes(*source, 256), all);
  ASSERT_EQ(source->write(all).value(), 256U);
  Bytes received;
  std::array<std::uint8_t, 256> buffer;
  while (received.size() < 256 && wait_readable(terminal.master())) {
    const ssize_t got = ::read(terminal.master(), buffer.data(), buffer.size());
    ASSERT_GT(got, 0);
    received.insert(received.end(), buffer.begin(), buffer.begin() + got);
  }
  EXPECT_EQ(received, all);
}

TEST(SerialSource, AnIdleLineHasNothingToReadAndNoError) {
  const PseudoTerminal terminal;
  const auto source = make_serial_source({terminal.name(), 115200});
  ASSERT_TRUE(source->open());
  std::array<std::uint8_t, 16> buffer;
  EXPECT_EQ(source->read(buffer).value(), 0U);
}

TEST(SerialSource, OpeningDropsWhatWasLeftOnTheLine) {
  const PseudoTerminal terminal;
  const auto before = make_serial_source({terminal.name(), 115200});
  ASSERT_TRUE(before->open());
  ASSERT_EQ(::write(terminal.master(), "stale", 5), 5);
  ASSERT_TRUE(wait_readable(before->fd()));
  const auto source = make_serial_source({terminal.name(), 115200});
  ASSERT_TRUE(source->open());
  ASSERT_EQ(::write(terminal.master(), "new", 3), 3);
  EXPECT_EQ(read_bytes(*source, 3), text("new"));
}

TEST(SerialSource, AnUnpluggedLineIsADeviceError) {
  PseudoTerminal terminal;
  const auto source = make_serial_source({terminal.name(), 115200});
  ASSERT_TRUE(source->open());
  terminal.unplug();
  EXPECT_EQ(error_of_read(*source).kind, base::ErrorKind::device);
  EXPECT_FALSE(source->write(text("x")));
}

TEST(SerialSource, SetsTheBaudRate) {
  const PseudoTerminal terminal;
  const auto source = make_serial_source({terminal.name(), 921600});
  ASSERT_TRUE(source->open());
  termios settings{};
  ASSERT_EQ(::tcgetattr(source->fd(), &settings), 0);
  EXPECT_EQ(::cfgetispeed(&settings), static_cast<speed_t>(B921600));
  EXPECT_EQ(::cfgetospeed(&settings), static_cast<speed_t>(B921600));
}

TEST(SerialSource, AnUnknownBaudRateIsBadInputThatListsTheKnownOnes) {
  const auto opened = make_serial_source({"/dev/null", 12345})->open();
  ASSERT_FALSE(opened);
  EXPECT_EQ(opened.error().kind, base::ErrorKind::bad_input);
  EXPECT_TRUE(names(opened.error(), {"115200"}));
}

TEST(SerialSource, AMissingDeviceAndAFileAreDeviceErrors) {
  for (const char* device : {"/dev/no-such-line", "/dev/null"}) {
    const auto opened = make_serial_source({device, 115200})->open();
    ASSERT_FALSE(opened) << device;
    EXPECT_EQ(opened.error().kind, base::ErrorKind::device);
    EXPECT_NE(opened.error().where.find(device), std::string::npos);
  }
}

}  // namespace
}  // namespace soak::hal::imu::test
