"use strict";
// Plays a replay of a mill: the charge as ray-cut spheres in axes of the body facts.home, the machine as triangles on its bodies.
const facts = JSON.parse(document.getElementById("facts").textContent);
const VIRIDIS = ["440154", "482878", "3e4989", "31688e", "26828e", "1f9e89", "35b779", "6ece58", "b5de2b", "fde725"];
const MATERIALS = ["0072B2", "E69F00", "009E73", "CC79A7", "56B4E9", "D55E00"];
const element = (id) => document.getElementById(id);

function fail(text) {
  element("trouble").style.display = "block";
  element("trouble").textContent = text;
  throw new Error(text);
}

const bytesOf = (text) => Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));

// Positions, speeds and forces are differences from frame to frame, high bytes before low ones: this undoes it.
async function unpacked() {
  if (typeof DecompressionStream === "undefined") fail("This browser is too old to unpack the data; any browser of 2023 or later can.");
  const stream = new Blob([bytesOf(element("packed").textContent)]).stream().pipeThrough(new DecompressionStream("deflate"));
  const raw = new Uint8Array(await new Response(stream).arrayBuffer());
  const { frames, particles } = facts, numbers = 3 * particles;
  const places = new Uint16Array(frames * numbers), speeds = new Uint8Array(frames * particles);
  const forces = facts.force ? new Uint8Array(frames * particles) : null;
  let at = 0;
  for (let f = 0; f < frames; f++) {
    for (let k = 0; k < numbers; k++) {
      const before = f ? places[(f - 1) * numbers + k] : 0;
      places[f * numbers + k] = before + 256 * raw[at + k] + raw[at + numbers + k];
    }
    at += 2 * numbers;
    for (let k = 0; k < particles; k++) speeds[f * particles + k] = (f ? speeds[(f - 1) * particles + k] : 0) + raw[at + k];
    at += particles;
    if (!forces) continue;
    for (let k = 0; k < particles; k++) forces[f * particles + k] = (f ? forces[(f - 1) * particles + k] : 0) + raw[at + k];
    at += particles;
  }
  return { places, speeds, forces };
}

// Matrices are 16 numbers, column after column, as WebGL takes them.
function times(a, b) {
  const c = new Float32Array(16);
  for (let i = 0; i < 4; i++) for (let j = 0; j < 4; j++) for (let k = 0; k < 4; k++) c[4 * j + i] += a[4 * k + i] * b[4 * j + k];
  return c;
}
function poseMatrix([x, y, z], [a, b, c, d]) {
  return new Float32Array([
    1 - 2 * (c * c + d * d), 2 * (b * c + a * d), 2 * (b * d - a * c), 0,
    2 * (b * c - a * d), 1 - 2 * (b * b + d * d), 2 * (c * d + a * b), 0,
    2 * (b * d + a * c), 2 * (c * d - a * b), 1 - 2 * (b * b + c * c), 0, x, y, z, 1]);
}
function inversePose(m) {
  const r = new Float32Array([m[0], m[4], m[8], 0, m[1], m[5], m[9], 0, m[2], m[6], m[10], 0, 0, 0, 0, 1]);
  for (let i = 0; i < 3; i++) r[12 + i] = -(r[i] * m[12] + r[4 + i] * m[13] + r[8 + i] * m[14]);
  return r;
}
const minus = (a, b) => a.map((x, i) => x - b[i]);
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const unit = (a) => a.map((x) => x / Math.hypot(...a));
function lookAt(eye, target, up) {
  const back = unit(minus(eye, target)), right = unit(cross(up, back)), top = cross(back, right);
  return inversePose(new Float32Array([...right, 0, ...top, 0, ...back, 0, ...eye, 1]));
}
function perspective(view, aspect, near, far) {
  const f = 1 / Math.tan(view / 2);
  return new Float32Array([f / aspect, 0, 0, 0, 0, f, 0, 0, 0, 0, (far + near) / (near - far), -1, 0, 0, (2 * far * near) / (near - far), 0]);
}

const SHADE = `
  vec3 lit(vec3 colour, vec3 normal) {
    float light = 0.45 + 0.5 * max(dot(normal, normalize(vec3(-0.4, 0.6, 0.7))), 0.0) + 0.1 * max(dot(normal, vec3(0.7, -0.3, 0.6)), 0.0);
    return colour * light;
  }`;
