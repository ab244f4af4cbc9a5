// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <pty.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <stdexcept>
#include <string>
#include <utility>

#include "hal/links/detail/byte_source.h"

/// Real kernel objects to hang a unit on.
namespace soak::hal::imu::test {

/// Listens on a free port of the loopback interface.
class TcpListener {
 public:
  explicit TcpListener(int backlog = 4) : listener_(::socket(AF_INET, SOCK_STREAM, 0)) {
    address_.sin_family = AF_INET;
    address_.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof address_;
    auto* address = reinterpret_cast<sockaddr*>(&address_);
    if (::bind(listener_.get(), address, size) != 0 || ::listen(listener_.get(), backlog) != 0 ||
        ::getsockname(listener_.get(), address, &size) != 0) {
      throw std::runtime_error("cannot listen");
    }
  }

  [[nodiscard]] int port() const { return ntohs(address_.sin_port); }
  [[nodiscard]] base::FileDescriptor accept() const {
    return base::FileDescriptor(::accept(listener_.get(), nullptr, nullptr));
  }
  [[nodiscard]] base::FileDescriptor begin_connecting() const {
    base::FileDescriptor socket(::socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK, 0));
    // In progress or connected: both will do.
    static_cast<void>(::connect(socket.get(), reinterpret_cast<const sockaddr*>(&address_), sizeof address_));
    return socket;
  }

 private:
  base::FileDescriptor listener_;
  sockaddr_in address_{};
};

class PseudoTerminal {
 public:
  PseudoTerminal() {
    int master = -1;
    int slave = -1;
    std::array<char, 64> name{};
    if (::openpty(&master, &slave, name.data(), nullptr, nullptr) != 0) throw std::runtime_error("no pseudo-terminal");
    master_ = base::FileDescriptor(master);
    slave_ = base::FileDescriptor(slave);
    name_ = name.data();
  }

  [[nodiscard]] int master() const { return master_.get(); }
  [[nodiscard]] const std::string& name() const { return name_; }
  void unplug() { master_.reset(); }

 private:
  base::FileDescriptor master_;
  base::FileDescriptor slave_;
  std::string name_;
};

/// One end of a socket pair; each open() makes a new pair.
class PairSource final : public DescriptorSource {
 public:
  base::Status open() override {
    std::array<int, 2> ends{};
    if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK, 0, ends.data()) != 0) return broken("no socket pair", errno);
    const int room = 1 << 20;
    ::setsockopt(ends[1], SOL_SOCKET, SO_SNDBUF, &room, sizeof room);
    adopt(base::FileDescriptor(ends[0]));
    far_end = base::FileDescriptor(ends[1]);
    return {};
  }
  std::string description() const override { return "socket pair"; }

  base::FileDescriptor far_end;
};

}  // namespace soak::hal::imu::test
