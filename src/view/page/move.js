// The camera of a scene that is looked at: mouse, touch and keys move it, and each move asks for its picture.

const add = (a, b, factor = 1) => a.map((value, i) => value + factor * b[i]);
const scaled = (a, factor) => a.map((value) => value * factor);
const dot = (a, b) => a.reduce((sum, value, i) => sum + value * b[i], 0);
const cross = ([a, b, c], [x, y, z]) => [b * z - c * y, c * x - a * z, a * y - b * x];
const unit = (a) => scaled(a, 1 / Math.hypot(...a));

/** A vector turned about a unit axis by an angle in radians. */
function turned(vector, axis, angle) {
  const [sine, cosine] = [Math.sin(angle), Math.cos(angle)];
  return add(add(scaled(vector, cosine), cross(axis, vector), sine), axis, dot(axis, vector) * (1 - cosine));
}

/** Radians that a camera turns for each pixel of a drag. */
const PER_PIXEL = 0.006;
/** Cosine between the direction of view and the vertical beyond which a camera turns no further. */
const STEEPEST = 0.998;
/** Distance that a wheel's click goes, as a share of the distance to the middle of the picture. */
const PER_CLICK = 0.1;
/** Distance that a walk goes in a second, as a share of the distance to the middle; and how much faster Shift makes it. */
const [PER_SECOND, FAST] = [0.4, 4];
/** Pixels of a drag that one press of an arrow key stands for. */
const PER_KEY = 12;
/** Keys of a walk: to the right, up, forward. */
const WALK = { KeyW: [0, 0, 1], KeyS: [0, 0, -1], KeyA: [-1, 0, 0], KeyD: [1, 0, 0], KeyE: [0, 1, 0], KeyQ: [0, -1, 0] };
/** Largest value of the lens's slider, which stands for a radius of this share of the distance to the middle. */
const [MOST_LENS, LENS_SHARE] = [20, 0.1];

/** Moves the camera. `host` asks the server, shows layers and says sentences. */
export class Mover {
  constructor(host) {
    Object.assign(this, { host, pose: null, vertical: null, distance: 1, wish: 0, mode: "orbit", held: new Set(), isBusy: false, isDragged: false });
  }

  /** Whether drags and keys move the camera. */
  isOn() {
    return Boolean(this.pose) && this.mode !== "mark" && !this.isLocked;
  }

  /** Takes the camera as the server has it, unless a move of this page is under way. */
  take(view, isLocked) {
    this.isLocked = isLocked;
    [this.halfWidth, this.isParallel] = [view.half_width, view.is_orthographic];
    if (this.isBusy || this.isDragged || this.isHeld() || view.wish < this.wish) return;
    [this.pose, this.distance] = [structuredClone(view.pose), view.distance];
    this.vertical ??= this.nearestAxis(view.pose.up);
  }

  /** The axis of the world that is nearest to a direction: where up is while the camera turns. */
  nearestAxis(up) {
    const axis = up.reduce((most, value, i) => (Math.abs(value) > Math.abs(up[most]) ? i : most), 0);
    return [0, 1, 2].map((i) => (i === axis ? Math.sign(up[axis]) : 0));
  }

  isHeld() {
    return this.held.size > 0;
  }

  right() {
    return unit(cross(this.pose.forward, this.pose.up));
  }

  /** Turns forward and up, by angles about the vertical and about the horizontal. Returns a function that turns other vectors so. */
  turn(across, along) {
    const { pose, vertical } = this, right = this.right();
    const steepness = dot(turned(pose.forward, right, along), vertical);
    const pitch = Math.abs(steepness) < STEEPEST || Math.abs(steepness) < Math.abs(dot(pose.forward, vertical)) ? along : 0;
    const both = (vector) => turned(turned(vector, right, pitch), vertical, across);
    [pose.forward, pose.up] = [unit(both(pose.forward)), unit(both(pose.up))];
    return both;
  }

  /** Moves as a drag by so many pixels does in a mode. */
  drag([x, y], mode = this.mode) {
    const { pose } = this;
    if (mode === "pan") {
      const depth = this.isParallel ? pose.scale : this.distance, perPixel = (2 * this.halfWidth * depth) / Math.max(1, this.host.pictureWidth());
      pose.eye = add(add(pose.eye, this.right(), -x * perPixel), pose.up, y * perPixel);
    } else if (mode === "turn") this.turn(x * PER_PIXEL * 0.5, y * PER_PIXEL * 0.5);
    else {
      const pivot = add(pose.eye, pose.forward, this.distance);
      this.turn(-x * PER_PIXEL, -y * PER_PIXEL);
      pose.eye = add(pivot, pose.forward, -this.distance);
    }
  }

  /** Goes nearer by so many clicks of a wheel. */
  dolly(clicks) {
    const factor = (1 - PER_CLICK) ** clicks;
    if (this.isParallel) this.pose.scale *= factor;
    else this.pose.eye = add(this.pose.eye, this.pose.forward, this.distance * (1 - factor));
    this.distance = Math.max(1e-9, this.isParallel ? this.distance : this.distance * factor);
  }