const SPHERE = [`#version 300 es
  layout(location = 0) in vec3 here; layout(location = 1) in vec3 next;
  layout(location = 2) in float speed; layout(location = 3) in float speedNext; layout(location = 4) in float radius; layout(location = 5) in float given;
  uniform mat4 toEye, lens; uniform vec3 low, span; uniform float between, pixels; uniform vec2 heights; uniform int by;
  out vec3 centre; out float size, value;
  void main() {
    vec3 place = low + span * mix(here, next, between);
    vec4 eye = toEye * vec4(place, 1.0);
    centre = eye.xyz; size = radius;
    value = by == 2 ? given : by == 1 ? clamp((place.z - heights.x) / heights.y, 0.0, 1.0) : mix(speed, speedNext, between);
    gl_Position = lens * eye;
    gl_PointSize = 1.06 * pixels * radius / max(-eye.z, 1e-3);
  }`, `#version 300 es
  precision highp float;
  in vec3 centre; in float size, value; uniform vec3 palette[10]; uniform mat4 lens; out vec4 colour;${SHADE}
  void main() {
    vec2 off = 2.12 * (gl_PointCoord - 0.5); float square = dot(off, off);
    if (square > 1.0) discard;
    vec3 normal = vec3(off.x, -off.y, sqrt(1.0 - square));
    vec4 clip = lens * vec4(centre + size * normal, 1.0);
    gl_FragDepth = 0.5 + 0.5 * clip.z / clip.w;
    float at = 9.0 * value; int k = int(min(floor(at), 8.0));
    colour = vec4(lit(mix(palette[k], palette[k + 1], at - float(k)), normal), 1.0);
  }`];
const MESH = [`#version 300 es
  layout(location = 0) in vec3 corner; uniform mat4 toEye, lens; out vec3 place;
  void main() { vec4 eye = toEye * vec4(corner, 1.0); place = eye.xyz; gl_Position = lens * eye; }`, `#version 300 es
  precision highp float;
  in vec3 place; uniform vec4 paint; out vec4 colour;${SHADE}
  void main() {
    vec3 normal = normalize(cross(dFdx(place), dFdy(place)));
    colour = vec4(lit(paint.rgb, normal), paint.a);
  }`];

function program(gl, [vertex, fragment]) {
  const made = gl.createProgram();
  for (const [kind, text] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
    const shader = gl.createShader(kind);
    gl.shaderSource(shader, text);
    gl.compileShader(shader);
    gl.attachShader(made, shader);
  }
  gl.linkProgram(made);
  if (!gl.getProgramParameter(made, gl.LINK_STATUS)) fail("The picture cannot be drawn here: " + gl.getProgramInfoLog(made));
  const uniforms = {};
  for (let k = 0; k < gl.getProgramParameter(made, gl.ACTIVE_UNIFORMS); k++) {
    const name = gl.getActiveUniform(made, k).name.replace("[0]", "");
    uniforms[name] = gl.getUniformLocation(made, name);
  }
  return { made, uniforms };
}

const rgb = (hex) => [0, 2, 4].map((k) => parseInt(hex.slice(k, k + 2), 16) / 255);
const camera = { view: "front", azimuth: 0, height: 0, distance: 1, target: [0, 0, 0], angle: 0 };
const playing = { on: true, frame: 0, stamp: 0 };

// Without the machine the camera looks at the vessel, from where its middle is on the mean, and comes nearer.
function frameVessel() {
  if (element("machine").checked || facts.home === "ground" || camera.rides) return choose(camera.view);
  const own = facts.parts.filter((part) => part.body === facts.home), walls = own.filter((part) => part.opacity < 1);
  const low = [Infinity, Infinity, Infinity], high = low.map((x) => -x);
  for (const part of own) {  // stubs make it longer than its wall, and the wall is cut open and not as wide
    const corners = new Float32Array(bytesOf(part.vertices).buffer);
    corners.forEach((x, k) => {
      if (k % 3 === 2 && walls.length && !walls.includes(part)) return;
      low[k % 3] = Math.min(low[k % 3], x);
      high[k % 3] = Math.max(high[k % 3], x);
    });
  }
  const middle = low.map((x, k) => (x + high[k]) / 2), radius = 0.5 * Math.max(...low.map((x, k) => high[k] - x));
  const target = [0, 0, 0];
  for (let frame = 0; frame < facts.frames; frame++) {
    const m = poseAt(facts.home, frame, 0);
    for (let i = 0; i < 3; i++) target[i] += (m[i] * middle[0] + m[4 + i] * middle[1] + m[8 + i] * middle[2] + m[12 + i]) / facts.frames;
  }
  Object.assign(camera, { target, distance: 1.15 * radius / Math.sin(camera.angle / 2) });
}

