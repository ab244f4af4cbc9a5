// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/lab/lab_fixture.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <utility>

#include "base/units.h"

namespace soak::hal::sim {
namespace {

using calib::Vector3;

// ---- Six positions

constexpr int kPositionRequest = 0;
constexpr int kPositionActual = 1;
constexpr int kSixStatus = 2;
constexpr int kSixIdentification = 32;
constexpr int kSixIdentity = 0x5046;
constexpr int kFirstPosition = 5;
constexpr int kPositions = 6;

calib::Position numbered(int number) {
  return *calib::position_named(calib::kSixPositionLabels[static_cast<std::size_t>(number - 1)]);
}

double angle_between(const calib::Vector3& a, const calib::Vector3& b) { return std::acos(dot(a, b)); }

/// Six positions, numbered 1 ... 6 in the order of calib::kSixPositionLabels. A request that
/// comes while it turns is begun when the turn has ended; only the last one counts. It starts in position 5, +Z.
class SixPositionFixture final : public LabFixture {
 public:
  SixPositionFixture(double turn_s_per_rad, const std::optional<EarthFrame>& earth);

  void advance_to(Tick now) override;
  [[nodiscard]] Attitude attitude() const override;
  [[nodiscard]] RegisterTable& registers() override { return registers_; }

 private:
  [[nodiscard]] bool moves() const { return turn_end_ > now_; }
  void begin_turn();

  double turn_s_per_rad_;
  std::optional<EarthFrame> earth_;
  Tick now_ = 0;
  int requested_;
  int from_;
  int position_;  ///< where it stands or turns to
  Tick turn_start_ = 0;
  Tick turn_end_ = 0;
  RegisterTable registers_;
};

SixPositionFixture::SixPositionFixture(double turn_s_per_rad, const std::optional<EarthFrame>& earth)
    : turn_s_per_rad_(turn_s_per_rad),
      earth_(earth),
      requested_(kFirstPosition),
      from_(kFirstPosition),
      position_(kFirstPosition) {
  registers_.add_number(kPositionRequest, 1, [this] { return requested_; },
                        {[](int number) { return number >= 1 && number <= kPositions; },
                         [this](int number) {
                           requested_ = number;
                           begin_turn();
                         }});
  registers_.add_number(kPositionActual, 1, [this] { return moves() ? 0 : position_; });
  registers_.add_number(kSixStatus, 1, [this] { return moves() ? 1 : 0; });
  registers_.add_number(kSixIdentification, 1, [] { return kSixIdentity; });
}

void SixPositionFixture::begin_turn() {
  if (moves() || requested_ == position_) return;
  from_ = position_;
  position_ = requested_;
  turn_start_ = now_;
  turn_end_ = now_ + ticks_of(turn_s_per_rad_ * angle_between(numbered(from_).up, numbered(position_).up));
}

void SixPositionFixture::advance_to(Tick now) {
  now_ = now;
  begin_turn();
}

Attitude SixPositionFixture::attitude() const {
  if (!moves()) return resting(numbered(position_), earth_);
  const auto ticks = static_cast<double>(turn_end_ - turn_start_);
  return turning(numbered(from_), numbered(position_), static_cast<double>(now_ - turn_start_) / ticks,
                 ticks / static_cast<double>(kTicksPerSecond));
}

// ---- Two axes

constexpr double kAcceleration_dps2 = 50.0;

/// One axis of a fixture: goes to an angle at a constant speed, or turns at a rate that it reaches at a constant
/// acceleration. A function of the commands and their times: however time is divided, it stands where it stands.
class TurningAxis {
 public:
  explicit TurningAxis(double speed_dps) : speed_dps_(speed_dps) {}

  /// From where it stands, which counts as `from_deg`, on a straight way.
  void go_to(double from_deg, double angle_deg, Tick now);
  void turn_at(double rate_dps, Tick now);

  /// Turns are counted: 370° is one turn and 10°.
  [[nodiscard]] double angle_deg(Tick now) const;
  [[nodiscard]] double rate_dps(Tick now) const;
  /// Has come to the angle or to the rate.
  [[nodiscard]] bool settled(Tick now) const;

 private:
  [[nodiscard]] double since_s(Tick now) const;