  /** A pointer has moved by a step in pixels. */
  onDrag(step, event) {
    this.isDragged = event.type === "pointermove";
    this.drag(step, event.shiftKey || event.buttons & 6 ? "pan" : this.mode);
    this.send(true);
  }

  /** Two fingers have moved and spread. */
  onPinch(spread, step) {
    this.isDragged = true;
    this.dolly(Math.log(spread) / -Math.log(1 - PER_CLICK));
    this.drag(scaled(step, 0.5), "pan");
    this.send(true);
  }

  onWheel(clicks) {
    this.dolly(clicks);
    this.send(true);
  }

  /** The pointer has left: the picture may become large. */
  onRest() {
    if (!this.isDragged) return;
    this.isDragged = false;
    if (!this.isHeld()) this.send(false);
  }

  /** Focuses on what a pixel shows; drags then turn around it. */
  async onClick([x, y]) {
    const answer = await this.host.ask(`/pixel?x=${x}&y=${y}`), seen = answer.status === 200 ? await answer.json() : null;
    if (!seen?.surface) return this.host.say("There is no surface to focus on.");
    const depth = dot(add(seen.surface.position, this.pose.eye, -1), this.pose.forward);
    if (!(depth > 0)) return;
    [this.pose.focus, this.distance] = [depth, depth];
    const closed = this.pose.aperture > 0 ? "" : " The lens is closed, so everything is sharp.";
    this.host.say(`Focus at a depth of ${this.host.short(depth)}.${closed}`);
    this.send(false);
  }

  /** Answers a key; returns whether it is one of the camera's. */
  onKey(event) {
    const arrows = { ArrowLeft: [-PER_KEY, 0], ArrowRight: [PER_KEY, 0], ArrowUp: [0, -PER_KEY], ArrowDown: [0, PER_KEY] };
    if (event.code in WALK) this.hold(event);
    else if (arrows[event.key]) this.onDrag(arrows[event.key], event);
    else if (event.key === "+" || event.key === "=") this.onWheel(1);
    else if (event.key === "-") this.onWheel(-1);
    else if (event.key === "Enter" || event.key === " ") this.onClick(this.host.middle()).catch(() => {});
    else return false;
    return true;
  }

  /** Walks until the key is let go. */
  hold(event) {
    this.isFast = event.shiftKey;
    if (this.held.has(event.code)) return;
    this.held.add(event.code);
    if (this.held.size === 1) this.walk(performance.now());
  }

  letGo(code) {
    if (this.held.delete(code) && !this.isHeld()) this.send(false);
  }

  /** Lets all keys go, as where the page loses the keyboard. */
  letAllGo() {
    [...this.held].forEach((code) => this.letGo(code));
  }

  walk(before) {
    requestAnimationFrame((now) => {
      if (!this.isHeld() || !this.isOn()) return this.letAllGo();
      const length = this.distance * PER_SECOND * (this.isFast ? FAST : 1) * Math.min(0.2, Math.max(0, now - before) / 1000);
      const axes = [this.right(), this.pose.up, this.pose.forward];
      for (const code of this.held) WALK[code].forEach((share, i) => { this.pose.eye = add(this.pose.eye, axes[i], share * length); });
      this.send(true);
      this.walk(now);
    });
  }

  /** Goes to a camera of the scene. */
  go(pose) {
    this.pose = structuredClone(pose);
    this.vertical = this.nearestAxis(pose.up);
    this.send(false);
  }

  /** Radius of the lens for a value of its slider, and the other way round. */
  radius(value) {
    return value <= 0 ? 0 : this.distance * LENS_SHARE * 2 ** ((value - MOST_LENS) / 2.5);
  }

  lensValue() {
    if (!this.pose?.aperture) return 0;
    return Math.min(MOST_LENS, Math.max(1, Math.round(MOST_LENS + 2.5 * Math.log2(this.pose.aperture / (this.distance * LENS_SHARE)))));
  }

  openLens(value) {
    if (this.pose.aperture === 0) this.pose.focus = this.distance;
    this.pose.aperture = this.radius(value);
    this.send(false);
  }

  /** Asks for the picture from here. Of the moves while one is under way, the last one is asked for next. */
  async send(isMoving) {
    [this.isWanted, this.isMoving] = [true, isMoving];
    if (this.isBusy) return;
    this.isBusy = true;
    try {
      while (this.isWanted) {
        this.isWanted = false;
        const { pose } = this, query = new URLSearchParams({ name: this.host.layer(), moving: this.isMoving ? "1" : "0" });
        for (const name of ["eye", "forward", "up"]) query.set(name, pose[name].join());
        for (const name of ["camera", "aperture", "focus", "scale"]) query.set(name, String(pose[name]));
        // Commas stay commas, and names of layers have nothing that needs an escape.
        const answer = await this.host.ask(`/move?${decodeURIComponent(query.toString())}`, { method: "POST" });
        if (answer.status === 200) this.wish = Math.max(this.wish, await this.host.show(answer));
        else if (answer.status >= 400) this.host.say((await answer.text()).trim());
      }
    } catch {
      this.host.say("The program cannot be reached.");
    } finally {
      this.isBusy = false;
      this.host.rest();
    }
  }
}
