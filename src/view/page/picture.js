// The picture: decoding layers, zoom and marks.

import { FILM_CURVES, srgb } from "./tone.js";

/** Values of all half floats. */
const HALVES = (() => {
  const values = new Float32Array(65536);
  for (let bits = 0; bits < 65536; bits++) {
    const [sign, exponent, fraction] = [bits >> 15 ? -1 : 1, (bits >> 10) & 31, bits & 1023];
    if (exponent === 31) values[bits] = fraction ? NaN : sign * Infinity;
    else values[bits] = sign * (exponent ? 2 ** (exponent - 15) * (1 + fraction / 1024) : 2 ** -14 * (fraction / 1024));
  }
  return values;
})();

const level = (x) => Math.round(255 * Math.min(1, Math.max(0, x)));

/** Colors of the ramp for values from 0 to 1: black, purple, red, yellow, white. */
const RAMP = [[0, 0, 0], [0.1, 0, 0.2], [0.7, 0.05, 0.02], [1, 0.6, 0.05], [1, 1, 1]];
const RAMP_LEVELS = Array.from({ length: 256 }, (_, i) => {
  const at = (i / 255) * (RAMP.length - 1), lower = Math.min(Math.floor(at), RAMP.length - 2);
  return RAMP[lower].map((value, c) => level(srgb(value + (RAMP[lower + 1][c] - value) * (at - lower))));
});

/** Color of a value; the middle of the ramp is `middle`. */
export function falseColor(value, middle) {
  if (Number.isNaN(value)) return [255, 0, 255];
  const share = value === Infinity ? 1 : value <= 0 ? 0 : value / (value + Math.max(middle, 1e-30));
  return RAMP_LEVELS[Math.round(255 * share)];
}

/** A number for people: four digits. */
export function short(value) {
  if (value === null || value === undefined) return "none";
  if (Number.isInteger(value) && Math.abs(value) < 1e6) return String(value);
  const size = Math.abs(value);
  if (size !== 0 && (size < 1e-3 || size >= 1e5)) return value.toExponential(2);
  return String(Number(value.toPrecision(4)));
}

/** A layer as the server has sent it: half floats, pixel by pixel. */
export class Layer {
  constructor(frame, buffer) {
    Object.assign(this, frame);
    this.halves = new Uint16Array(buffer);
    this.count = frame.channels.length;
  }

  values(x, y) {
    const at = (y * this.width + x) * this.count;
    return Array.from(this.halves.subarray(at, at + this.count), (half) => HALVES[half] * this.factor);
  }

  /** Draws the layer into image data by a curve and an exposure in stops. */
  draw(data, curve, stops) {
    const { halves, count, factor } = this, scale = factor * 2 ** stops, pixels = this.width * this.height;
    const get = (at, c) => halves[at * count + (count === 1 ? 0 : c)];
    if (curve === "srgb" || curve === "signed") {
      const tone = curve === "srgb" ? (x) => srgb(x * scale) : (x) => 0.5 + 0.5 * x * scale;
      const table = Uint8Array.from(HALVES, (x) => level(tone(x)));
      for (let at = 0; at < pixels; at++) {
        for (let c = 0; c < 3; c++) data[4 * at + c] = table[get(at, c)];
        data[4 * at + 3] = 255;
      }
    } else if (curve === "paper") {
      const powers = Uint8Array.from({ length: 4096 }, (_, i) => level((i / 4095) ** (2 / 2.2)));
      for (let at = 0; at < pixels; at++) {
        const [r, g, b] = [0, 1, 2].map((c) => Math.min(1e30, Math.max(0, HALVES[get(at, c)] * scale)));
        const share = 1 / (1 + (0.3 * r + 0.6 * g + 0.1 * b) / 1.5);
        data[4 * at] = powers[Math.min(4095, Math.round(4095 * Math.sqrt(r * share)))];
        data[4 * at + 1] = powers[Math.min(4095, Math.round(4095 * Math.sqrt(g * share)))];
        data[4 * at + 2] = powers[Math.min(4095, Math.round(4095 * Math.sqrt(b * share)))];
        data[4 * at + 3] = 255;
      }
    } else if (FILM_CURVES[curve]) {
      for (let at = 0; at < pixels; at++) {
        const color = [0, 1, 2].map((c) => Math.min(1e6, Math.max(0, HALVES[get(at, c)] * scale)));
        data.set(FILM_CURVES[curve](color).map(level), 4 * at);
        data[4 * at + 3] = 255;
      }
    } else {
      const middle = Math.abs(this.mean) / 2 ** stops;
      for (let at = 0; at < pixels; at++) {
        let sum = 0;
        for (let c = 0; c < count; c++) sum += HALVES[halves[at * count + c]];
        data.set(falseColor((sum / count) * factor, middle), 4 * at);
        data[4 * at + 3] = 255;
      }
    }
  }
}

