// The page: listens to the render's events, fetches what has changed and sends orders.

import { drawCurve } from "./curve.js";
import { drawRamp, facts, showGuide } from "./guide.js";
import { Mover } from "./move.js";
import { Layer, Stage, short } from "./picture.js";

const find = (id) => document.getElementById(id);
const token = location.hash.slice(1);
/** Name that the printed address has in place of a token that the user has chosen. */
const VARIABLE = "LODESTAR_VIEW_TOKEN";
const MISSING = "This address lacks the render’s token: open the one that the render has printed on its terminal.";
const PHASES = {
  preparing: "Preparing", rendering: "Rendering", pausing: "Pausing after this step", paused: "Paused",
  stopping: "Stopping", ended: "Ended", file: "File", lost: "No connection", locked: "No token", moving: "Moving", resting: "At rest",
};
/** Colors with which a layer is shown first. */
const CURVES = { variance: "false", samples: "false", depth: "false", hits: "false", normal: "signed" };
/** Time after which a connection that has ended is tried again. */
const RETRY = 2000;
/** Time in which the second click on the button that stops must come. */
const SURE = 4000;

let state = { phase: "preparing", shot: 0, guide: 0 };
let [layer, pixel, hovered, fetching, stopAsked] = [null, null, null, false, 0];
/** Sentence about a layer that cannot be shown, until another one is chosen. */
let failure = "";
const choices = {};
const stage = new Stage(find("picture"), pick, hover);
/** Labels of the picture: where keys move a mark, and where they move the camera. */
const LOOKS = find("readout").textContent;
const MOVES = "Drag to orbit, with Shift to shift; the wheel goes nearer; W A S D walk; a click focuses.";
const LABELS = [
  find("picture").getAttribute("aria-label"),
  "The picture. Arrow keys turn the camera, W, A, S, D, Q and E walk, plus and minus go nearer and farther, Enter focuses on the middle, N denoises.",
];
const mover = new Mover({
  ask: (...request) => ask(...request),
  say: (text) => say(text),
  short,
  layer: () => find("layer").value,
  middle: () => [layer.width >> 1, layer.height >> 1],
  pictureWidth: () => layer.width * stage.scale,
  show: async (answer) => {
    await showAnswer(answer);
    noteShown();
    return layer.wish;
  },
  rest: () => { showMoves(); refresh(); },
});
stage.steer = mover;

/** Says a sentence to screen readers. */
function say(text) {
  find("said").textContent = text;
}

/** Asks the server. Browsers send the part of the address after # to nobody, so the token goes in a header. */
const ask = (path, options) => fetch(path, { ...options, headers: { "X-Lodestar-Token": token } });

const capital = (text) => text.charAt(0).toUpperCase() + text.slice(1);
const plain = (name) => name.split("/").slice(-2).join("/").replace(/\/scene\.xml$/, "").replace(/\.(xml|exr)$/, "");

function duration(seconds) {
  const whole = Math.round(seconds), [hours, minutes] = [Math.floor(whole / 3600), Math.floor(whole / 60) % 60];
  if (hours) return `${hours} h ${minutes} min`;
  return minutes ? `${minutes} min ${whole % 60} s` : seconds < 10 ? `${seconds.toFixed(1)} s` : `${whole} s`;
}

const share = (value) => `${short(100 * value)} %`;
const million = (value) => (value > 0 ? `${short(value / 1e6)} M` : "none yet");

