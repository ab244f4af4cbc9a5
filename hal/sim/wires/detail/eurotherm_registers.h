// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "hal/sim/lab/register_table.h"
#include "hal/sim/lab/simulated_chamber.h"

namespace soak::hal::sim {

/// The registers of a Eurotherm 2400 that controls the chamber (the maker's handbook HA026230): parameter n as an
/// integer of one decimal in register n, and as a float, high word first, in 32768 + 2 n. Reading what is not there
/// gives an arbitrary number, writing it succeeds. `chamber` must outlive them.
[[nodiscard]] RegisterTable eurotherm_registers(SimulatedChamber& chamber);

}  // namespace soak::hal::sim
