// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <utility>

#include "tests/usb/bus/fake_device.h"

namespace soak::fake {
namespace {

using Clock = std::chrono::steady_clock;

double since(Clock::time_point begin) { return std::chrono::duration<double>(Clock::now() - begin).count(); }

Bytes device_descriptor(std::uint16_t vendor, std::uint16_t product) {
  return {18,
          1,
          0,
          2,
          0,
          0,
          0,
          64,
          static_cast<std::uint8_t>(vendor),
          static_cast<std::uint8_t>(vendor >> 8U),
          static_cast<std::uint8_t>(product),
          static_cast<std::uint8_t>(product >> 8U),
          0,
          6,
          1,
          2,
          3,
          1};
}

Bytes interface(std::uint8_t number, std::uint8_t endpoints) {
  return {9, 4, number, 0, endpoints, 0xFF, 0xFF, 0xFF, 0};
}

Bytes endpoint(std::uint8_t address, std::uint8_t attributes, std::size_t packet_size) {
  return {
      7, 5, address, attributes, static_cast<std::uint8_t>(packet_size), static_cast<std::uint8_t>(packet_size >> 8U),
      0};
}

Bytes join(const std::vector<Bytes>& parts) {
  Bytes all;
  for (const Bytes& part : parts) all.insert(all.end(), part.begin(), part.end());
  return all;
}

Bytes configuration(std::uint8_t interfaces, const Bytes& rest) {
  const std::size_t total = 9 + rest.size();
  return join(
      {{9, 2, static_cast<std::uint8_t>(total), static_cast<std::uint8_t>(total >> 8U), interfaces, 1, 0, 0x80, 50},
       rest});
}

class XsensGadget final : public Gadget {
 public:
  XsensGadget(std::uint32_t serial, double rate_hz) : rate_hz_(rate_hz) { unit_.serial = serial; }

  void receive(const Bytes& bytes) override {
    const bool before = unit_.measuring;
    say(unit_.take(bytes));
    if (unit_.measuring && !before) {
      began_ = Clock::now();
      sent_ = 0;
    }
  }

  Bytes send(std::size_t most) override {
    if (!said_.empty()) return take_said(most);
    if (!unit_.measuring || sent_ >= static_cast<std::int64_t>(since(began_) * rate_hz_)) return {};
    ++sent_;
    unit_.ticks_per_packet = static_cast<std::uint32_t>(10000.0 / rate_hz_);
    return unit_.packet();
  }

  Bytes descriptors() const override {
    return join({device_descriptor(0x2639, 0x0013),
                 configuration(2, join({interface(0, 1), endpoint(0x83, 3, 8), interface(1, 2), endpoint(0x02, 2, 64),
                                        endpoint(0x81, 2, 64)}))});
  }

 private:
  hal::imu::test::ScriptedUnit unit_;
  double rate_hz_;
  Clock::time_point began_;
  std::int64_t sent_ = 0;
};

class Ft232Gadget final : public Gadget {
 public:
  Ft232Gadget(std::uint32_t serial, std::size_t packet_size) : packet_size_(packet_size) { unit_.serial = serial; }

  void receive(const Bytes& bytes) override { line_ = join({line_, unit_.take(bytes)}); }

  /// A transfer is full packets and one that is not; each begins with the status, which also comes alone.
  Bytes send(std::size_t most) override {
    // The notes' 38400 baud: anything else on the line is not understood.
    if (baud_ != 0xC04E || line_modes_ != 0x0008) line_.clear();
    line_ = join({line_, std::exchange(said_, {})});
    stream();
    const bool status_due = since(status_sent_) > 0.008;
    if (line_.empty() && !status_due) return {};
    status_sent_ = Clock::now();
    Bytes transfer;
    do {
      const std::size_t count = std::min({line_.size(), packet_size_ - 2, most - transfer.size() - 2});
      transfer = join({transfer, {0x01, 0x60}, Bytes(line_.begin(), line_.begin() + static_cast<long>(count))});
      line_.erase(line_.begin(), line_.begin() + static_cast<long>(count));
      if (count < packet_size_ - 2) break;
    } while (most - transfer.size() >= packet_size_);
    return transfer;
  }

  void control(std::uint8_t request, std::uint16_t value, std::uint16_t /*index*/) override {
    if (request == 3) baud_ = value;
    if (request == 4) line_modes_ = value;
  }

  Bytes descriptors() const override {
    return join(
        {device_descriptor(0x0403, 0x6001),
         configuration(1, join({interface(0, 2), endpoint(0x81, 2, packet_size_), endpoint(0x02, 2, packet_size_)}))});
  }

 private:
  void stream() {
    if (!unit_.continuous || unit_.mode != 's') {
      began_ = Clock::now();
      return;
    }
    for (; unit_.time_s < since(began_); unit_.time_s += 0.0155) line_ = join({line_, unit_.packet()});
  }

  hal::imu::test::Ahrs400Unit unit_;
  std::size_t packet_size_;
  Bytes line_;
  std::uint16_t baud_ = 0;
  std::uint16_t line_modes_ = 0;
  Clock::time_point began_ = Clock::now();
  Clock::time_point status_sent_ = Clock::now();
};

}  // namespace

Bytes Gadget::take_said(std::size_t most) {
  const auto count = static_cast<long>(std::min(most, said_.size()));
  Bytes bytes(said_.begin(), said_.begin() + count);
  said_.erase(said_.begin(), said_.begin() + count);
  return bytes;
}

std::unique_ptr<Gadget> make_xsens_gadget(std::uint32_t serial, double rate_hz) {
  return std::make_unique<XsensGadget>(serial, rate_hz);
}

std::unique_ptr<Gadget> make_ft232_gadget(std::uint32_t serial, std::size_t packet_size) {
  return std::make_unique<Ft232Gadget>(serial, packet_size);
}

}  // namespace soak::fake
