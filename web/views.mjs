// SPDX-License-Identifier: Apache-2.0
// Which view of the page is shown: what stands behind # in the address, so that links, reload and Back work.

import { $, show } from "./dom.mjs";

/** Where a unit's page is. */
export const unitAddress = (serial) => `#${new URLSearchParams({ unit: serial })}`;

/** "#run=ID&unit=SN" → {name: "run", parameters}; what is not known is the station. */
function placeOf(hash, views) {
  const parameters = new URLSearchParams(hash.replace(/^#/, ""));
  const [name] = parameters.keys();
  return { name: Object.hasOwn(views, name ?? "") ? name : "station", parameters };
}

/**
 * `views`: name → an object with open(parameters), called whenever the address leads there, or null. The section of a view
 * is NAME-view; a link to it is marked as the current one.
 */
export function connectViews(views) {
  const go = async (event) => {
    const { name, parameters } = placeOf(location.hash, views);
    for (const other of Object.keys(views)) show($(`${other}-view`), other === name);
    const link = { run: "runs", unit: "units" }[name] ?? name;
    for (const other of document.querySelectorAll(".top nav a")) {
      if (other.id === `to-${link}`) other.setAttribute("aria-current", "page");
      else other.removeAttribute("aria-current");
    }
    show($("view-failure"), false);
    if (event) scrollTo(0, 0);
    const place = location.hash;
    const focused = document.activeElement;
    const isOpen = await Promise.resolve(views[name]?.open(parameters)).then(() => true, (error) => {
      console.warn(`${name}:`, error.message);
      return false;
    });
    if (!isOpen && place === location.hash) show($("view-failure"), true);
    if (!event || place !== location.hash) return;
    // A view may have gone to one of its headings itself.
    if (document.activeElement !== focused && $(`${name}-view`).contains(document.activeElement)) return;
    // Whoever cannot see the page is told where it has led, once there are words for it; where it begins is seen.
    const title = /** @type {HTMLElement | null} */ (document.querySelector(`#${name}-view .view-title`));
    title?.focus({ preventScroll: true });
  };
  addEventListener("hashchange", go);
  go(null);
}
