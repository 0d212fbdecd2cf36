// SPDX-License-Identifier: Apache-2.0
// The rotor's handle, the walls, and the hand that a mouse leads.

import { cleared, colour, figures, ticks } from "./canvas.js";
import { Led } from "./led.js";

const MARGIN = 34;
const KNOB = 21;
const HAND = 15;
const KEY_STEP = 0.01;

export class Stage extends Led {
  constructor(canvas, lead) {
    super(canvas, ([place]) => lead(place), [-0.35, 0.35], KEY_STEP);
  }

  get ends() {
    return [this.view];
  }

  // Radians, or counts, of a pixel.
  #scale(width) {
    return (this.view[1] - this.view[0]) / (width - 2 * MARGIN);
  }

  place(event) {
    const box = this.canvas.getBoundingClientRect();
    return [this.view[0] + (event.clientX - box.left - MARGIN) * this.#scale(box.width)];
  }

  near([place], [at]) {
    return Math.abs(place - at) < (HAND + KNOB) * this.#scale(this.canvas.clientWidth);
  }

  draw({ x, f, fMost, walls, alive, counts }) {
    const { context: c, width, height } = cleared(this.canvas);
    const [low, high] = this.view;
    const at = (place) => MARGIN + ((place - low) / (high - low)) * (width - 2 * MARGIN);
    const middle = height * 0.47, foot = height - 26;
    this.canvas.setAttribute("aria-valuenow", (this.target ?? this.hand ?? [0])[0].toFixed(3));
    const inside = (place) => Math.max(-4, Math.min(at(place), width + 4)); // a face beyond isn't seen
    for (const wall of walls) this.#wall(c, inside(wall.from), inside(wall.to), foot, wall.soft);
    this.#rail(c, at, low, high, middle, foot, counts);
    if (x === undefined) return;
    const rotor = at(x), hand = this.led && this.hand !== null ? at(this.hand[0]) : null;
    if (hand !== null) {
      this.#spring(c, rotor, hand, middle);
      this.#hand(c, hand, middle);
      if (this.target !== null && Math.abs(at(this.target[0]) - hand) > 2) this.#ghost(c, at(this.target[0]), middle);
    }
    this.#knob(c, rotor, middle, alive);
    if (f) this.#force(c, rotor, middle, f, fMost);
  }

  // A rigid wall is hatched, a soft one isn't.
  #wall(c, from, to, foot, soft) {
    if (to <= from) return;
    c.save();
    c.beginPath();
    c.rect(from, 6, to - from, foot - 6);
    c.clip();
    c.fillStyle = colour("wall");
    c.globalAlpha = 0.22;
    c.fillRect(from, 6, to - from, foot - 6);
    c.globalAlpha = 0.5;
    c.strokeStyle = colour("wall");
    c.lineWidth = 1.5;
    c.beginPath();
    for (let x = from - foot; x < to && !soft; x += 13) {
      c.moveTo(x, foot);
      c.lineTo(x + foot, 0);
    }
    c.stroke();
    c.restore();
    c.fillStyle = colour("wall-face");
    for (const face of [from, to]) c.fillRect(face - 1.5, 6, 3, foot - 6);
  }

  #rail(c, at, low, high, middle, foot, counts) {
    c.strokeStyle = colour("edge");
    c.lineWidth = 5;
    c.lineCap = "round";
    c.beginPath();
    c.moveTo(at(low), middle);
    c.lineTo(at(high), middle);
    c.stroke();
    c.fillStyle = colour("muted");
    c.font = "11.5px system-ui, sans-serif";
    c.textAlign = "center";
    c.strokeStyle = colour("muted");
    c.lineWidth = 1;
    const width = at(high) - at(low);
    for (const place of ticks(low, high, width / 75)) {
      if (at(high) - at(place) < 12) continue; // the unit stands there
      c.beginPath();
      c.moveTo(at(place), foot);
      c.lineTo(at(place), foot + 5);
      c.stroke();
      c.fillText(figures(place), at(place), foot + 18);
    }
    c.textAlign = "right";
    c.fillText(counts ? "counts" : "rad", at(high) + MARGIN - 4, foot + 18);
  }

  #spring(c, from, to, y) {
    const turns = 9, reach = to - from;
    c.strokeStyle = colour("hand");
    c.lineWidth = 2;
    c.lineJoin = "round";
    c.beginPath();
    c.moveTo(from, y);
    for (let n = 0; n < turns; n++) {
      const height = n === 0 || n === turns - 1 ? 0 : n % 2 ? -9 : 9;
      c.lineTo(from + (reach * (n + 0.5)) / turns, y + height);
    }
    c.lineTo(to, y);
    c.stroke();
  }

  #disc(c, x, y, radius, fill, line, width) {
    c.beginPath();
    c.arc(x, y, radius, 0, 2 * Math.PI);
    if (fill) {
      c.fillStyle = fill;
      c.fill();
    }
    c.strokeStyle = line;
    c.lineWidth = width;
    c.stroke();
  }

  #hand(c, x, y) {
    this.#disc(c, x, y, HAND, colour("card"), colour("hand"), this.held ? 5 : 3.5);
    this.#disc(c, x, y, 3, colour("hand"), colour("hand"), 1);
  }

  #ghost(c, x, y) {
    c.setLineDash([3, 4]);
    this.#disc(c, x, y, HAND, null, colour("hand"), 1.5);
    c.setLineDash([]);
  }

  #knob(c, x, y, alive) {
    this.#disc(c, x, y, KNOB, alive ? colour("wave") : colour("muted"), colour("card"), 3);
    c.fillStyle = colour("card");
    for (const way of [-1, 0, 1]) c.fillRect(x + 5 * way - 1, y - 7, 2, 14);
  }

  #force(c, x, y, f, most) {
    const length = Math.max(-1, Math.min(1, f / most)) * 120;
    if (Math.abs(length) < 3) return;
    const tip = x - length, way = Math.sign(length), top = y - KNOB - 16;
    c.strokeStyle = c.fillStyle = colour("second");
    c.lineWidth = 4;
    c.lineCap = "butt";
    c.beginPath();
    c.moveTo(x, top);
    c.lineTo(tip + 9 * way, top);
    c.stroke();
    c.beginPath();
    c.moveTo(tip, top);
    c.lineTo(tip + 11 * way, top - 7);
    c.lineTo(tip + 11 * way, top + 7);
    c.fill();
  }
}
