// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <variant>
#include <vector>

#include "base/result.h"
#include "hal/sim/lab/device_time.h"
#include "hal/sim/lab/lab.h"
#include "hal/sim/wires/detail/chamber_wire.h"
#include "hal/sim/wires/detail/modbus_server.h"
#include "hal/sim/wires/detail/ports.h"

namespace soak::hal::sim {

/// How the laboratory is reached and how fast its time goes.
struct LabServerOptions {
  double rate = 1.0;             ///< device seconds per second of host time
  std::optional<int> base_port;  ///< absent = any free ports
  std::set<int> pty_slots;       ///< slots (from 1) with a pseudo-terminal instead of a TCP port
  ChamberKind chamber = ChamberKind::f4t;
  LabKinds kinds;
};

/// A TCP port of 127.0.0.1, or the path of a pseudo-terminal.
using UnitAddress = std::variant<int, std::string>;

struct LabAddresses {
  int chamber = 0;           ///< of the F4T, over Modbus TCP: always there
  UnitAddress chamber_wire;  ///< of the controller that the station is to use
  int fixture = 0;
  int relay = 0;
  std::vector<UnitAddress> units;
};

/// The laboratory behind its wires, in one thread. Its clock waits while a reader has not taken all bytes of a unit
/// that streams; commands are answered all the same.
class LabServer {
 public:
  /// Listens. Errors: a port that cannot be had (bad_input), no pseudo-terminal (internal).
  [[nodiscard]] static base::Result<std::unique_ptr<LabServer>> open(const CampaignConfig& config,
                                                                     const LabServerOptions& options);

  [[nodiscard]] LabAddresses addresses() const;
  /// Runs until `stop_fd` becomes readable.
  void run_until_readable(int stop_fd);

 private:
  LabServer(const CampaignConfig& config, const LabServerOptions& options)
      : lab_(config, options.kinds), clock_(options.rate) {}

  [[nodiscard]] base::Status open_servers(const std::optional<int>& base_port);
  [[nodiscard]] base::Status open_wire(const LabServerOptions& options);
  [[nodiscard]] base::Status open_unit_port(std::size_t index, const LabServerOptions& options);
  void advance();
  void hand_on_output();
  [[nodiscard]] bool reader_lags() const;
  [[nodiscard]] bool batch_is_full() const;
  [[nodiscard]] std::int64_t idle_ns() const;

  SimulatedLab lab_;
  LabClock clock_;
  std::unique_ptr<ModbusServer> chamber_;
  std::unique_ptr<ModbusServer> fixture_;
  std::unique_ptr<ModbusServer> relay_;
  std::unique_ptr<ChamberWire> wire_;  ///< null where the F4T over TCP is all
  UnitAddress wire_address_;
  std::vector<std::unique_ptr<UnitPort>> ports_;
  std::vector<UnitAddress> unit_addresses_;
};

}  // namespace soak::hal::sim
