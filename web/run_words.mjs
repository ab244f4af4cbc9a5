// SPDX-License-Identifier: Apache-2.0
// What the documents of stored runs mean in words. Nothing here touches the page.

import { number, significant } from "./format.mjs";

const PURPOSES = { calibration: null, verification: "verification", diagnosis: "pre-flight" };
const CAMPAIGN_STATES = { null: "imported" };

/**
 * Marks of a run: {text, state} with the states of a badge.
 * @param {import("./documents.mjs").Run} run
 */
export function marksOf(run) {
  const marks = [];
  if (run.voided) marks.push({ text: "void", state: "failed" });
  if (PURPOSES[run.purpose]) marks.push({ text: PURPOSES[run.purpose], state: "" });
  if (run.cut_short !== null) marks.push({ text: "cut short", state: "waiting" });
  if (run.samples_dropped !== null) marks.push({ text: "no samples", state: "waiting" });
  if (run.simulated) marks.push({ text: "SIMULATED", state: "simulated" });
  if (marks.length === 0) marks.push({ text: "complete", state: "finished" });
  return marks;
}

/**
 * Whether a fit may use it.
 * @param {import("./documents.mjs").Run} run
 */
export const counts = (run) => !run.voided && run.purpose !== "diagnosis";

export const campaignState = (state) => CAMPAIGN_STATES[state] ?? state;

/** "126, 3 refused, 6 void" */
export function segmentsText({ recorded, withdrawn, rejected }) {
  const parts = [String(recorded)];
  if (rejected > 0) parts.push(`${rejected} refused`);
  if (withdrawn > 0) parts.push(`${withdrawn} void`);
  return parts.join(", ");
}

const rejecting = (segment) => segment.findings.filter((finding) => finding.severity === "reject");

/** What became of a segment: {kind: "used" | "part" | "refused" | "void", title, why}. */
export function stateOf(segment) {
  if (segment.void) {
    return { kind: "void", title: "void", why: `${segment.void.reason} (${segment.void.user})` };
  }
  const findings = rejecting(segment);
  if (findings.length > 0) {
    const whole = findings.some((finding) => finding.sensor === null);
    const why = findings.map((f) => `${f.code}${f.sensor ? ` (${f.sensor})` : ""}: ${f.text}`).join("; ");
    return { kind: whole ? "refused" : "part", title: whole ? "refused" : "sensors refused", why };
  }
  return { kind: "used", title: "sound", why: segment.findings.map((f) => `${f.code}: ${f.text}`).join("; ") };
}

export const plateauText = ({ plateau_c }) => (plateau_c === null ? "no plateau" : `${number(plateau_c, 0)} °C`);
export const upText = ({ position, attempt }) => {
  const up = position === "" ? "at rest" : position.replace("-", "−");
  return attempt > 0 ? `${up}, attempt ${attempt + 1}` : up;
};
const sweepText = ({ sweep }) => (sweep === "unknown" ? "" : ` (${sweep})`);
export const placeText = (segment) => `${plateauText(segment)}${sweepText(segment)}, ${upText(segment)}`;

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
    add(`Only this segment: ${placeText(segment)}`, { visit, position, attempt }, (one) => samePlace(one) && one.attempt === attempt);
    if (attempts > 1) add(`All ${attempts} attempts at it`, { visit, position }, samePlace);
    add(`The whole visit to ${plateauText(segment)}`, { visit }, (one) => one.visit === visit);
  }
  add("The whole run", {}, () => true);
  return scopes;
}

/** What is lost. */
export function lossText(document, scope) {
  const before = document.segments.filter((segment) => !segment.void).length;
  const { run } = document;
  const all = scope.segments.length === before;
  const what = scope.record.visit === undefined
    ? `Run ${run.run} of unit ${run.unit} becomes void, with all ${before} of its segments that are not void yet.`
    : `${scope.segments.length} of the ${before} segments of run ${run.run} that are not void yet ${scope.segments.length === 1 ? "becomes" : "become"} void${all ? ": none is left" : ""}.`;
  const kept = run.samples_dropped === null ? "The samples are kept, but this" : "This";
  return `${what} No fit, no verification and no report uses what is void. Models that were fitted from it stay as they are until the
    unit is fitted again. ${kept} cannot be taken back.`;
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
  const text = name.replace(/_c$/, " °C").replace(/_/g, " ");
  return stream === "imu" ? text : `${stream}: ${text}`;
}

const PANELS = { "°C": "Temperature", "°/s": "Rotation rate", "m/s²": "Specific force", V: "Voltage", A: "Current" };
export const panelTitle = (unit) => [PANELS[unit], unit].filter(Boolean).join(", ") || "Without a unit";

// ---- times in a run

/** "2:05:07", with so many decimals of the second as `step_s` needs. */
export function runTime(t_s, step_s = 1) {
  const decimals = Math.max(0, Math.min(6, Math.ceil(-Math.log10(step_s) - 1e-9)));
  const ticks = Math.round(Math.abs(t_s) * 10 ** decimals);
  const whole = Math.floor(ticks / 10 ** decimals);
  const two = (n) => String(n).padStart(2, "0");
  const rest = decimals ? `.${String(ticks % 10 ** decimals).padStart(decimals, "0")}` : "";
  const minutes = Math.floor((whole % 3600) / 60);
  return `${t_s < 0 && ticks > 0 ? "−" : ""}${Math.floor(whole / 3600)}:${two(minutes)}:${two(whole % 60)}${rest}`;
}

/** A value with the digits that a range of that size shows apart. */
export function valueText(value, range) {
  if (value === null || !Number.isFinite(value)) return "–";
  if (!(range > 0)) return significant(value, 6);
  return number(value, Math.max(0, Math.min(9, 3 - Math.floor(Math.log10(range)))));
}
