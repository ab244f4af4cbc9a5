// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/wires/detail/chamber_wire.h"

#include <fmt/format.h>

#include <cmath>
#include <cstddef>
#include <functional>
#include <optional>
#include <vector>

#include "base/bytes.h"
#include "base/text.h"

namespace soak::hal::sim {
namespace {

// ---- Modbus RTU

constexpr std::uint8_t kRtuUnit = 1;
constexpr std::uint8_t kReadRegisters = 3;
constexpr std::uint8_t kWriteOne = 6;
constexpr std::uint8_t kWriteMany = 16;
constexpr std::uint8_t kExceptionFlag = 0x80;
constexpr std::size_t kCrcSize = 2;
constexpr std::size_t kFixedRequest = 8;
constexpr std::size_t kWriteHeader = 7;  // of function 16, up to its byte count
constexpr int kMaxRead = 125;
/// Silence that ends a frame. A pseudo-terminal has no characters' time: this is what a busy machine may pause in one.
constexpr std::int64_t kSilence_ns = 200'000'000;

/// Size of the request that begins so; nothing = not yet known, 0 = no request that is answered here.
std::optional<std::size_t> request_size(std::span<const std::uint8_t> start) {
  if (start.size() < 2) return std::nullopt;
  if (start[1] == kReadRegisters || start[1] == kWriteOne) return kFixedRequest;
  if (start[1] != kWriteMany) return 0;
  if (start.size() < kWriteHeader) return std::nullopt;
  return kWriteHeader + start[kWriteHeader - 1] + kCrcSize;
}

ModbusAnswer read_registers(const RegisterTable& registers, std::span<const std::uint8_t> request,
                            base::Bytes& answer) {
  const int count = base::big_endian_u16(request, 4);
  if (count < 1 || count > kMaxRead) return ModbusAnswer::illegal_value;
  std::vector<std::uint16_t> words(static_cast<std::size_t>(count));
  const ModbusAnswer done = registers.read(base::big_endian_u16(request, 2), words);
  if (done != ModbusAnswer::done) return done;
  answer.push_back(static_cast<std::uint8_t>(2 * count));
  for (const std::uint16_t word : words) base::append_big_endian(answer, word);
  return done;
}

ModbusAnswer write_registers(RegisterTable& registers, std::span<const std::uint8_t> request, base::Bytes& answer) {
  std::vector<std::uint16_t> words;
  if (request[1] == kWriteOne) {
    words.push_back(base::big_endian_u16(request, 4));
  } else {
    if (request[kWriteHeader - 1] != 2 * base::big_endian_u16(request, 4)) return ModbusAnswer::illegal_value;
    for (std::size_t at = kWriteHeader; at + kCrcSize < request.size(); at += 2)
      words.push_back(base::big_endian_u16(request, at));
  }
  const ModbusAnswer done = registers.write(base::big_endian_u16(request, 2), words);
  answer.insert(answer.end(), request.begin() + 2, request.begin() + 6);
  return done;
}

// ---- Eurotherm 2400

constexpr int kParameterProcessValue = 1;
constexpr int kTargetSetPoint = 2;
constexpr int kParameterOutputPower = 3;
constexpr int kParameterWorkingSetPoint = 5;
constexpr int kParameterStatus = 75;
constexpr int kParameterSetPointHigh = 111;
constexpr int kParameterSetPointLow = 112;
constexpr int kInstrumentMode = 199;
constexpr int kAutoManual = 273;
constexpr int kDecimalPlaces = 525;

constexpr int kDecimals = 1;
constexpr double kIntegersPerUnit = 10.0;
constexpr int kNormal = 0;
constexpr int kStandby = 1;
constexpr int kAlarm1 = 1 << 0;
constexpr int kAlarm2 = 1 << 1;
/// What stands where nothing is.
constexpr std::uint16_t kUndefined = 0x5A5A;

constexpr int float_address(int parameter) { return 0x8000 + 2 * parameter; }

/// A value in both areas.
void add_parameter(RegisterTable& registers, int parameter, const std::function<double()>& read,
                   const RegisterTable::ValueWriter& write = {}) {
  registers.add_value(float_address(parameter), read, write, RegisterTable::FirstWord::high);
  RegisterTable::NumberWriter integer;
  if (write.takes) {
    const auto value_of = [](int number) { return static_cast<std::int16_t>(number) / kIntegersPerUnit; };
    integer = {[takes = write.takes, value_of](int number) { return takes(value_of(number)); },
               [store = write.store, value_of](int number) { store(value_of(number)); }};
  }
  registers.add_number(
      parameter, 1, [read] { return static_cast<int>(std::lround(read() * kIntegersPerUnit)); }, std::move(integer));
}

// ---- ESPEC P300

constexpr std::string_view kSetPointCommand = "TEMP, S";

int alarm_count(const SimulatedChamber& chamber) {
  return int{chamber.alarm_is_on()} + int{chamber.limit_is_tripped()};
}

/// Codes are made up: the maker's list is not public.
std::string alarms(const SimulatedChamber& chamber) {
  return fmt::format("{}{}{}", alarm_count(chamber), chamber.alarm_is_on() ? ",1" : "",
                     chamber.limit_is_tripped() ? ",2" : "");
}

std::string mode(const SimulatedChamber& chamber) { return chamber.controller().is_on() ? "CONSTANT" : "STANDBY"; }

std::string temperatures(const SimulatedChamber& chamber) {
  return fmt::format("{:.1f},{:.1f},{:.1f},{:.1f}", chamber.process_value_c(), chamber.controller().set_point_c(),
                     chamber.set_point_high_c(), chamber.set_point_low_c());
}

std::string change_set_point(SimulatedChamber& chamber, std::string_view line) {
  const auto value = base::parse_double(line.substr(kSetPointCommand.size()));
  if (!value) return "NA:PARA ERR";
  if (!chamber.takes_set_point(*value)) return "NA:DATA OUT OF RANGE";
  chamber.set_set_point_c(*value);
  return fmt::format("OK:{}", line);
}

std::string change_mode(SimulatedChamber& chamber, std::string_view line) {
  chamber.switch_control(line == "MODE,CONSTANT");
  return fmt::format("OK:{}", line);
}

constexpr std::string_view kLineEnd = "\r\n";
constexpr std::size_t kLongestTextLine = 256;

}  // namespace

std::uint16_t rtu_crc(std::span<const std::uint8_t> bytes) {
  std::uint32_t crc = 0xFFFF;
  for (const std::uint8_t byte : bytes) {
    crc ^= byte;
    for (int bit = 0; bit < 8; ++bit) crc = (crc & 1) != 0 ? (crc >> 1) ^ 0xA001 : crc >> 1;
  }
  return static_cast<std::uint16_t>(crc);
}

base::Result<std::unique_ptr<RtuWire>> RtuWire::open(RegisterTable registers) {
  std::unique_ptr<RtuWire> wire(new RtuWire(std::move(registers)));
  auto port = PtyUnitPort::open([it = wire.get()](std::span<const std::uint8_t> bytes) { it->receive(bytes); });
  if (!port) return base::forward_error(port);
  wire->port_ = *std::move(port);
  return wire;
}

void RtuWire::receive(std::span<const std::uint8_t> bytes) {
  const std::int64_t now_ns = host_now_ns();
  if (now_ns - last_byte_ns_ > kSilence_ns) received_.clear();
  last_byte_ns_ = now_ns;
  received_.insert(received_.end(), bytes.begin(), bytes.end());
  const auto size = request_size(received_);
  if (!size || received_.size() < *size) return;
  const base::Bytes frame = std::exchange(received_, {});
  // More than one frame at once is none: a master waits for its answer.
  if (*size != frame.size() || *size <= kCrcSize) return;
  const std::span<const std::uint8_t> body = std::span(frame).first(frame.size() - kCrcSize);
  const auto sent = static_cast<std::uint16_t>(frame[frame.size() - 2] | frame[frame.size() - 1] << 8);
  if (rtu_crc(body) == sent && frame[0] == kRtuUnit) answer(frame);
}

void RtuWire::answer(std::span<const std::uint8_t> request) {
  base::Bytes reply = {kRtuUnit, request[1]};
  const ModbusAnswer done = request[1] == kReadRegisters ? read_registers(registers_, request, reply)
                                                         : write_registers(registers_, request, reply);
  if (done != ModbusAnswer::done) {
    reply = {kRtuUnit, static_cast<std::uint8_t>(request[1] | kExceptionFlag), static_cast<std::uint8_t>(done)};
  }
  const std::uint16_t crc = rtu_crc(reply);
  reply.push_back(static_cast<std::uint8_t>(crc & 0xFF));
  reply.push_back(static_cast<std::uint8_t>(crc >> 8));
  port_->queue(reply);
  port_->flush();
}

RegisterTable eurotherm_registers(SimulatedChamber& chamber) {
  RegisterTable registers;
  SimulatedChamber* const it = &chamber;
  add_parameter(registers, kParameterProcessValue, [it] { return it->process_value_c(); });
  add_parameter(
      registers, kTargetSetPoint, [it] { return it->controller().set_point_c(); },
      {[it](double value) { return it->takes_set_point(value); }, [it](double value) { it->set_set_point_c(value); }});
  add_parameter(registers, kParameterOutputPower, [it] { return 100.0 * it->applied_output(); });
  add_parameter(registers, kParameterWorkingSetPoint, [it] { return it->controller().working_set_point_c(); });
  add_parameter(registers, kParameterSetPointHigh, [it] { return it->set_point_high_c(); });
  add_parameter(registers, kParameterSetPointLow, [it] { return it->set_point_low_c(); });
  registers.add_number(kParameterStatus, 1,
                       [it] { return (it->alarm_is_on() ? kAlarm1 : 0) | (it->limit_is_tripped() ? kAlarm2 : 0); });
  registers.add_number(kInstrumentMode, 1, [it] { return it->controller().is_on() ? kNormal : kStandby; },
                       {[](int mode) { return mode == kNormal || mode == kStandby; },
                        [it](int mode) { it->switch_control(mode == kNormal); }});
  registers.add_number(kAutoManual, 1, [] { return 0; }, {[](int mode) { return mode == 0; }, [](int) {}});
  registers.add_number(kDecimalPlaces, 1, [] { return kDecimals; });
  registers.pretend_everywhere(kUndefined);
  return registers;
}

std::string espec_answer(SimulatedChamber& chamber, std::string_view line) {
  if (line == "TEMP?") return temperatures(chamber);
  if (line == "MODE?") return mode(chamber);
  if (line == "ALARM?") return alarms(chamber);
  if (line == "MON?") {
    return fmt::format("{:.1f},,{},{}", chamber.process_value_c(), mode(chamber), alarm_count(chamber));
  }
  if (line.starts_with(kSetPointCommand)) return change_set_point(chamber, line);
  if (line == "MODE,CONSTANT" || line == "MODE,STANDBY") return change_mode(chamber, line);
  return "NA:CMD ERR";
}

base::Result<std::unique_ptr<TextWire>> TextWire::open(int tcp_port, SimulatedChamber& chamber) {
  std::unique_ptr<TextWire> wire(new TextWire(chamber));
  auto port =
      TcpUnitPort::open(tcp_port, [it = wire.get()](std::span<const std::uint8_t> bytes) { it->receive(bytes); });
  if (!port) return base::forward_error(port);
  wire->port_ = *std::move(port);
  return wire;
}

void TextWire::receive(std::span<const std::uint8_t> bytes) {
  received_.append(bytes.begin(), bytes.end());
  for (std::size_t end = received_.find(kLineEnd); end != std::string::npos; end = received_.find(kLineEnd)) {
    const std::string answer = espec_answer(chamber_, received_.substr(0, end)) + std::string(kLineEnd);
    received_.erase(0, end + kLineEnd.size());
    port_->queue(base::Bytes(answer.begin(), answer.end()));
    port_->flush();
  }
  if (received_.size() > kLongestTextLine) received_.clear();
}

}  // namespace soak::hal::sim