/** Borders between pixels of different cells, in pixels of the picture. */
function borders(ofPixels, width, height) {
  const path = new Path2D();
  const runs = (count, length, differs, line) => {
    for (let row = 1; row < count; row++) {
      for (let at = 0, start = -1; at <= length; at++) {
        const isBorder = at < length && differs(row, at);
        if (isBorder && start < 0) start = at;
        if (!isBorder && start >= 0) [start] = [-1, line(row, start, at)];
      }
    }
  };
  const segment = (x0, y0, x1, y1) => { path.moveTo(x0, y0); path.lineTo(x1, y1); };
  const pixel = (x, y) => ofPixels[y * width + x];
  runs(height, width, (y, x) => pixel(x, y) !== pixel(x, y - 1), (y, from, to) => segment(from, y, to, y));
  runs(width, height, (x, y) => pixel(x, y) !== pixel(x - 1, y), (x, from, to) => segment(x, from, x, to));
  return path;
}

/** Least size of a pixel on the screen at which its values are written into it. */
const VALUES_FROM = 56;

/** The canvas: a layer, cells over it, a mark, and the part of the picture that is seen. */
export class Stage {
  constructor(canvas, onPick, onHover) {
    Object.assign(this, { canvas, onPick, onHover, layer: null, cells: null, mark: null, fits: true, scale: 1, x: 0, y: 0 });
    this.pixels = document.createElement("canvas");
    this.overlay = document.createElement("canvas");
    this.pointers = new Map();
    new ResizeObserver(() => this.resize()).observe(canvas.parentElement);
    canvas.addEventListener("wheel", (event) => this.wheel(event), { passive: false });
    canvas.addEventListener("pointerdown", (event) => this.down(event));
    canvas.addEventListener("pointermove", (event) => this.move(event));
    canvas.addEventListener("pointerup", (event) => this.up(event));
    canvas.addEventListener("pointercancel", (event) => { this.pointers.delete(event.pointerId); this.steer?.onRest(); });
    canvas.addEventListener("keydown", (event) => this.key(event));
    canvas.addEventListener("contextmenu", (event) => this.isSteered() && event.preventDefault());
  }

  /** Whether pointers and keys move a camera in place of the picture. `steer` is who moves it. */
  isSteered() {
    return Boolean(this.steer?.isOn());
  }

  /** Shows a layer by a curve and an exposure in stops. */
  show(layer, curve, stops) {
    const { width, height } = layer;
    if (this.pixels.width !== width || this.pixels.height !== height || !this.data) {
      const factor = this.pixels.width / width, isSameView = this.data && Math.abs(this.pixels.height / height / factor - 1) < 0.05;
      [this.pixels.width, this.pixels.height] = [width, height];
      this.data = new ImageData(width, height);
      // A smaller picture of a camera that moves stays where the larger one was.
      if (isSameView && !this.fits) this.scale *= factor;
      else this.fits = true;
      this.mark = null;
    }
    this.layer = layer;
    layer.draw(this.data.data, curve, stops);
    this.pixels.getContext("2d").putImageData(this.data, 0, 0);
    this.resize();
  }

  /** Shows cells over the picture: the cell of every pixel and the mean radiance of every cell; `null` shows none. */
  showCells(cells) {
    this.cells = cells;
    if (cells) {
      const { width, height, ofPixels, means } = cells;
      [this.overlay.width, this.overlay.height] = [width, height];
      const middle = means.reduce((sum, mean) => sum + mean, 0) / Math.max(1, means.length);
      const colors = Array.from(means, (mean) => falseColor(mean, middle));
      const data = new ImageData(width, height);
      ofPixels.forEach((cell, at) => cell < means.length && data.data.set([...colors[cell], 140], 4 * at));
      this.borders = borders(ofPixels, width, height);
      this.overlay.getContext("2d").putImageData(data, 0, 0);
    }
    this.paint();
  }

