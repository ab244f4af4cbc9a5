// SPDX-License-Identifier: Apache-2.0
#include "hal/imu/detail/vectornav_protocol.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "base/text.h"

namespace soak::hal::imu {
namespace {

namespace field = vectornav_field;

constexpr VectorNavFields kWithSaturation = {field::kTimeStartup,
                                             field::kTemp | field::kAccel | field::kRate | field::kSaturation};
/// Firmware that does not know the flags refuses them.
constexpr VectorNavFields kWithoutSaturation = {field::kTimeStartup, field::kTemp | field::kAccel | field::kRate};

/// Accelerometers and gyros; the others are of the magnetometer and the barometer.
constexpr std::uint16_t kSaturatedSensors = 0x01F8;
constexpr double kVectorNavRateTolerance = 0.01;

struct Question {
  std::string_view text;
  std::string_view name;
};

constexpr std::array<Question, 5> kQuestions = {{
    {"VNWRG,06,0", "the request to stop its lines (register 6)"},
    {"VNRRG,01", "the request for its model (register 1)"},
    {"VNRRG,03", "the request for its serial number (register 3)"},
    {"VNRRG,04", "the request for its firmware (register 4)"},
    {"VNWRG,75", "the output configuration (register 75)"},
}};

enum ErrorCode { kBadCheck = 3, kBadCommand = 4, kTooFewParameters = 5, kTooManyParameters = 6, kBadParameter = 7 };

constexpr std::array<std::string_view, 13> kErrors = {"",
                                                      "hard fault",
                                                      "serial buffer overflow",
                                                      "invalid checksum",
                                                      "invalid command",
                                                      "not enough parameters",
                                                      "too many parameters",
                                                      "invalid parameter",
                                                      "invalid register",
                                                      "unauthorized access",
                                                      "watchdog reset",
                                                      "output buffer overflow",
                                                      "insufficient baud rate"};

/// Rate of the sensors before it is divided (manuals): 800 Hz of a VN-100 or VN-110, 400 Hz of those with GNSS.
double own_rate_hz(std::string_view model) { return model.starts_with("VN-1") ? 800.0 : 400.0; }

}  // namespace

base::Status VectorNavProtocol::check(const Imu::Settings& settings) const {
  if (settings.rate_hz < 1.0 || settings.rate_hz > 800.0) {
    return base::bad_input(fmt::format("a VectorNav sends 1 to 800 packets a second, not {}", settings.rate_hz));
  }
  if (!(settings.temp_rate_hz > 0.0)) return base::bad_input("the temperature rate must be above 0 Hz");
  return {};
}

// --- the stream of bytes

void VectorNavProtocol::append(std::span<const std::uint8_t> bytes, std::chrono::steady_clock::time_point /*now*/,
                               bool /*drained*/) {
  decoder_.append(bytes);
}

base::Result<std::optional<Protocol::Heard>> VectorNavProtocol::next() {
  const auto message = decoder_.next();
  if (!message) return std::nullopt;
  if (!message->is_text) return take_binary(*message);
  const auto heard = take_text(message->text);
  if (!heard) return base::forward_error(heard);
  return *heard;
}

base::Result<Protocol::Heard> VectorNavProtocol::take_text(std::string_view text) {
  if (listening_only_) return Heard::other;
  if (text.starts_with("VNERR")) return take_error(text);
  const bool is_answer = text.starts_with("VNRRG") || text.starts_with("VNWRG");
  if (done()) return is_answer ? Heard::other : Heard::wake_up;
  const std::string_view question = kQuestions[static_cast<std::size_t>(step_)].text.substr(0, 8);
  if (!text.starts_with(question)) return Heard::other;
  text.remove_prefix(std::min(text.size(), question.size() + 1));
  return take_answer(text);
}

base::Result<Protocol::Heard> VectorNavProtocol::take_error(std::string_view text) {
  const auto code = base::parse_int(std::string(text.substr(std::min(text.size(), std::size_t{6}))));
  // Bytes were lost on the way to the unit: it will be asked again.
  if (done() || !code || *code == kBadCheck || *code == kBadCommand) return Heard::other;
  const bool about_fields = *code >= kTooFewParameters && *code <= kBadParameter;
  if (step_ == Step::output && about_fields && asked_ == kWithSaturation) {
    asked_ = kWithoutSaturation;
    return Heard::answer;
  }
  const bool known = *code > 0 && static_cast<std::size_t>(*code) < kErrors.size();
  return base::fail(
      base::ErrorKind::device,
      fmt::format("the unit reports error {}{} in reply to {}", *code,
                  known ? fmt::format(" ({})", kErrors[static_cast<std::size_t>(*code)]) : "", request_name()));
}

base::Result<Protocol::Heard> VectorNavProtocol::take_answer(std::string_view value) {
  switch (step_) {
    case Step::model:
      identity_.product = value;
      identity_.simulated = identity_.product.find("SIMULATED") != std::string::npos;
      if (const auto checked = check_rate(); !checked) return base::forward_error(checked);
      break;
    case Step::serial:
      identity_.serial = value;
      break;
    case Step::firmware:
      identity_.firmware = value;
      break;
    default:
      break;
  }
  step_ = static_cast<Step>(static_cast<std::uint8_t>(step_) + 1);
  return Heard::answer;
}

Protocol::Heard VectorNavProtocol::take_binary(const VectorNavMessage& message) {
  if (!done()) return Heard::other;
  // Another output of the unit may carry the same quantities: only the one that was asked for counts.
  if (!listening_only_ && message.fields != asked_) return Heard::other;
  const VectorNavPacket data = decode_vectornav(message);
  packet_ = {};
  packet_.stamped = data.time_ns.has_value();
  packet_ns_ = data.time_ns.value_or(0);
  packet_.temp_c = data.temp_c;
  packet_.measured = data.accel_mps2 && data.rate_rps;
  if (packet_.measured) {
    packet_.accel_mps2 = *data.accel_mps2;
    packet_.rate_rps = *data.rate_rps;
  }
  packet_.status = data.saturation.value_or(0);
  packet_.clipped = (packet_.status & kSaturatedSensors) != 0;
  return Heard::packet;
}

// --- the dialogue

void VectorNavProtocol::begin(const Imu::Settings& settings) {
  settings_ = settings;
  step_ = Step::lines_off;
  listening_only_ = false;
  asked_ = kWithSaturation;
  identity_ = {};
}

void VectorNavProtocol::assume_done(const Imu::Settings& settings) {
  begin(settings);
  step_ = Step::done;
  listening_only_ = true;
}

base::Bytes VectorNavProtocol::request() {
  const std::string_view question = kQuestions[static_cast<std::size_t>(step_)].text;
  if (step_ != Step::output) return encode_vectornav(question);
  // Register, serial port, divisor, groups, masks.
  return encode_vectornav(fmt::format("{},1,{},05,{:04X},{:04X}", question, divisor(), asked_.common, asked_.imu));
}

std::string_view VectorNavProtocol::request_name() const {
  return done() ? "" : kQuestions[static_cast<std::size_t>(step_)].name;
}

int VectorNavProtocol::divisor() const {
  return static_cast<int>(std::lround(own_rate_hz(identity_.product) / settings_.rate_hz));
}

base::Status VectorNavProtocol::check_rate() const {
  const double own_hz = own_rate_hz(identity_.product);
  const int nearest = std::max(1, divisor());
  if (std::abs(own_hz / nearest - settings_.rate_hz) <= kVectorNavRateTolerance * settings_.rate_hz) return {};
  return base::fail(base::ErrorKind::device,
                    fmt::format("the unit ({}) offers only {:.0f} Hz divided by a whole number: the nearest is {:.4g} "
                                "Hz, not {:.4g} Hz; choose a rate that it has",
                                identity_.product, own_hz, own_hz / nearest, settings_.rate_hz));
}

/// A unit that was restarted sends its lines at once; one whose lines are turned off for good waits.
std::chrono::steady_clock::duration VectorNavProtocol::silence_limit() const { return std::chrono::seconds(10); }

// --- measurements and the unit's clock

bool VectorNavProtocol::advance() {
  if (last_ns_ && packet_ns_ < *last_ns_) return false;
  lost_packets_ = 0;
  if (last_ns_ && !interrupted_) {
    const double steps = std::min(1e-9 * static_cast<double>(packet_ns_ - *last_ns_) * settings_.rate_hz, 1e9);
    lost_packets_ = static_cast<std::uint32_t>(std::max(0L, std::lround(steps) - 1));
  }
  last_ns_ = packet_ns_;
  interrupted_ = false;
  return true;
}

void VectorNavProtocol::restart_clock() {
  last_ns_.reset();
  interrupted_ = true;
  lost_packets_ = 0;
}

}  // namespace soak::hal::imu
