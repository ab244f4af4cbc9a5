// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <utility>

#include "base/result.h"
#include "hal/sim/lab/register_table.h"
#include "hal/sim/lab/simulated_chamber.h"
#include "hal/sim/wires/detail/ports.h"

namespace soak::hal::sim {

/// Which controller the station meets at the chamber, and over what.
enum class ChamberKind : std::uint8_t {
  f4t,             ///< Watlow F4T over Modbus TCP
  f4t_rtu,         ///< the same over Modbus RTU on a pseudo-terminal
  eurotherm_2400,  ///< Modbus RTU on a pseudo-terminal
  espec_p300       ///< lines of text over TCP
};

/// A second way to the chamber, beside the Modbus TCP server of its F4T: one reader at a time.
class ChamberWire {
 public:
  ChamberWire() = default;
  ChamberWire(const ChamberWire&) = delete;
  ChamberWire& operator=(const ChamberWire&) = delete;
  virtual ~ChamberWire() = default;

  [[nodiscard]] virtual UnitPort& port() = 0;
};

/// A Modbus RTU slave, unit 1, on a raw pseudo-terminal: functions 3, 6 and 16, silence to others. A frame that is
/// damaged or interrupted is dropped.
class RtuWire final : public ChamberWire {
 public:
  [[nodiscard]] static base::Result<std::unique_ptr<RtuWire>> open(RegisterTable registers);

  [[nodiscard]] UnitPort& port() override { return *port_; }
  [[nodiscard]] const std::string& path() const { return port_->path(); }

 private:
  explicit RtuWire(RegisterTable registers) : registers_(std::move(registers)) {}
  void receive(std::span<const std::uint8_t> bytes);
  void answer(std::span<const std::uint8_t> request);

  RegisterTable registers_;
  base::Bytes received_;
  std::int64_t last_byte_ns_ = 0;
  std::unique_ptr<PtyUnitPort> port_;
};

/// Lines that end in CR LF over TCP, answered by espec_answer(). `chamber` must outlive it.
class TextWire final : public ChamberWire {
 public:
  [[nodiscard]] static base::Result<std::unique_ptr<TextWire>> open(int tcp_port, SimulatedChamber& chamber);

  [[nodiscard]] UnitPort& port() override { return *port_; }
  [[nodiscard]] int tcp_port() const { return port_->port(); }

 private:
  explicit TextWire(SimulatedChamber& chamber) : chamber_(chamber) {}
  void receive(std::span<const std::uint8_t> bytes);

  SimulatedChamber& chamber_;
  std::string received_;
  std::unique_ptr<TcpUnitPort> port_;
};

/// CRC-16 of Modbus RTU (polynomial A001 reflected, start FFFF), low byte first on the wire.
[[nodiscard]] std::uint16_t rtu_crc(std::span<const std::uint8_t> bytes);

/// The registers of a Eurotherm 2400 that controls the chamber (the maker's handbook HA026230): parameter n as an
/// integer of one decimal in register n, and as a float, high word first, in 32768 + 2 n. Reading what is not there
/// gives an arbitrary number, writing it succeeds. `chamber` must outlive them.
[[nodiscard]] RegisterTable eurotherm_registers(SimulatedChamber& chamber);

/// The answer of an ESPEC P300 that controls the chamber to a line, both without their ends: TEMP?, MODE?, ALARM?,
/// MON?, "TEMP, S25.0", "MODE,CONSTANT", "MODE,STANDBY"; "NA:..." to anything else.
[[nodiscard]] std::string espec_answer(SimulatedChamber& chamber, std::string_view line);

}  // namespace soak::hal::sim
