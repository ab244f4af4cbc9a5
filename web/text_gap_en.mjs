// SPDX-License-Identifier: Apache-2.0
// What the card of a unit's gap says, in English.

import { plural } from "./format.mjs";

/** What a unit does that has the effect. */
const PLAIN = {
  thermal_hysteresis: "readings differ between heating and cooling, and keep differing after the soak", temperature_rate: "readings shift with how fast the temperature moves",
  sensor_lag: "the sensing elements follow the thermometer late", warmup_transient: "readings move after power-on and then settle",
  g_sensitivity: "the gyros' bias depends on how the unit lies: they feel acceleration", earth_rate: "the rotation of the Earth is still in the gyros' readings",
  cross_axis: "the sensing axes turn as the temperature changes", fixture_tilt: "the fixture stood at another angle from run to run",
  scale_nonlinearity: "the accelerometers do not read in proportion", vibration_rectification: "readings shift while the compressor runs",
  supply_sensitivity: "readings follow the supply voltage", temperature_gradient: "readings shift while the air is warmer or colder than the unit",
  position_memory: "the unit remembers the position before", moisture: "readings move while the unit dries", narrow_bump: "the curve has a narrow bump at one temperature",
  aging_drift: "readings drift from run to run, as a unit that ages does", noise_vs_temperature: "the noise depends on the temperature", quantization: "readings come in coarse steps",
  saturation: "readings stop at the end of their range",
};

/** What readings follow that no effect explains (docs/gap-workflow.md): what such a thing usually is, and where to look. */
const KINDS = {
  direction_of_sweep: { usual: "a memory of the way the temperature came: glue, solder or the package gives way slowly, or the soak is too short", look: "the time before the first position: a run with twice the soak shows whether the difference dies out" },
  settling: { usual: "a unit that is not yet as warm inside as its thermometer says when the first position begins", look: "the time before the first position: make the soak longer" },
  creep_after_turn: { usual: "something that moves on for a minute or two after each turn: a clamp, a cable, the fixture's own bearing", look: "the fixture: how the unit is clamped, how its cable hangs; wait longer after a turn" },
  position_order: { usual: "something that goes on through a visit and begins anew with the next one: heat from a drive of the fixture, creep", look: "the order of the positions: record a run in another one" },
  position: { usual: "a fixture that does not stand as the procedure says, or a field or a draught that is fixed in the room", look: "the fixture's angles and what is magnetic or blows nearby" },
  position_before: { usual: "a unit or a fixture that remembers the position before: clamps that slip, cables that pull", look: "clamps and cables; record a run with another order of the positions" },
  position_and_temperature: { usual: "a fixture that bends as it warms, or an axis of the unit that turns with temperature in a way of its own", look: "the fixture: what of it grows with temperature; mount the unit turned by 90 degrees and compare" },
  drift_in_run: { usual: "something that goes on through every run alike: warming up, drying, a leaking reference", look: "what starts with each run: power, heaters, drying of the unit; record a run in another order of temperatures" },
  daily_wave: { usual: "the building: heating, sun, mains voltage or people that come back every day", look: "the room: its temperature, the supply, what else is switched on at those hours" },
  after_power_on: { usual: "electronics that warm up after power-on, in a way that is no simple decay", look: "the unit's warm-up time: power it earlier, and cycle the power in mid-run to see it again" },
  air_gradient: { usual: "heat that flows through the unit: its sides are not equally warm while the chamber's air moves", look: "the air around the unit: shield it, or soak longer" },
  between_effects: { usual: "one memory of the temperature's history whose shape is not in the library", look: "the ramps: a run at another ramp rate and one with a longer soak show what it follows" },
  wander: { usual: "slow noise (bias instability, rate random walk); too few runs to know it from a bias that jumps", look: "the number of runs: with four or more of one procedure, slow noise is measured and counted as noise" },
  step: { usual: "a contact, a solder joint or a sensor that gives way once and stays: a defect, a knock, a reset of the unit", look: "what happened at that time: the run's events, the cable, a knock; if no cause is found, the sensor" },
  telegraph_noise: { usual: "a loose contact or a defect in the sensor that jumps between two levels (telegraph noise)", look: "connectors and cables; if it stays with the unit on another cable, the sensor is faulty" },
  jumps: { usual: "a contact or a sensor that gives way at times, or jumps between two levels: these runs do not tell which", look: "connectors and cables, and what happened at the times of the steps; if it stays with the unit, the sensor" },
};