// The views of facts.views: place of the camera about its target, in world axes or riding on the chamber.
function choose(name) {
  Object.assign(camera, facts.views[name], { view: name });
  element("view").value = name;
}

function buffers(gl, data) {
  const spheres = { places: gl.createBuffer(), speeds: gl.createBuffer(), forces: gl.createBuffer(), radii: gl.createBuffer(), materials: gl.createBuffer(), sizes: gl.createBuffer() };
  const radii = new Float32Array(bytesOf(facts.radii).buffer), [small, large] = facts.sizes;
  const sizes = radii.map((radius) => (large > small ? (2 * radius - small) / (large - small) : 1));
  const materials = Float32Array.from(bytesOf(facts.material), (number) => Math.min(number, MATERIALS.length - 1) / 9);
  for (const [buffer, numbers] of [[spheres.places, data.places], [spheres.speeds, data.speeds], [spheres.forces, data.forces || data.speeds], [spheres.radii, radii], [spheres.materials, materials], [spheres.sizes, sizes]]) {
    gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
    gl.bufferData(gl.ARRAY_BUFFER, numbers, gl.STATIC_DRAW);
  }
  const parts = facts.parts.map((part) => {
    const own = gl.createVertexArray(), corners = gl.createBuffer(), order = gl.createBuffer();
    const triangles = new Uint16Array(bytesOf(part.triangles).buffer);
    gl.bindVertexArray(own);
    gl.bindBuffer(gl.ARRAY_BUFFER, corners);
    gl.bufferData(gl.ARRAY_BUFFER, new Float32Array(bytesOf(part.vertices).buffer), gl.STATIC_DRAW);
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, order);
    gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, triangles, gl.STATIC_DRAW);
    gl.enableVertexAttribArray(0);
    gl.vertexAttribPointer(0, 3, gl.FLOAT, false, 0, 0);
    return { ...part, own, count: triangles.length, paint: [...rgb(part.colour.slice(1)), part.opacity] };
  });
  gl.bindVertexArray(null);
  return { spheres, parts, own: gl.createVertexArray() };
}

function poseAt(body, frame, between) {
  const moves = facts.bodies[body], a = moves[frame], b = moves[Math.min(frame + 1, moves.length - 1)];
  const mixed = a.map((x, k) => x + between * (b[k] - x)), q = mixed.slice(3), length = Math.hypot(...q);
  return poseMatrix(mixed.slice(0, 3), q.map((x) => x / length));
}

function cameraMatrix(chamber) {
  const c = Math.cos(camera.height), direction = [c * Math.cos(camera.azimuth), c * Math.sin(camera.azimuth), Math.sin(camera.height)];
  const eye = camera.target.map((x, k) => x + camera.distance * direction[k]);
  const up = Math.abs(direction[2]) > 0.999 ? [0, 1, 0] : [0, 0, 1];
  const seen = lookAt(eye, camera.target, up);
  return camera.rides ? times(seen, inversePose(chamber)) : seen;
}

function shown(part) {
  if (part.body === facts.home && facts.home !== "ground") return element("chamber").checked && !(camera.hides || []).includes(part.name);
  return element("machine").checked && !(camera.hides || []).includes(part.name);
}

