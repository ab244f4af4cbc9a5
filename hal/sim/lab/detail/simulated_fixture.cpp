// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/lab/detail/simulated_fixture.h"

#include <cmath>
#include <cstddef>

namespace soak::hal::sim {
namespace {

constexpr int kRequest = 0;
constexpr int kActual = 1;
constexpr int kStatus = 2;
constexpr int kIdentification = 32;
constexpr int kIdentity = 0x5046;
constexpr int kFirstPosition = 5;
constexpr int kPositions = 6;

calib::Position numbered(int number) {
  return *calib::position_named(calib::kSixPositionLabels[static_cast<std::size_t>(number - 1)]);
}

double angle_between(const calib::Vector3& a, const calib::Vector3& b) {
  return std::acos(a[0] * b[0] + a[1] * b[1] + a[2] * b[2]);
}

}  // namespace

SimulatedFixture::SimulatedFixture(double turn_s_per_rad, const std::optional<EarthFrame>& earth)
    : turn_s_per_rad_(turn_s_per_rad),
      earth_(earth),
      requested_(kFirstPosition),
      from_(kFirstPosition),
      position_(kFirstPosition) {
  registers_.add_number(kRequest, 1, [this] { return requested_; },
                        {[](int number) { return number >= 1 && number <= kPositions; },
                         [this](int number) {
                           requested_ = number;
                           begin_turn();
                         }});
  registers_.add_number(kActual, 1, [this] { return moves() ? 0 : position_; });
  registers_.add_number(kStatus, 1, [this] { return moves() ? 1 : 0; });
  registers_.add_number(kIdentification, 1, [] { return kIdentity; });
}

void SimulatedFixture::begin_turn() {
  if (moves() || requested_ == position_) return;
  from_ = position_;
  position_ = requested_;
  turn_start_ = now_;
  turn_end_ = now_ + ticks_of(turn_s_per_rad_ * angle_between(numbered(from_).up, numbered(position_).up));
}

void SimulatedFixture::advance_to(Tick now) {
  now_ = now;
  begin_turn();
}

Attitude SimulatedFixture::attitude() const {
  if (!moves()) return resting(numbered(position_), earth_);
  const auto ticks = static_cast<double>(turn_end_ - turn_start_);
  return turning(numbered(from_), numbered(position_), static_cast<double>(now_ - turn_start_) / ticks,
                 ticks / static_cast<double>(kTicksPerSecond));
}

}  // namespace soak::hal::sim
