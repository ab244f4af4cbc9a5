// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstdint>
#include <thread>
#include <vector>

namespace soak::hal::test {

enum class Fault : std::uint8_t {
  none,
  late,            ///< the answer comes after the client's time-out
  exception,       ///< exception 4
  busy,            ///< exception 6
  acknowledge,     ///< exception 5
  wrong_unit,      ///< the right content under another unit number
  wrong_function,  ///< function code of another request
  truncated,       ///< the answer lacks its last byte
  garbage,         ///< random bytes
  byte_by_byte,    ///< the right answer in single bytes
  reset,           ///< the connection is reset instead of an answer
  silence,         ///< no answer
  stale,           ///< the answer before this one comes again, and then the right one
  twice,           ///< the right answer comes twice
};

/// Stands between a client and a Modbus server on this machine and spoils single answers.
class FaultProxy {
 public:
  enum class Framing : std::uint8_t { tcp, rtu };

  FaultProxy(int server_port, Framing framing, int late_ms);
  FaultProxy(const FaultProxy&) = delete;
  FaultProxy& operator=(const FaultProxy&) = delete;
  ~FaultProxy();

  [[nodiscard]] int port() const { return port_; }
  /// Spoils an answer after `after` good ones, and the `count` - 1 that follow it.
  void spoil(Fault fault, int after = 0, int count = 1);
  /// Clients that have connected so far.
  [[nodiscard]] int connections() const { return connections_; }

 private:
  using Frame = std::vector<std::uint8_t>;

  void run();
  void serve(int client);
  [[nodiscard]] bool relay(int client, int server);
  /// False if the connection shall end.
  [[nodiscard]] bool answer(int client, Fault fault, const Frame& frame);
  /// Appends bytes; false if not all have come.
  [[nodiscard]] bool receive(int from, Frame& frame, std::size_t count) const;
  [[nodiscard]] Frame receive_frame(int from, bool request) const;
  [[nodiscard]] Frame spoiled(Fault fault, Frame frame);
  [[nodiscard]] Fault next_fault();

  Framing framing_;
  int server_port_;
  int late_ms_;
  int listener_ = -1;
  int port_ = 0;
  Frame last_;
  std::atomic<Fault> fault_{Fault::none};
  std::atomic<int> after_{0};
  std::atomic<int> count_{0};
  std::atomic<int> connections_{0};
  std::atomic<bool> stop_{false};
  std::uint32_t random_ = 1;
  std::thread thread_;
};

}  // namespace soak::hal::test