  resize() {
    const { clientWidth, clientHeight } = this.canvas, ratio = window.devicePixelRatio || 1;
    [this.canvas.width, this.canvas.height] = [Math.round(clientWidth * ratio), Math.round(clientHeight * ratio)];
    if (this.fits) this.fit();
    else this.paint();
  }

  fit() {
    if (!this.layer) return;
    const { clientWidth, clientHeight } = this.canvas, { width, height } = this.layer;
    const margin = Math.min(24, clientWidth / 20);
    this.fits = true;
    this.scale = Math.max(1e-3, Math.min((clientWidth - margin) / width, (clientHeight - margin) / height));
    this.x = (clientWidth - width * this.scale) / 2;
    this.y = (clientHeight - height * this.scale) / 2;
    this.paint();
  }

  /** Zooms by a factor around a point of the canvas, or around its middle. */
  zoom(factor, at = [this.canvas.clientWidth / 2, this.canvas.clientHeight / 2]) {
    const scale = Math.min(160, Math.max(0.05, this.scale * factor));
    this.x = at[0] - ((at[0] - this.x) * scale) / this.scale;
    this.y = at[1] - ((at[1] - this.y) * scale) / this.scale;
    [this.scale, this.fits] = [scale, false];
    this.paint();
  }

  /** Pixel at a point of the canvas, or `null`. */
  pixelAt(x, y) {
    if (!this.layer) return null;
    const pixel = [Math.floor((x - this.x) / this.scale), Math.floor((y - this.y) / this.scale)];
    const isInside = pixel[0] >= 0 && pixel[1] >= 0 && pixel[0] < this.layer.width && pixel[1] < this.layer.height;
    return isInside ? pixel : null;
  }

  /** Point of the canvas at which the middle of a pixel lies. */
  pointOf([x, y]) {
    return [this.x + (x + 0.5) * this.scale, this.y + (y + 0.5) * this.scale];
  }

  pick(pixel) {
    this.mark = pixel;
    this.paint();
    this.onPick(pixel);
  }

  wheel(event) {
    event.preventDefault();
    if (this.isSteered()) return this.steer.onWheel(-event.deltaY / 120);
    this.zoom(2 ** (-event.deltaY / 240), [event.offsetX, event.offsetY]);
  }

  down(event) {
    this.pointers.set(event.pointerId, [event.offsetX, event.offsetY]);
    this.moved = 0;
    this.canvas.setPointerCapture(event.pointerId);
  }

  move(event) {
    const now = [event.offsetX, event.offsetY], before = this.pointers.get(event.pointerId);
    if (!before) return this.onHover(this.pixelAt(...now));
    const others = [...this.pointers].filter(([id]) => id !== event.pointerId).map(([, point]) => point);
    const step = [now[0] - before[0], now[1] - before[1]];
    this.moved += Math.hypot(...step);
    this.pointers.set(event.pointerId, now);
    if (others.length === 1) {
      const spread = (point) => Math.hypot(point[0] - others[0][0], point[1] - others[0][1]);
      if (this.isSteered()) return this.steer.onPinch(Math.max(1, spread(now)) / Math.max(1, spread(before)), step);
      this.zoom(spread(now) / Math.max(1, spread(before)), others[0]);
    } else if (this.isSteered()) {
      if (this.moved > 4) this.steer.onDrag(step, event);
    } else if (this.moved > 4 && !(this.fits && event.pointerType === "touch")) {
      [this.x, this.y, this.fits] = [this.x + step[0], this.y + step[1], false];
      this.paint();
    }
  }

  up(event) {
    const isClick = this.pointers.delete(event.pointerId) && this.moved <= 4;
    const pixel = isClick && this.pixelAt(event.offsetX, event.offsetY);
    if (this.isSteered()) return pixel ? this.steer.onClick(pixel).catch(() => {}) : this.steer.onRest();
    if (pixel) this.pick(pixel);
  }

