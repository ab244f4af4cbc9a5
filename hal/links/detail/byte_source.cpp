// SPDX-License-Identifier: Apache-2.0
#include "hal/links/detail/byte_source.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <termios.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <optional>
#include <system_error>
#include <utility>
#include <variant>

namespace soak::hal::imu {

// --- what all sources on a file descriptor have in common

namespace {

bool is_not_now(int error_number) {
  return error_number == EAGAIN || error_number == EWOULDBLOCK || error_number == EINTR;
}

/// As write(), but a socket whose peer has gone answers EPIPE instead of raising a signal.
ssize_t write_quietly(int fd, std::span<const std::uint8_t> bytes) {
  const ssize_t sent = ::send(fd, bytes.data(), bytes.size(), MSG_NOSIGNAL);
  if (sent < 0 && errno == ENOTSOCK) return ::write(fd, bytes.data(), bytes.size());
  return sent;
}

}  // namespace

base::Result<std::size_t> DescriptorSource::read(std::span<std::uint8_t> buffer) {
  const ssize_t got = ::read(fd(), buffer.data(), buffer.size());
  if (got > 0) return static_cast<std::size_t>(got);
  if (got < 0 && is_not_now(errno)) return 0;
  if (got < 0) return broken("reading failed", errno);
  return base::fail(base::ErrorKind::device, "the other end has closed the connection or was unplugged", description());
}

base::Result<std::size_t> DescriptorSource::write(std::span<const std::uint8_t> bytes) {
  const ssize_t sent = write_quietly(fd(), bytes);
  if (sent >= 0) return static_cast<std::size_t>(sent);
  if (is_not_now(errno)) return 0;
  return broken("writing failed", errno);
}

tl::unexpected<base::Error> DescriptorSource::broken(const std::string& what, int error_number) const {
  return base::fail(base::ErrorKind::device, what + ": " + std::generic_category().message(error_number),
                    description());
}

// --- TCP

namespace {

using SteadyClock = std::chrono::steady_clock;

constexpr std::chrono::milliseconds kConnectTimeout{1000};

void set_option(int fd, int level, int name, int value) { ::setsockopt(fd, level, name, &value, sizeof value); }

/// A peer that vanishes without a word (cable, power of the gateway) is noticed after some 25 s, whether the station is
/// only listening (keep-alive) or has sent something (user time-out).
void watch_the_peer(int fd) {
  set_option(fd, SOL_SOCKET, SO_KEEPALIVE, 1);
  set_option(fd, IPPROTO_TCP, TCP_KEEPIDLE, 10);
  set_option(fd, IPPROTO_TCP, TCP_KEEPINTVL, 5);
  set_option(fd, IPPROTO_TCP, TCP_KEEPCNT, 3);
  set_option(fd, IPPROTO_TCP, TCP_USER_TIMEOUT, 25'000);
  set_option(fd, IPPROTO_TCP, TCP_NODELAY, 1);
}

/// Waits until the connection stands; returns errno, 0 = it stands.
int finish_connecting(int fd, SteadyClock::time_point deadline) {
  pollfd waiting{fd, POLLOUT, 0};
  for (;;) {
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(deadline - SteadyClock::now());
    if (left.count() <= 0) return ETIMEDOUT;
    const int ready = ::poll(&waiting, 1, static_cast<int>(left.count()));
    if (ready > 0) break;
    if (ready < 0 && errno != EINTR) return errno;
  }
  int error_number = 0;
  socklen_t size = sizeof error_number;
  ::getsockopt(fd, SOL_SOCKET, SO_ERROR, &error_number, &size);
  return error_number;
}

/// A connected socket, or errno.
tl::expected<base::FileDescriptor, int> connect_to(const addrinfo& address, SteadyClock::time_point deadline) {
  base::FileDescriptor socket(
      ::socket(address.ai_family, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, address.ai_protocol));
  if (!socket) return tl::unexpected(errno);
  if (::connect(socket.get(), address.ai_addr, address.ai_addrlen) != 0) {
    const int error_number = errno == EINPROGRESS ? finish_connecting(socket.get(), deadline) : errno;
    if (error_number != 0) return tl::unexpected(error_number);
  }
  return socket;
}

class TcpSource final : public DescriptorSource {
 public:
  explicit TcpSource(const TcpAddress& address) : address_(address) {}

  base::Status open() override;
  std::string description() const override { return fmt::format("tcp {}:{}", address_.host, address_.port); }

 private:
  TcpAddress address_;
};

base::Status TcpSource::open() {
  close();
  addrinfo hints{};
  hints.ai_socktype = SOCK_STREAM;
  addrinfo* found = nullptr;
  const int failure = ::getaddrinfo(address_.host.c_str(), std::to_string(address_.port).c_str(), &hints, &found);
  if (failure != 0) {
    return base::fail(base::ErrorKind::device,
                      fmt::format("unknown host '{}': {}", address_.host, ::gai_strerror(failure)), description());
  }
  const auto deadline = SteadyClock::now() + kConnectTimeout;
  tl::expected<base::FileDescriptor, int> socket = tl::unexpected(EADDRNOTAVAIL);
  for (const addrinfo* one = found; one != nullptr && !socket; one = one->ai_next) socket = connect_to(*one, deadline);
  ::freeaddrinfo(found);
  if (!socket) return broken("cannot connect", socket.error());
  watch_the_peer(socket->get());
  adopt(std::move(*socket));
  return {};
}

}  // namespace

std::unique_ptr<ByteSource> make_tcp_source(const TcpAddress& address) { return std::make_unique<TcpSource>(address); }

// --- serial lines

namespace {

struct BaudRate {
  int baud;
  speed_t code;
};

constexpr std::array kBaudRates = {
    BaudRate{4800, B4800},     BaudRate{9600, B9600},       BaudRate{19200, B19200},     BaudRate{38400, B38400},
    BaudRate{57600, B57600},   BaudRate{115200, B115200},   BaudRate{230400, B230400},   BaudRate{460800, B460800},
    BaudRate{921600, B921600}, BaudRate{1000000, B1000000}, BaudRate{2000000, B2000000}, BaudRate{4000000, B4000000},
};

std::optional<speed_t> code_of(int baud) {
  for (const BaudRate& rate : kBaudRates) {
    if (rate.baud == baud) return rate.code;
  }
  return std::nullopt;
}

std::string all_baud_rates() {
  std::string text;
  for (const BaudRate& rate : kBaudRates) text += fmt::format("{}{}", text.empty() ? "" : ", ", rate.baud);
  return text;
}

/// Raw bytes, 8N1, no flow control, modem lines ignored. Returns whether the line took it.
bool make_raw(int fd, speed_t speed) {
  termios settings{};
  if (::tcgetattr(fd, &settings) != 0) return false;
  ::cfmakeraw(&settings);
  settings.c_cflag &= ~static_cast<tcflag_t>(CRTSCTS | CSTOPB);
  settings.c_cflag |= CLOCAL | CREAD;
  // With VMIN 0 an idle line would read as 0 bytes, which is what a line that was hung up reads as.
  settings.c_cc[VMIN] = 1;
  settings.c_cc[VTIME] = 0;
  ::cfsetispeed(&settings, speed);
  ::cfsetospeed(&settings, speed);
  return ::tcsetattr(fd, TCSANOW, &settings) == 0;
}

class SerialSource final : public DescriptorSource {
 public:
  explicit SerialSource(const SerialAddress& address) : address_(address) {}

