// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/lab/simulated_relay.h"

#include <cstddef>
#include <utility>

namespace soak::hal::sim {
namespace {

constexpr int kState = 16;
constexpr int kIdentification = 32;
constexpr int kIdentity = 0x5052;

}  // namespace

SimulatedRelay::SimulatedRelay(std::function<void(int, bool)> switched) : switched_(std::move(switched)) {
  for (int output = 0; output < kRelayOutputs; ++output) {
    bool& on = on_[static_cast<std::size_t>(output)];
    const auto read = [&on] { return on ? 1 : 0; };
    const auto store = [this, &on, output](int request) {
      if (on == (request == 1)) return;
      on = request == 1;
      switched_(output + 1, on);
    };
    registers_.add_number(output, 1, read, {[](int request) { return request == 0 || request == 1; }, store});
    registers_.add_number(kState + output, 1, read);
  }
  registers_.add_number(kIdentification, 1, [] { return kIdentity; });
}

}  // namespace soak::hal::sim
