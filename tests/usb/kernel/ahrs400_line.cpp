// SPDX-License-Identifier: Apache-2.0
// ahrs400_line SOCKET: a Crossbow AHRS400 at the end of a serial line, which is a Unix socket: the far end of the FT232
// that QEMU emulates. Streams a packet every 15.5 ms when told to. Ends when the socket does.
#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <cstring>
#include <string>

#include "tests/hal/ahrs400_peer.h"

namespace {

using Clock = std::chrono::steady_clock;
constexpr double kPeriod_s = 0.0155;

int connect_to(const std::string& path) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (path.size() >= sizeof address.sun_path) return -1;
  std::memcpy(address.sun_path, path.c_str(), path.size() + 1);
  const int line = ::socket(AF_UNIX, SOCK_STREAM, 0);
  if (line < 0 || ::connect(line, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) return -1;
  return line;
}

bool send(int line, const soak::hal::imu::test::Bytes& bytes) {
  return bytes.empty() || ::write(line, bytes.data(), bytes.size()) == static_cast<ssize_t>(bytes.size());
}

/// Until the line is cut.
void serve(int line) {
  soak::hal::imu::test::Ahrs400Unit unit;
  auto next = Clock::now();
  const auto period = std::chrono::round<Clock::duration>(std::chrono::duration<double>(kPeriod_s));
  for (;;) {
    pollfd waiting{line, POLLIN, 0};
    if (::poll(&waiting, 1, 2) > 0) {
      soak::hal::imu::test::Bytes heard(256);
      const ssize_t got = ::read(line, heard.data(), heard.size());
      if (got <= 0) return;
      heard.resize(static_cast<std::size_t>(got));
      if (!unit.continuous) next = Clock::now();
      if (!send(line, unit.take(heard))) return;
    }
    for (; unit.continuous && next <= Clock::now(); next += period) {
      if (!send(line, unit.packets(1, kPeriod_s))) return;
    }
  }
}

}  // namespace

int main(int count, char** arguments) {
  const int line = count == 2 ? connect_to(arguments[1]) : -1;
  if (line < 0) {
    std::fputs("usage: ahrs400_line SOCKET (of somebody who listens)\n", stderr);
    return 2;
  }
  serve(line);
  return 0;
}
