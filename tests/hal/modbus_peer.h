// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/types.h>

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "hal/maps/device_map.h"

/// Modbus peers that are not ours, as processes.
namespace soak::hal::test {

/// A process that ends when this object does: its standard input closes, then it is told to end.
class Process {
 public:
  /// Runs a program with its standard output (or nothing) readable.
  explicit Process(const std::vector<std::string>& command);
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;
  ~Process();

  /// The next line of its standard output; nothing at its end.
  [[nodiscard]] std::optional<std::string> line();
  /// Writes a line to its standard input.
  void tell(const std::string& line) const;
  /// Exit status, after its standard output ended.
  [[nodiscard]] int wait();

 private:
  pid_t pid_ = -1;
  int input_ = -1;
  int output_ = -1;
};

/// pymodbus_server.py with given registers; its file says what specs are.
class PymodbusServer {
 public:
  /// Nothing if pymodbus is not installed. Port 0 = any.
  [[nodiscard]] static std::unique_ptr<PymodbusServer> start(const std::string& framing,
                                                             const std::vector<std::string>& specs, int port = 0);
  [[nodiscard]] int port() const { return port_; }
  /// A port with Modbus TCP frames for the same registers, whatever the framing.
  [[nodiscard]] int look_port() const { return look_port_; }
  /// Requests that wrote, asked for with mbpoll.
  [[nodiscard]] int writes() const;

 private:
  explicit PymodbusServer(std::vector<std::string> command) : process_(command) {}
  Process process_;
  int port_ = 0;
  int look_port_ = 0;
};

/// A pseudo-terminal that socat joins to a TCP port of this machine. Destroying it is pulling the adapter.
class SerialLine {
 public:
  explicit SerialLine(int port);
  /// The device that a driver opens: the same for every line to that port.
  [[nodiscard]] const std::string& path() const { return path_; }

 private:
  std::string path_;
  Process socat_;
};

[[nodiscard]] bool have_program(const std::string& name);

/// What mbpoll reads: type as in its -t ("4", "4:float"; the latter low word first).
[[nodiscard]] std::string mbpoll_read(int port, int address, const std::string& type);
[[nodiscard]] bool mbpoll_write(int port, int address, const std::string& type, const std::string& value);

/// A map file of this repository ("chambers/watlow-f4t.toml"), its link set to a local port with short time-outs.
[[nodiscard]] DeviceMap repository_map(const std::string& path, int port);
[[nodiscard]] DeviceMap parsed_map(const std::string& text);

/// Registers of an idle F4T chamber with the air at 23.25 °C.
[[nodiscard]] std::vector<std::string> f4t_registers();

}  // namespace soak::hal::test

/// Skips the test where socat is not installed.
#define SOAK_NEED_SOCAT() \
  if (!test::have_program("socat")) GTEST_SKIP() << "skipped: socat is not installed"

/// Skips the test where a peer is not installed.
#define SOAK_START_PYMODBUS(server, framing, ...)                        \
  const auto server = test::PymodbusServer::start(framing, __VA_ARGS__); \
  if (!server) GTEST_SKIP() << "skipped: python3-pymodbus is not installed"