function draw(gl, sphere, mesh, made) {
  const canvas = gl.canvas, ratio = window.devicePixelRatio || 1;
  const width = Math.round(canvas.clientWidth * ratio), height = Math.round(canvas.clientHeight * ratio);
  if (canvas.width !== width || canvas.height !== height) Object.assign(canvas, { width, height });
  gl.viewport(0, 0, width, height);
  gl.clearColor(0.957, 0.965, 0.973, 1);
  gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
  const frame = Math.min(Math.floor(playing.frame), facts.frames - 1), between = playing.frame - frame;
  const chamber = poseAt(facts.home, frame, between), world = cameraMatrix(chamber);
  const lens = perspective(camera.angle, width / height, facts.reach / 200, 12 * facts.reach);
  const paint = (part) => {
    gl.uniformMatrix4fv(mesh.uniforms.toEye, false, times(world, poseAt(part.body, frame, between)));
    gl.uniform4fv(mesh.uniforms.paint, part.paint);
    gl.bindVertexArray(part.own);
    gl.drawElements(gl.TRIANGLES, part.count, gl.UNSIGNED_SHORT, 0);
  };
  gl.useProgram(mesh.made);
  gl.uniformMatrix4fv(mesh.uniforms.lens, false, lens);
  made.parts.filter((part) => shown(part) && part.opacity === 1).forEach(paint);
  if (facts.particles) drawSpheres(gl, sphere, made, frame, between, times(world, chamber), lens, height);
  gl.useProgram(mesh.made);
  gl.enable(gl.BLEND);
  gl.depthMask(false);
  made.parts.filter((part) => shown(part) && part.opacity < 1).forEach(paint);
  gl.depthMask(true);
  gl.disable(gl.BLEND);
}

function drawSpheres(gl, sphere, made, frame, between, toEye, lens, height) {
  const { particles } = facts, next = Math.min(frame + 1, facts.frames - 1);
  gl.useProgram(sphere.made);
  gl.bindVertexArray(made.own);
  const stream = (place, buffer, size, kind, byte, whole) => {
    gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
    gl.enableVertexAttribArray(place);
    gl.vertexAttribPointer(place, size, kind, whole, 0, byte);
  };
  stream(0, made.spheres.places, 3, gl.UNSIGNED_SHORT, 6 * particles * frame, true);
  stream(1, made.spheres.places, 3, gl.UNSIGNED_SHORT, 6 * particles * next, true);
  const by = element("colour").value, rates = by === "force" ? made.spheres.forces : made.spheres.speeds;
  stream(2, rates, 1, gl.UNSIGNED_BYTE, particles * frame, true);
  stream(3, rates, 1, gl.UNSIGNED_BYTE, particles * next, true);
  stream(4, made.spheres.radii, 1, gl.FLOAT, 0, false);
  stream(5, by === "material" ? made.spheres.materials : made.spheres.sizes, 1, gl.FLOAT, 0, false);
  gl.uniformMatrix4fv(sphere.uniforms.toEye, false, toEye);
  gl.uniformMatrix4fv(sphere.uniforms.lens, false, lens);
  gl.uniform3fv(sphere.uniforms.low, facts.low);
  gl.uniform3fv(sphere.uniforms.span, facts.span);
  gl.uniform2fv(sphere.uniforms.heights, facts.heights);
  gl.uniform1f(sphere.uniforms.between, between);
  gl.uniform1f(sphere.uniforms.pixels, height * lens[5]);
  gl.uniform1i(sphere.uniforms.by, { height: 1, material: 2, size: 2 }[by] || 0);
  gl.uniform3fv(sphere.uniforms.palette, paletteOf(by).flatMap(rgb));
  gl.drawArrays(gl.POINTS, 0, particles);
  gl.bindVertexArray(null);
}

const timeAt = (frame) => {
  const k = Math.min(Math.floor(frame), facts.frames - 1), next = Math.min(k + 1, facts.frames - 1);
  return facts.times[k] + (frame - k) * (facts.times[next] - facts.times[k]);
};
function frameAt(time) {
  let k = 0;
  while (k < facts.frames - 2 && facts.times[k + 1] <= time) k++;
  const step = facts.frames > 1 ? facts.times[k + 1] - facts.times[k] : 1;
  return Math.max(0, Math.min(facts.frames - 1, k + (time - facts.times[k]) / step));
}