function showState() {
  const { phase } = state, isOver = ["ended", "file", "lost", "locked", "stopping"].includes(phase);
  const name = find("phase");
  if (name.dataset.phase !== phase) [name.dataset.phase, name.textContent] = [phase, PHASES[phase] ?? phase];
  const said = capital(failure || (state.message ?? ""));
  if (find("message").textContent !== said) find("message").textContent = said;
  if (state.scene) {
    find("scene").textContent = plain(state.scene);
    find("scene").title = state.scene;
    document.title = `${phase === "rendering" ? `${Math.floor(100 * state.fraction)} % ` : ""}${plain(state.scene)} · Lodestar`;
  }
  find("orders").hidden = phase === "file" || Boolean(state.view);
  showMoves();
  find("progress").value = state.fraction ?? 0;
  find("pause").textContent = phase === "paused" || phase === "pausing" ? "Go on" : "Pause";
  for (const id of ["pause", "write", "stop"]) {
    find(id).disabled = isOver || (phase === "preparing" && id !== "stop");
    find(id).title = phase === "locked" ? "Orders need the token, too." : "";
  }
  if (phase === "locked") find("waiting").textContent = "Nothing is shown without the token.";
  find("cells").disabled = Boolean(state.no_guide);
  find("guide-part").hidden = phase === "file";
  const of = (value, wanted) => (wanted ? `${value} of ${wanted}` : value);
  const noise = layer?.noise ?? state.noise?.at(-1)?.value;
  const error = state.errors?.at(-1);
  facts(find("facts"), [
    ["Samples per pixel", of(state.samples ?? 0, state.wanted_samples)],
    ["Time", of(duration(state.seconds ?? 0), state.wanted_seconds && duration(state.wanted_seconds))],
    ...(phase === "file" ? [] : [["Rays per second", million(state.rays_per_second)], ["Light-hit rate", share(state.light_hit_rate ?? 0)]]),
    ["Noise (estimate)", noise ? share(noise) : "not known yet"],
    ...(state.noise_target ? [
      ["Noisiest tile", `${state.noisiest_tile ? short(state.noisiest_tile) : "not known yet"} (${short(state.noise_target)} is wanted)`],
      ["Pixels still sampled", share(state.sampled_share)],
    ] : []),
    ...(error ? [["Error", `${short(error.value)} after ${error.samples} samples`]] : []),
    ...(state.sampler ? [["Sampler", state.sampler]] : []),
    ...(state.device ? [["Device", state.device]] : []),
    ...(state.files?.length ? [["Files", state.files.map((file) => file.split("/").pop()).join(", ")]] : []),
  ]);
  drawCurve(find("errors"), state.errors ?? []);
  drawCurve(find("noise"), state.noise ?? []);
  find("curves-part").hidden = find("errors").hidden && find("noise").hidden;
}

/** Shows where the camera is, if it can be moved. */
function showMoves() {
  const { view, phase } = state, isRendering = phase === "rendering";
  find("moves").hidden = find("view-orders").hidden = !view;
  if (!view) return;
  const isOver = ["ended", "lost", "locked", "stopping"].includes(phase);
  mover.take(view, isRendering || isOver);
  if (!find("cameras").options.length) loadCameras().catch(() => {});
  for (const id of ["cameras", "back", "lens"]) find(id).disabled = mover.isLocked;
  [find("copy").disabled, find("render").disabled] = [isOver, isOver];
  find("render").textContent = isRendering ? "End and save" : "Render this";
  if (document.activeElement !== find("lens")) find("lens").value = mover.lensValue();
  find("radius").value = mover.pose.aperture > 0 ? short(mover.pose.aperture) : "closed";
  find("lens").setAttribute("aria-valuetext", mover.pose.aperture > 0 ? `radius ${short(mover.pose.aperture)}` : "closed");
  const names = layer?.layers ?? [];
  find("denoised").disabled = !names.includes("denoised");
  find("denoised").checked = find("layer").value === "denoised";
  const label = LABELS[mover.isOn() ? 1 : 0];
  if (find("picture").getAttribute("aria-label") !== label) find("picture").setAttribute("aria-label", label);
  if (mover.isOn() && pixel) forgetPixel();
  if (!hovered) find("readout").textContent = mover.isOn() ? MOVES : LOOKS;
}

/** Cameras of the scene. The page asks for them once. */
async function loadCameras() {
  const select = find("cameras");
  if (select.dataset.asked) return;
  select.dataset.asked = "yes";
  const cameras = await (await ask("/cameras")).json();
  select.replaceChildren(...cameras.map(([name], at) => new Option(name, at)));
  select.value = mover.pose.camera;
  const go = () => { mover.go(cameras[select.value][1]); say(`Camera ${cameras[select.value][0]}`); };
  select.addEventListener("change", go);
  find("back").addEventListener("click", go);
}

/** Forgets the pixel that was looked at, because the camera has moved. */
function forgetPixel() {
  [pixel, hovered, stage.mark] = [null, null, null];
  find("pixel-part").hidden = true;
}

/** Shows a layer that the server has answered with. */
async function showAnswer(answer) {
  layer = new Layer(JSON.parse(answer.headers.get("X-Frame")), await answer.arrayBuffer());
  stage.isSmall = Boolean(state.view) && layer.width < state.view.size[0];
  showLayers(layer.layers);
  showPicture();
}

/** Notes for tests which picture is shown. */
function noteShown() {
  Object.assign(find("picture").dataset, { shot: layer.shot, samples: layer.samples, size: `${layer.width} ${layer.height}` });
}

/** Chooses the denoised layer, or the radiance. */
function denoise(isWanted) {
  const name = isWanted ? "denoised" : "radiance";
  if (!(layer?.layers ?? []).includes(name)) return say("There is no denoiser.");
  find("layer").value = name;
  find("layer").dispatchEvent(new Event("change"));
  say(isWanted ? "Denoised" : "Not denoised");
}