  base::Status open() override;
  std::string description() const override {
    return fmt::format("serial {} at {} baud", address_.device, address_.baud);
  }

 private:
  SerialAddress address_;
};

base::Status SerialSource::open() {
  close();
  const auto speed = code_of(address_.baud);
  if (!speed) return base::bad_input("the baud rate must be one of " + all_baud_rates(), description());
  base::FileDescriptor line(::open(address_.device.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC));
  if (!line) return broken("cannot open", errno);
  if (!make_raw(line.get(), *speed)) return broken("cannot set up the line", errno);
  ::tcflush(line.get(), TCIFLUSH);
  adopt(std::move(line));
  return {};
}

}  // namespace

std::unique_ptr<ByteSource> make_serial_source(const SerialAddress& address) {
  return std::make_unique<SerialSource>(address);
}

// --- recordings

namespace {

class RecordedSource final : public DescriptorSource {
 public:
  explicit RecordedSource(const RecordedAddress& address) : address_(address) {}

  base::Status open() override;
  base::Result<std::size_t> read(std::span<std::uint8_t> buffer) override;
  base::Result<std::size_t> write(std::span<const std::uint8_t> bytes) override { return bytes.size(); }
  bool answers() const override { return false; }
  std::string description() const override { return "recording " + address_.file; }

 private:
  RecordedAddress address_;
};

base::Status RecordedSource::open() {
  close();
  base::FileDescriptor file(::open(address_.file.c_str(), O_RDONLY | O_CLOEXEC));
  if (!file) return broken("cannot open", errno);
  adopt(std::move(file));
  return {};
}

base::Result<std::size_t> RecordedSource::read(std::span<std::uint8_t> buffer) {
  const ssize_t got = ::read(fd(), buffer.data(), buffer.size());
  if (got < 0) return broken("reading failed", errno);
  if (got == 0) return base::fail(base::ErrorKind::device, kRecordingEnded, description());
  return static_cast<std::size_t>(got);
}

}  // namespace

std::unique_ptr<ByteSource> make_recorded_source(const RecordedAddress& address) {
  return std::make_unique<RecordedSource>(address);
}

// --- addresses in words

namespace {

struct AddressText {
  std::string operator()(const TcpAddress& tcp) const { return fmt::format("tcp {}:{}", tcp.host, tcp.port); }
  std::string operator()(const SerialAddress& serial) const { return fmt::format("serial {}", serial.device); }
  std::string operator()(const UsbAddress& usb) const {
    std::string text = fmt::format("usb {:04x}:{:04x}", usb.vendor, usb.product);
    for (const std::string& part : {usb.serial, usb.path}) text += part.empty() ? "" : " " + part;
    return text;
  }
  std::string operator()(const RecordedAddress& recorded) const { return fmt::format("recording {}", recorded.file); }
};

}  // namespace

}  // namespace soak::hal::imu

namespace soak::hal {

std::string text_of(const UnitAddress& address) { return std::visit(imu::AddressText{}, address); }

std::string text_of(const ControllerAddress& address) {
  if (const auto* tcp = std::get_if<TcpAddress>(&address)) return fmt::format("{}:{}", tcp->host, tcp->port);
  return std::get<SerialAddress>(address).device;
}

}  // namespace soak::hal