// Force and torque over the whole run, the time that is shown marked, and a cursor at the present moment.
const shownTimes = () => [facts.times[0], facts.times[facts.frames - 1]];
function runTimes() {
  const [first, last] = shownTimes(), times = facts.traceTimes;
  return times.length ? [Math.min(times[0], first), Math.max(times[times.length - 1], last)] : [first, last];
}
const margin = { left: 62, right: 14, top: 22, gap: 46 };
function drawTraces() {
  const canvas = element("plot"), ratio = window.devicePixelRatio || 1;
  const width = canvas.clientWidth, height = canvas.clientHeight, pen = canvas.getContext("2d");
  Object.assign(canvas, { width: width * ratio, height: height * ratio });
  pen.scale(ratio, ratio);
  pen.font = "12px system-ui, sans-serif";
  const tall = (height - margin.top - 16 - facts.traces.length * margin.gap) / facts.traces.length + 10;
  const [first, last] = runTimes(), [from, to] = shownTimes();
  const across = (time) => margin.left + ((time - first) / (last - first || 1)) * (width - margin.left - margin.right);
  facts.traces.forEach((trace, number) => {
    const top = margin.top + number * (tall + margin.gap), least = Math.min(...trace.values), most = Math.max(...trace.values);
    const spare = 0.05 * (most - least) || 1e-3 * Math.abs(most) || 1, low = least - spare, high = most + spare;
    const down = (value) => top + tall * (1 - (value - low) / (high - low));
    pen.fillStyle = "#e3eef7";
    pen.fillRect(across(from), top, Math.max(across(to) - across(from), 2), tall);
    pen.fillStyle = "#222";
    pen.textAlign = "left";
    pen.fillText(trace.label, margin.left, top - 7);
    pen.strokeStyle = "#ddd";
    pen.textAlign = "right";
    for (const value of ticks(low, high, 5)) {
      pen.beginPath(); pen.moveTo(margin.left, down(value)); pen.lineTo(width - margin.right, down(value)); pen.stroke();
      pen.fillText(String(value), margin.left - 6, down(value) + 4);
    }
    pen.textAlign = "center";
    for (const value of ticks(first, last, 5)) pen.fillText(String(value), across(value), top + tall + 16);
    if (number === facts.traces.length - 1) pen.fillText("time (s)", (margin.left + width - margin.right) / 2, top + tall + 32);
    pen.strokeStyle = trace.colour;
    pen.beginPath();
    facts.traceTimes.forEach((time, k) => pen[k ? "lineTo" : "moveTo"](across(time), down(trace.values[k])));
    pen.stroke();
  });
  pen.strokeStyle = "#b5482a";
  pen.beginPath();
  pen.moveTo(across(timeAt(playing.frame)), 0);
  pen.lineTo(across(timeAt(playing.frame)), height);
  pen.stroke();
}
function ticks(low, high, count) {
  const rough = (high - low) / count, power = 10 ** Math.floor(Math.log10(rough)), step = power * [1, 2, 5, 10].find((k) => k * power >= rough);
  const found = [];
  for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; k++) found.push(Number((k * step).toPrecision(6)));
  return found;
}

function paletteOf(by) {
  return by === "material" ? [...MATERIALS, ...VIRIDIS].slice(0, 10) : VIRIDIS;
}

function legend() {
  const by = element("colour").value, pen = element("bar").getContext("2d"), fill = pen.createLinearGradient(0, 0, 160, 0);
  VIRIDIS.forEach((colour, k) => fill.addColorStop(k / 9, "#" + colour));
  pen.fillStyle = fill;
  pen.fillRect(0, 0, 160, 10);
  const bars = {
    speed: ["speed (m/s)", 0, facts.speed], height: ["height over the floor (m)", 0, facts.heights[1]],
    force: ["contact force (N)", 0, facts.force], size: ["diameter (mm)", 1000 * facts.sizes[0], 1000 * facts.sizes[1]],
  };
  element("bar").hidden = element("ends").hidden = by === "material";
  if (by === "material") {
    const names = facts.materials.map((name, k) => {
      const word = document.createElement("span");
      word.textContent = name;
      word.style.borderLeft = "12px solid #" + MATERIALS[Math.min(k, MATERIALS.length - 1)];
      return word;
    });
    element("what").replaceChildren(...names);
  } else {
    const [words, low, high] = bars[by];
    element("what").textContent = words;
    element("low").textContent = low ? low.toPrecision(3) : "0";
    element("high").textContent = high.toPrecision(3);
  }
  element("legend").style.display = facts.particles ? "block" : "none";
}

