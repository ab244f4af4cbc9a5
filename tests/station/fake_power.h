// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "hal/devices/unit_power.h"

namespace soak::station {

/// A supply that says what it is told to say, or does not answer.
class FakePower final : public hal::UnitPower {
 public:
  base::Status connect() override { return {}; }
  [[nodiscard]] base::Status check(int, const hal::SupplySettings&) const override { return {}; }
  base::Status prepare(int output, const hal::SupplySettings& settings) override {
    outputs[output].limit_a = settings.limit_a;
    return {};
  }
  base::Status set(int output, bool on) override {
    if (!answers) return base::fail(base::ErrorKind::device, "no answer");
    outputs[output].on = on;
    ++commands;
    return {};
  }
  base::Result<std::map<int, hal::OutputReading>> read(const std::vector<int>& asked) override {
    ++reads;
    if (before_read) before_read();
    if (!answers) return base::fail(base::ErrorKind::device, "no answer");
    std::map<int, hal::OutputReading> readings;
    for (const int output : asked) readings[output] = outputs[output];
    return readings;
  }
  [[nodiscard]] bool measures(int) const override { return true; }
  [[nodiscard]] std::string description() const override { return "the fake"; }

  bool answers = true;
  std::function<void()> before_read;  ///< what happens to it just then
  int reads = 0;
  int commands = 0;  ///< to switch
  std::map<int, hal::OutputReading> outputs;
};

}  // namespace soak::station
