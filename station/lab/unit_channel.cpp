// SPDX-License-Identifier: Apache-2.0
#include "station/lab/unit_channel.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace soak::station {
namespace {

using std::chrono::steady_clock;

constexpr std::chrono::seconds kReopenInterval{1};
constexpr int kReopenPauseFactor = 20;
constexpr double kLongestClockStep_s = 60.0;
constexpr double kTemperatureAge_s = 60.0;    ///< of a temperature, device time
constexpr float kLowestCredible_c = -150.0F;  ///< anything else is no temperature of a unit
constexpr float kHighestCredible_c = 300.0F;

}  // namespace

std::string product_text(const hal::ImuIdentity& identity) {
  const std::string product = identity.product.empty() ? "product not told" : identity.product;
  return identity.firmware.empty() ? product : fmt::format("{}, firmware {}", product, identity.firmware);
}

UnitChannel::UnitChannel(Slot slot, std::string serial, calib::UnitType type, std::unique_ptr<hal::Imu> imu,
                         const hal::Imu::Settings& settings)
    : noise(std::make_shared<NoiseWatch>(settings.rate_hz)),
      slot_(std::move(slot)),
      serial_(std::move(serial)),
      type_(std::move(type)),
      imu_(std::move(imu)),
      settings_(settings),
      judge_(calib::StabilityCriterion{}) {}

void UnitChannel::reopen() {
  const auto now = steady_clock::now();
  if (now < next_open_) return;
  if (const auto opened = imu_->open(settings_); !opened) trouble_ = opened.error().message;
  // Opening a host that is gone blocks: it may take a twentieth of our time, no more.
  const auto tried = steady_clock::now();
  next_open_ = tried + kReopenInterval + kReopenPauseFactor * (tried - now);
}

void UnitChannel::close() {
  closed_ = true;
  imu_->close();
}

void UnitChannel::poll() {
  fresh_.clear();
  advance_s_ = 0.0;
  clock_restarted_ = false;
  if (closed_) return;
  const hal::ImuState state = imu_->state();
  if (state == hal::ImuState::closed || state == hal::ImuState::failed) reopen();
  if (imu_->wait_fd() >= 0) {
    if (const auto polled = imu_->poll(fresh_); polled) {
      if (streaming()) trouble_.clear();
    } else {
      trouble_ = polled.error().message;
    }
  }
  for (const hal::ImuSample& sample : fresh_) take(sample);
  if (!fresh_.empty()) streamed_ = steady_clock::now();
}

void UnitChannel::take(const hal::ImuSample& sample) {
  // A clock that jumps says nothing of the time that went by.
  const bool begins = !latest_ || sample.power_on != power_on_ || sample.t_s < latest_->t_s ||
                      sample.t_s - latest_->t_s > kLongestClockStep_s;
  if (begins) {
    clock_restarted_ = true;
    advance_s_ = 0.0;
    power_on_ = sample.power_on;
    first_sample_s_ = sample.t_s;
    first_heard_ = std::chrono::steady_clock::now();
    judge_.disturb();
  } else {
    advance_s_ += sample.t_s - latest_->t_s;
  }
  latest_ = sample;
  if (sample.temp_c && std::clamp(*sample.temp_c, kLowestCredible_c, kHighestCredible_c) == *sample.temp_c) {
    temp_c_ = static_cast<double>(*sample.temp_c);
    temp_s_ = sample.t_s;
    judge_.add(sample.t_s, *temp_c_);
  } else if (temp_c_ && sample.t_s - temp_s_ > kTemperatureAge_s) {
    temp_c_.reset();
  }
  attitude_.add(sample);
  rate_.add(sample);
}

double UnitChannel::silent_s() const { return std::chrono::duration<double>(steady_clock::now() - streamed_).count(); }

void UnitChannel::judge_by(const calib::StabilityCriterion& criterion) { judge_ = calib::StabilityJudge(criterion); }

void UnitChannel::expect_position(const std::string& fixture_up) {
  position_ = unit_position(slot_, fixture_up);
  attitude_.expect(position_, type_.sign_at_rest);
}

}  // namespace soak::station
