// Maps of what the guide has learned at a pixel.

import { falseColor, short } from "./picture.js";

const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const list = (numbers) => numbers.map((number) => short(number)).join(", ");
const unit = (numbers) => numbers.map((number) => (Math.round(100 * number) / 100 + 0).toFixed(2).replace("-", "−")).join(", ");

/** Index of the bin whose center is nearest to a direction. */
function nearest(directions, direction) {
  let [best, most] = [0, -2];
  for (let bin = 0; bin < directions.length; bin++) {
    const cosine = dot(directions[bin], direction);
    if (cosine > most) [best, most] = [bin, cosine];
  }
  return best;
}

/** Direction in the world of a point of the unit disk, which keeps areas: the middle is the normal, the rim the horizon. */
export function diskDirection(surface, x, y) {
  const square = x * x + y * y, cosine = 1 - square, stretch = Math.sqrt(Math.max(0, 2 - square));
  return [0, 1, 2].map((c) => surface.right[c] * x * stretch + surface.up[c] * y * stretch + surface.normal[c] * cosine);
}

/** Point of the disk at which a direction lies. */
export function diskPoint(surface, direction) {
  const stretch = Math.sqrt(1 + dot(surface.normal, direction));
  return [dot(surface.right, direction) / stretch, dot(surface.up, direction) / stretch];
}

/** Bin of every pixel of a disk of `size` pixels; -1 outside. */
function diskBins(size, surface, directions) {
  const bins = new Int32Array(size * size).fill(-1);
  for (let i = 0; i < size * size; i++) {
    const x = ((i % size) + 0.5) / (size / 2) - 1, y = 1 - (Math.floor(i / size) + 0.5) / (size / 2);
    if (x * x + y * y <= 1) bins[i] = nearest(directions, diskDirection(surface, x, y));
  }
  return bins;
}

function drawDisk(canvas, bins, radiance, middle) {
  const size = Math.sqrt(bins.length), data = new ImageData(size, size);
  bins.forEach((bin, i) => bin >= 0 && data.data.set([...falseColor(radiance[bin], middle), 255], 4 * i));
  const small = document.createElement("canvas");
  [small.width, small.height] = [size, size];
  small.getContext("2d").putImageData(data, 0, 0);
  const context = canvas.getContext("2d");
  context.clearRect(0, 0, canvas.width, canvas.height);
  context.drawImage(small, 0, 0, canvas.width, canvas.height);
}

function ring(context, x, y) {
  for (const [color, width] of [["#000", 4], ["#fff", 2]]) {
    [context.strokeStyle, context.lineWidth] = [color, width];
    context.beginPath();
    context.arc(x, y, 8, 0, 2 * Math.PI);
    context.stroke();
  }
}

function drawSquare(canvas, learned, middle) {
  const context = canvas.getContext("2d"), { side } = learned, step = canvas.width / side;
  context.clearRect(0, 0, canvas.width, canvas.height);
  learned.cell.radiance.forEach((value, bin) => {
    const [x, y] = [(bin % side) * step, Math.floor(bin / side) * step];
    context.fillStyle = `rgb(${falseColor(value, middle)})`;
    context.fillRect(x, y, step + 0.5, step + 0.5);
    if (learned.above[bin]) return;
    [context.strokeStyle, context.lineWidth] = ["#8fb6ffcc", 1];
    context.beginPath();
    context.moveTo(x, y + step);
    context.lineTo(x + step, y);
    context.stroke();
  });
}

function facts(list, rows) {
  list.replaceChildren(...rows.flatMap(([name, value]) => {
    const [term, text] = [document.createElement("dt"), document.createElement("dd")];
    [term.textContent, text.textContent] = [name, value];
    return [term, text];
  }));
}

/** Shows what the guide has learned at the surface of a pixel. */
export function showGuide(pixel, state) {
  const find = (id) => document.getElementById(id), { surface, learned } = pixel;
  const part = find("guide"), none = find("no-guide");
  [part.hidden, none.hidden] = [!learned, Boolean(learned)];
  if (!learned) {
    none.textContent = state.no_guide ?? (surface ? "The guide is copied after the step under way." : "This pixel shows no surface, so the guide has no map of it.");
    delete part.dataset.brightest;
    return;
  }
  const { cell } = learned, above = cell.radiance.filter((_, bin) => learned.above[bin]);
  const middle = above.reduce((sum, value) => sum + value, 0) / Math.max(1, above.length);
  const disk = find("hemisphere"), bins = diskBins(104, surface, learned.directions);
  drawDisk(disk, bins, cell.radiance, middle);
  const [x, y] = diskPoint(surface, learned.brightest);
  ring(disk.getContext("2d"), ((x + 1) / 2) * disk.width, ((1 - y) / 2) * disk.height);
  drawSquare(find("square"), learned, middle);
  const elevation = Math.round((Math.asin(Math.min(1, dot(learned.brightest, surface.normal))) * 180) / Math.PI);
  const brightest = `${short(learned.brightest_radiance)} from (${unit(learned.brightest)}), ${elevation}° above the horizon`;
  disk.setAttribute("aria-label", `Learned radiance above the surface. The brightest bin has ${brightest}.`);
  find("square").setAttribute("aria-label", `Learned radiance of all ${learned.side} by ${learned.side} bins of the cell.`);
  find("middle").textContent = short(middle);
  facts(find("learned"), [
    ["Irradiance", short(cell.irradiance)],
    ["Brightest bin", brightest],
    ["Position", `(${list(surface.position)})${surface.is_mixed ? ", a mean of several surfaces" : ""}`],
    ["Normal", `(${unit(surface.normal)})`],
    ["Cell", `${cell.number}: (${list(cell.lower)}) to (${list(cell.upper)})`],
    ...(learned.bsdf_share === null ? [] : [["Samples left to the BSDF", `${short(100 * learned.bsdf_share)} %`]]),
    ["Learned from", `${learned.samples} samples per pixel`],
    ...(state.samples_lights ? [["Light that is sampled directly", "not in the map"]] : []),
  ]);
  const small = diskBins(44, surface, learned.directions);
  find("neighbors").replaceChildren(...learned.neighbors.map(([side, neighbor]) => {
    const [item, canvas] = [document.createElement("li"), document.createElement("canvas")];
    [canvas.width, canvas.height] = [88, 88];
    drawDisk(canvas, small, neighbor.radiance, middle);
    canvas.setAttribute("role", "img");
    canvas.setAttribute("aria-label", `Map of the neighbor at ${side}, cell ${neighbor.number}`);
    item.append(canvas, `${side.replace("-", "−")}: ${short(Number(neighbor.irradiance.toPrecision(2)))}`);
    item.title = `Cell ${neighbor.number}, irradiance ${short(neighbor.irradiance)}`;
    return item;
  }));
  part.dataset.brightest = learned.brightest.join(",");
  part.dataset.samples = learned.samples;
}

/** Draws the ramp of false colors. */
export function drawRamp(canvas) {
  const context = canvas.getContext("2d");
  for (let x = 0; x < canvas.width; x++) {
    const share = x / (canvas.width - 1);
    context.fillStyle = `rgb(${falseColor(share === 1 ? Infinity : share / (1 - share), 1)})`;
    context.fillRect(x, 0, 1, canvas.height);
  }
}

export { facts };
