// SPDX-License-Identifier: Apache-2.0
#include <cstddef>

#include "hal/sim/wires/detail/chamber_wire.h"
#include "hal/sim/wires/detail/espec_text.h"

namespace soak::hal::sim {
namespace {

constexpr std::string_view kLineEnd = "\r\n";
constexpr std::size_t kLongestLine = 256;

}  // namespace

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
  if (received_.size() > kLongestLine) received_.clear();
}

}  // namespace soak::hal::sim
