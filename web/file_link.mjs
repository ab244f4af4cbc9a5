// SPDX-License-Identifier: Apache-2.0
// The file that a job has made, to be saved.

import { element } from "./dom.mjs";
import { U } from "./unit_words.mjs";

/**
 * @param {import("./documents.mjs").Job} job that has made one
 * @returns {HTMLAnchorElement}
 */
export function fileLink({ id, file }) {
  const link = /** @type {HTMLAnchorElement} */ (element("a", U.jobs.download(file.name)));
  link.href = `/api/v1/job/file?${new URLSearchParams({ id: String(id) })}`;
  link.download = file.name;
  return link;
}
