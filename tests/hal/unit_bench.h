// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <memory>
#include <stdexcept>
#include <utility>
#include <vector>

#include "hal/imu/detail/stream_imu.h"
#include "tests/hal/xsens_peer.h"
#include "tests/hal/xsens_wires.h"

namespace soak::hal::imu::test {

/// Driver and scripted unit on the two ends of a socket pair, under a clock that the test moves.
template <class Unit>
class UnitBench {
 public:
  using Clock = StreamImu::Clock;

  UnitBench(std::unique_ptr<Protocol> protocol, const Imu::Settings& settings) : settings_(settings) {
    auto source = std::make_unique<PairSource>();
    wire = source.get();
    imu = std::make_unique<StreamImu>(std::move(source), std::move(protocol), [this] { return now; });
  }

  base::Status open() { return open(settings_); }
  base::Status open(const Imu::Settings& settings) { return imu->open(settings); }

  /// One poll of the driver, then the unit obeys what it was told.
  base::Status step() {
    base::Status status = imu->poll(samples);
    if (wire->fd() >= 0) send(unit.take(receive()));
    return status;
  }

  /// Steps until nothing is under way any more.
  base::Status settle() {
    for (int i = 0; i < 20; ++i) {
      if (base::Status status = step(); !status) return status;
    }
    return {};
  }

  /// Time passes in steps of `step_s`.
  base::Status pass(double seconds, double step_s = 0.1) {
    for (int i = 0; i < static_cast<int>(seconds / step_s + 0.5); ++i) {
      now += std::chrono::round<Clock::duration>(std::chrono::duration<double>(step_s));
      if (base::Status status = step(); !status) return status;
    }
    return {};
  }

  void send(const Bytes& bytes) {
    if (bytes.empty()) return;
    if (::write(wire->far_end.get(), bytes.data(), bytes.size()) != static_cast<ssize_t>(bytes.size())) {
      throw std::runtime_error("the wire does not take the unit's bytes");
    }
  }

  Bytes receive() {
    Bytes bytes(4096);
    const ssize_t got = ::read(wire->far_end.get(), bytes.data(), bytes.size());
    bytes.resize(got > 0 ? static_cast<std::size_t>(got) : 0);
    return bytes;
  }

  [[nodiscard]] std::vector<std::uint32_t> power_ons() const {
    std::vector<std::uint32_t> all;
    for (const ImuSample& sample : samples) all.push_back(sample.power_on);
    return all;
  }

  Unit unit;
  Clock::time_point now{std::chrono::hours(1000)};
  PairSource* wire = nullptr;
  std::unique_ptr<StreamImu> imu;
  std::vector<ImuSample> samples;

 private:
  Imu::Settings settings_;
};

}  // namespace soak::hal::imu::test
