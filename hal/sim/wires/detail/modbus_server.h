// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "base/result.h"
#include "hal/sim/lab/register_table.h"
#include "hal/sim/wires/detail/ports.h"

// libmodbus' own names, so that its header stays in one source file.
struct _modbus;            // NOLINT(bugprone-reserved-identifier)
struct _modbus_mapping_t;  // NOLINT(bugprone-reserved-identifier)

namespace soak::hal::sim {

/// A Modbus TCP server (libmodbus) for the registers of one device: functions 3, 6 and 16, several clients at once, any
/// unit identifier. It never waits for a client: a client that sends what is no Modbus frame is disconnected.
class ModbusServer {
 public:
  /// `registers` must outlive the server. Errors: those of TcpListener::open().
  [[nodiscard]] static base::Result<std::unique_ptr<ModbusServer>> open(int port, RegisterTable& registers);
  ModbusServer(const ModbusServer&) = delete;
  ModbusServer& operator=(const ModbusServer&) = delete;
  ~ModbusServer();

  [[nodiscard]] int port() const { return listener_.port(); }
  void add_to(PollSet& polls);

 private:
  ModbusServer(TcpListener listener, RegisterTable& registers);

  void accept_client();
  void drop_client(int fd);
  void serve_client(int fd, short events);
  /// Whether the client may stay.
  [[nodiscard]] bool serve_request(int fd, std::size_t frame_size);
  [[nodiscard]] ModbusAnswer carry_out(const std::vector<std::uint8_t>& request);

  TcpListener listener_;
  RegisterTable& registers_;
  struct ContextDeleter {
    void operator()(_modbus* context) const;
  };
  struct MappingDeleter {
    void operator()(_modbus_mapping_t* mapping) const;
  };
  std::unique_ptr<_modbus, ContextDeleter> context_;
  std::unique_ptr<_modbus_mapping_t, MappingDeleter> mapping_;
  std::vector<base::FileDescriptor> clients_;
};

}  // namespace soak::hal::sim
