// SPDX-License-Identifier: Apache-2.0
// What the card of a unit's gap says, in English.

import { plural } from "./format.mjs";

/** "sensor lag" */
const effect = (name) => name.replaceAll("_", " ");
const either = (names) => names.map(effect).join(" or ");

export const text = {
  card: {
    title: "Gap: what the model does not explain",
    find: "Search",
    show: "Compare before and after",
    none: "Nobody has searched yet, or the result is not kept. A search takes the runs that a fit takes: two of one procedure at least, better six.",
    next: "What to do next",
    accept: "Accept…",
    /** @returns {import("./dom.mjs").Part[]} */
    stale: (version, time, user, why) => [`This search is of model ${version}, ${time} by ${user}. It does not hold any more: `, { english: why }, "."],
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
  allSensors: "all sensors",
  found: {
    none: "What the unit read beyond the model is no more than how its runs differ. Smaller effects may be there unseen: the limits are below.",
    /** @type {(where: import("./dom.mjs").Part[]) => import("./dom.mjs").Part[]} `where`: what follows() says, or nothing */
    unknown: (where) => ["The unit reads something that no known effect explains.", ...where, " Nothing is named on a guess."],
    /** @returns {import("./dom.mjs").Part[]} */
    follows: (axis, sensors) => [" It follows ", { english: axis }, `, in ${sensors}.`],
    cannotJudge: "These runs cannot show whether the model lacks something.",
    one: (effect, size, sensors) => `${effect} (${size}) in ${sensors}`,
    accepted: (effects, version, newest) => `A search found ${effects.join(" and ")} in model ${version}. Model ${newest} carries ${effects.length === 1 ? "it" : "them"}.`,
    lacks: (effects) => `The model lacks ${effects.join("; and ")}.`,
  },
  next: {
    none: "The model lacks nothing that these runs can show: go on with what stands at the top.",
    unknown: "Look along that axis: fixture, cables, building. Then record again and search again.",
    cannotJudge: "Record another run of the same procedure, or void the run that the reason names. Then search again.",
    carried: "The model carries what was found already: record a run that no fit has seen, then compare before and after.",
    /** @returns {import("./dom.mjs").Part[]} */
    tell: (name, rivals, experiment) => [`What was found may be ${effect(name)}, or ${either(rivals)}: these runs hardly tell. Before you accept it, record this: `, { english: experiment }, "."],
    /** `names`: of the effects, where not all that were found are to be accepted. */
    accept: (names) => `Accept ${names.length > 0 ? names.map(effect).join(" and ") : "it"}, record a run that no fit has seen, then compare before and after.`,
  },
  evidence: {
    size: "Size",
    sensors: "In",
    chance: "Chance that scatter looks like it",
    hardlyAny: "below 1 in a million",
    takes: "Takes of the gap in runs set aside",
    rivals: "Nearly as good",
    noRivals: "nothing else",
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
    /** @returns {import("./dom.mjs").Part[]} */
    stale: (why) => [" It does not hold any more: ", { english: why }, "."],
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
    about: "What the runs read beyond the curve over temperature, mean over the runs; ▲ reached by heating, ▼ by cooling. Coloured is what is more than chance would often make; among so many cells a single one may still be chance, a row or a column is not.",
    label: (sensor) => `Map of ${sensor}`,
    more: (sigmas) => `reads more, from ${sigmas} sigma`,
    less: (sigmas) => `reads less, from ${sigmas} sigma`,
    from: (sigmas) => `from ${sigmas}`,
    sweeps: { up: "heating", down: "cooling", unknown: "" },
    noSigma: "no run repeats another: sigma is not known",
    sigma: (least, most) => `1 sigma is ${least === most ? least : `${least} to ${most}`}`,
    any: "any",
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
    about: "Whether that was right only a run shows that no fit has seen: record one, then compare before and after. Verify, release and export the unit again.",
    keep: "Leave the model as it is",
    send: "Accept",
    carried: "Carried already: withdraw it first in a terminal.",
    what: (newer, version) => `Model ${newer} will carry them: all runs are freed of them and fitted again. Model ${version} stays as it is. The search is done once more before; where it does not name one of them any more, nothing is taken.`,
    rivals: (names) => `Nearly as good: ${names.map(effect).join(", ")}. These runs hardly tell them apart.`,
  },
};
