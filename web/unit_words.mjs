// SPDX-License-Identifier: Apache-2.0
// What the documents of units and jobs mean in words that a technician acts on. Nothing here touches the page.

import { number, shortDuration, significant, UNKNOWN } from "./format.mjs";
import { effectName, gapVerdictOf } from "./gap_words.mjs";

/** Kinds of jobs: what the button, a running job and an ended one are called. */
const KINDS = {
  fit: { verb: "Fit", doing: "Fitting", noun: "Fit" },
  verify: { verb: "Verify", doing: "Verifying", noun: "Verification" },
  report: { verb: "Report", doing: "Writing the report", noun: "Report" },
  export: { verb: "Export", doing: "Exporting", noun: "Export" },
  gap_find: { verb: "Search", doing: "Searching for what the model lacks", noun: "Gap search" },
  gap_accept: { verb: "Accept", doing: "Fitting again with the accepted effects", noun: "Accepted" },
  gap_show: { verb: "Compare", doing: "Comparing before and after", noun: "Before and after" },
};
const VERDICTS = {
  pass: { title: "PASS", state: "finished" },
  marginal: { title: "MARGINAL", state: "waiting" },
  fail: { title: "FAIL", state: "failed" },
  not_measured: { title: "NOT MEASURED", state: "waiting" },
};
const NOT_JUDGED = { title: "NOT JUDGED", state: "" };

/** What the formats are for, in the order in which they are offered: name in the interface → text. */
export const FORMATS = {
  blob: "Calibration file (.soakcal)",
  c: "C header (.h)",
  json: "JSON",
  px4: "PX4 parameters",
  ardupilot: "ArduPilot parameters",
  kalibr: "Kalibr noise values",
};

/** {title, state}: of the document's verdict, null where nothing has been judged. */
export const verdictOf = (verdict) => (verdict !== null && Object.hasOwn(VERDICTS, verdict) ? VERDICTS[verdict] : NOT_JUDGED);

/**
 * The verdict that holds for the newest model, or null.
 * @param {import("./documents.mjs").Unit} unit
 */
export function verdictNow({ verification }) {
  return verification && verification.stale === null ? (verification.job.result.verdict ?? null) : null;
}

const curvesWith = (sensors, verdict) =>
  Object.entries(sensors).filter(([, sensor]) => sensor.verdict === verdict).map(([name]) => sensorText(name)).join(", ");

/**
 * Why the verdict is what it is, one sentence.
 * @param {import("./documents.mjs").Unit} unit
 */
export function verdictText(unit) {
  const { model, verification } = unit;
  if (model === null) return "There is no model of this unit yet.";
  if (verification === null) return `Model ${model.version} has not been verified here.`;
  const { job, stale } = verification;
  const by = `Model ${job.result.model} against campaign ${job.campaign}, by ${job.user}`;
  if (stale !== null) return `The last verification does not hold any more: ${stale}. It was ${verdictOf(job.result.verdict).title}: ${by}.`;
  const { verdict, sensors, limits } = job.result;
  if (verdict === "info" && limits === null) return `${by}: no limits are set for the type ${unit.type}, so nothing was judged.`;
  const which = verdict === "pass" ? "" : curvesWith(sensors, verdict === "info" ? "not_measured" : verdict);
  const words = { pass: "all sensors are within their limits", fail: "beyond the limits", marginal: "too near to the limits to tell", info: "not measured" };
  return `${by}: ${[words[verdict], which].filter(Boolean).join(": ")}.`;
}

/**
 * What is to be done next: {kind, text, link}; `kind` of the job that does it, null where none does; `link`: {text, address} of where it is done or described.
 * @param {import("./documents.mjs").Unit} unit
 */
export function nextOf(unit) {
  const { model, verify_with, exported } = unit;
  if (model === null && unit.to_fit === 0) return { kind: null, text: "Record a campaign with it, or import its recordings." };
  if (model === null) return { kind: "fit", text: "Fit it." };
  if (model.epoch !== unit.epoch) return { kind: null, text: "Record it as it is now and fit it again: it was repaired or changed after this model." };
  if (unit.warnings.some(({ code }) => code === "voided_since")) return { kind: "fit", text: "Fit it again: data of this model were withdrawn." };
  const verdict = verdictNow(unit);
  if (verdict === null && verify_with.length > 0) return { kind: "verify", text: "Verify it with a run that the fit has not seen." };
  if (verdict === null) return { kind: null, text: "Record a run that the fit has not seen with a verification procedure, then verify it.", link: { text: "New campaign", address: "#station" } };
  if (verdict === "fail") return { kind: "report", text: "Do not hand it over: it exceeds its limits. The report shows where." };
  if (verdict === "marginal") return { kind: null, text: "Do not hand it over as passed: record more runs for the fit or the verification, and verify it again." };
  if (verdict !== "pass") return { kind: null, text: `Write limits into the file of its type, ${unit.type}.toml, or verify it over the whole range: it is not judged yet.`, link: { text: "How", address: "#help=guide&at=8-verify" } };
  if (warningsOf(unit).some(({ code, urgency }) => urgency === "grave" && code !== "simulated")) return { kind: "report", text: "Do not hand it over before the first warning below is settled." };
  return exported === null ? { kind: "export", text: "Export it." } : { kind: null, text: "Nothing: it is verified and exported." };
}

