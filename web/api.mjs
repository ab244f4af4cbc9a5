// SPDX-License-Identifier: Apache-2.0
// The station's HTTP interface (docs/http-api.md).

const ROOT = "/api/v1/";
const RETRY_MS = 2000;
const SILENCE_MS = 20000;
const LOCK = "soak-events";
const CHANNEL = "soak-events";
const NOT_KNOWN = 401; // docs/access.md

function logIn() {
  location.assign(`login.html${location.hash}`);
}

/**
 * Answer of GET /api/v1/`path`. Throws where there is none.
 * @template {string} P
 * @param {P} path
 * @returns {Promise<import("./documents.mjs").AnswerTo<P>>}
 */
export async function get(path) {
  return answer(await fetch(ROOT + path));
}

/**
 * A function that brings the jobs to `take`, one question at a time: called while an answer is under way, it asks once more, so that what is taken last
 * is never older than the call. A question that is not answered says nothing about the jobs, and is asked again before long by whoever calls.
 * @param {(jobs: import("./documents.mjs").Job[]) => unknown} take
 * @returns {() => Promise<boolean>} whether this call has looked, and not one that was looking already
 */
export function looksForJobs(take) {
  let isLooking = false;
  let looksAgain = false;
  return async () => {
    looksAgain = true;
    if (isLooking) return false;
    isLooking = true;
    while (looksAgain) {
      looksAgain = false;
      try {
        await take((await get("jobs")).jobs);
      } catch (error) {
        console.warn("no jobs:", error.message);
      }
    }
    isLooking = false;
    return true;
  };
}

/** Whether the station has too much to do for a question now, by the error that get() throws: it can be asked again before long. */
export const isBusy = ({ status }) => status === 503;

/** Carries out POST /api/v1/`path`. Throws an Error whose message is for the user; of an answer, with its `status` and, where it says so, `where` the mistake is. */
export async function post(path, body) {
  // The second header says that a page of this station asks: pages of other origins cannot send it.
  const headers = { "Content-Type": "application/json", "X-Requested-With": "soak" };
  const options = { method: "POST", headers, body: JSON.stringify(body) };
  return answer(await fetch(ROOT + path, options));
}

/** Carries out POST /api/v1/campaign/`command`, as post() does. */
export const send = (command, body) => post(`campaign/${command}`, body);

async function answer(response) {
  const document = await response.json();
  if (response.status === NOT_KNOWN && document.error?.where === "account") logIn();
  if (!response.ok) {
    const error = new Error(document.error?.message ?? `HTTP status ${response.status}`);
    throw Object.assign(error, { status: response.status, where: document.error?.where ?? "" });
  }
  return document;
}

/**
 * Calls `take(message)` with {kind: "connected"}, {kind: "lost"}, {kind: "status", data} and {kind: "log", data}.
 *
 * A browser allows six connections to a host, so the tabs share one stream: the tab that holds a lock reads it and tells
 * the others. When that tab closes, the next one gets the lock. Browsers offer locks to pages from this machine (and
 * over TLS) only; without them each tab has a stream of its own.
 */
export function subscribe(take) {
  if (!navigator.locks) {
    readStream(take);
    return;
  }
  const channel = new BroadcastChannel(CHANNEL);
  const latest = new Map();
  let reads = false;
  const publish = (message) => {
    if (message.kind !== "log") latest.set(message.kind === "status" ? "status" : "link", message);
    channel.postMessage(message);
    take(message);
  };
  channel.onmessage = ({ data: message }) => {
    if (message.kind !== "hello") take(message);
    else if (reads) latest.forEach((known) => channel.postMessage(known));
  };
  channel.postMessage({ kind: "hello" });
  navigator.locks.request(LOCK, () => {
    reads = true;
    readStream(publish);
    return new Promise(() => {}); // held until the tab closes
  });
}

/** Reads the event stream for ever. */
function readStream(take) {
  const source = new EventSource(`${ROOT}events`);
  let heard = Date.now();
  const hear = (message) => {
    heard = Date.now();
    take(message);
  };
  const again = () => {
    clearInterval(watch);
    source.close();
    take({ kind: "lost" });
    // Perhaps the session has ended: a stream does not say why it does.
    fetch(`${ROOT}session`).then(answer).catch(() => {});
    setTimeout(() => readStream(take), RETRY_MS);
  };
  source.onopen = () => hear({ kind: "connected" });
  for (const kind of ["status", "log"]) {
    source.addEventListener(kind, (event) => hear({ kind, data: JSON.parse(event.data) }));
  }
  source.onerror = again;
  // A connection can also die without a word. A station where nothing changes is silent too, so ask it.
  const watch = setInterval(async () => {
    if (Date.now() - heard < SILENCE_MS) return;
    try {
      const { timeout } = /** @type {any} */ (AbortSignal); // TypeScript 4.8 does not know it
      await fetch(`${ROOT}status`, { signal: timeout.call(AbortSignal, RETRY_MS) });
      heard = Date.now();
    } catch {
      again();
    }
  }, SILENCE_MS);
}
