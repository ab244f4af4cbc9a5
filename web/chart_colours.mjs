// SPDX-License-Identifier: Apache-2.0
// Colours of the style sheet for what is drawn on a canvas.

const known = new Map();

/** A colour as it is now. Read once: a page that has changed since is laid out anew for each that is asked for. */
export function colour(name) {
  if (!known.has(name)) known.set(name, getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim());
  return known.get(name);
}

/** To be called where light has become dark, or dark light. */
export function forgetColours() {
  known.clear();
}