  double speed_dps_;
  Tick start_ = 0;
  double start_deg_ = 0.0;
  double start_dps_ = 0.0;
  double change_s_ = 0.0;  ///< until the rate is reached
  double dps_ = 0.0;       ///< from then on
  double end_s_ = 0.0;     ///< of the way to an angle; turning at a rate has none
  double end_deg_ = 0.0;
  bool ends_ = true;
};

double TurningAxis::since_s(Tick now) const {
  return static_cast<double>(now - start_) / static_cast<double>(kTicksPerSecond);
}

void TurningAxis::go_to(double from_deg, double angle_deg, Tick now) {
  start_ = now;
  start_deg_ = from_deg;
  end_deg_ = angle_deg;
  dps_ = start_dps_ = std::copysign(speed_dps_, angle_deg - from_deg);
  change_s_ = 0.0;
  end_s_ = std::abs(angle_deg - from_deg) / speed_dps_;
  ends_ = true;
}

void TurningAxis::turn_at(double rate_dps, Tick now) {
  const double from_deg = angle_deg(now);
  const double from_dps = this->rate_dps(now);
  start_ = now;
  start_deg_ = from_deg;
  start_dps_ = from_dps;
  dps_ = rate_dps;
  change_s_ = std::abs(rate_dps - from_dps) / kAcceleration_dps2;
  ends_ = false;
}

double TurningAxis::angle_deg(Tick now) const {
  const double t_s = since_s(now);
  if (ends_) return t_s < end_s_ ? start_deg_ + dps_ * t_s : end_deg_;
  const double changing_s = std::min(t_s, change_s_);
  const double mean_dps = 0.5 * (start_dps_ + rate_dps(now));
  return start_deg_ + mean_dps * changing_s + dps_ * (t_s - changing_s);
}

double TurningAxis::rate_dps(Tick now) const {
  const double t_s = since_s(now);
  if (ends_) return t_s < end_s_ ? dps_ : 0.0;
  return t_s < change_s_ ? start_dps_ + (dps_ - start_dps_) * t_s / change_s_ : dps_;
}

bool TurningAxis::settled(Tick now) const { return since_s(now) >= (ends_ ? end_s_ : change_s_); }

constexpr int kOuterRequest = 0;
constexpr int kInnerRequest = 2;
constexpr int kRateRequest = 4;
constexpr int kCommand = 6;
constexpr int kOuterAngle = 10;
constexpr int kInnerAngle = 12;
constexpr int kRate = 14;
constexpr int kTwoAxisStatus = 16;
constexpr int kTwoAxisIdentification = 32;
constexpr int kTwoAxisIdentity = 0x5441;

constexpr int kGoToAngles = 1;
constexpr int kTurnAtRate = 2;
constexpr std::pair<double, double> kOuterLimits_deg = {-5.0, 185.0};
constexpr std::pair<double, double> kInnerLimits_deg = {-180.0, 180.0};
constexpr std::pair<double, double> kRateLimits_dps = {-200.0, 200.0};

/// What a vector that is fixed in the room is in the axes of a body that was turned by `angle_deg` about +X.
Vector3 seen_after_tilt(const Vector3& v, double angle_deg) {
  const double c = std::cos(angle_deg * base::kRadPerDeg);
  const double s = std::sin(angle_deg * base::kRadPerDeg);
  return {v[0], c * v[1] + s * v[2], c * v[2] - s * v[1]};
}

/// The same about +Z.
Vector3 seen_after_turn(const Vector3& v, double angle_deg) {
  const double c = std::cos(angle_deg * base::kRadPerDeg);
  const double s = std::sin(angle_deg * base::kRadPerDeg);
  return {c * v[0] + s * v[1], c * v[1] - s * v[0], v[2]};
}

/// Of the Earth, in the axes of the fixture at 0, 0: x forward, y to the left, z up.
Vector3 earth_rate_rps(const std::optional<EarthFrame>& earth) {
  if (!earth) return {};
  const double latitude = earth->latitude_deg * base::kRadPerDeg;
  const double azimuth = earth->azimuth_deg * base::kRadPerDeg;
  const double north_rps = base::kEarthRate_rps * std::cos(latitude);
  return {north_rps * std::cos(azimuth), north_rps * std::sin(azimuth), base::kEarthRate_rps * std::sin(latitude)};
}

RegisterTable::ValueWriter kept_in(double& value, std::pair<double, double> limits) {
  return {[limits](double asked) { return asked >= limits.first && asked <= limits.second; },
          [&value](double asked) { value = asked; }};
}

/// A tilting axis, horizontal in the room, that carries a turning axis with slip rings. At 0, 0 the fixture's +Z points
/// up, the outer axis lies along its +X, the inner one along its +Z; with `earth` its +X then points at
/// `earth->azimuth_deg`. It starts there, and does what was asked of it once a command begins it; a command in mid-way
/// is begun from there.
class TwoAxisFixture final : public LabFixture {
 public:
  TwoAxisFixture(double turn_s_per_rad, const std::optional<EarthFrame>& earth);

