// SPDX-License-Identifier: Apache-2.0
// The page: what it hears goes into its parts, and once a frame they are drawn.

import { Arm } from "./arm.js";
import { figures, result } from "./canvas.js";
import { Data } from "./data.js";
import { Link, token } from "./link.js";
import { Phase } from "./phase.js";
import { Plots } from "./plots.js";
import { Sliders } from "./sliders.js";
import { Stage } from "./stage.js";

const by = (id) => document.getElementById(id);
const RAD = { name: "mrad", scale: 1e3 }, COUNTS = { name: "counts", scale: 1 };
const TORQUE = { name: "mN·m", scale: 1e3 }, CURRENT = { name: "A", scale: 1 };
const DRAWN_MS = 33;
const TOLD_MS = 8000;
const FORCE_S = 6; // what the arrow's scale looks back on

const data = new Data();
let state = null, told = "", toldAt = -Infinity, there = false;

const link = new Link({ hello, rows, state: take, told: answer }, away);
const stage = new Stage(by("stage"), (place) => link.say("hand", { place }));
const arm = new Arm(by("arm-stage"), (place) => link.say("hand", { place }));
const phase = new Phase(by("phase"));
const plots = new Plots(by("plots"));
const sliders = new Sliders(by("sliders"), (name, value) => link.say("slide", { name, value }));

by("arm").onclick = () => link.say("arm");
by("stop").onclick = () => link.say("stop");
by("clear").onclick = () => link.say("clear");
by("record").onclick = () => link.say("record", { on: !state?.recording });
by("plug").onclick = () => link.say("plug", { in: !state?.plugged });
by("word").onsubmit = (event) => {
  event.preventDefault();
  link.say("word", { text: by("word-text").value });
};
addEventListener("keydown", (event) => event.key === "Escape" && link.say("stop"));
for (const kind of ["npz", "csv"]) by(kind).href = `/trace.${kind}?token=${encodeURIComponent(token)}`;

function hello({ faults, feels }) {
  there = true;
  by("feels").replaceChildren(
    ...feels.map(({ name, title, meaning }) => {
      const button = document.createElement("button");
      [button.id, button.value, button.className] = [`feel-${name}`, name, "quiet small"];
      [button.textContent, button.title, button.hidden] = [title, meaning, true];
      button.onclick = () => link.say("feel", { name });
      return button;
    }),
  );
  by("faults").replaceChildren(
    ...faults.map(({ name, meaning }) => {
      const lamp = document.createElement("li");
      lamp.textContent = name.toLowerCase().replaceAll("_", " ");
      lamp.title = meaning || lamp.textContent;
      lamp.dataset.name = name;
      return lamp;
    }),
  );
}

function rows({ columns }) {
  data.add(columns);
}

function answer({ problem }) {
  [told, toldAt] = [problem, performance.now()];
  sliders.answered();
}

function away() {
  there = false;
  sliders.away();
  show();
}

function take(message) {
  const before = state;
  state = message;
  if (state.sliders) {
    const spring = JSON.stringify([state.stiffness, state.walls, state.tau_s, state.sliders.eta]);
    if (spring !== data.spring) data.changed();
    data.spring = spring;
    if (state.feel && state.feel !== before?.feel) data.since = data.count;
  }
  if (before?.live && !state.live) sliders.away();
  show();
}

function show() {
  const live = there && state?.live;
  const on = live && state.running;
  by("link").dataset.state = !live ? "away" : on ? "on" : "off";
  by("link").lastChild.textContent = !there ? "the scope has ended" : !live ? "no answer" : on ? "on" : "off";
  document.body.dataset.live = live ? "1" : "0";
  by("arm").disabled = !live || state.wanted;
  by("arm").dataset.on = on ? "1" : "0";
  by("arm").textContent = on ? "Armed" : live && state.wanted ? "Arming…" : "Arm";
  if (!state) return;
  const old = performance.now() - toldAt > TOLD_MS;
  const gone = "the scope has ended: what was seen stays here; start it anew for another address";
  by("line").textContent = !there ? gone : state.problem || (old ? "" : told) || state.note;
  const speed = live ? state.speed : null; // a board that begins anew has none yet
  by("speed").hidden = speed === null;
  by("speed").textContent = speed === null ? "" : `simulated, ${speed.toFixed(2)} of real time`;
  by("plug").hidden = !state.virtual;
  by("plug").textContent = state.plugged ? "Pull the plug" : "Plug it in";
  by("record").dataset.on = state.recording ? "1" : "0";
  by("record").lastChild.textContent = state.recording ? "End" : "Record";
  by("rows").textContent = state.recorded ? `${state.recorded} rows recorded` : `${state.rows} rows kept, nothing recorded`;
  for (const lamp of by("faults").children) lamp.classList.toggle("lit", live && state.faults.includes(lamp.dataset.name));
  if (state.sliders) shape(live);
}