function listen() {
  const scene = element("scene"), play = element("play"), seek = element("seek"), plot = element("plot");
  const whole = () => (document.fullscreenElement ? document.exitFullscreen() : document.documentElement.requestFullscreen().catch(() => {}));
  const help = () => { element("help").hidden = !element("help").hidden; };
  const reset = () => {
    Object.assign(playing, { frame: 0, on: true });
    play.textContent = "pause";
    for (const name of ["chamber", "machine"]) element(name).checked = true;
    choose("front");
  };
  element("reset").onclick = reset;
  element("whole").onclick = whole;
  element("ask").onclick = element("close").onclick = help;
  element("whole").hidden = !document.fullscreenEnabled;
  const keys = { KeyR: reset, KeyF: whole, KeyH: help, Slash: help };
  const toggle = () => { playing.on = !playing.on; play.textContent = playing.on ? "pause" : "play"; };
  play.onclick = toggle;
  document.onkeydown = (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || event.target.tagName === "SELECT") return;
    if (event.code === "Space" && event.target === document.body) { event.preventDefault(); toggle(); }
    if (event.code in keys) keys[event.code]();
    if (event.code === "Escape") element("help").hidden = true;
    if (event.target === document.body && event.code.startsWith("Arrow")) step(event.code === "ArrowLeft" || event.code === "ArrowDown" ? -1 : 1);
  };
  const step = (by) => {
    if (playing.on) toggle();
    playing.frame = Math.max(0, Math.min(facts.frames - 1, Math.round(playing.frame) + by));
  };
  seek.max = facts.frames - 1;
  seek.oninput = () => { playing.frame = Number(seek.value); };
  element("view").onchange = (event) => { choose(event.target.value); frameVessel(); };
  element("colour").onchange = legend;
  element("machine").onchange = frameVessel;
  scene.onpointerdown = (event) => scene.setPointerCapture(event.pointerId);
  scene.onpointermove = (event) => {
    if (!event.buttons) return;
    camera.azimuth -= 0.008 * event.movementX;
    camera.height = Math.max(-1.57, Math.min(1.57, camera.height + 0.008 * event.movementY));
  };
  scene.addEventListener("wheel", (event) => { event.preventDefault(); camera.distance *= Math.exp(0.001 * event.deltaY); }, { passive: false });
  const jump = (event) => {
    if (!event.buttons) return;
    const share = (event.offsetX - margin.left) / (plot.clientWidth - margin.left - margin.right);
    const [first, last] = runTimes();
    playing.frame = frameAt(first + share * (last - first));
  };
  plot.onpointerdown = jump;
  plot.onpointermove = jump;
}

async function begin() {
  const gl = element("scene").getContext("webgl2", { alpha: false, antialias: true, preserveDrawingBuffer: true });
  if (!gl) fail("This browser has no WebGL 2, or it is switched off. Switch on hardware acceleration, or use another browser.");
  const made = buffers(gl, await unpacked()), sphere = program(gl, SPHERE), mesh = program(gl, MESH);
  gl.enable(gl.DEPTH_TEST);
  gl.blendFunc(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA);
  for (const option of [...element("view").options]) if (!(option.text in facts.views)) option.remove();
  const missing = { force: !facts.force, material: !facts.materials.length };
  for (const option of [...element("colour").options]) if (missing[option.value]) option.remove();
  choose("front");
  legend();
  listen();
  const step = (stamp) => {
    if (playing.on && playing.stamp && facts.frames > 1) {
      const time = timeAt(playing.frame) + (stamp - playing.stamp) / 1000 / Number(element("slow").value);
      playing.frame = time < facts.times[facts.frames - 1] ? frameAt(time) : 0;
    }
    playing.stamp = stamp;
    element("seek").value = playing.frame;
    element("time").textContent = "t = " + timeAt(playing.frame).toFixed(4) + " s";
    draw(gl, sphere, mesh, made);
    drawTraces();
    document.body.dataset.drawn = gl.getError() ? "fault" : "yes";
    requestAnimationFrame(step);
  };
  requestAnimationFrame(step);
}
begin().catch((fault) => { element("trouble").style.display = "block"; element("trouble").textContent = fault.message; throw fault; });
