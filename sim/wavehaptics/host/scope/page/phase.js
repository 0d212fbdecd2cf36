// SPDX-License-Identifier: Apache-2.0
// What the wall pushes back with, over the place, and the spring that it is designed to be.

import { cleared, colour, figures, ticks } from "./canvas.js";

const TRAIL_S = 12;
const LEFT = 52, RIGHT = 12, TOP = 12, FOOT = 34;
const EASE = 0.15;
const MOST_POINTS = 1500; // of a stream there are many more than a picture has room for

export class Phase {
  constructor(canvas) {
    this.canvas = canvas;
    this.reach = null; // ends of the view beyond, before, up and down, eased
  }

  draw({ rows, since, fit, walls, edge, through, k, pairs, leastDepth, leastForce, unit, forceUnit }) {
    const { context: c, width, height } = cleared(this.canvas);
    const last = rows.at(-1)?.t ?? 0;
    const shown = rows.filter((row) => row.n >= since && row.t >= last - TRAIL_S && row.f !== null);
    let depth = leastDepth, force = leastForce, before = 0, pull = 0;
    for (const row of shown) {
      if (!row.contact) continue;
      depth = Math.max(depth, row.x - edge);
      force = Math.max(force, row.f);
      before = Math.max(before, edge - row.x);
      pull = Math.max(pull, -row.f);
    }
    const wanted = [depth, Math.max(before, 0.3 * depth), force, Math.max(pull, 0.14 * force)].map((end) => 1.12 * end);
    this.reach = this.reach ? this.reach.map((old, n) => old + EASE * (wanted[n] - old)) : wanted;
    const [far, near, most, least] = this.reach;
    const x0 = edge - near, x1 = edge + far, f0 = -least, f1 = most;
    const at = (x) => LEFT + ((x - x0) / (x1 - x0)) * (width - LEFT - RIGHT);
    const up = (f) => height - FOOT - ((f - f0) / (f1 - f0)) * (height - FOOT - TOP);
    const box = [LEFT, TOP, width - LEFT - RIGHT, height - TOP - FOOT];

    c.fillStyle = colour("wall");
    c.globalAlpha = 0.12;
    for (const wall of walls) {
      const [from, to] = [wall.from, wall.to].map((face) => Math.max(LEFT, Math.min(at(face), width - RIGHT)));
      if (to > from) c.fillRect(from, TOP, to - from, box[3]);
    }
    c.globalAlpha = 1;
    this.#axes(c, { x0, x1, f0, f1, at, up, width, height, edge, unit, forceUnit });

    c.save();
    c.beginPath();
    c.rect(...box);
    c.clip();
    // A brushless motor's wall is a sine of the magnets' turn, which begins as the straight line.
    const bent = (way) => (pairs ? Math.sin(pairs * way) / pairs : way);
    if (k !== null) this.#line(c, at, up, [edge, x1], (x) => through[1] + k * bent(x - through[0]), colour("design"), 2, [7, 5], pairs ? 48 : 1);
    const every = 2 ** Math.max(0, Math.ceil(Math.log2(shown.length / MOST_POINTS)));
    for (const row of shown) {
      if (row.n % every) continue;
      const age = (last - row.t) / TRAIL_S;
      c.globalAlpha = 0.1 + 0.75 * (1 - age) ** 2;
      c.fillStyle = row.contact ? colour("wave") : colour("muted");
      c.beginPath();
      c.arc(at(row.x), up(row.f), row.contact ? 2.6 : 1.8, 0, 2 * Math.PI);
      c.fill();
    }
    c.globalAlpha = 1;
    if (fit) this.#line(c, at, up, [fit.from, fit.to], (x) => fit.k * (x - fit.x0), colour("wave"), 3, []);
    const now = shown.at(-1);
    if (now) {
      c.strokeStyle = c.fillStyle = colour("second");
      c.beginPath();
      c.arc(at(now.x), up(now.f), 4.5, 0, 2 * Math.PI);
      c.fill();
    }
    c.restore();
  }

  #line(c, at, up, ends, of, stroke, width, dash, parts = 1) {
    c.strokeStyle = stroke;
    c.lineWidth = width;
    c.setLineDash(dash);
    c.beginPath();
    c.moveTo(at(ends[0]), up(of(ends[0])));
    for (let n = 1; n <= parts; n++) {
      const x = ends[0] + (n / parts) * (ends[1] - ends[0]);
      c.lineTo(at(x), up(of(x)));
    }
    c.stroke();
    c.setLineDash([]);
  }

  #axes(c, { x0, x1, f0, f1, at, up, width, height, edge, unit, forceUnit }) {
    c.font = "11px system-ui, sans-serif";
    c.fillStyle = colour("muted");
    c.strokeStyle = colour("grid");
    c.lineWidth = 1;
    const [xScale, fScale] = [unit.scale, forceUnit.scale];
    c.textAlign = "center";
    for (const tick of ticks((x0 - edge) * xScale, (x1 - edge) * xScale, 5)) {
      const x = at(tick / xScale + edge);
      c.beginPath();
      c.moveTo(x, TOP);
      c.lineTo(x, height - FOOT);
      c.stroke();
      c.fillText(figures(tick), x, height - FOOT + 14);
    }
    c.fillText(`beyond the wall's face, ${unit.name}`, (LEFT + width - RIGHT) / 2, height - 5);
    c.textAlign = "right";
    for (const tick of ticks(f0 * fScale, f1 * fScale, 5)) {
      const y = up(tick / fScale);
      c.beginPath();
      c.moveTo(LEFT, y);
      c.lineTo(width - RIGHT, y);
      c.stroke();
      c.fillText(figures(tick), LEFT - 6, y + 4);
    }
    c.save();
    c.translate(12, (TOP + height - FOOT) / 2);
    c.rotate(-Math.PI / 2);
    c.textAlign = "center";
    c.fillText(`push back, ${forceUnit.name}`, 0, 0);
    c.restore();
    c.strokeStyle = colour("muted");
    c.beginPath();
    c.moveTo(LEFT, up(0));
    c.lineTo(width - RIGHT, up(0));
    c.stroke();
  }
}
