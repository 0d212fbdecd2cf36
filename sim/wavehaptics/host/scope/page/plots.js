// SPDX-License-Identifier: Apache-2.0
// The rows over time, a uPlot each for what has one unit.

/* global uPlot */
import { colour, figures } from "./canvas.js";

const WINDOW_S = 6;
const LEAST_S = 1;
const HEIGHT = 118;
const AXIS = 58;

// [name, unit, scale, series as [column, label, colour, dash]]
const PLOTS = {
  place: ["Place", "mrad", 1e3, [["x", "rotor", "wave"], ["x_hand", "hand", "hand", [5, 4]]]],
  tip: ["Tip", "mm", 1e3, [["tip_x", "x", "wave"], ["tip_y", "y", "second"], ["hand_x", "hand's x", "wave", [5, 4]], ["hand_y", "hand's y", "second", [5, 4]]]],
  force: ["Force at the tip", "N", 1, [["force_x", "x", "wave"], ["force_y", "y", "second"]]],
  torque: ["Torque", "mN·m", 1e3, [["torque", "of the motor", "second"]]],
  axes: ["Currents of both axes", "A", 1, [["i_alpha", "α", "wave"], ["i_beta", "β", "second"]]],
  voltage: ["Voltage", "V", 1, [["e_a", "asked for", "wave"]]],
  waves: ["Waves", "√W", 1, [["u", "u, out", "wave"], ["v", "v, back", "second"]]],
  flux: ["χ, waves against encoder", "counts", 1, [["flux", "χ", "wave"]]],
};

export class Plots {
  constructor(box) {
    this.box = box;
    this.plots = new Map();
    new ResizeObserver(() => this.#size()).observe(box);
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.#anew());
  }

  // Choose what is there: without a motor's data amperes and counts.
  shape({ torque, rad, hand, flux, axes, arm }) {
    const key = JSON.stringify([torque, rad, hand, flux, axes, arm]);
    if (key === this.key) return;
    this.key = key;
    this.chosen = structuredClone(PLOTS);
    if (!torque) this.chosen.torque = ["Current", "A", 1, [["i", "of the motor", "second"]]];
    if (!rad) [this.chosen.place[1], this.chosen.place[2]] = ["counts", 1];
    if (!hand) this.chosen.place[3].length = 1;
    if (!flux) delete this.chosen.flux;
    if (!axes) delete this.chosen.axes;
    for (const name of arm ? ["place"] : ["tip", "force"]) delete this.chosen[name];
    this.#anew();
  }

  #anew() {
    if (!this.chosen) return;
    for (const { plot } of this.plots.values()) plot.destroy();
    this.plots.clear();
    this.box.replaceChildren();
    const names = Object.keys(this.chosen);
    for (const name of names) this.#make(name, name === names.at(-1));
  }

  #make(name, last) {
    const [title, unit, scale, series] = this.chosen[name];
    const box = document.createElement("div");
    box.className = "plot";
    const head = document.createElement("div");
    head.className = "name";
    const label = document.createElement("b");
    label.textContent = title;
    head.append(label);
    for (const [, text, paint] of series.length > 1 ? series : []) {
      const key = document.createElement("span"), mark = document.createElement("i");
      mark.style.background = colour(paint);
      key.append(mark, text);
      head.append(key);
    }
    const value = document.createElement("output");
    head.append(value);
    box.append(head);
    this.box.append(box);
    const axis = { stroke: colour("muted"), grid: { stroke: colour("grid"), width: 1 }, ticks: { show: false }, font: "11px system-ui" };
    const plot = new uPlot(
      {
        width: this.box.clientWidth,
        height: HEIGHT + (last ? 22 : 0),
        padding: [6, 4, last ? 0 : 6, 0],
        cursor: { sync: { key: "time" }, drag: { x: false, y: false }, points: { size: 6 } },
        legend: { show: false },
        scales: { x: { time: false }, y: { range: (_, low, high) => spread(low, high) } },
        axes: [
          { ...axis, size: last ? 24 : 0, values: last ? (_, all) => all.map((t) => `${figures(t)} s`) : () => [] },
          { ...axis, size: AXIS, space: 26, values: (_, all) => all.map((v) => figures(v)) },
        ],
        series: [{}, ...series.map(([, , paint, dash]) => ({ stroke: colour(paint), width: 1.6, dash, points: { show: false } }))],
      },
      [[], ...series.map(() => [])],
      box,
    );
    this.plots.set(name, { plot, series, scale, unit, value });
  }

  #size() {
    for (const { plot } of this.plots.values()) plot.setSize({ width: this.box.clientWidth, height: plot.height });
  }

  draw(rows) {
    if (!rows.length) return;
    const end = rows.at(-1).t;
    const begin = Math.min(end - LEAST_S, Math.max(end - WINDOW_S, rows[0].t));
    let first = rows.length;
    while (first > 0 && rows[first - 1].t >= begin) first--;
    const shown = rows.slice(first);
    const time = shown.map((row) => row.t);
    for (const { plot, series, scale, unit, value } of this.plots.values()) {
      const columns = series.map(([column]) => shown.map((row) => (row[column] == null ? null : row[column] * scale)));
      plot.batch(() => {
        plot.setData([time, ...columns], false);
        plot.setScale("x", { min: begin, max: end });
      });
      const newest = columns.map((all) => figures(all.findLast((one) => one !== null) ?? null));
      value.value = `${newest.join(" · ")} ${unit}`;
    }
  }
}

function spread(low, high) {
  if (low === null || low === undefined) return [-1, 1];
  const room = Math.max(0.08 * (high - low), 1e-3 * Math.abs(high), 1e-3);
  return [low - room, high + room];
}
