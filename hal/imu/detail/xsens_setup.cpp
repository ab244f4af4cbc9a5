// SPDX-License-Identifier: Apache-2.0
#include "hal/imu/detail/xsens_setup.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <cstdlib>
#include <optional>
#include <utility>

#include "hal/imu/detail/big_endian.h"
#include "hal/imu/detail/mt_data2.h"

namespace soak::hal::imu {
namespace {

using Data = std::span<const std::uint8_t>;

constexpr std::uint16_t kWithEveryPacket = 0xFFFF;
constexpr double kRateTolerance = 0.01;
constexpr std::size_t kOutputSize = 4;

struct Step {
  Mid request;
  std::string_view name;
};

constexpr std::array kSteps = {
    Step{Mid::go_to_config, "the request to enter configuration (30)"},
    Step{Mid::request_device_id, "the request for its device id (00)"},
    Step{Mid::request_product_code, "the request for its product code (1C)"},
    Step{Mid::request_firmware, "the request for its firmware revision (12)"},
    Step{Mid::set_output_configuration, "the output configuration (C0)"},
    Step{Mid::go_to_measurement, "the request to enter measurement (10)"},
};

/// One line of the output configuration.
struct Output {
  std::uint16_t id;
  std::string_view name;
  std::uint16_t rate_hz;
};

std::array<Output, 6> outputs_for(const Imu::Settings& settings) {
  const auto rate_hz = static_cast<std::uint16_t>(settings.rate_hz);
  const auto temp_rate_hz = static_cast<std::uint16_t>(settings.temp_rate_hz);
  return {{{data_id::kPacketCounter, "packet counter", kWithEveryPacket},
           {data_id::kSampleTimeFine, "sample time", kWithEveryPacket},
           {data_id::kAcceleration, "acceleration", rate_hz},
           {data_id::kRateOfTurn, "rate of turn", rate_hz},
           {data_id::kTemperature, "temperature", temp_rate_hz},
           {data_id::kStatusWord, "status word", kWithEveryPacket}}};
}

void append_big_endian(base::Bytes& bytes, std::uint16_t value) {
  bytes.push_back(static_cast<std::uint8_t>(value >> 8U));
  bytes.push_back(static_cast<std::uint8_t>(value));
}

base::Bytes compose(const std::array<Output, 6>& outputs) {
  base::Bytes bytes;
  for (const Output& output : outputs) {
    append_big_endian(bytes, output.id);
    append_big_endian(bytes, output.rate_hz);
  }
  return bytes;
}

tl::unexpected<base::Error> device_error(std::string message) {
  return base::fail(base::ErrorKind::device, std::move(message));
}

/// The rate that an output configuration gives `id`, whatever its number format.
std::optional<std::uint16_t> rate_of(std::uint16_t id, Data configuration) {
  for (; !configuration.empty(); configuration = configuration.subspan(kOutputSize)) {
    if ((big_endian<std::uint16_t>(configuration.data()) & 0xFFF0U) == id) {
      return big_endian<std::uint16_t>(configuration.data() + 2);
    }
  }
  return std::nullopt;
}

bool is_near(std::uint16_t offered_hz, std::uint16_t asked_hz) {
  return std::abs(asked_hz - offered_hz) <= kRateTolerance * asked_hz;
}

/// Printable characters without the padding.
std::string text_of(Data data) {
  std::string text;
  for (const std::uint8_t byte : data) {
    if (byte >= 0x20 && byte < 0x7F) text.push_back(static_cast<char>(byte));
  }
  text.erase(text.find_last_not_of(' ') + 1);
  return text;
}

bool is_rate(double rate_hz) { return rate_hz >= 1.0 && rate_hz <= 2000.0 && std::floor(rate_hz) == rate_hz; }

}  // namespace

base::Status check_rates(const Imu::Settings& settings) {
  for (const double rate_hz : {settings.rate_hz, settings.temp_rate_hz}) {
    if (is_rate(rate_hz)) continue;
    return base::bad_input(fmt::format("a rate must be a whole number of Hz from 1 to 2000, not {}", rate_hz));
  }
  return {};
}

void XsensSetup::begin() {
  step_ = 0;
  identity_ = {};
}

bool XsensSetup::done() const { return step_ == kSteps.size(); }

base::Bytes XsensSetup::request() const {
  const Mid id = kSteps[step_].request;
  return id == Mid::set_output_configuration ? encode_xbus(id, compose(outputs_for(settings_))) : encode_xbus(id);
}

std::string_view XsensSetup::request_name() const { return kSteps[step_].name; }

base::Result<bool> XsensSetup::take(const XbusMessage& message) {
  if (done() || message.id != answer_to(kSteps[step_].request)) return false;
  if (const base::Status taken = take_answer(kSteps[step_].request, message.data); !taken)
    return base::forward_error(taken);
  ++step_;
  return true;
}

base::Status XsensSetup::take_answer(Mid request, Data data) {
  switch (request) {
    case Mid::request_device_id:
      if (data.size() != 4) return device_error(fmt::format("a device id of {} bytes: not 4", data.size()));
      identity_.serial = fmt::format("{:08X}", big_endian<std::uint32_t>(data.data()));
      return {};
    case Mid::request_product_code:
      identity_.product = text_of(data);
      identity_.simulated = identity_.product.find("SIMULATED") != std::string::npos;
      return {};
    case Mid::request_firmware:
      if (data.size() < 3) return device_error(fmt::format("a firmware revision of {} bytes: not 3", data.size()));
      identity_.firmware = fmt::format("{}.{}.{}", data[0], data[1], data[2]);
      return {};
    case Mid::set_output_configuration:
      return check_offer(data);
    default:
      return {};
  }
}

base::Status XsensSetup::check_offer(Data data) const {
  if (data.size() % kOutputSize != 0) return device_error("its answer to the output configuration is malformed");
  for (const Output& asked : outputs_for(settings_)) {
    const auto offered_hz = rate_of(asked.id, data);
    if (!offered_hz) return device_error(fmt::format("the unit does not offer {} ({:04X})", asked.name, asked.id));
    if (asked.rate_hz != kWithEveryPacket && !is_near(*offered_hz, asked.rate_hz)) {
      return device_error(
          fmt::format("the unit offers {} ({:04X}) at {} Hz, not at the {} Hz asked for: ask for a rate that it has",
                      asked.name, asked.id, *offered_hz, asked.rate_hz));
    }
  }
  return {};
}

}  // namespace soak::hal::imu
