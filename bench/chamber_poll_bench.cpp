// SPDX-License-Identifier: Apache-2.0
// What a reading of the chamber costs on the bus over TCP: the driver with the shipped map of the F4T before the
// simulated laboratory in another process, against bare requests (socket, send, receive; no library) to the same server
// in the same run. A chamber is read once a second: 20 ms of bus time per reading are the limit.
#include <arpa/inet.h>
#include <fmt/format.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <functional>
#include <string>
#include <vector>

#include "hal/devices/chamber.h"
#include "hal/maps/device_map.h"
#include "hal/sim/config/campaign_config.h"
#include "hal/sim/wires/lab_server.h"

namespace soak {
namespace {

constexpr double kLimit_ms = 20.0;
constexpr int kReadings = 500;

/// Ends the program where a result is an error.
template <class T>
T must(base::Result<T> result) {
  if (result) return *std::move(result);
  fmt::print(stderr, "{}: {}\n", result.error().where, result.error().message);
  std::exit(1);
}

/// The simulated laboratory in a process of its own, ended with the object.
class Laboratory {
 public:
  Laboratory() {
    std::array<int, 2> announce{};
    if (::pipe(announce.data()) != 0 || ::pipe(stop_.data()) != 0) std::exit(1);
    child_ = ::fork();
    if (child_ == 0) serve(announce[1]);
    if (::read(announce[0], &port_, sizeof port_) != sizeof port_) std::exit(1);
  }
  Laboratory(const Laboratory&) = delete;
  Laboratory& operator=(const Laboratory&) = delete;
  ~Laboratory() {
    ::close(stop_[1]);
    ::waitpid(child_, nullptr, 0);
  }
  [[nodiscard]] int port() const { return port_; }

 private:
  [[noreturn]] void serve(int announce) {
    ::close(stop_[1]);
    auto config = must(hal::sim::read_campaign_config(SOAK_SIM_LAB_TOML));
    config.units = 1;
    const auto server = must(hal::sim::LabServer::open(config, {}));
    const int port = server->addresses().chamber;
    if (::write(announce, &port, sizeof port) != sizeof port) ::_exit(1);
    server->run_until_readable(stop_[0]);
    ::_exit(0);
  }

  std::array<int, 2> stop_{};
  pid_t child_ = -1;
  int port_ = 0;
};

/// Bare Modbus TCP requests over a socket.
class BareClient {
 public:
  explicit BareClient(int port) : socket_(::socket(AF_INET, SOCK_STREAM, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(static_cast<std::uint16_t>(port));
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    const int on = 1;
    ::setsockopt(socket_, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
    if (::connect(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) std::exit(1);
  }
  BareClient(const BareClient&) = delete;
  BareClient& operator=(const BareClient&) = delete;
  ~BareClient() { ::close(socket_); }

  void read_registers(int address, int count) {
    const std::array<std::uint8_t, 12> request = {0, 1, 0, 0, 0, 6, 1, 3, high(address), low(address), 0, low(count)};
    std::array<std::uint8_t, 260> answer;
    const std::size_t size = 9U + 2U * static_cast<std::size_t>(count);
    const bool done = ::send(socket_, request.data(), request.size(), 0) == static_cast<ssize_t>(request.size()) &&
                      ::recv(socket_, answer.data(), size, MSG_WAITALL) == static_cast<ssize_t>(size) && answer[7] == 3;
    if (!done) std::exit(1);
  }

 private:
  static std::uint8_t high(int number) { return static_cast<std::uint8_t>(number >> 8); }
  static std::uint8_t low(int number) { return static_cast<std::uint8_t>(number & 0xFF); }
  int socket_;
};

struct Spread {
  double median_ms;
  double p99_ms;
};

Spread measure(const std::function<void()>& once) {
  std::vector<double> times_ms;
  for (int i = 0; i < kReadings; ++i) {
    const auto start = std::chrono::steady_clock::now();
    once();
    times_ms.push_back(std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count());
  }
  std::sort(times_ms.begin(), times_ms.end());
  return {times_ms[kReadings / 2], times_ms[kReadings * 99 / 100]};
}

int run() {
  const Laboratory laboratory;
  auto map = must(hal::read_device_map(SOAK_PROCEDURES "/chambers/watlow-f4t.toml"));
  map.link.address = hal::TcpAddress{"127.0.0.1", laboratory.port()};
  const auto chamber = must(hal::make_chamber(map));
  if (!chamber->connect()) return 1;
  const Spread driver = measure([&] { (void)must(chamber->read()); });
  BareClient bare(laboratory.port());
  const Spread request = measure([&] { bare.read_registers(2810, 2); });
  // What the driver asks for at each reading: the laboratory refuses blocks over registers that it does not have.
  const Spread same = measure([&] {
    bare.read_registers(2782, 2);
    bare.read_registers(2808, 4);
    bare.read_registers(2814, 1);
    bare.read_registers(2820, 2);
    for (int alarm = 0; alarm < 6; ++alarm) bare.read_registers(1356 + 100 * alarm, 1);
    for (const int limit : {11250, 11264, 11288}) bare.read_registers(limit, 1);
  });
  fmt::print(
      "chamber reading over TCP        median {:.3f} ms, 99 % {:.3f} ms: median {:.1f} % of the limit of {:g} ms\n",
      driver.median_ms, driver.p99_ms, 100.0 * driver.median_ms / kLimit_ms, kLimit_ms);
  fmt::print("one bare request                median {:.3f} ms, 99 % {:.3f} ms\n", request.median_ms, request.p99_ms);
  fmt::print("the same registers, bare        median {:.3f} ms, 99 % {:.3f} ms: the driver takes {:.2f} times that\n",
             same.median_ms, same.p99_ms, driver.median_ms / same.median_ms);
  // A busy machine takes the processor from either side now and then: that is not bus time, and the bare requests show
  // it.
  return driver.median_ms <= kLimit_ms ? 0 : 1;
}

}  // namespace
}  // namespace soak

int main() { return soak::run(); }
