// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <utility>

#include "base/result.h"
#include "hal/devices/chamber.h"
#include "station/config/procedure.h"

/// A second pair of eyes on the chamber: a thread of its own with a connection of its own, which an engine that is busy
/// or blocked (a slow device, a full disk, a locked catalog) cannot delay. It can do one thing: switch heating and
/// cooling off.
namespace soak::station {

/// What a chamber that carries out a campaign may do. Air temperatures; times are host time.
struct WatchLimits {
  double lowest_c = -150.0;
  double highest_c = 400.0;
  double fastest_kpmin = 40.0;  ///< twice what the quickest chambers for units do, of process time
  /// For how long a controller may answer with readings that nobody can believe; the time for which it is silent in
  /// between does not count.
  std::chrono::milliseconds longest_unreadable{60'000};
  /// For how long the engine may not turn: shorter than the service's watchdog, which kills soakd.
  std::chrono::milliseconds longest_engine_silence{480'000};

  bool operator==(const WatchLimits&) const = default;
};

/// Limits for a procedure: 10 K beyond its coldest and hottest set point and the safe temperature (safe_temp_c()). The
/// ratings of the units lie farther out: a procedure that leaves them is refused.
[[nodiscard]] WatchLimits watch_limits(const Procedure& procedure, double dew_point_c);

/// Judges the readings of a chamber; knows no device and no clock. Trips:
/// - the air is beyond its limits in two readings in a row. Until it has once been within them (somebody left the
/// chamber
///   hot), 10 K beyond the first reading is the limit where that is farther out;
/// - the air moves faster than `fastest_kpmin` over a minute, seen three times;
/// - an alarm with `outputs_off` in two readings in a row.
class WatchJudge {
 public:
  explicit WatchJudge(const WatchLimits& limits) : limits_(limits) {}

  /// Why heating and cooling must be switched off; nothing where all is well. `now_s`: process time.
  [[nodiscard]] std::optional<std::string> look(double now_s, const hal::ChamberReading& reading);
  /// Whether the last reading was the first of those that would trip: the next one must not wait.
  [[nodiscard]] bool suspects() const { return outside_ == 1 || alarmed_ == 1; }

 private:
  [[nodiscard]] bool is_outside(double air_c);
  [[nodiscard]] double rate_kpmin(double now_s, double air_c);

  WatchLimits limits_;
  std::optional<double> first_c_;
  bool was_within_ = false;
  std::deque<std::pair<double, double>> airs_;  ///< process time and °C, of a little more than the last minute
  int outside_ = 0;                             ///< readings in a row
  int fast_ = 0;
  int alarmed_ = 0;
};

/// What a watch has found.
struct WatchVerdict {
  bool armed = false;
  std::string tripped;                         ///< why heating and cooling are switched off; empty = all is well
  bool is_off = false;                         ///< after a trip: the controller has taken the command
  std::string trouble;                         ///< why the last reading failed; empty after one that did not
  bool blind = false;                          ///< for a minute and more it has had no reading
  std::optional<hal::ChamberReading> reading;  ///< the last one, however old
  std::optional<double> age_s;                 ///< of it, host time
};

/// The watch. It is armed while a campaign drives the chamber, and has no connection otherwise. Once it has tripped it
/// switches heating and cooling off, and off again whenever a reading says that they are on, until it is disarmed. A
/// chamber that it cannot reach it goes on trying to reach; that alone is no reason to trip, since nothing could
/// follow. All functions may be called from any thread and return at once; the destructor waits for the call that is
/// under way.
class ChamberWatch {
 public:
  using MakeChamber = std::function<base::Result<std::unique_ptr<hal::Chamber>>()>;
  /// `outputs_off`: by what was read of air and alarms, so that the chamber must not be driven even to be made safe.
  using Tripped = std::function<void(bool outputs_off)>;

  /// Null where the chamber's controller is not to be asked over a second connection (a serial line has one master; a
  /// map may say so by `second_connection`).
  [[nodiscard]] static std::unique_ptr<ChamberWatch> make(
      const hal::DeviceMap& map, double clock_rate, Tripped tripped = [](bool) {});

  /// `make`: called on the watch's own thread whenever it is armed. `poll_s`: process time between readings;
  /// `clock_rate`: process time per host time. `tripped`: called on that thread before heating and cooling are switched
  /// off, perhaps more than once.
  ChamberWatch(MakeChamber make, double poll_s, double clock_rate, Tripped tripped = [](bool) {});
  ChamberWatch(const ChamberWatch&) = delete;
  ChamberWatch& operator=(const ChamberWatch&) = delete;
  ~ChamberWatch();

  /// Watches from now on. Where it is armed already it only takes other limits.
  void arm(const WatchLimits& limits);
  /// Stops watching and forgets a trip.
  void disarm();
  /// The engine turns.
  void note_engine();
  /// Switches heating and cooling off now, for this reason. Nothing while it is not armed.
  void stop_now(std::string reason);
  [[nodiscard]] WatchVerdict verdict() const;

 private:
  using Clock = std::chrono::steady_clock;

  void run();
  /// Reads, judges, switches off where it must: without the lock held, but for what it notes. `arming`: that it belongs
  /// to, begun at `begun`.
  void turn(hal::Chamber& chamber, WatchJudge& judge, std::uint64_t arming, Clock::time_point begun);
  void switch_off(hal::Chamber& chamber, std::uint64_t arming);
  void note_reading(const base::Result<hal::ChamberReading>& reading, bool answers);
  void trip(std::string reason);
  [[nodiscard]] Clock::duration pause(const WatchJudge& judge) const;

  MakeChamber make_;
  double poll_s_;
  double clock_rate_;
  Tripped tripped_;

  mutable std::mutex mutex_;
  std::condition_variable wake_;
  bool ended_ = false;
  bool hurry_ = false;
  std::uint64_t arming_ = 0;  ///< counts arm(), disarm() and new limits: the thread begins anew
  WatchLimits limits_;
  WatchVerdict verdict_;
  Clock::time_point armed_{};
  Clock::time_point heard_{};       ///< a reading
  Clock::time_point looked_{};      ///< the last try, whatever came of it
  Clock::duration unbelievable_{};  ///< for which the controller has answered, and nothing credible; silence pauses it
  Clock::time_point engine_{};
  std::thread thread_;  ///< last: it uses all of the above
};

}  // namespace soak::station