/** Fetches the chosen layer if there is a newer shot, one at a time. */
async function refresh(isForced = false) {
  const name = find("layer").value;
  const isOld = !layer || layer.shot < state.shot || layer.layer !== name;
  if (fetching || mover.isBusy || document.hidden || !state.shot || !(isOld || isForced)) return;
  fetching = true;
  if (layer && layer.layer !== name) wait(`Waiting for the layer ${name}`);
  try {
    const answer = await ask(`/layer?name=${encodeURIComponent(name)}`);
    if (answer.status === 200) {
      await showAnswer(answer);
      await Promise.all([refreshPixel(), refreshCells()]);
      noteShown();
    } else if (answer.status === 404) {
      // The layer cannot be made, and is offered no longer.
      failure = (await answer.text()).trim();
      say(failure);
      find("layer").value = layer && layer.layer !== name ? layer.layer : find("layer").options[0].value;
      if (layer) layer.shot = 0;
      find("waiting").hidden = Boolean(layer);
    }
  } catch {
    // The server has left; its events say so, too.
  } finally {
    fetching = false;
  }
  showState();
  if (layer && !failure && (layer.shot < state.shot || find("layer").value !== layer.layer)) refresh();
}

/** Covers the picture with a sentence. */
function wait(text) {
  [find("waiting").textContent, find("waiting").hidden] = [text, false];
}

function showLayers(names) {
  const select = find("layer");
  if ([...select.options].map((option) => option.value).join() === names.join()) return;
  const chosen = select.value;
  select.replaceChildren(...names.map((name) => new Option(capital(name), name)));
  select.value = names.includes(chosen) ? chosen : names[0];
}

function choice() {
  const name = layer?.layer ?? "radiance";
  return (choices[name] ??= { curve: CURVES[name] ?? (layer?.count === 1 ? "false" : "srgb"), stops: 0 });
}

function showPicture() {
  if (!layer) return;
  const { curve, stops } = choice();
  find("waiting").hidden = true;
  [find("curve").value, find("exposure").value] = [curve, stops];
  find("stops").value = `${stops > 0 ? "+" : ""}${stops} EV`;
  find("exposure").setAttribute("aria-valuetext", `${stops} stops`);
  stage.show(layer, curve, stops);
  if (hovered) readOut();
}

async function refreshPixel() {
  if (!pixel) return;
  const [x, y] = pixel;
  const answer = await ask(`/pixel?x=${x}&y=${y}`);
  if (answer.status !== 200) return;
  const seen = await answer.json();
  if (pixel[0] !== x || pixel[1] !== y) return;
  find("pixel-part").hidden = false;
  find("of-pixel").textContent = `Pixel ${x}, ${y}`;
  const rows = seen.layers.map(([name, channels, values]) => {
    const row = document.createElement("tr"), head = document.createElement("th");
    [head.scope, head.textContent] = ["row", `${capital(name)} ${channels.length > 1 ? channels.join(" ") : ""}`];
    const cells = values.map((value) => Object.assign(document.createElement("td"), { textContent: value === null ? "∞" : short(value) }));
    if (cells.length === 1) cells[0].colSpan = 3;
    row.append(head, ...cells);
    return row;
  });
  find("values").tBodies[0].replaceChildren(...rows);
  showGuide(seen, state);
  find("guide-part").dataset.pixel = pixel.join(",");
}

async function refreshCells() {
  if (!find("cells").checked) return stage.showCells(null);
  const answer = await ask("/cells");
  if (answer.status !== 200) return;
  const { width, height, count } = JSON.parse(answer.headers.get("X-Frame")), buffer = await answer.arrayBuffer();
  const ofPixels = new Uint32Array(buffer, 0, width * height), means = new Float32Array(buffer, 4 * width * height, count);
  stage.showCells({ width, height, ofPixels, means });
}

function values([x, y]) {
  const { channels } = layer;
  return layer.values(x, y).map((value, i) => `${channels.length > 1 ? `${channels[i]} ` : ""}${short(value)}`).join("  ");
}

/** Shows the values of the pixel that was hovered over or clicked last. */
function readOut() {
  const [x, y] = hovered;
  find("readout").textContent = `Pixel ${x + layer.offset[0]}, ${y + layer.offset[1]}:  ${values(hovered)}`;
}

function hover(at) {
  if (!at || !layer) return;
  hovered = at;
  readOut();
  if (document.activeElement === find("picture") && stage.mark === at) say(find("readout").textContent);
}

async function pick(at) {
  pixel = at;
  hover(at);
  await refreshPixel().catch(() => {});
  const brightest = find("learned").textContent && !find("guide").hidden ? find("hemisphere").getAttribute("aria-label") : "";
  say(`${find("readout").textContent} ${brightest}`);
}

async function order(name) {
  try {
    const answer = await ask(`/${name}`, { method: "POST" });
    if (!answer.ok) say(await answer.text());
  } catch {
    say("The render cannot be reached.");
  }
}

