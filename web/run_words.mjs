// SPDX-License-Identifier: Apache-2.0
// What the documents of stored runs mean in words. Nothing here touches the page.

import { number, setTemperature, significant, written } from "./format.mjs";
import { T, textsOf } from "./text.mjs";

/** @type {typeof import("./text_runs_en.mjs").text} */
export const R = await textsOf("runs");

const PURPOSES = { calibration: null, verification: R.marks.verification, diagnosis: R.marks.diagnosis };

/**
 * Marks of a run: {text, state} with the states of a badge.
 * @param {import("./documents.mjs").Run} run
 */
export function marksOf(run) {
  const marks = [];
  if (run.voided) marks.push({ text: R.marks.void, state: "failed" });
  if (PURPOSES[run.purpose]) marks.push({ text: PURPOSES[run.purpose], state: "" });
  if (run.cut_short !== null) marks.push({ text: R.marks.cutShort, state: "waiting" });
  if (run.samples_dropped !== null) marks.push({ text: R.marks.noSamples, state: "waiting" });
  if (run.simulated) marks.push({ text: R.marks.simulated, state: "simulated" });
  if (marks.length === 0) marks.push({ text: R.marks.complete, state: "finished" });
  return marks;
}

/**
 * Whether a fit may use it.
 * @param {import("./documents.mjs").Run} run
 */
export const counts = (run) => !run.voided && run.purpose !== "diagnosis";

export const campaignState = (state) => (state === null ? T.imported : T.states[state] ?? state);

/** "126, 3 refused, 6 void" */
export function segmentsText({ recorded, withdrawn, rejected }) {
  const parts = [String(recorded)];
  if (rejected > 0) parts.push(R.list.refused(rejected));
  if (withdrawn > 0) parts.push(R.list.void(withdrawn));
  return parts.join(", ");
}

const rejecting = (segment) => segment.findings.filter((finding) => finding.severity === "reject");

/** The data gate's findings: their names, and what the station says of each. */
const findingsText = (findings) => findings.flatMap(({ code, sensor, text }, i) => [`${i > 0 ? "; " : ""}${R.segments.finding(code, sensor)}: `, { english: text }]);

/** What became of a segment: {kind: "used" | "part" | "refused" | "void", title, why}; `why`: parts of a sentence. */
export function stateOf(segment) {
  if (segment.void) {
    return { kind: "void", title: R.segments.states.void, why: [`${segment.void.reason} (${segment.void.user})`] };
  }
  const findings = rejecting(segment);
  if (findings.length > 0) {
    const kind = findings.some((finding) => finding.sensor === null) ? "refused" : "part";
    return { kind, title: R.segments.states[kind], why: findingsText(findings) };
  }
  return { kind: "used", title: R.segments.states.used, why: findingsText(segment.findings) };
}

export const plateauText = ({ plateau_c }) => (plateau_c === null ? R.segments.noPlateau : `${setTemperature(plateau_c)} °C`);
export const upText = ({ position, attempt }) => {
  const up = position === "" ? R.segments.atRest : position.replace("-", "−");
  return attempt > 0 ? R.segments.attempt(up, attempt + 1) : up;
};
export const placeText = (segment) => `${plateauText(segment)}${R.segments.sweeps[segment.sweep]}, ${upText(segment)}`;

// ---- what may become void

/** The parts of a run that hold `segment`, the smallest first; without a segment only the run: {text, record, segments}. */
export function scopesOf(document, segment) {
  const { segments } = document;
  const scopes = [];
  const add = (text, record, holds) => {
    scopes.push({ text, record, segments: segments.filter((one) => !one.void && holds(one)) });
  };
  if (segment) {
    const { visit, position, attempt } = segment;
    const samePlace = (one) => one.visit === visit && one.position === position;
    const attempts = segments.filter(samePlace).length;
    add(R.void.segment(placeText(segment)), { visit, position, attempt }, (one) => samePlace(one) && one.attempt === attempt);
    if (attempts > 1) add(R.void.attempts(attempts), { visit, position }, samePlace);
    add(R.void.visit(plateauText(segment)), { visit }, (one) => one.visit === visit);
  }
  add(R.void.run, {}, () => true);
  return scopes;
}

