// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/wires/detail/tcp_listener.h"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>

#include <cerrno>
#include <cstdint>
#include <cstring>
#include <utility>

namespace soak::hal::sim {
namespace {

constexpr int kBacklog = 8;

}  // namespace

base::Result<TcpListener> TcpListener::open(int port, int send_buffer) {
  const auto refused = [port] {
    return base::bad_input(
        fmt::format("cannot listen on port {} of 127.0.0.1 ({}); --base-port wants one followed by "
                    "free ports",
                    port, std::strerror(errno)));
  };
  TcpListener listener;
  listener.fd_ = FileDescriptor(socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
  const int fd = listener.fd_.get();
  if (fd < 0) return refused();
  const int yes = 1;
  setsockopt(fd, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
  // Accepted sockets inherit it; set later it would not take effect on bytes that are on their way.
  if (send_buffer > 0) setsockopt(fd, SOL_SOCKET, SO_SNDBUF, &send_buffer, sizeof send_buffer);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  auto* generic = reinterpret_cast<sockaddr*>(&address);
  socklen_t size = sizeof address;
  if (bind(fd, generic, size) != 0 || listen(fd, kBacklog) != 0 || getsockname(fd, generic, &size) != 0) {
    return refused();
  }
  listener.port_ = ntohs(address.sin_port);
  return listener;
}

FileDescriptor TcpListener::accept() const {
  FileDescriptor client(accept4(fd_.get(), nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC));
  if (client.is_open()) {
    const int yes = 1;
    setsockopt(client.get(), IPPROTO_TCP, TCP_NODELAY, &yes, sizeof yes);
  }
  return client;
}

}  // namespace soak::hal::sim