// ---- warnings

const URGENCIES = ["grave", "act", "none"];

/**
 * Those of the model and of its verification, the gravest first.
 * @param {import("./documents.mjs").Unit} unit
 */
export function warningsOf({ warnings, verification }) {
  const rank = ({ urgency }) => URGENCIES.indexOf(urgency);
  return [...warnings, ...(verification?.warnings ?? [])].sort((a, b) => rank(a) - rank(b));
}

/** A warning about each of several sensors in the same words is one: its `text` then does not begin with the sensor, which `sensors` names. */
function gathered(warnings) {
  const found = new Map();
  for (const warning of warnings) {
    const [first] = warning.sensors;
    const text = first && warning.text.startsWith(first) ? warning.text.slice(first.length).replace(/^:? /, "") : warning.text;
    const key = JSON.stringify([warning.code, text, warning.remedy, warning.urgency]);
    const same = found.get(key);
    found.set(key, same ? { ...same, text, sensors: [...new Set([...same.sensors, ...warning.sensors])] } : warning);
  }
  return [...found.values()];
}

/**
 * {act, rest}: those that ask for something, the gravest first, and those that ask for nothing.
 * @param {import("./documents.mjs").Unit} unit
 */
export function sortedWarnings(unit) {
  const warnings = gathered(warningsOf(unit));
  const asks = ({ urgency }) => urgency !== "none";
  return { act: warnings.filter(asks), rest: warnings.filter((warning) => !asks(warning)) };
}

// ---- sensors

export const sensorText = (name) => name.replace("_", " ");
export const unitText = ({ unit }) => ({ "deg/s": "°/s", "m/s2": "m/s²" })[unit] ?? unit;

/** An error as people read it; small ones with the digits that they have. */
const size = (value) => (value === null ? UNKNOWN : significant(value, 2));

/**
 * [name, value] of what is stated of a sensor's curve.
 * @param {import("./documents.mjs").Sensor} sensor
 */
export function sensorFacts(sensor) {
  const unit = unitText(sensor);
  const residual = sensor.check_rmse_shape === null ? ["Residual of the fit", `${size(sensor.train_rmse)} ${unit}`]
    : ["Residual, held-out runs", `${size(sensor.check_rmse_shape)} ${unit}`];
  const widest = Math.max(...sensor.curve.map(({ ci95 }) => ci95));
  return [
    ["Curve", sensor.deployed === "anfis" ? `ANFIS, ${sensor.rules} rules` : sensor.deployed],
    residual,
    ["Run to run", sensor.run_to_run_sigma === null ? "not known" : `${size(sensor.run_to_run_sigma)} ${unit}`],
    ["Span", `${number(sensor.temp_min_c, 0)} to ${number(sensor.temp_max_c, 0)} °C`],
    ["95 % band, widest", `±${size(widest)} ${unit}`],
  ];
}

// ---- jobs

export const verbOf = (kind) => KINDS[kind]?.verb ?? kind;

/**
 * "Fitting SN1 since 12 s, by Eva"
 * @param {import("./documents.mjs").Job} job
 * @param {number} now_s
 */
export function runningText(job, now_s) {
  const since = shortDuration(Math.max(0, Math.round(now_s - job.started_utc_s)));
  return `${KINDS[job.kind]?.doing ?? job.kind}: unit ${job.unit}, for ${since} now, started by ${job.user}`;
}

/** @param {import("./documents.mjs").Job} job */
const detailOf = ({ kind, campaign, format, effects, sign, result }) => {
  if (kind === "gap_accept") return ` ${effects.map(effectName).join(", ")}${result ? `: model ${result.model}` : ""}`;
  if (kind === "verify") return ` against ${campaign}`;
  if (kind === "export") return ` as ${Object.hasOwn(FORMATS, format ?? "") ? FORMATS[format] : format}${sign ? `, signed${result?.key_id ? ` with key ${result.key_id}` : ""}` : ""}`;
  return kind === "fit" && result ? `: model ${result.model}` : "";
};

/**
 * What a job that has ended did: {title, badge, text}; `text` is why not, or what came of it.
 * @param {import("./documents.mjs").Job} job
 */
export function endedText(job) {
  const title = `${KINDS[job.kind]?.noun ?? job.kind}${detailOf(job)}`;
  if (job.state === "done") {
    const verdict = job.result?.verdict;
    const judged = job.kind === "gap_find" ? gapVerdictOf : verdictOf;
    const shown = verdict === undefined ? { title: "done", state: "finished" } : judged(verdict);
    return { title, badge: { text: shown.title, state: shown.state }, text: job.result?.sentence ?? job.result?.reason ?? "" };
  }
  const state = job.state === "failed" ? "failed" : "waiting";
  return { title, badge: { text: job.state, state }, text: job.message ?? "" };
}