  key(event) {
    if (!this.layer || event.ctrlKey || event.metaKey || event.altKey) return;
    if (this.isSteered() && this.steer.onKey(event)) return event.preventDefault();
    const { width, height } = this.layer, stride = event.shiftKey ? 10 : 1;
    const steps = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
    const step = steps[event.key], mark = this.mark ?? [width >> 1, height >> 1];
    const within = (at, size) => Math.min(size - 1, Math.max(0, at));
    if (step) {
      this.mark = [within(mark[0] + stride * step[0], width), within(mark[1] + stride * step[1], height)];
      this.keepInSight();
      this.onHover(this.mark);
    } else if (event.key === "Enter" || event.key === " ") this.pick(mark);
    else if (event.key === "+" || event.key === "=") this.zoom(Math.SQRT2, this.pointOf(mark));
    else if (event.key === "-") this.zoom(Math.SQRT1_2, this.pointOf(mark));
    else if (event.key === "0") this.fit();
    else return;
    event.preventDefault();
    this.paint();
  }

  keepInSight() {
    const [x, y] = this.pointOf(this.mark), { clientWidth, clientHeight } = this.canvas;
    if (x < 0 || x > clientWidth) this.x += clientWidth / 2 - x;
    if (y < 0 || y > clientHeight) this.y += clientHeight / 2 - y;
  }

  paint() {
    if (this.painting) return;
    this.painting = requestAnimationFrame(() => {
      this.painting = 0;
      this.paintNow();
    });
  }

  paintNow() {
    const context = this.canvas.getContext("2d"), ratio = window.devicePixelRatio || 1;
    this.canvas.classList.toggle("zoomed", !this.fits || this.isSteered());
    this.canvas.classList.toggle("steered", this.isSteered());
    context.setTransform(1, 0, 0, 1, 0, 0);
    context.clearRect(0, 0, this.canvas.width, this.canvas.height);
    if (!this.layer) return;
    const { width, height } = this.layer;
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    context.imageSmoothingEnabled = this.isSmall || this.scale * ratio < 1;
    context.imageSmoothingQuality = "high";
    const box = [this.x, this.y, width * this.scale, height * this.scale];
    context.drawImage(this.pixels, ...box);
    if (this.cells && this.overlay.width === width && this.overlay.height === height) this.paintCells(context, box, ratio);
    if (this.scale >= VALUES_FROM && !this.isSmall) this.paintValues(context);
    if (this.mark) this.paintMark(context);
  }

  paintCells(context, box, ratio) {
    context.drawImage(this.overlay, ...box);
    context.setTransform(ratio * this.scale, 0, 0, ratio * this.scale, ratio * this.x, ratio * this.y);
    [context.strokeStyle, context.lineWidth] = ["#ffffffd9", 1.25 / this.scale];
    context.stroke(this.borders);
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
  }

  paintMark(context) {
    const [x, y] = this.pointOf(this.mark), half = Math.max(4, this.scale / 2);
    for (const [color, width] of [["#000a", 4], ["#fff", 1.5]]) {
      [context.strokeStyle, context.lineWidth] = [color, width];
      context.strokeRect(x - half, y - half, 2 * half, 2 * half);
      if (this.scale < 12) {
        context.beginPath();
        for (const [dx, dy] of [[1, 0], [-1, 0], [0, 1], [0, -1]]) {
          context.moveTo(x + dx * half, y + dy * half);
          context.lineTo(x + dx * (half + 7), y + dy * (half + 7));
        }
        context.stroke();
      }
    }
  }

  /** Writes the values of every pixel that is seen into it. */
  paintValues(context) {
    const { clientWidth, clientHeight } = this.canvas, { width, height } = this.layer, data = this.data.data;
    const first = [Math.max(0, Math.floor(-this.x / this.scale)), Math.max(0, Math.floor(-this.y / this.scale))];
    const last = [Math.min(width, Math.ceil((clientWidth - this.x) / this.scale)), Math.min(height, Math.ceil((clientHeight - this.y) / this.scale))];
    const line = Math.min(18, this.scale / 4.6);
    context.font = `${line * 0.86}px system-ui, sans-serif`;
    [context.textAlign, context.textBaseline] = ["center", "middle"];
    for (let y = first[1]; y < last[1]; y++) {
      for (let x = first[0]; x < last[0]; x++) {
        const at = 4 * (y * width + x), light = 0.3 * data[at] + 0.6 * data[at + 1] + 0.1 * data[at + 2];
        const values = this.layer.values(x, y), [cx, cy] = this.pointOf([x, y]);
        context.fillStyle = light > 140 ? "#000" : "#fff";
        values.forEach((value, i) => context.fillText(short(value), cx, cy + (i - (values.length - 1) / 2) * line));
      }
    }
  }
}
