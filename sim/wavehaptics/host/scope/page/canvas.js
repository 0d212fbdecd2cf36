// SPDX-License-Identifier: Apache-2.0
// Canvases as sharp as the screen, in the page's colours.

let colours = {};
function read() {
  const style = getComputedStyle(document.documentElement);
  const names = ["card", "edge", "text", "muted", "grid", "wave", "second", "hand", "wall", "wall-face", "design", "danger", "ground"];
  colours = Object.fromEntries(names.map((name) => [name, style.getPropertyValue(`--${name}`).trim()]));
}
read();
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", read);

export const colour = (name) => colours[name];

// The context in CSS pixels, cleared, with its width and height.
export function cleared(canvas) {
  const { clientWidth: width, clientHeight: height } = canvas;
  const scale = devicePixelRatio || 1;
  const [w, h] = [Math.round(width * scale), Math.round(height * scale)];
  if (canvas.width !== w || canvas.height !== h) [canvas.width, canvas.height] = [w, h];
  const context = canvas.getContext("2d");
  context.setTransform(scale, 0, 0, scale, 0, 0);
  context.clearRect(0, 0, width, height);
  return { context, width, height };
}

// Round numbers between two ends, some `count` of them.
export function ticks(low, high, count) {
  const raw = (high - low) / count;
  const power = 10 ** Math.floor(Math.log10(raw));
  const step = [1, 2, 5, 10].map((n) => n * power).find((n) => n >= raw);
  const found = [];
  for (let n = Math.ceil(low / step); n * step <= high; n++) found.push(n * step);
  return found;
}

const FIGURES = 3;
export function figures(value) {
  if (value === null || value === undefined || !Number.isFinite(value)) return "–";
  if (value !== 0 && (Math.abs(value) >= 1e5 || Math.abs(value) < 1e-3)) return minus(value.toExponential(FIGURES - 1));
  return minus(Number(value.toPrecision(FIGURES + (Math.abs(value) >= 1000 ? 1 : 0))).toString());
}

// The same with zeros at its end, which a result has.
export function result(value) {
  return value === null || !Number.isFinite(value) ? "–" : minus(value.toPrecision(FIGURES));
}

const minus = (text) => text.replace("-", "−");