function shape(live) {
  const last = data.last ?? {};
  const rad = state.rad, torque = state.torque;
  data.unit = rad ? "rad" : "counts";
  data.cell = state.cell;
  data.edge = state.wall[0];
  data.k = torque && rad ? state.stiffness : null;
  stage.led = state.hand !== null;
  stage.hand = state.hand === null ? null : [state.hand];
  stage.canvas.classList.toggle("still", !stage.led);
  if (state.arm) {
    arm.led = stage.led;
    arm.view = state.arm.view;
    arm.canvas.classList.toggle("still", !arm.led);
  }
  by("stage").hidden = by("phase-card").hidden = by("sliders").hidden = !!state.arm;
  by("arm-stage").hidden = !state.arm;
  by("stage-title").textContent = state.arm ? "The arm" : "The wall";
  const { min, max } = state.sliders.wall, room = 0.375 * (max - min);
  stage.view = [min - room, max + room];
  stage.canvas.setAttribute("aria-valuemin", stage.view[0]);
  stage.canvas.setAttribute("aria-valuemax", stage.view[1]);
  const lost = live && state.running && state.magnet === false;
  by("hint").textContent = lost ? "turn the rotor briskly in free space: its magnets' angle isn't known yet" : !stage.led ? `${state.arm ? "move the tip" : "turn the motor"} by hand` : live && !state.running ? `arm it, then drag the ring into ${state.arm ? "a surface" : "the wall"}` : "drag the ring, or use the arrow keys";
  by("time-unit").textContent = [
    live && (state.row_hz ? `${state.row_hz.toFixed(0)} rows a second by stream` : "polled"),
    state.lost && `${state.lost} packets lost`,
    (state.virtual || state.speed !== null) && "simulated time",
  ].filter(Boolean).join(" · ");
  by("k-design").textContent = result(state.stiffness);
  by("k-l").textContent = result(state.k_l);
  for (const unit of document.getElementsByClassName("k-unit")) unit.textContent = torque ? (rad ? "N·m/rad" : "N·m/count") : rad ? "A/rad" : "A/count";
  by("k-l-is").innerHTML = state.brushless ? "K<sub>L</sub> = 1.5 (pψ)²/L" : "K<sub>L</sub> = k<sub>T</sub>²/L";
  for (const button of by("feels").children) {
    button.hidden = !state.feels.includes(button.value);
    button.disabled = !live;
    button.ariaPressed = button.value === state.feel;
  }
  plots.shape({ torque, rad, hand: stage.led && !state.arm, arm: !!state.arm, flux: "flux" in last, axes: state.brushless });
  if (live && !state.arm) sliders.show(state.sliders, rad, state);
}

let drawn = 0;
function draw(now) {
  requestAnimationFrame(draw);
  if (now - drawn < DRAWN_MS || !state?.sliders) return;
  drawn = now;
  const last = data.last ?? {};
  document.body.dataset.time = last.t ?? "";
  by("k-fit").textContent = data.fit ? result(data.fit.k) : "–";
  if (state.arm) {
    let most = 0.5;
    for (let n = data.rows.length - 1; n >= 0 && data.rows[n].t > last.t - FORCE_S; n--) most = Math.max(most, Math.hypot(data.rows[n].force_x ?? 0, data.rows[n].force_y ?? 0));
    arm.draw({ row: last, most, shapes: state.arm.shapes, alive: there && state.live });
    [document.body.dataset.view, document.body.dataset.tip] = [state.arm.view.join(" "), JSON.stringify(last)];
    by("force").textContent = last.force_x === undefined ? "" : `${result(Math.hypot(last.force_x, last.force_y))} N`;
    plots.draw(data.rows);
    return;
  }
  let most = 0.02;
  for (let n = data.rows.length - 1; n >= 0 && data.rows[n].t > last.t - FORCE_S; n--) most = Math.max(most, Math.abs(data.rows[n].f ?? 0));
  stage.draw({ x: last.x, f: last.f, fMost: most, walls: state.walls, alive: there && state.live, counts: !state.rad });
  phase.draw({
    rows: data.rows, since: data.since, fit: data.fit, walls: state.walls, edge: state.wall[0], through: data.through(), k: data.inFirst ? data.k : null, pairs: state.rad ? state.pairs : null,
    leastDepth: state.rad ? 4e-3 : 10, leastForce: state.torque ? 0.02 : 0.2,
    unit: state.rad ? RAD : COUNTS, forceUnit: state.torque ? TORQUE : CURRENT,
  });
  plots.draw(data.rows);
}
requestAnimationFrame(draw);