/** The same where they depend on the recording: on ramps, and with enough runs. */
const ON_RAMPS = {
  direction_of_sweep: { usual: "a memory of the way the temperature came: glue, solder or the package gives way slowly, or the inside of the unit lags behind its thermometer in a way that the library does not have", look: "how fast the temperature moves: the same cycle at half the ramp rate shows whether the difference gets smaller" },
  drift_in_run: { usual: "something that goes on through the recording: warming up, drying, a leaking reference", look: "what starts with the recording: power, heaters, drying of the unit; record the same cycle once more" },
};
const WANDER_IN_ENOUGH_RUNS = { usual: "something that moves slowly and is another in each run, but not as slow noise does: the room, the supply, a cable", look: "what was not alike in the runs: the room, the supply, how the unit was mounted; record a run with all of it alike" };
const ENOUGH_RUNS = 4; // of one procedure, to measure how a bias wanders

/** "sensor lag" */
const effect = (name) => name.replaceAll("_", " ");
const either = (names) => names.map(effect).join(" or ");

export const text = {
  card: {
    title: "Gap: what the model does not explain",
    find: "Search",
    show: "Compare before and after",
    none: "Nobody has searched yet, or the result is not kept. A search takes the runs that a fit takes: two of one procedure at least, better six.",
    next: "To close the gap",
    howToRecord: "How to record it, step by step",
    accept: "Accept…",
    /** @returns {import("./dom.mjs").Part[]} */
    before: (version, time, user) => [`This search is of model ${version}, ${time} by ${user}: of before its effects were accepted.`],
    /** @returns {import("./dom.mjs").Part[]} */
    stale: (version, time, user, why) => [`This search is of model ${version}, ${time} by ${user}. It does not hold any more: `, why, "."],
    terms: "Effects that the model carries",
    labOnly: "Lab only: the unit itself cannot correct it.",
    inFile: "In the calibration file: the unit corrects it.",
  },
  verdicts: { none: "NOTHING FOUND", named: "EFFECT FOUND", accepted: "EFFECT ACCEPTED", unknown: "NOT EXPLAINED", cannot_judge: "CANNOT BE JUDGED" },
  /** An effect by its name in the interface. */
  effect,
  /** The same at the head of its card; the g of "g sensitivity" is no G. */
  effectTitle: (name) => effect(name).replace(/^[a-z](?=[a-z])/, (first) => first.toUpperCase()),
  either,
  /** Of which sensors a size is that not all of them have a unit for. */
  sizeOf: { gyro: "of the gyros", accel: "of the accelerometers" },
  allSensors: "all sensors",
  found: {
    none: "What the unit read beyond the model is no more than how its runs differ. Smaller effects may be there unseen: the limits are below.",
    /** @type {(where: import("./dom.mjs").Part[]) => import("./dom.mjs").Part[]} `where`: what follows() says, or nothing */
    unknown: (where) => ["The unit reads something that no known effect explains.", ...where, " Nothing is named on a guess."],
    /** @returns {import("./dom.mjs").Part[]} */
    follows: (axis, sensors) => [" It follows ", { english: axis }, `, in ${sensors}.`],
    cannotJudge: "These runs cannot show whether the model lacks something.",
    /** `name`: of an effect */
    one: (name, size, sensors) => `${PLAIN[name] ?? "an effect that this page does not know"} (${effect(name)}: ${size}, in ${sensors})`,
    /** Of the sensor that stands out most. */
    gap: (sensor, before, floor, unit) => ` The gap of ${sensor} is ${before} ${unit} (RMS), noise alone leaves ${floor}.`,
    step: (sensor, size, unit, run, when, temp, more) => `The bias of ${sensor} steps by ${size} ${unit} in run ${run}, ${when} after its first reading at a plateau, at ${temp} °C${more > 0 ? ` (${more} more below)` : ""}. No known effect explains that.`,
    jumps: (sensors) => ` The bias jumps to and fro while the unit runs, in ${sensors}.`,
    accepted: (effects, version, newest) => `A search found ${effects.join(" and ")} in model ${version}. Model ${newest} carries ${effects.length === 1 ? "it" : "them"}.`,
    lacks: (effects) => `The model lacks something: ${effects.join("; and ")}.`,
  },
  /** `runs`: that were searched at plateaus. */
  kinds: (kind, onRamps, runs) => (onRamps && ON_RAMPS[kind]) || (kind === "wander" && runs >= ENOUGH_RUNS ? WANDER_IN_ENOUGH_RUNS : KINDS[kind] ?? null),
  sure: {
    certain: "This is no chance",
    likely: "Chance very seldom looks like this",
    alone: (chance) => `${chance}, and no other known effect explains it nearly as well.`,
    /** `doubts`: [name, names of rivals] */
    rivals: (chance, doubts) => `${chance}; but ${doubts.map(([name, names]) => `${either(names)} explains nearly as much as ${effect(name)}`).join(", and ")}: these runs do not surely tell them apart.`,
    decided: (chance, pairs) => `${chance}. ${pairs.map(([name, names]) => `${either(names)} explains nearly as much as ${effect(name)}`).join(", and ")}, but the odds are below one to a million: these runs tell them apart.`,
    limit: (least, most, unit, isGyro) => `${least} to ${most} ${unit} in ${isGyro ? "a gyro" : "an accelerometer"}`,
    none: (limits) => (limits.length === 0 ? "Smaller effects than these runs scatter may be there unseen."
      : `Smaller effects may be there unseen: one would be named in half of such campaigns from ${limits.join(", from ")}.`),
    usual: (usual) => `Nothing is named on a guess; such readings usually come from ${usual}.`,
    suspected: (suspects, usual) => `Suspected, but not surely enough to be named: ${suspects.join("; ")}${usual === null ? "" : `; else such readings usually come from ${usual}`}.`,
    /** @returns {import("./dom.mjs").Part[]} */
    cannotJudge: (reason) => ["Why: ", { english: reason }, "."],
    accepted: "Whether that was right only a run shows that no fit has seen.",
    compared: "A run that no fit has seen was compared: what it says stands under Before and after.",
  },
  next: {
    none: "The model lacks nothing that these runs can show: go on with what stands at the top.",
    unknown: "Look along that axis: fixture, cables, building. Then record again and search again.",
    look: (look) => `Look at ${look}. Then record again and search again.`,
    plateaus: (apart) => `Record a campaign with plateaus ${apart} K apart, then search again.`,
    thirdBranch: "Record a third branch: heat or cool once more over the same temperatures. Then search again.",
    again: "Record the same procedure again, then search again.",
    sameCycle: "Record the same cycle once more, then search again.",
    cannotJudge: "Record another run of the same procedure, or void the run that the reason names. Then search again.",
    carried: "The model carries what was found already: record a run that no fit has seen, then compare before and after.",
    /** `check`: a campaign */
    carriedWith: (check) => `The model carries what was found already: compare before and after. Campaign ${check} has runs that no fit has seen.`,
    /** @returns {import("./dom.mjs").Part[]} */
    tell: (name, rivals, experiment) => [`What was found may be ${effect(name)}, or ${either(rivals)}: these runs hardly tell. Before you accept it, record this: `, { english: experiment },
      ". Where it does not matter for the unit's use, leave it, and go on with what stands at the top."],
    /** `names`: of the effects, where not all that were found are to be accepted. */
    accept: (names) => `Accept ${names.length > 0 ? names.map(effect).join(" and ") : "it"}, record a run that no fit has seen, then compare before and after.`,
    acceptWith: (names, check) => `Accept ${names.length > 0 ? names.map(effect).join(" and ") : "it"}, then compare before and after: campaign ${check} has runs that no fit has seen.`,
  },
  evidence: {
    size: "Size",
    sensors: "In",
    chance: "Chance that scatter looks like it",
    hardlyAny: "below 1 in a million",
    takes: "Share of the gap that it explains, in runs it was not fitted to",
    rivals: "Nearly as good",
    noRivals: "nothing else",
    ruledOut: (names) => `nothing else: ${either(names)} is ruled out`,
    suspected: (name) => `Only suspected: ${effect(name)}`,
    experiment: "Next experiment: ",
    outside: "It shows in the single samples, not in their mean: the gap, which is one of means, stays as it is.",
  },
  shown: {
    title: "Before and after",
    bySensor: "Before and after, by sensor",
    noTerms: (version) => `Model ${version} carries no accepted effect: this is how far it is from what was measured.`,
    models: (before, after) => `Model ${before} before, model ${after} after`,
    noFresh: (models) => `${models}. No run is fresh, so nothing is proved yet: record one that no fit has seen.`,
    closer: (models, fresh, closer, judged) => `${models}, on ${plural(fresh, { one: `${fresh} fresh run`, other: `${fresh} fresh runs` })}: the gap is smaller in ${
      closer === judged ? "every sensor" : `${closer} of ${judged} sensors`} that the effects act on.`,
    compared: (time, user) => ` Compared ${time} by ${user}.`,
    /** Behind the sentence above, where fresh runs are judged by what was expected. */
    asExpected: " As much is closed as was expected.",
    less: (sensors) => ` In ${sensors} less is closed than was expected when it was accepted. The effect takes its part, as the gap is smaller with it: keep it. The rest is something else.`,
    /** `sensors`: that no effect acts on. */
    curve: (sensors) => ` In fresh runs ${sensors}, on which the effects do not act, are far above the floor, too: the curve over temperature does not fit these runs. Mostly they stand between plateaus that are far apart. Verify says whether that keeps the limits; if not, record plateaus closer together and fit again.`,
    searchAgain: " Record the calibration procedure once more, fit again and search again.",
    /** @returns {import("./dom.mjs").Part[]} */
    stale: (why) => [" It does not hold any more: ", why, "."],
    heads: ["Sensor", "Runs", "Before", "After", "Floor", "Unit", "Closed", "Expected when accepted (95 %)"],
    uses: { fresh: "fresh", fitted: "fitted" },
    tooSmall: "too small to tell",
    chance: "chance: the gap was small",
    interval: (low, high) => `${low} to ${high} %`,
  },
  map: {
    title: "Where it sits: plateau by position",
    effects: "Effects",
    without: "Without the effects found",
    with: "With them",
    about: "What the runs read beyond the curve over temperature, mean over the runs; ▲ reached by heating, ▼ by cooling. Rows are temperatures that the unit had, not those that were set. Coloured is what is more than chance would often make; among so many cells a single one may still be chance, a row or a column is not.",
    label: (sensor) => `Map of ${sensor}`,
    more: (sigmas) => `reads more, from ${sigmas} sigma`,
    less: (sigmas) => `reads less, from ${sigmas} sigma`,
    from: (sigmas) => `from ${sigmas}`,
    sweeps: { up: "heating", down: "cooling", unknown: "" },
    noSigma: "no run repeats another: sigma is not known",
    sigma: (least, most) => `1 sigma is ${least === most ? least : `${least} to ${most}`}`,
    any: "any",
  },
  steps: {
    title: "Where the bias steps",
    label: "Steps of the bias",
    heads: ["Run", "Sensor", "After its first reading at a plateau", "At, °C", "Size", "Unit"],
    span: (from, to) => `${from} to ${to}`,
  },
  slow: {
    title: "Slow noise",
    label: "Slow noise, by sensor",
    about: "How the bias wanders while the unit runs, in another way in each run: bias instability and rate random walk. It is counted as noise. Beside it stands the bias instability B of the longest rest of the unit, where one lasts half an hour or longer and shows it.",
    heads: ["Sensor", "Within a run (standard deviation)", "Unit", "Forgotten within minutes", "Within hours", "B at rest (95 %)"],
    rest: (value, low, high) => `${value} (${low} to ${high})`,
  },
  limits: {
    title: "What this search could not see",
    label: "Smallest effects that would be named",
    heads: ["Sensor", "Named in half of such campaigns from", "Gap without", "with the effects", "Floor", "Unit"],
    notTestable: (name) => `Not testable: ${effect(name)}: `,
    rejected: (run, sensor, segments, all) => `Rejected by the data gate: run ${run}${sensor ? `, ${sensor}` : ""}: ${segments} of ${all} segments: `,
  },
  accept: {
    title: "Accept into the model?",
    effects: "Effects",
    share: (percent) => `explains ${percent} % of the gap`,
    outside: "explains nothing of the gap: it shows in the single samples only",
    about: "Whether that was right only a run shows that no fit has seen: record one, where none is there yet, then compare before and after. Verify, release and export the unit again.",
    keep: "Leave the model as it is",
    send: "Accept",
    carried: "Carried already: withdraw it first in a terminal.",
    what: (newer, version) => `Model ${newer} will carry them: all runs are freed of them and fitted again. Model ${version} stays as it is. The search is done once more before; where it does not name one of them any more, nothing is taken.`,
    rivals: (names) => `Nearly as good: ${names.map(effect).join(", ")}. These runs hardly tell them apart.`,
  },
};
