// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <functional>

#include "hal/sim/lab/register_table.h"

namespace soak::hal::sim {

inline constexpr int kRelayOutputs = 16;

/// The relay card that feeds the units. All outputs are off at the start; they switch at once.
class SimulatedRelay {
 public:
  /// `switched` is told each output (from 1) that changes.
  explicit SimulatedRelay(std::function<void(int output, bool on)> switched);
  SimulatedRelay(const SimulatedRelay&) = delete;
  SimulatedRelay& operator=(const SimulatedRelay&) = delete;

  [[nodiscard]] RegisterTable& registers() { return registers_; }

 private:
  std::function<void(int, bool)> switched_;
  std::array<bool, kRelayOutputs> on_{};
  RegisterTable registers_;
};

}  // namespace soak::hal::sim
