// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>

#include <cerrno>
#include <chrono>
#include <utility>

#include "hal/links/detail/descriptor_source.h"

namespace soak::hal::imu {
namespace {

using Clock = std::chrono::steady_clock;

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
int finish_connecting(int fd, Clock::time_point deadline) {
  pollfd waiting{fd, POLLOUT, 0};
  for (;;) {
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(deadline - Clock::now());
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
tl::expected<Descriptor, int> connect_to(const addrinfo& address, Clock::time_point deadline) {
  Descriptor socket(::socket(address.ai_family, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, address.ai_protocol));
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
    return base::fail(base::ErrorKind::device, fmt::format("the host is not known: {}", ::gai_strerror(failure)),
                      description());
  }
  const auto deadline = Clock::now() + kConnectTimeout;
  tl::expected<Descriptor, int> socket = tl::unexpected(EADDRNOTAVAIL);
  for (const addrinfo* one = found; one != nullptr && !socket; one = one->ai_next) socket = connect_to(*one, deadline);
  ::freeaddrinfo(found);
  if (!socket) return broken("cannot connect", socket.error());
  watch_the_peer(socket->get());
  adopt(std::move(*socket));
  return {};
}

}  // namespace

std::unique_ptr<ByteSource> make_tcp_source(const TcpAddress& address) { return std::make_unique<TcpSource>(address); }

}  // namespace soak::hal::imu
