// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/wires/detail/ports.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <stdlib.h>
#include <sys/socket.h>
#include <termios.h>

#include <array>
#include <cerrno>
#include <cstring>

namespace soak::hal::sim {
namespace {

constexpr int kBacklog = 8;

// Little is on its way, so that the laboratory's clock keeps close to what has been read.
constexpr int kSendBuffer = 8192;

}  // namespace

base::Result<TcpListener> TcpListener::open(int port, int send_buffer) {
  const auto refused = [port] {
    return base::bad_input(
        fmt::format("cannot listen on port {} of 127.0.0.1 ({}); --base-port needs one followed by free ports", port,
                    std::strerror(errno)));
  };
  TcpListener listener;
  listener.fd_ = base::FileDescriptor(::socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
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
  if (::bind(fd, generic, size) != 0 || ::listen(fd, kBacklog) != 0 || getsockname(fd, generic, &size) != 0) {
    return refused();
  }
  listener.port_ = ntohs(address.sin_port);
  return listener;
}

base::FileDescriptor TcpListener::accept() const {
  base::FileDescriptor client(accept4(fd_.get(), nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC));
  if (client) {
    const int yes = 1;
    setsockopt(client.get(), IPPROTO_TCP, TCP_NODELAY, &yes, sizeof yes);
  }
  return client;
}

void UnitPort::queue(const base::Bytes& bytes) {
  if (connected()) pending_.insert(pending_.end(), bytes.begin(), bytes.end());
}

void UnitPort::flush() {
  std::size_t sent = 0;
  while (connected() && sent < pending_.size()) {
    const ssize_t count = ::write(channel(), pending_.data() + sent, pending_.size() - sent);
    if (count > 0) {
      sent += static_cast<std::size_t>(count);
    } else if (count < 0 && (errno == EAGAIN || errno == EWOULDBLOCK)) {
      break;
    } else if (errno != EINTR) {
      disconnect();
      return;
    }
  }
  pending_.erase(pending_.begin(), pending_.begin() + static_cast<std::ptrdiff_t>(sent));
}

void UnitPort::serve_channel(short events) {
  if ((events & (POLLIN | POLLHUP | POLLERR)) != 0) {
    std::array<std::uint8_t, 4096> bytes;
    const ssize_t count = ::read(channel(), bytes.data(), bytes.size());
    if (count > 0) receive_(std::span(bytes).first(static_cast<std::size_t>(count)));
    const bool nothing_yet = count < 0 && (errno == EAGAIN || errno == EINTR);
    if (count <= 0 && !nothing_yet) {
      disconnect();
      return;
    }
  }
  if ((events & POLLOUT) != 0) flush();
}

void UnitPort::add_channel_to(PollSet& polls) {
  const short events = has_backlog() ? POLLIN | POLLOUT : POLLIN;
  polls.add(channel(), events, [this](short happened) { serve_channel(happened); });
}

base::Result<std::unique_ptr<TcpUnitPort>> TcpUnitPort::open(int port, Receiver receive) {
  auto listener = TcpListener::open(port, kSendBuffer);
  if (!listener) return base::forward_error(listener);
  return std::unique_ptr<TcpUnitPort>(new TcpUnitPort(*std::move(listener), std::move(receive)));
}

void TcpUnitPort::add_to(PollSet& polls) {
  if (connected()) add_channel_to(polls);
  polls.add(listener_.fd(), POLLIN, [this](short) { accept_reader(); });
}

void TcpUnitPort::disconnect() {
  forget_backlog();
  reader_.reset();
}

bool TcpUnitPort::reader_is_gone() const {
  std::uint8_t byte = 0;
  const ssize_t count = recv(reader_.get(), &byte, 1, MSG_PEEK | MSG_DONTWAIT);
  return count == 0 || (count < 0 && errno != EAGAIN && errno != EWOULDBLOCK);
}

void TcpUnitPort::accept_reader() {
  base::FileDescriptor reader = listener_.accept();
  if (!reader) return;
  if (connected() && !reader_is_gone()) return;
  disconnect();
  reader_ = std::move(reader);
}

base::Result<std::unique_ptr<PtyUnitPort>> PtyUnitPort::open(Receiver receive) {
  const auto refused = [] {
    return base::fail(base::ErrorKind::internal, std::string("no pseudo-terminal: ") + std::strerror(errno));
  };
  base::FileDescriptor master(posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC));
  std::array<char, 128> path{};
  if (!master || grantpt(master.get()) != 0 || unlockpt(master.get()) != 0 ||
      ptsname_r(master.get(), path.data(), path.size()) != 0) {
    return refused();
  }
  // Opened and closed once, the terminal tells by POLLHUP that nobody reads it.
  const base::FileDescriptor slave(::open(path.data(), O_RDWR | O_NOCTTY | O_CLOEXEC));
  termios settings{};
  if (!slave || tcgetattr(slave.get(), &settings) != 0) return refused();
  cfmakeraw(&settings);
  if (tcsetattr(slave.get(), TCSANOW, &settings) != 0) return refused();
  return std::unique_ptr<PtyUnitPort>(new PtyUnitPort(std::move(master), path.data(), std::move(receive)));
}

void PtyUnitPort::watch() {
  pollfd state = {master_.get(), 0, 0};
  const bool has_reader = poll(&state, 1, 0) == 0;
  if (connected_ && !has_reader) disconnect();
  connected_ = has_reader;
}

void PtyUnitPort::add_to(PollSet& polls) {
  if (connected_) add_channel_to(polls);
}

void PtyUnitPort::disconnect() {
  connected_ = false;
  forget_backlog();
  // What the last reader has left would be given to the next one.
  tcflush(master_.get(), TCIOFLUSH);
}

}  // namespace soak::hal::sim