  void advance_to(Tick now) override { now_ = now; }
  [[nodiscard]] Attitude attitude() const override;
  [[nodiscard]] RegisterTable& registers() override { return registers_; }

 private:
  void add_registers();
  void carry_out(int command);
  /// Within the turn, -180 ... 180: the slip rings count no turns.
  [[nodiscard]] double inner_deg() const;

  std::optional<EarthFrame> earth_;
  Tick now_ = 0;
  TurningAxis outer_;
  TurningAxis inner_;
  double asked_outer_deg_ = 0.0;
  double asked_inner_deg_ = 0.0;
  double asked_dps_ = 0.0;
  RegisterTable registers_;
};

TwoAxisFixture::TwoAxisFixture(double turn_s_per_rad, const std::optional<EarthFrame>& earth)
    : earth_(earth), outer_(base::kDegPerRad / turn_s_per_rad), inner_(base::kDegPerRad / turn_s_per_rad) {
  add_registers();
}

void TwoAxisFixture::add_registers() {
  constexpr auto high = RegisterTable::FirstWord::high;
  registers_.add_value(
      kOuterRequest, [this] { return asked_outer_deg_; }, kept_in(asked_outer_deg_, kOuterLimits_deg), high);
  registers_.add_value(
      kInnerRequest, [this] { return asked_inner_deg_; }, kept_in(asked_inner_deg_, kInnerLimits_deg), high);
  registers_.add_value(kRateRequest, [this] { return asked_dps_; }, kept_in(asked_dps_, kRateLimits_dps), high);
  registers_.add_number(kCommand, 1, [] { return 0; },
                        {[](int command) { return command == kGoToAngles || command == kTurnAtRate; },
                         [this](int command) { carry_out(command); }});
  registers_.add_value(kOuterAngle, [this] { return outer_.angle_deg(now_); }, {}, high);
  registers_.add_value(kInnerAngle, [this] { return inner_deg(); }, {}, high);
  registers_.add_value(kRate, [this] { return inner_.rate_dps(now_); }, {}, high);
  registers_.add_number(kTwoAxisStatus, 1, [this] { return outer_.settled(now_) && inner_.settled(now_) ? 0 : 1; });
  registers_.add_number(kTwoAxisIdentification, 1, [] { return kTwoAxisIdentity; });
}

void TwoAxisFixture::carry_out(int command) {
  if (command == kTurnAtRate) {
    inner_.turn_at(asked_dps_, now_);
    return;
  }
  outer_.go_to(outer_.angle_deg(now_), asked_outer_deg_, now_);
  inner_.go_to(inner_deg(), asked_inner_deg_, now_);
}

double TwoAxisFixture::inner_deg() const { return std::remainder(inner_.angle_deg(now_), 360.0); }

Attitude TwoAxisFixture::attitude() const {
  const double tilt_deg = outer_.angle_deg(now_);
  const double turn_deg = inner_.angle_deg(now_);
  const Vector3 room_rate_rps = earth_rate_rps(earth_);
  const double tilting_rps = outer_.rate_dps(now_) * base::kRadPerDeg;
  // The outer axis adds its rate in the room's axes, the inner one in those of the fixture.
  const Vector3 carried_rps = {room_rate_rps[0] + tilting_rps, room_rate_rps[1], room_rate_rps[2]};
  Attitude attitude{seen_after_turn(seen_after_tilt({0.0, 0.0, 1.0}, tilt_deg), turn_deg),
                    seen_after_turn(seen_after_tilt(carried_rps, tilt_deg), turn_deg)};
  attitude.rate_rps[2] += inner_.rate_dps(now_) * base::kRadPerDeg;
  return attitude;
}

}  // namespace

std::unique_ptr<LabFixture> make_fixture(FixtureKind kind, const CampaignConfig& config) {
  if (kind == FixtureKind::two_axis) return std::make_unique<TwoAxisFixture>(config.lab.turn_s_per_rad, config.earth);
  return std::make_unique<SixPositionFixture>(config.lab.turn_s_per_rad, config.earth);
}

}  // namespace soak::hal::sim
