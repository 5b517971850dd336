"use strict";
// Draws series over time on a canvas, one panel below another, in the colours of the page.
function colourOf(name) {
  return getComputedStyle(document.documentElement).getPropertyValue(name).trim();
}

const LINES = ["--blue", "--orange", "--green", "--fitted", "--red", "--assumed"];

function ticksBetween(low, high, count) {
  const rough = (high - low) / count, power = 10 ** Math.floor(Math.log10(rough)), step = power * [1, 2, 5, 10].find((k) => k * power >= rough);
  const all = [];
  for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; k++) all.push(Number((k * step).toPrecision(6)));
  return all;
}

// panels: [{label, lines: [{time, values, colour}]}], all over the same time.
function drawChart(canvas, panels, end) {
  const ratio = window.devicePixelRatio || 1, width = canvas.clientWidth, height = canvas.clientHeight, pen = canvas.getContext("2d");
  Object.assign(canvas, { width: Math.round(width * ratio), height: Math.round(height * ratio) });
  pen.scale(ratio, ratio);
  pen.font = "12px system-ui, sans-serif";
  const known = panels.flatMap((panel) => panel.lines).filter((line) => line.time.length);
  const margin = { left: 58, right: 12, top: 22, gap: 40 }, last = end || Math.max(1e-9, ...known.map((line) => line.time[line.time.length - 1]));
  const first = end ? 0 : Math.min(0, ...known.map((line) => line.time[0]));
  const tall = (height - 20 - panels.length * margin.gap) / panels.length;
  const across = (time) => margin.left + ((time - first) / (last - first)) * (width - margin.left - margin.right);
  panels.forEach((panel, number) => {
    const top = margin.top + number * (tall + margin.gap);
    let least = Infinity, most = -Infinity;
    for (const line of panel.lines) for (const value of line.values) if (value !== null) { least = Math.min(least, value); most = Math.max(most, value); }
    if (least > most) [least, most] = [0, 1];
    const spare = 0.05 * (most - least) || 1e-3 * Math.abs(most) || 1, low = least - spare, high = most + spare;
    const down = (value) => top + tall * (1 - (value - low) / (high - low));
    pen.fillStyle = colourOf("--ink");
    pen.textAlign = "left";
    pen.fillText(panel.label, margin.left, top - 7);
    pen.strokeStyle = colourOf("--line");
    pen.fillStyle = colourOf("--soft");
    pen.lineWidth = 1;
    pen.textAlign = "right";
    for (const value of ticksBetween(low, high, 4)) {
      pen.beginPath(); pen.moveTo(margin.left, down(value)); pen.lineTo(width - margin.right, down(value)); pen.stroke();
      pen.fillText(String(value), margin.left - 6, down(value) + 4);
    }
    pen.textAlign = "center";
    for (const value of ticksBetween(first, last, 6)) pen.fillText(String(value), across(value), top + tall + 15);
    if (number === panels.length - 1) pen.fillText("time (s)", (margin.left + width - margin.right) / 2, top + tall + 30);
    pen.lineWidth = 1.2;
    for (const line of panel.lines) {
      pen.strokeStyle = line.colour;
      pen.beginPath();
      line.time.forEach((time, k) => { if (line.values[k] !== null) pen[k ? "lineTo" : "moveTo"](across(time), down(line.values[k])); });
      pen.stroke();
    }
  });
}
