// SPDX-License-Identifier: Apache-2.0
// A planar arm, the surfaces in its plane, and the hand that a mouse leads at its tip.

import { cleared, colour } from "./canvas.js";
import { Led } from "./led.js";

const TIP = 9;
const HAND = 13;
const FORCE = 90;
const LEAST_FORCE = 3;
const KEY_STEP = 0.002;

export class Arm extends Led {
  constructor(canvas, lead) {
    super(canvas, lead, [0, 0, 1, 1], KEY_STEP);
  }

  get ends() {
    const [left, low, right, high] = this.view;
    return [[left, right], [low, high]];
  }

  // The middle of the view is that of the canvas; x goes right, y up.
  #scale(width, height) {
    const [left, low, right, high] = this.view;
    const scale = Math.min(width / (right - left), height / (high - low));
    return { scale, x0: width / 2 - (scale * (left + right)) / 2, y0: height / 2 + (scale * (low + high)) / 2 };
  }

  place(event) {
    const box = this.canvas.getBoundingClientRect();
    const { scale, x0, y0 } = this.#scale(box.width, box.height);
    return [(event.clientX - box.left - x0) / scale, (y0 - event.clientY + box.top) / scale];
  }

  near([x, y], at) {
    return Math.hypot(x - at[0], y - at[1]) * this.#scale(this.canvas.clientWidth, this.canvas.clientHeight).scale < 2 * HAND;
  }

  draw({ row, most, shapes, alive }) {
    const { context: c, width, height } = cleared(this.canvas);
    const { scale, x0, y0 } = this.#scale(width, height);
    const at = ([x, y]) => [x0 + scale * x, y0 - scale * y];
    for (const shape of shapes) this.#solid(c, shape, at, scale, 2 * (width + height));
    if (row.tip_x === undefined) return;
    const tip = at([row.tip_x, row.tip_y]);
    this.#links(c, [at([0, 0]), at([row.elbow_x, row.elbow_y]), tip], alive);
    const hand = this.led && row.hand_x !== undefined ? at([row.hand_x, row.hand_y]) : null;
    if (hand) {
      this.hand = [row.hand_x, row.hand_y];
      this.#line(c, [tip, hand], colour("hand"), 2);
      this.#disc(c, hand, HAND, colour("card"), colour("hand"), this.held ? 5 : 3.5);
      const target = this.target && at(this.target);
      if (target && Math.hypot(target[0] - hand[0], target[1] - hand[1]) > 3) {
        c.setLineDash([3, 4]);
        this.#disc(c, target, HAND, null, colour("hand"), 1.5);
        c.setLineDash([]);
      }
    }
    this.#disc(c, tip, TIP, row.acting ? colour("second") : colour("wave"), colour("card"), 2);
    const force = [row.force_x, -row.force_y].map((part) => (part / most) * FORCE);
    if (Math.hypot(...force) > LEAST_FORCE) this.#arrow(c, tip, force);
  }

  #solid(c, { kind, point, normal, radius, size }, at, scale, far) {
    const [x, y] = at(point);
    c.beginPath();
    if (kind === "sphere") c.arc(x, y, radius * scale, 0, 2 * Math.PI);
    else if (kind === "box") c.rect(x - (scale * size[0]) / 2, y - (scale * size[1]) / 2, scale * size[0], scale * size[1]);
    else {
      // Its face, and as far as the canvas goes behind it.
      const length = Math.hypot(...normal) || 1, n = [normal[0] / length, -normal[1] / length];
      const corner = (along, behind) => [x - along * n[1] - behind * n[0], y + along * n[0] - behind * n[1]];
      for (const place of [corner(-far, 0), corner(far, 0), corner(far, far), corner(-far, far)]) c.lineTo(...place);
      c.closePath();
    }
    c.globalAlpha = 0.3;
    c.fillStyle = colour("wall");
    c.fill();
    c.globalAlpha = 1;
    c.strokeStyle = colour("wall-face");
    c.lineWidth = 2.5;
    c.stroke();
  }

  #links(c, joints, alive) {
    const shown = alive ? colour("design") : colour("edge");
    this.#line(c, joints, shown, 9);
    for (const joint of joints.slice(0, 2)) this.#disc(c, joint, 8, colour("card"), shown, 4);
  }

  #line(c, places, shown, width) {
    c.strokeStyle = shown;
    c.lineWidth = width;
    c.lineCap = c.lineJoin = "round";
    c.beginPath();
    for (const place of places) c.lineTo(...place);
    c.stroke();
  }

  #disc(c, [x, y], radius, fill, line, width) {
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

  #arrow(c, [x, y], [dx, dy]) {
    const length = Math.hypot(dx, dy), way = [dx / length, dy / length];
    const end = [x + dx, y + dy], neck = [end[0] - 9 * way[0], end[1] - 9 * way[1]];
    this.#line(c, [[x, y], neck], colour("second"), 4);
    c.fillStyle = colour("second");
    c.beginPath();
    c.moveTo(...end);
    for (const side of [-6, 6]) c.lineTo(neck[0] - side * way[1], neck[1] + side * way[0]);
    c.fill();
  }
}