/** What is lost. */
export function lossText(document, scope) {
  const before = document.segments.filter((segment) => !segment.void).length;
  const { run } = document;
  const what = scope.record.visit === undefined ? R.void.losesRun(run.run, run.unit, before) : R.void.losesSegments(scope.segments.length, before, run.run);
  return `${what} ${R.void.notUsed} ${run.samples_dropped === null ? R.void.keepsSamples : R.void.final}`;
}

// ---- units of channels, as people read them

const DEGREES = 180 / Math.PI;
const QUANTITIES = {
  c: ["°C", 1, 0], k: ["°C", 1, -273.15], f: ["°C", 5 / 9, -160 / 9],
  dps: ["°/s", 1, 0], rps: ["°/s", DEGREES, 0], degph: ["°/s", 1 / 3600, 0],
  mps2: ["m/s²", 1, 0], g: ["m/s²", 9.80665, 0], mg: ["m/s²", 0.00980665, 0],
  v: ["V", 1, 0], a: ["A", 1, 0], s: ["s", 1, 0], deg: ["°", 1, 0],
};

/** {unit, factor, offset}: shown = factor · value + offset. A unit that is not known is shown as it is. */
export function quantityOf(unit) {
  const [text, factor, offset] = Object.hasOwn(QUANTITIES, unit) ? QUANTITIES[unit] : [unit, 1, 0];
  return { unit: text, factor, offset };
}

/** A channel as people read it: "temp °C", "gyro x", "chamber: air rh". */
export function channelText(stream, name) {
  const text = R.strip.channel(name);
  return stream === "imu" ? text : `${R.strip.stream(stream)}: ${text}`;
}

export const panelTitle = (unit) => [R.strip.panels[unit], unit].filter(Boolean).join(", ") || R.strip.noUnit;

// ---- times in a run

/** "2:05:07", with so many decimals of the second as `step_s` needs. */
export function runTime(t_s, step_s = 1) {
  const decimals = Math.max(0, Math.min(6, Math.ceil(-Math.log10(step_s) - 1e-9)));
  const ticks = Math.round(Math.abs(t_s) * 10 ** decimals);
  const whole = Math.floor(ticks / 10 ** decimals);
  const two = (n) => String(n).padStart(2, "0");
  const rest = decimals ? written(`.${String(ticks % 10 ** decimals).padStart(decimals, "0")}`) : "";
  const minutes = Math.floor((whole % 3600) / 60);
  return `${t_s < 0 && ticks > 0 ? "−" : ""}${Math.floor(whole / 3600)}:${two(minutes)}:${two(whole % 60)}${rest}`;
}

/** A value with the digits that a range of that size shows apart. */
export function valueText(value, range) {
  if (value === null || !Number.isFinite(value)) return "–";
  if (!(range > 0)) return significant(value, 6);
  return number(value, Math.max(0, Math.min(9, 3 - Math.floor(Math.log10(range)))));
}

/** Whether stretches of samples are shown of at least one stream, instead of every sample. */
export const isStretches = (answers) => answers.some(({ kind }) => kind === "buckets");

/** Which span the strip chart shows, and how, once the station has answered. */
export function windowText(from_s, to_s, answers) {
  const step_s = (to_s - from_s) / 1000;
  const digits_s = step_s >= 1 ? 1 : 10 ** Math.floor(Math.log10(step_s));
  const rows = Math.max(0, ...answers.map((answer) => answer.rows));
  const how = answers.length === 0 ? "" : isStretches(answers) ? R.strip.stretches(rows) : R.strip.everySample(rows);
  return `${R.strip.window(runTime(from_s, digits_s), runTime(to_s, digits_s))}${how}`;
}
