// SPDX-License-Identifier: Apache-2.0
// What takes the station a while is asked for once somebody comes near it.

const NEAR = "400px"; // below and above what can be seen
const ASK_AGAIN_MS = 5000; // a station that is busy

/** Loads what belongs into a part of the page while that is near the view, once for each thing that it is to be of. */
export class WhenSeen {
  #load;
  #near = false;
  #wanted = null;
  #loaded = null;

  /**
   * @param {Element} node
   * @param {(isLate: () => boolean) => Promise<boolean | "busy">} load whether it was found; what was not is asked for again when somebody comes by once more,
   *   or before long where the station was busy. `isLate()`: something else is wanted by now
   */
  constructor(node, load) {
    this.#load = load;
    new IntersectionObserver((entries) => {
      this.#near = entries.at(-1).isIntersecting;
      this.#follow();
    }, { rootMargin: NEAR }).observe(node);
  }

  /**
   * @param {string | null} key of what is to be there from now on; null: nothing
   * @returns {boolean} whether that is something else than before
   */
  want(key) {
    const isNew = key !== this.#wanted;
    this.#wanted = key;
    this.#follow();
    return isNew;
  }

  async #follow() {
    const key = this.#wanted;
    if (!this.#near || key === null || key === this.#loaded) return;
    this.#loaded = key;
    const found = await this.#load(() => key !== this.#wanted);
    if (found === true || this.#loaded !== key) return;
    this.#loaded = null;
    if (found === "busy") setTimeout(() => this.#follow(), ASK_AGAIN_MS);
  }
}
