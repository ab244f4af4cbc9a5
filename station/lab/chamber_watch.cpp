// SPDX-License-Identifier: Apache-2.0
#include "station/lab/chamber_watch.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <exception>

#include "station/lab/dew_safe_warm_up.h"

namespace soak::station {
namespace {

using namespace std::chrono_literals;

constexpr double kAirMargin_c = 10.0;  ///< overshoot of a controller, and what the units' ratings leave
constexpr double kAirRateWindow_s = 60.0;
constexpr int kOutsideLooks = 2;
constexpr int kFastLooks = 3;
constexpr int kAlarmLooks = 2;
constexpr std::chrono::milliseconds kShortestPause{50};  ///< of the host: a fast clock must not flood the controller
constexpr std::chrono::seconds kBlind{60};
constexpr std::chrono::milliseconds kStopPause{500};  ///< between two commands to switch off

}  // namespace

WatchLimits watch_limits(const Procedure& procedure, double dew_point_c) {
  WatchLimits limits;
  if (procedure.set_points_c.empty()) return limits;  // what a predecessor's campaign needs is not known any more
  const double safe_c = safe_temp_c(procedure.end_c, dew_point_c);
  limits.lowest_c = limits.highest_c = safe_c;
  for (const double set_point_c : procedure.set_points_c) {
    limits.lowest_c = std::min(limits.lowest_c, set_point_c);
    limits.highest_c = std::max(limits.highest_c, set_point_c);
  }
  limits.lowest_c -= kAirMargin_c;
  limits.highest_c += kAirMargin_c;
  return limits;
}

// --- WatchJudge -------------------------------------------------------------------------------------------------

bool WatchJudge::is_outside(double air_c) {
  if (!first_c_) first_c_ = air_c;
  was_within_ = was_within_ || (air_c >= limits_.lowest_c && air_c <= limits_.highest_c);
  const double lowest_c = was_within_ ? limits_.lowest_c : std::min(limits_.lowest_c, *first_c_ - kAirMargin_c);
  const double highest_c = was_within_ ? limits_.highest_c : std::max(limits_.highest_c, *first_c_ + kAirMargin_c);
  return air_c < lowest_c || air_c > highest_c;
}

double WatchJudge::rate_kpmin(double now_s, double air_c) {
  airs_.emplace_back(now_s, air_c);
  while (airs_.size() > 2 && now_s - airs_[1].first >= kAirRateWindow_s) airs_.pop_front();
  const auto rate_since = [&](const std::pair<double, double>& past) {
    return 60.0 * (air_c - past.second) / (now_s - past.first);
  };
  if (airs_.size() < 3 || now_s - airs_.front().first < kAirRateWindow_s) return 0.0;
  // The smaller of two: one wrong number at the beginning of the window is no movement.
  const double since_oldest = rate_since(airs_[0]);
  const double since_next = rate_since(airs_[1]);
  return std::abs(since_oldest) < std::abs(since_next) ? since_oldest : since_next;
}

std::optional<std::string> WatchJudge::look(double now_s, const hal::ChamberReading& reading) {
  outside_ = is_outside(reading.air_c) ? outside_ + 1 : 0;
  const double rate = rate_kpmin(now_s, reading.air_c);
  fast_ = std::abs(rate) > limits_.fastest_kpmin ? fast_ + 1 : 0;
  const auto alarm = std::ranges::find_if(reading.alarms, &hal::ChamberAlarm::outputs_off);
  alarmed_ = alarm != reading.alarms.end() ? alarmed_ + 1 : 0;

  if (outside_ >= kOutsideLooks) {
    return fmt::format("the chamber's air is at {:+.1f} °C; this campaign needs {:+.1f} to {:+.1f} °C", reading.air_c,
                       limits_.lowest_c, limits_.highest_c);
  }
  if (fast_ >= kFastLooks) {
    return fmt::format("the chamber's air moves by {:+.0f} K/min (now {:+.1f} °C)", rate, reading.air_c);
  }
  if (alarmed_ >= kAlarmLooks) return "the chamber reports an alarm: " + alarm->name;
  return std::nullopt;
}

// --- ChamberWatch -----------------------------------------------------------------------------------------------

std::unique_ptr<ChamberWatch> ChamberWatch::make(const hal::DeviceMap& map, double clock_rate, Tripped tripped) {
  if (!map.link.second_connection || hal::link_kind(map) != hal::LinkKind::tcp) return nullptr;
  return std::make_unique<ChamberWatch>([map] { return hal::make_chamber(map); }, map.link.poll_s, clock_rate,
                                        std::move(tripped));
}

ChamberWatch::ChamberWatch(MakeChamber make, double poll_s, double clock_rate, Tripped tripped)
    : make_(std::move(make)), poll_s_(poll_s), clock_rate_(clock_rate), tripped_(std::move(tripped)), thread_([this] {
        run();
      }) {}

ChamberWatch::~ChamberWatch() {
  {
    const std::lock_guard lock(mutex_);
    ended_ = true;
  }
  wake_.notify_all();
  thread_.join();
}

void ChamberWatch::arm(const WatchLimits& limits) {
  const std::lock_guard lock(mutex_);
  if (verdict_.armed && limits == limits_) return;
  if (!verdict_.armed) {
    verdict_ = {};
    verdict_.armed = true;
    armed_ = looked_ = engine_ = Clock::now();
    unbelievable_ = {};
  }
  limits_ = limits;
  ++arming_;
  wake_.notify_all();
}

void ChamberWatch::disarm() {
  const std::lock_guard lock(mutex_);
  if (!verdict_.armed) return;
  verdict_ = {};
  ++arming_;
  wake_.notify_all();
}

void ChamberWatch::note_engine() {
  const std::lock_guard lock(mutex_);
  engine_ = Clock::now();
}

void ChamberWatch::stop_now(std::string reason) {
  const std::lock_guard lock(mutex_);
  if (!verdict_.armed) return;
  if (verdict_.tripped.empty()) verdict_.tripped = std::move(reason);
  hurry_ = true;
  wake_.notify_all();
}

WatchVerdict ChamberWatch::verdict() const {
  const std::lock_guard lock(mutex_);
  WatchVerdict verdict = verdict_;
  const auto now = Clock::now();
  if (verdict.reading) verdict.age_s = std::chrono::duration<double>(now - heard_).count();
  verdict.blind = verdict.armed && now - std::max(heard_, armed_) > kBlind;
  return verdict;
}

void ChamberWatch::run() {
  std::unique_lock lock(mutex_);
  while (!ended_) {
    wake_.wait(lock, [this] { return ended_ || verdict_.armed; });
    if (ended_) return;
    const std::uint64_t arming = arming_;
    const auto begun = Clock::now();
    WatchJudge judge(limits_);
    lock.unlock();
    // Made anew each time: a connection that nobody needs is not kept from others.
    const auto chamber = make_();
    lock.lock();
    if (!chamber) verdict_.trouble = chamber.error().message;
    while (chamber && !ended_ && arming == arming_) {
      hurry_ = false;
      lock.unlock();
      std::string thrown;
      try {
        turn(**chamber, judge, arming, begun);
      } catch (const std::exception& what) {  // no memory: the next turn may have some
        thrown = what.what();
      }
      lock.lock();
      if (!thrown.empty()) verdict_.trouble = thrown;
      wake_.wait_for(lock, pause(judge), [&] { return ended_ || hurry_ || arming != arming_; });
    }
    if (!chamber) wake_.wait(lock, [&] { return ended_ || arming != arming_; });
  }
}

ChamberWatch::Clock::duration ChamberWatch::pause(const WatchJudge& judge) const {
  if (judge.suspects()) return kShortestPause;
  const std::chrono::duration<double> poll{poll_s_ / clock_rate_};
  const auto usual = std::max<Clock::duration>(std::chrono::duration_cast<Clock::duration>(poll), kShortestPause);
  return verdict_.tripped.empty() || verdict_.is_off ? usual : std::min<Clock::duration>(usual, kStopPause);
}

void ChamberWatch::turn(hal::Chamber& chamber, WatchJudge& judge, std::uint64_t arming, Clock::time_point begun) {
  const auto reading = chamber.read();
  std::optional<std::string> why;
  if (reading) {
    const std::chrono::duration<double> host = Clock::now() - begun;
    why = judge.look(host.count() * clock_rate_, *reading);
  }
  bool must_stop = false;
  {
    const std::lock_guard lock(mutex_);
    if (arming != arming_) return;
    note_reading(reading, chamber.answers());
    if (why) trip(*why);
    must_stop = !verdict_.tripped.empty() && !verdict_.is_off;
  }
  if (!must_stop) return;
  tripped_(why.has_value());
  switch_off(chamber, arming);
}

void ChamberWatch::note_reading(const base::Result<hal::ChamberReading>& reading, bool answers) {
  const auto now = Clock::now();
  if (reading) {
    verdict_.reading = *reading;
    heard_ = now;
    if (reading->running) verdict_.is_off = false;
  }
  verdict_.trouble = reading ? "" : reading.error().message;
  if (reading) unbelievable_ = {};
  if (!reading && answers) unbelievable_ += now - looked_;
  looked_ = now;
  if (unbelievable_ > limits_.longest_unreadable) {
    trip("the chamber's readings have been impossible for a minute: " + verdict_.trouble);
  }
  if (now - engine_ > limits_.longest_engine_silence) trip("soakd itself has not turned for minutes");
}

void ChamberWatch::trip(std::string reason) {
  if (!verdict_.armed || !verdict_.tripped.empty()) return;
  verdict_.tripped = std::move(reason);
}

void ChamberWatch::switch_off(hal::Chamber& chamber, std::uint64_t arming) {
  const auto off = chamber.stop();
  const std::lock_guard lock(mutex_);
  if (arming != arming_) return;
  verdict_.is_off = off.has_value();
  if (!off) verdict_.trouble = off.error().message;
}

}  // namespace soak::station