/** Shows a state of the render and fetches what is new. */
async function take(next) {
  const { guide } = state;
  state = next;
  showState();
  if (state.guide !== guide && !fetching) {
    refreshPixel().catch(() => {});
    refreshCells().catch(() => {});
  }
  await refresh();
}

/** Shows that nothing comes from the server. */
function lose(phase, message) {
  state = { ...state, phase, message };
  showState();
}

/** Reads events until the connection ends. EventSource cannot send the token. */
async function readEvents(body) {
  const reader = body.pipeThrough(new TextDecoderStream()).getReader();
  let text = "";
  for (;;) {
    const { value, done } = await reader.read();
    if (done) return;
    const events = (text + value).split("\n\n");
    text = events.pop();
    // Only the last state counts.
    const last = events.at(-1);
    if (last) take(JSON.parse(last.slice("data: ".length))).catch(() => {});
  }
}

async function listen() {
  if (!token) return lose("locked", MISSING);
  if (token === VARIABLE) return lose("locked", `Write the value of ${VARIABLE} in place of its name in this address.`);
  try {
    const answer = await ask("/events");
    if (answer.status === 403) return lose("locked", (await answer.text()).trim());
    if (answer.ok) await readEvents(answer.body);
    else lose("lost", (await answer.text()).trim());
  } catch {
    // The server has left.
  }
  if (state.phase === "ended") return;
  if (state.phase !== "lost") lose("lost", "The program has ended or cannot be reached.");
  setTimeout(listen, RETRY);
}

find("layer").addEventListener("change", () => { failure = ""; refresh(); });
find("curve").addEventListener("change", () => { choice().curve = find("curve").value; showPicture(); });
find("exposure").addEventListener("input", () => { choice().stops = Number(find("exposure").value); showPicture(); });
find("cells").addEventListener("change", () => refreshCells().catch(() => {}));
find("fit").addEventListener("click", () => stage.fit());
find("actual").addEventListener("click", () => stage.zoom(1 / stage.scale));
find("larger").addEventListener("click", () => stage.zoom(Math.SQRT2, stage.mark ? stage.pointOf(stage.mark) : undefined));
find("smaller").addEventListener("click", () => stage.zoom(Math.SQRT1_2, stage.mark ? stage.pointOf(stage.mark) : undefined));
find("pause").addEventListener("click", () => order(state.phase === "paused" || state.phase === "pausing" ? "go-on" : "pause"));
find("write").addEventListener("click", () => order("write"));
find("stop").addEventListener("click", () => {
  const button = find("stop"), isSure = Date.now() - stopAsked < SURE;
  stopAsked = isSure ? 0 : Date.now();
  button.classList.toggle("asking", !isSure);
  button.textContent = isSure ? "Stop and save" : "Stop now?";
  if (isSure) return order("stop");
  say("Press again to stop the render and save the picture.");
  setTimeout(() => { button.textContent = "Stop and save"; button.classList.remove("asking"); }, SURE);
});
find("drag").addEventListener("change", () => { mover.mode = find("drag").value; showMoves(); stage.paint(); });
find("lens").addEventListener("input", () => { mover.openLens(Number(find("lens").value)); showMoves(); });
find("denoised").addEventListener("change", () => denoise(find("denoised").checked));
find("render").addEventListener("click", () => order("render"));
find("copy").addEventListener("click", async () => {
  const text = await (await ask("/camera.xml")).text();
  find("xml-text").value = text;
  find("xml").showModal();
  find("xml-text").select();
  // Only pages of this machine may write the clipboard; elsewhere the text is selected.
  const isCopied = await navigator.clipboard?.writeText(text).then(() => true, () => false);
  say(isCopied ? "The XML of the camera is copied." : "The XML of the camera is selected.");
});
find("picture").addEventListener("keyup", (event) => mover.letGo(event.code));
find("picture").addEventListener("keydown", (event) => {
  if (event.code === "KeyN" && state.view && !event.ctrlKey && !event.metaKey) denoise(find("layer").value !== "denoised");
});
find("picture").addEventListener("blur", () => mover.letAllGo());
document.addEventListener("visibilitychange", () => refresh());
// The link to the picture must not take the token's place in the address, and a new token begins the page anew.
document.querySelector(".skip").addEventListener("click", (event) => { event.preventDefault(); find("picture").focus(); });
window.addEventListener("hashchange", () => location.reload());
drawRamp(find("ramp"));
showState();
listen();

// For tests: where pixels lie on the screen.
window.lodestar = { ask, pointOf: (at) => { const box = find("picture").getBoundingClientRect(), [x, y] = stage.pointOf(at); return [box.x + x, box.y + y]; } };
