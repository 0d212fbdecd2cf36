// SPDX-License-Identifier: Apache-2.0
// Rows of the last seconds, and the spring that the newest contact shows.

const KEPT_S = 30;
const SLOW = 0.3; // rad/s: faster, current and place of a row aren't of one moment
const LEAST_ROWS = 10;
const LEAST_PART = 0.25; // of the depth, that the rows of a fit spread over
const LEAST_DEPTH_CELLS = 8;
const JUMP = 0.25; // of the contact's force: between two rows the rotor was out of the wall and back

export class Data {
  constructor() {
    this.rows = []; // {n, t, x, f, ...}: f is what the wall pushes back with; of a lost row t alone
    this.last = null; // the newest that wasn't lost
    this.count = 0;
    this.since = 0; // number of the first row with the feel that was set last
    this.contact = []; // rows of the newest contact since the last change of a setting
    this.most = 0; // force of it
    this.fit = null; // {k, x0, from, to}
    this.cell = 0;
    this.ended = true;
    this.bent = false;
  }

  add(columns) {
    const count = columns.t.length, before = this.contact.length;
    for (let n = 0; n < count; n++) {
      const row = { n: this.count++ };
      for (const name in columns) row[name] = columns[name][n];
      const push = row.torque ?? row.i ?? null;
      row.f = push === null ? null : -push;
      this.rows.push(row);
      if (row.lost) continue;
      this.#judge(row);
      this.last = row;
    }
    if (this.contact.length !== before) this.#line();
    const first = (this.rows.at(-1)?.t ?? 0) - KEPT_S;
    let old = 0;
    while (this.rows[old]?.t < first) old++;
    if (old) this.rows.splice(0, old);
  }

  // A setting has changed: what was measured before is of another spring.
  changed() {
    this.#anew();
    this.fit = null;
    this.bent = !this.ended;
  }

  // A place and a force that the design spring goes through: a contact that began with it begins at the
  // wall's face, one in which it was changed went on from where it was.
  through() {
    const [first] = this.contact;
    return this.bent && first ? [first.x, first.f] : [this.edge ?? 0, 0];
  }

  // Whether that contact is one with the first wall, whose design spring is known.
  get inFirst() {
    const [first] = this.contact;
    return !first || this.bent || first.x > this.edge - this.cell;
  }

  #anew() {
    this.contact = [];
    this.most = 0;
  }

  #judge(row) {
    const before = this.last;
    if (!row.contact) {
      this.ended = true;
      return;
    }
    if (this.ended || this.#jumped(row, before)) {
      this.#anew();
      this.ended = this.bent = false;
    }
    const step = before ? row.t - before.t : 0;
    if (row.saturated || !before?.contact || step <= 0) return;
    const slow = this.unit === "counts" ? Infinity : SLOW;
    if (Math.abs(row.x - before.x) > slow * step + this.cell) return;
    this.contact.push(row);
    this.most = Math.max(this.most, Math.abs(row.f));
  }

  #jumped(row, before) {
    if (!this.k || !before) return false;
    const off = Math.abs(row.f - before.f - this.k * (row.x - before.x));
    return this.most > 0 && off > JUMP * this.most + LEAST_DEPTH_CELLS * this.k * this.cell;
  }

  // The straight line through the contact's rows by least squares.
  #line() {
    const rows = this.contact;
    if (rows.length < LEAST_ROWS) return;
    let sx = 0, sf = 0, low = Infinity, high = -Infinity;
    for (const { x, f } of rows) {
      sx += x;
      sf += f;
      low = Math.min(low, x);
      high = Math.max(high, x);
    }
    const mx = sx / rows.length, mf = sf / rows.length;
    let sxx = 0, sxf = 0;
    for (const { x, f } of rows) {
      sxx += (x - mx) ** 2;
      sxf += (x - mx) * (f - mf);
    }
    const depth = high - (this.edge ?? low);
    if (high - low < Math.max(LEAST_PART * depth, LEAST_DEPTH_CELLS * this.cell) || !sxx) return;
    const k = sxf / sxx;
    this.fit = { k, x0: mx - mf / k, from: low, to: high };
  }
}
