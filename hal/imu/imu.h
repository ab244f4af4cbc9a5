// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "hal/links/addresses.h"

namespace soak::hal {

/// One packet of a unit's stream, in the unit's own numbers.
struct ImuSample {
  double t_s = 0.0;            ///< device time since power-on, unwrapped
  std::uint32_t power_on = 0;  ///< counts the restarts that were noticed, from 0: time starts from 0 with each
  std::uint32_t packet = 0;    ///< the unit's own counter as sent
  std::uint32_t lost = 0;      ///< packets that were lost since the sample before, by the unit's own counter
  std::array<float, 3> rate_rps{};
  std::array<float, 3> accel_mps2{};
  std::optional<float> temp_c;  ///< only where the packet carries a new reading of the thermometer
  std::uint32_t status = 0;     ///< status word as sent
  bool clipped = false;         ///< the unit says that a sensor was at its rail
};

/// Who the unit says it is.
struct ImuIdentity {
  std::string serial;
  std::string product;
  std::string firmware;
  bool simulated = false;  ///< the unit says that it is not a physical one

  bool operator==(const ImuIdentity&) const = default;
};

/// What became of the bytes so far.
struct ImuStatistics {
  std::uint64_t packets = 0;        ///< samples decoded
  std::uint64_t lost_packets = 0;   ///< by the unit's own counter
  std::uint64_t garbage_bytes = 0;  ///< bytes that belonged to no valid frame
  std::uint32_t restarts = 0;
};

enum class ImuState : std::uint8_t {
  closed,       ///< no transport
  silent,       ///< transport open, nothing heard (power off?)
  configuring,  ///< being identified and told what to send
  streaming,
  failed,  ///< the transport broke; open() again
};

/// Imu::poll() reads so many at most.
inline constexpr std::size_t kBytesPerPoll = 65536;

/// A unit behind a byte stream. Only open() may wait, for 1 s at most (and for the resolver where a host is a name):
/// poll() takes what has arrived. A unit that restarts is noticed (wake-up message, device time or counter that begins
/// anew), identified and configured again.
class Imu {
 public:
  /// What the unit is asked to send.
  struct Settings {
    double rate_hz = 100.0;
    double temp_rate_hz = 10.0;
  };

  Imu() = default;
  Imu(const Imu&) = delete;
  Imu& operator=(const Imu&) = delete;
  virtual ~Imu() = default;

  /// Opens the transport (fails as `device` if it cannot) and begins to ask for the unit.
  [[nodiscard]] virtual base::Status open(const Settings& settings) = 0;
  virtual void close() = 0;
  /// Moves on: reads what has arrived, at most kBytesPerPoll, appends its samples, sends what is to be sent. A
  /// transport that broke is an error of kind `device`.
  [[nodiscard]] virtual base::Status poll(std::vector<ImuSample>& samples) = 0;
  [[nodiscard]] virtual ImuState state() const = 0;
  /// Known from `streaming` on; stays until the next one is read.
  [[nodiscard]] virtual const std::optional<ImuIdentity>& identity() const = 0;
  [[nodiscard]] virtual const ImuStatistics& statistics() const = 0;
  /// Becomes readable when poll() has something to do; -1 while there is no transport.
  [[nodiscard]] virtual int wait_fd() const = 0;
  [[nodiscard]] virtual std::string description() const = 0;
};

/// What a unit speaks.
enum class UnitDecoder : std::uint8_t { xsens, ahrs400, vectornav };

/// Nominal ranges of a Crossbow AHRS400, from its label: the scale of its numbers.
struct Ahrs400Ranges {
  double rate_dps = 0.0;
  double accel_g = 0.0;
};

struct UnitLink {
  UnitAddress address;
  UnitDecoder decoder = UnitDecoder::xsens;
  Ahrs400Ranges ranges = {};  ///< for ahrs400 only
};

/// Any decoder over any address.
[[nodiscard]] std::unique_ptr<Imu> make_imu(const UnitLink& link);

}  // namespace soak::hal
