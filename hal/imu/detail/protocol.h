// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "base/bytes.h"
#include "base/result.h"
#include "hal/imu/imu.h"

namespace soak::hal::imu {

/// A measurement as a unit sends it.
struct UnitPacket {
  bool stamped = false;         ///< tells the unit's time
  std::uint32_t counter = 0;    ///< as sent; 0 where the unit counts nothing
  std::optional<float> temp_c;  ///< where the packet carries a reading
  bool measured = false;        ///< all six sensors are there
  std::array<float, 3> rate_rps{};
  std::array<float, 3> accel_mps2{};
  std::uint32_t status = 0;
  bool clipped = false;
};

/// What a family of units speaks: frames, the dialogue that makes a unit stream, and its clock. Waits for nothing,
/// reads no clock and touches no transport: StreamImu carries the bytes and keeps the time-outs, so that any protocol
/// runs over any ByteSource.
///
/// Bytes go in by append(); next() then tells message by message what was heard, until there is no more.
class Protocol {
 public:
  /// What a valid message was.
  enum class Heard : std::uint8_t {
    other,    ///< nothing of interest
    answer,   ///< the answer that was waited for: the dialogue has moved on
    packet,   ///< a measurement of a unit that was told what to send: packet()
    wake_up,  ///< the unit has just been switched on
  };

  Protocol() = default;
  Protocol(const Protocol&) = delete;
  Protocol& operator=(const Protocol&) = delete;
  virtual ~Protocol() = default;

  /// For messages to the user: "Xsens MTi".
  [[nodiscard]] virtual std::string name() const = 0;
  /// Fails (bad_input) unless a unit can be asked for these rates.
  [[nodiscard]] virtual base::Status check(const Imu::Settings& settings) const = 0;

  // --- the stream of bytes

  /// Takes what arrived at `now`. `drained`: there was no more at that time.
  virtual void append(std::span<const std::uint8_t> bytes, std::chrono::steady_clock::time_point now, bool drained) = 0;
  /// The next message. Error `device`: the unit reports one, or answers what cannot be worked with.
  [[nodiscard]] virtual base::Result<std::optional<Heard>> next() = 0;
  /// Gives up a frame that has begun but does not end; next() may then find messages behind it. False if none was
  /// pending.
  virtual bool drop_partial() = 0;
  /// Forgets the bytes that are not yet decoded.
  virtual void clear() = 0;
  /// Bytes that belonged to no valid frame.
  [[nodiscard]] virtual std::uint64_t garbage_bytes() const = 0;

  // --- the dialogue

  /// Back to the first request.
  virtual void begin(const Imu::Settings& settings) = 0;
  [[nodiscard]] virtual bool done() const = 0;
  /// The message to send now. Not after done().
  [[nodiscard]] virtual base::Bytes request() = 0;
  /// What the current request is, for messages to the user.
  [[nodiscard]] virtual std::string_view request_name() const = 0;
  /// No byte has come for `quiet`: the end of an answer that nothing else ends. Returns whether the dialogue moved on.
  [[nodiscard]] virtual base::Result<bool> end_answer(std::chrono::steady_clock::duration quiet) = 0;
  /// What is to be sent when the dialogue is done, and is not answered but by the stream.
  [[nodiscard]] virtual base::Bytes start_command() const = 0;
  /// What is to be sent upon a wake-up message before the dialogue begins.
  [[nodiscard]] virtual base::Bytes wake_up_answer() const = 0;
  /// Complete once done().
  [[nodiscard]] virtual const ImuIdentity& identity() const = 0;
  /// The dialogue found a unit idle that an earlier one had told to stream: it has lost its power meanwhile. Always
  /// false where the unit's own time tells as much.
  [[nodiscard]] virtual bool found_idle() const = 0;
  /// Nobody answers (a recording): takes the stream as what was asked for. identity() stays empty.
  virtual void assume_done(const Imu::Settings& settings) = 0;

  // --- measurements and the unit's clock

  /// The measurement that next() has told of; valid until the next call of that.
  [[nodiscard]] virtual const UnitPacket& packet() const = 0;
  /// Brings the clock to packet(), which is stamped. False, and nothing is changed, if its stamp cannot follow the last
  /// one: the unit has restarted.
  [[nodiscard]] virtual bool advance() = 0;
  /// No stamped packet yet since power-on.
  [[nodiscard]] virtual bool clock_empty() const = 0;
  /// Of the last packet, since power-on.
  [[nodiscard]] virtual double time_s() const = 0;
  /// Packets missing between the last two.
  [[nodiscard]] virtual std::uint32_t lost_packets() const = 0;
  /// The next packet is the first one after a power-on.
  virtual void restart_clock() = 0;
  /// The next packet follows an interruption that the station itself has made.
  virtual void interrupt() = 0;

  // --- habits of the family

  /// How long a stream may be silent before the unit is asked again.
  [[nodiscard]] virtual std::chrono::steady_clock::duration silence_limit() const = 0;
  /// The thermometer comes with every packet, whatever rate was asked for.
  [[nodiscard]] virtual bool temp_with_every_packet() const = 0;
};

}  // namespace soak::hal::imu
