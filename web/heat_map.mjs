// SPDX-License-Identifier: Apache-2.0
// What a sensor read beyond the base at each plateau and position, as a table whose cells stand out where they are more than
// chance.

import { element } from "./dom.mjs";
import { number, written } from "./format.mjs";
import { G, biasText, biasUnitOf } from "./gap_words.mjs";
import { sensorText } from "./unit_words.mjs";

const STEPS = [3, 6, 12]; // standard errors of a cell from which on it is coloured, and more so
const SWEEPS = { up: "▲", down: "▼", unknown: "" };

/** 0: within chance; 1 to 3: further off. */
function stepOf(value, sigma) {
  if (!(sigma > 0)) return 0;
  return STEPS.filter((step) => Math.abs(value) >= step * sigma).length;
}

/** What the colours mean, as entries of a legend. */
export function mapKey() {
  const entry = (style, text) => {
    const swatch = element("span", "");
    swatch.className = `heat ${style}`;
    const line = element("li", "");
    line.append(swatch, text);
    return line;
  };
  const [one, two, three] = STEPS;
  return [entry("hot-1", G.map.more(one)), entry("hot-2", G.map.from(two)), entry("hot-3", G.map.from(three)), entry("cold-1", G.map.less(one)),
    entry("cold-2", G.map.from(two)), entry("cold-3", G.map.from(three))];
}

function plateauHead({ temp_c, sweep }) {
  const head = element("th", `${written(String(Number(temp_c.toFixed(1)) + 0))} °C `);
  head.scope = "row";
  const sign = element("span", SWEEPS[sweep]);
  sign.ariaHidden = "true";
  head.append(sign, Object.assign(element("span", G.map.sweeps[sweep]), { className: "unseen" }));
  return head;
}

/** One digit more than the standard error has: what is beyond is chance. */
const decimalsOf = (sigma) => (sigma > 0 ? Math.max(0, 1 - Math.floor(Math.log10(1000 * sigma))) : 3);

function cell(value, sigma) {
  const node = element("td", number(value === null ? null : 1000 * value, decimalsOf(sigma)));
  const step = value === null ? 0 : stepOf(value, sigma);
  if (step > 0) node.className = `${value > 0 ? "hot" : "cold"}-${step}`;
  return node;
}

/** "1 sigma is 0.31 to 0.44": cells that fewer runs have are known less well. */
function sigmaText(sigma) {
  if (sigma === null) return G.map.noSigma;
  const known = sigma.flat().filter((value) => value !== null);
  const [least, most] = [Math.min(...known), Math.max(...known)].map((value) => biasText(value));
  return G.map.sigma(least, most);
}

/** The table of one sensor; `values`: its part `before` or `after` of the document's map. */
export function heatTable(name, { sigma }, values, { plateaus, positions }) {
  const table = element("table", "");
  table.className = "heat-map";
  const caption = element("caption", "");
  caption.append(element("b", sensorText(name)), ` ${biasUnitOf(name)}; ${sigmaText(sigma)}`);
  const head = element("tr", "");
  head.append(element("td", ""), ...positions.map((position) => Object.assign(element("th", position || G.map.any), { scope: "col" })));
  const top = element("thead", "");
  top.append(head);
  const body = element("tbody", "");
  body.append(...plateaus.map((plateau, row) => {
    const line = element("tr", "");
    line.append(plateauHead(plateau), ...positions.map((_, column) => cell(values[row][column], sigma === null ? null : sigma[row][column])));
    return line;
  }));
  table.append(caption, top, body);
  return table;
}
