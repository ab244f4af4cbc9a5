// SPDX-License-Identifier: Apache-2.0
// From the answers of GET /api/v1/run/series to what is drawn. Nothing here touches the page.

import { channelText, quantityOf } from "./run_words.mjs";

const GAP = 4; // times the widest usual spacing: nothing is known of the time between
const USUAL = 0.9; // of the spacings are usual, however they differ: where time is simulated fast, the chamber's do by a factor of ten
const [FEWEST_POINTS, MOST_POINTS] = [200, 2000]; // the latter is the station's limit
const POINT_PIXELS = 2; // of one stretch: what is drawn takes as long as it has points
const STEPS_S = [1, 2, 5, 10, 15, 30, 60, 120, 300, 600, 900, 1800, 3600, 7200, 14400, 21600, 43200, 86400];

/** The value that so large a share of them does not exceed; 0 of none. */
const quantile = (values, share) => [...values].sort((a, b) => a - b)[Math.floor(share * (values.length - 1))] ?? 0;

/** A pause of the recording parts the line: a point without a value between. */
function withGaps(points) {
  const usual_s = quantile(points.slice(1).map((point, i) => point.t_s - points[i].t_s), USUAL);
  return points.flatMap((point, i) => {
    const before = points[i - 1];
    if (!before || point.first_s - before.last_s <= GAP * usual_s) return [point];
    const t_s = (before.last_s + point.first_s) / 2;
    return [{ t_s, first_s: t_s, last_s: t_s, low: NaN, mean: NaN, high: NaN }, point];
  });
}

function samplesOf(t_s, { values }, shown) {
  const points = t_s.map((t, i) => ({ t_s: t, first_s: t, last_s: t, value: values[i] })).filter(({ value }) => value !== null);
  return points.map(({ value, ...time }) => ({ ...time, low: shown(value), mean: shown(value), high: shown(value) }));
}

function bucketsOf(channel, shown) {
  return channel.t_first_s.map((first_s, i) => ({
    t_s: (first_s + channel.t_last_s[i]) / 2,
    first_s,
    last_s: channel.t_last_s[i],
    low: shown(channel.minimum[i]),
    mean: shown(channel.mean[i]),
    high: shown(channel.maximum[i]),
  }));
}

/**
 * What the station is asked for channels {stream, name} of a run over a span: one question for each stream. `width`: of the chart, in pixels.
 * @returns {string[]}
 */
export function questionsOf({ run_id, unit }, channels, from_s, to_s, width) {
  const points = Math.round(Math.min(MOST_POINTS, Math.max(FEWEST_POINTS, width / POINT_PIXELS)));
  return [...new Set(channels.map(({ stream }) => stream))].map((stream) => {
    const question = new URLSearchParams({ run: run_id, unit, stream, from_s: String(from_s), to_s: String(to_s), points: String(points) });
    for (const channel of channels) if (channel.stream === stream) question.append("channel", channel.name);
    return `run/series?${question}`;
  });
}

/** One line for each channel of an answer: {key, name, unit, raw, points}, points {t_s, first_s, last_s, low, mean, high} rising in time. */
export function linesOf(series) {
  const raw = series.kind === "samples";
  return series.channels.map((channel) => {
    const { unit, factor, offset } = quantityOf(channel.unit);
    const shown = (value) => factor * value + offset;
    const points = withGaps(raw ? samplesOf(series.t_s, channel, shown) : bucketsOf(channel, shown));
    return { key: `${series.stream}/${channel.name}`, name: channelText(series.stream, channel.name), unit, raw, points };
  });
}

/** Rows for dygraphs with `customBars`: time, then [low, mean, high] of each line, null where it has no point then. */
export function tableOf(lines, from_s, to_s) {
  const rows = new Map();
  const row = (t_s) => {
    if (!rows.has(t_s)) rows.set(t_s, [t_s, ...lines.map(() => null)]);
    return rows.get(t_s);
  };
  lines.forEach(({ points }, i) => points.forEach(({ t_s, low, mean, high }) => { row(t_s)[i + 1] = [low, mean, high]; }));
  if (rows.size === 0) [from_s, to_s].forEach(row); // dygraphs draws no axes for nothing
  return [...rows.values()].sort((a, b) => a[0] - b[0]);
}

/** Index of the element of the rising `values` that is nearest to `value`; -1 where there is none. */
export function nearest(values, value) {
  let low = 0;
  let high = values.length - 1;
  while (high - low > 1) {
    const at = (low + high) >> 1;
    if (values[at] < value) low = at;
    else high = at;
  }
  return high < 0 ? -1 : value - values[low] <= values[high] - value ? low : high;
}

/** Round times from `from_s` to `to_s`, at most about `most`: {step_s, times_s}. */
export function timeTicks(from_s, to_s, most) {
  const rough = (to_s - from_s) / Math.max(1, most);
  const power = 10 ** Math.floor(Math.log10(rough));
  const fine = [1, 2, 5, 10].map((m) => m * power).find((s) => s >= rough);
  const step_s = rough <= 0.5 ? fine : STEPS_S.find((s) => s >= rough) ?? 86400 * Math.ceil(rough / 86400);
  const times_s = [];
  for (let k = Math.ceil(from_s / step_s - 1e-9); k * step_s <= to_s + 1e-9 * step_s; ++k) times_s.push(k * step_s);
  return { step_s, times_s };
}
