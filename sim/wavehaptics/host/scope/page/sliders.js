// SPDX-License-Identifier: Apache-2.0
// Sliders of the settings: one change on its way at a time.

import { figures } from "./canvas.js";

const STEPS = 1000;
const SETTLES_MS = 700; // until the device's own value is shown again

// Name, unit, whether a decade is as wide as the next one.
const KINDS = {
  lambda: ["λ, how soon contact answers", "rad/s", true],
  eta: ["η in contact: −1 rigid, 0 damped", "", false],
  wall: ["Wall's face", "rad", false],
  soft: ["Soft: the wall is W", "", false],
  stiffness: ["W: stiffness", "N·m/rad", false],
  damping: ["W: damping", "N·m·s/rad", false],
};

export class Sliders {
  // `send` is called with a slider's name and value.
  constructor(box, send) {
    this.box = box;
    this.send = send;
    this.made = new Map();
    this.waiting = null;
    this.next = new Map();
  }

  show(sliders, rad, note) {
    for (const [name, given] of Object.entries(sliders)) {
      const slider = this.made.get(name) ?? this.#make(name);
      slider.given = given;
      if (performance.now() - slider.touched > SETTLES_MS) this.#put(slider, given.value);
      slider.unit = name === "wall" && !rad ? "counts" : KINDS[name][1];
      slider.row.hidden = false;
      slider.input.disabled = false;
    }
    for (const [name, slider] of this.made) if (!(name in sliders)) slider.row.hidden = true;
    for (const slider of this.made.values()) this.#tell(slider, note);
  }

  // What was sent has been answered: the newest of what has been moved since goes next.
  answered() {
    this.waiting = null;
    const [first] = this.next;
    if (first) {
      this.next.delete(first[0]);
      this.#give(...first);
    }
  }

  // Nobody is there to answer.
  away() {
    this.waiting = null;
    this.next.clear();
    for (const { input } of this.made.values()) input.disabled = true;
  }

  #make(name) {
    const row = document.createElement("div");
    const check = name === "soft";
    row.className = check ? "slider check" : "slider";
    const input = document.createElement("input");
    input.id = `slider-${name}`;
    input.type = check ? "checkbox" : "range";
    if (!check) [input.min, input.max, input.step] = [0, STEPS, 1];
    const label = document.createElement("label");
    label.htmlFor = input.id;
    label.textContent = KINDS[name][0];
    const output = document.createElement("output");
    row.append(...(check ? [input, label] : [label, output, input]));
    this.box.append(row);
    const slider = { name, row, input, output, touched: -Infinity };
    input.addEventListener(check ? "change" : "input", () => {
      slider.touched = performance.now();
      slider.value = check ? Number(input.checked) : this.#value(slider);
      this.#give(name, slider.value);
    });
    this.made.set(name, slider);
    return slider;
  }

  #give(name, value) {
    if (this.waiting === null) {
      this.waiting = name;
      this.send(name, value);
    } else {
      this.next.set(name, value);
    }
  }

  #value({ name, input, given }) {
    const part = input.value / STEPS;
    if (KINDS[name][2]) return given.min * (given.max / given.min) ** part;
    return given.min + part * (given.max - given.min);
  }

  #put(slider, value) {
    slider.value = value;
    const { min, max } = slider.given;
    if (slider.input.type === "checkbox") {
      slider.input.checked = value === 1;
      return;
    }
    const part = KINDS[slider.name][2] ? Math.log(value / min) / Math.log(max / min) : (value - min) / (max - min);
    slider.input.value = Math.round(part * STEPS);
  }

  #tell(slider, note) {
    const more = slider.name === "lambda" ? `, a = ${figures(note.a)}` : "";
    slider.output.value = `${figures(slider.value)} ${slider.unit ?? ""}${more}`;
  }
}
