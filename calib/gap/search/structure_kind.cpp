// SPDX-License-Identifier: Apache-2.0
#include "calib/gap/search/structure_kind.h"

#include <array>
#include <cstddef>

namespace soak::calib::gap {
namespace {

struct Entry {
  std::string_view name;
  StructureWords words;
};

/// In the order of StructureKind.
constexpr std::array<Entry, 16> kEntries = {{
    {"direction_of_sweep",
     {"a memory of the way the temperature came: glue, solder or the package gives way slowly, or the soak is too "
      "short",
      "the time before the first position: a run with twice the soak shows whether the difference dies out"}},
    {"settling",
     {"a unit that is not yet as warm inside as its thermometer says when the first position begins",
      "the time before the first position: make the soak longer"}},
    {"creep_after_turn",
     {"something that moves on for a minute or two after each turn: a clamp, a cable, the fixture's own bearing",
      "the fixture: how the unit is clamped, how its cable hangs; wait longer after a turn"}},
    {"position_order",
     {"something that goes on through a visit and begins anew with the next one: heat from a drive of the fixture, "
      "creep",
      "the order of the positions: record a run in another one"}},
    {"position",
     {"a fixture that does not stand as the procedure says, or a field or a draught that is fixed in the room",
      "the fixture's angles and what is magnetic or blows nearby"}},
    {"position_before",
     {"a unit or a fixture that remembers the position before: clamps that slip, cables that pull",
      "clamps and cables; record a run with another order of the positions"}},
    {"position_and_temperature",
     {"a fixture that bends as it warms, or an axis of the unit that turns with temperature in a way of its own",
      "the fixture: what of it grows with temperature; mount the unit turned by 90 degrees and compare"}},
    {"drift_in_run",
     {"something that goes on through every run alike: warming up, drying, a leaking reference",
      "what starts with each run: power, heaters, drying of the unit; record a run in another order of temperatures"}},
    {"daily_wave",
     {"the building: heating, sun, mains voltage or people that come back every day",
      "the room: its temperature, the supply, what else is switched on at those hours"}},
    {"after_power_on",
     {"electronics that warm up after power-on, in a way that is no simple decay",
      "the unit's warm-up time: power it earlier, and cycle the power in mid-run to see it again"}},
    {"air_gradient",
     {"heat that flows through the unit: its sides are not equally warm while the chamber's air moves",
      "the air around the unit: shield it, or soak longer"}},
    {"between_effects",
     {"one memory of the temperature's history whose shape is not in the library",
      "the ramps: a run at another ramp rate and one with a longer soak show what it follows"}},
    {"wander",
     {"slow noise (bias instability, rate random walk); too few runs to know it from a bias that jumps",
      "the number of runs: with four or more of one procedure, slow noise is measured and counted as noise"}},
    {"step",
     {"a contact, a solder joint or a sensor that gives way once and stays: a defect, a knock, a reset of the unit",
      "what happened at that time: the run's events, the cable, a knock; if no cause is found, the sensor"}},
    {"telegraph_noise",
     {"a loose contact or a defect in the sensor that jumps between two levels (telegraph noise)",
      "connectors and cables; if it stays with the unit on another cable, the sensor is faulty"}},
    {"jumps",
     {"a contact or a sensor that gives way at times, or jumps between two levels: these runs do not tell which",
      "connectors and cables, and what happened at the times of the steps; if it stays with the unit, the sensor"}},
}};

constexpr int kEnoughRuns = 4;  ///< of one procedure, to measure how a bias wanders

constexpr StructureWords kWanderInEnoughRuns = {
    "something that moves slowly and is another in each run, but not as slow noise does: the room, the supply, a cable",
    "what was not alike in the runs: the room, the supply, how the unit was mounted; record a run with all of it "
    "alike"};
constexpr StructureWords kSweepOnRamps = {
    "a memory of the way the temperature came: glue, solder or the package gives way slowly, or the inside of the unit "
    "lags behind its thermometer in a way that the library does not have",
    "how fast the temperature moves: the same cycle at half the ramp rate shows whether the difference gets smaller"};
constexpr StructureWords kDriftOnRamps = {
    "something that goes on through the recording: warming up, drying, a leaking reference",
    "what starts with the recording: power, heaters, drying of the unit; record the same cycle once more"};

const Entry& entry_of(StructureKind kind) { return kEntries.at(static_cast<std::size_t>(kind)); }

static_assert(kEntries.size() == static_cast<std::size_t>(StructureKind::jumps) + 1);

}  // namespace

std::string_view name_of(StructureKind kind) { return entry_of(kind).name; }

StructureWords words_of(StructureKind kind, const Recorded& recorded) {
  if (kind == StructureKind::direction_of_sweep && recorded.on_ramps) return kSweepOnRamps;
  if (kind == StructureKind::drift_in_run && recorded.on_ramps) return kDriftOnRamps;
  if (kind == StructureKind::wander && recorded.runs >= kEnoughRuns) return kWanderInEnoughRuns;
  return entry_of(kind).words;
}

}  // namespace soak::calib::gap
