// SPDX-License-Identifier: Apache-2.0
// The banner of what needs somebody at once, with a sound where the user wants one.

import { $, element, say, show } from "./dom.mjs";
import { T } from "./text.mjs";
import { alertsOf } from "./words.mjs";

const KEY = "soak-alarm-sound";
const AGAIN_MS = 4000;
const TONES_HZ = [880, 660];
const TONE_S = 0.22;

let context = null;
let alarmed = false;

const isWanted = () => localStorage.getItem(KEY) === "on";

/**
 * Whether sound is allowed: by the browser's rules only once the user has touched the page. What is scheduled before that
 * would sound all at once later, so nothing is.
 */
const isAllowed = () => context?.state === "running";

/** Asks the browser for sound; when it allows it, the alarm that there is sounds at once. */
function ask() {
  if (!context) {
    context = new AudioContext();
    context.addEventListener("statechange", () => {
      renderToggle();
      beep();
    });
  }
  context.resume();
}

function beep() {
  if (!alarmed || !isWanted()) return;
  if (!isAllowed()) return ask();
  TONES_HZ.forEach((hertz, i) => {
    const [tone, volume] = [context.createOscillator(), context.createGain()];
    const begin = context.currentTime + i * TONE_S;
    tone.frequency.value = hertz;
    volume.gain.value = 0.15;
    tone.connect(volume).connect(context.destination);
    tone.start(begin);
    tone.stop(begin + TONE_S);
  });
}

function renderToggle() {
  $("sound").setAttribute("aria-pressed", isWanted());
  const text = !isWanted() ? T.head.soundOff : isAllowed() ? T.head.soundOn : T.head.soundAsks;
  say($("sound"), text);
  $("sound").title = text;
  $("sound").toggleAttribute("data-asks", isWanted() && !isAllowed());
}

export function connectAlerts() {
  $("sound").addEventListener("click", () => {
    const wanted = !isWanted() || !isAllowed();
    localStorage.setItem(KEY, wanted ? "on" : "off");
    renderToggle();
    if (wanted && !isAllowed()) ask();
    else beep();
  });
  if (isWanted()) ask();
  renderToggle();
  setInterval(beep, AGAIN_MS);
}

function alertNode({ level, title, detail, action }) {
  const node = element("li", "");
  node.className = level;
  node.append(element("strong", title));
  if (detail) node.append(Object.assign(element("p", detail), { lang: "en" }));
  node.append(Object.assign(element("p", action), { className: "action" }));
  return node;
}

/**
 * Written anew only where something has changed: a screen reader says it again then.
 * @param {import("./documents.mjs").Status} status
 */
export function renderAlerts(status) {
  const alerts = alertsOf(status);
  const text = JSON.stringify(alerts);
  if ($("alerts").dataset.text === text) return;
  $("alerts").dataset.text = text;
  $("alert-list").replaceChildren(...alerts.map(alertNode));
  show($("alerts"), alerts.length > 0);
  const was = alarmed;
  alarmed = alerts.some(({ level }) => level === "alarm");
  if (alarmed && !was) beep();
}
