// SPDX-License-Identifier: Apache-2.0
// A canvas with a hand that a mouse or the arrow keys lead. Places are lists of coordinates.

const WAYS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowDown: [0, -1], ArrowUp: [0, 1] };
const CAREFUL = 0.2; // of a key's step, with shift

// Of a canvas: `place` of an event; `near`, whether a place grabs a hand; `ends`, the least and the
// greatest of each coordinate; `step` of a key.
export class Led {
  // `lead` is called with the place that the hand is to go to.
  constructor(canvas, lead, view, step) {
    Object.assign(this, { canvas, lead, view, step });
    this.led = false; // whether there is a hand to lead
    this.hand = this.target = null;
    canvas.addEventListener("pointerdown", (event) => this.#grab(event));
    canvas.addEventListener("pointermove", (event) => this.held && this.#move(event));
    for (const type of ["pointerup", "pointercancel"]) canvas.addEventListener(type, () => this.#release());
    canvas.addEventListener("keydown", (event) => this.#key(event));
  }

  #grab(event) {
    if (!this.led) return;
    this.canvas.setPointerCapture(event.pointerId);
    this.held = true;
    this.canvas.classList.add("held");
    // Grabbed beside its middle, the hand doesn't jump.
    const place = this.place(event), at = this.target ?? this.hand ?? place;
    const near = this.near(place, at);
    this.off = place.map((value, n) => (near ? at[n] - value : 0));
    this.#move(event);
  }

  #move(event) {
    this.#to(this.place(event).map((value, n) => value + this.off[n]));
  }

  #release() {
    this.held = false;
    this.canvas.classList.remove("held");
  }

  #key(event) {
    const ends = this.ends, way = WAYS[event.key]?.slice(0, ends.length), at = this.target ?? this.hand;
    if (!way?.some(Boolean) || !this.led || !at) return;
    event.preventDefault();
    const step = this.step * (event.shiftKey ? CAREFUL : 1);
    this.#to(at.map((value, n) => value + way[n] * step));
  }

  #to(place) {
    this.target = this.ends.map(([low, high], n) => Math.min(high, Math.max(low, place[n])));
    this.lead(this.target);
  }
}
