// Curves of noise and error over samples, on logarithmic axes.

import { short } from "./picture.js";

const NAMESPACE = "http://www.w3.org/2000/svg";
const [WIDTH, HEIGHT, LEFT, BOTTOM, TOP, RIGHT] = [340, 130, 44, 20, 8, 10];

function make(name, attributes, text) {
  const element = document.createElementNS(NAMESPACE, name);
  Object.entries(attributes).forEach(([key, value]) => element.setAttribute(key, value));
  if (text !== undefined) element.textContent = text;
  return element;
}

/** Marks of a logarithmic axis: powers of ten, or of ten and their halves if there are few. */
function marks(low, high) {
  const all = [];
  const steps = Math.log10(high / low) < 1.5 ? [1, 2, 5] : [1];
  for (let power = Math.floor(Math.log10(low)); power <= Math.ceil(Math.log10(high)); power++) {
    all.push(...steps.map((step) => step * 10 ** power));
  }
  const inside = all.filter((mark) => mark >= low * 0.999 && mark <= high * 1.001);
  return inside.length > 6 ? inside.filter((_, i) => i % Math.ceil(inside.length / 6) === 0) : inside;
}

/** Draws `points` with `samples` and `value` into a figure, above its caption. */
export function drawCurve(figure, points) {
  const usable = points.filter((point) => point.value > 0 && point.samples > 0);
  figure.hidden = usable.length < 2;
  if (figure.hidden) return;
  const range = (values) => {
    const [low, high] = values.reduce(([low, high], value) => [Math.min(low, value), Math.max(high, value)], [Infinity, -Infinity]);
    return low === high ? [low / 2, high * 2] : [low, high];
  };
  const [x0, x1] = range(usable.map((point) => point.samples)), [y0, y1] = range(usable.map((point) => point.value));
  const share = (value, low, high) => Math.log(value / low) / Math.log(high / low);
  const x = (samples) => LEFT + share(samples, x0, x1) * (WIDTH - LEFT - RIGHT);
  const y = (value) => HEIGHT - BOTTOM - share(value, y0, y1) * (HEIGHT - BOTTOM - TOP);
  const svg = make("svg", { class: "chart", viewBox: `0 0 ${WIDTH} ${HEIGHT}`, role: "img" });
  const [first, last] = [usable[0], usable[usable.length - 1]];
  svg.setAttribute("aria-label", `${short(first.value)} after ${first.samples} samples per pixel, ${short(last.value)} after ${last.samples}`);
  for (const mark of marks(y0, y1)) {
    svg.append(make("line", { class: "grid", x1: LEFT, x2: WIDTH - RIGHT, y1: y(mark), y2: y(mark) }));
    svg.append(make("text", { x: LEFT - 6, y: y(mark) + 4, "text-anchor": "end" }, short(mark)));
  }
  for (const mark of marks(x0, x1)) {
    svg.append(make("line", { class: "grid", x1: x(mark), x2: x(mark), y1: TOP, y2: HEIGHT - BOTTOM }));
    svg.append(make("text", { x: x(mark), y: HEIGHT - 5, "text-anchor": "middle" }, short(mark)));
  }
  const path = usable.map((point, i) => `${i ? "L" : "M"}${x(point.samples).toFixed(1)} ${y(point.value).toFixed(1)}`);
  svg.append(make("path", { class: "line", d: path.join("") }));
  svg.append(make("circle", { class: "dot", cx: x(last.samples), cy: y(last.value), r: 3.5 }));
  figure.querySelector("svg")?.remove();
  figure.prepend(svg);
}
