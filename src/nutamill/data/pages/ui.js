"use strict";
// The page of `nutamill ui`: shows what the server answers and sends what is typed; it computes nothing.
const element = (id) => document.getElementById(id);
const state = { name: "", entries: [], changes: {}, demonstration: false, asked: 0, runs: [], traces: {}, compared: null };
const PAUSE = 350, LOOK = 1000;
const FRONT = ["drive", "drives", "linear_drives", "unbalance_motors", "charge", "run"];

function made(tag, properties = {}, ...inside) {
  const one = Object.assign(document.createElement(tag), properties);
  one.append(...inside);
  return one;
}

async function ask(name, body) {
  const how = body === undefined ? {} : { method: "POST", headers: { "Content-Type": "application/json" }, body: JSON.stringify(body) };
  let reply, content;
  try {
    reply = await fetch(name, how);
    content = await reply.json();
  } catch {
    throw new Error("The page does not answer any more: its terminal was closed. Start nutamill ui again.");
  }
  if (!reply.ok) throw new Error(content.error);
  return content;
}

function trouble(error) {
  element("trouble").hidden = !error;
  element("trouble").textContent = error ? error.message : "";
}
const trying = (work) => async (...words) => {
  try {
    trouble();
    await work(...words);
  } catch (error) {
    trouble(error);
  }
};

// Tabs
function choose(tab) {
  for (const name of ["case", "runs", "results"]) {
    element(name).hidden = name !== tab;
    element("tab-" + name).setAttribute("aria-selected", String(name === tab));
  }
  if (tab === "results") showResults();
  if (tab === "runs") drawCards();
}

// The form
const asked = () => ({ case: state.name, changes: state.changes, quick: element("quick").checked && state.demonstration });
const markOf = (entry) => (entry.key in state.changes ? "changed" : entry.mark.split(" ")[0]);

function control(entry) {
  const held = state.changes[entry.key] ?? entry.value;
  const input = entry.choices.length
    ? made("select", {}, ...(entry.choices.includes(held) ? [] : [made("option", { value: held, textContent: held })]), ...entry.choices.map((choice) => made("option", { value: choice, textContent: choice })))
    : made("input", { type: "text", spellcheck: false, autocomplete: "off", placeholder: entry.value ? "" : "not set" });
  input.value = held;
  input.name = entry.key;
  input.setAttribute("aria-label", entry.key);
  input.oninput = () => changed(entry.key, input.value.trim());
  return input;
}

function row(entry) {
  const takes = entry.units.length ? `${entry.takes} in ${entry.units.join(", ")}` : entry.choices.length ? "" : entry.takes;
  const meaning = made("div", { textContent: entry.meaning || entry.key.split(".").pop().replaceAll("_", " ") });
  const more = made("div", { className: "more" }, made("div", { className: "fault" }), [takes, entry.note].filter(Boolean).join(" · "));
  const mark = markOf(entry);
  const line = made("div", { className: "row" }, made("div", { className: "label" }, meaning, made("div", { className: "key", textContent: entry.key })), control(entry), made("div", {}, made("span", { className: "mark " + mark, textContent: mark, hidden: !mark, title: entry.note })), more);
  line.dataset.key = entry.key;
  line.dataset.text = `${entry.key} ${entry.meaning} ${entry.note}`.toLowerCase();
  line.classList.toggle("changed-row", entry.key in state.changes);
  return line;
}

function showForm() {
  const groups = new Map(), opened = new Set([...document.querySelectorAll("#tables > details[open]")].map((one) => one.dataset.table));
  for (const table of FRONT) groups.set(table, []);
  for (const entry of state.entries) {
    const table = entry.key.includes(".") ? entry.key.split(".")[0] : "case";
    groups.set(table, [...(groups.get(table) || []), entry]);
  }
  element("tables").replaceChildren(...[...groups].filter(([, entries]) => entries.length).map(([table, entries]) => {
    const given = entries.filter((entry) => entry.value || entry.key in state.changes), left = entries.filter((entry) => !given.includes(entry));
    const group = made("details", { open: opened.size ? opened.has(table) : FRONT.slice(0, -1).includes(table) }, made("summary", { textContent: table.replaceAll("_", " ") }), ...given.map(row));
    group.dataset.table = table;
    if (left.length) group.append(made("details", {}, made("summary", { textContent: `${left.length} more, not set` }), ...left.map(row)));
    return group;
  }));
  find();
}

function find() {
  const words = element("find").value.toLowerCase().split(/\s+/).filter(Boolean);
  for (const line of document.querySelectorAll(".row")) line.hidden = !words.every((word) => line.dataset.text.includes(word));
  for (const group of document.querySelectorAll("#tables details")) {
    const some = [...group.querySelectorAll(".row")].some((line) => !line.hidden);
    group.hidden = !some;
    if (words.length && some) group.open = true;
  }
}

let waiting;
function changed(key, text) {
  const entry = state.entries.find((one) => one.key === key), before = state.given.get(key) ?? "";
  if (text === before || (text === "" && entry)) delete state.changes[key];
  else state.changes[key] = text;
  const line = document.querySelector(`.row[data-key="${CSS.escape(key)}"]`), mark = line.querySelector(".mark"), name = markOf(entry);
  line.classList.toggle("changed-row", key in state.changes);
  Object.assign(mark, { className: "mark " + name, textContent: name, hidden: !name });
  clearTimeout(waiting);
  waiting = setTimeout(trying(check), PAUSE);
  showChanges();
}

function showChanges() {
  const count = Object.keys(state.changes).length;
  element("changes").textContent = Object.entries(state.changes).map(([key, value]) => `${key} = ${value}`).join(" · ");
  element("undo").disabled = !count;
}

// What is wrong at once, then the sheet, which takes some seconds.
async function check() {
  const number = ++state.asked, sheet = await ask("case", asked());
  if (number !== state.asked) return;
  const bad = sheet.faults.length, odd = sheet.warnings.length;
  element("title").textContent = sheet.title || state.name;
  element("verdict").className = bad ? "bad" : odd ? "odd" : "good";
  element("verdict").textContent = bad ? `${bad} fault${bad > 1 ? "s" : ""}: it cannot be run` : odd ? `can be run, ${odd} warning${odd > 1 ? "s" : ""}` : "can be run, no warnings";
  element("faults").replaceChildren(...sheet.faults.map((text) => made("li", { className: "fault", textContent: text })), ...sheet.warnings.map((text) => made("li", { className: "warning", textContent: text })));
  for (const line of document.querySelectorAll(".row")) {
    const own = sheet.faults.find((text) => text.startsWith(line.dataset.key + ":"));
    line.classList.toggle("wrong", Boolean(own));
    line.querySelector(".fault").textContent = own ? own.slice(line.dataset.key.length + 2) : "";
  }
  element("run").disabled = bad > 0;
  element("sheet").classList.add("old");
  element("checking").hidden = bad > 0;
  if (bad) return;
  state.demonstration = sheet.demonstration;
  element("demonstration").hidden = !state.demonstration;
  try {
    const { lines } = await ask("check", asked());
    if (number === state.asked) showSheet(lines);
  } finally {
    if (number === state.asked) element("checking").hidden = true;
  }
}

function showSheet(lines) {
  const shown = [];
  for (const line of lines.slice(1).filter((text) => !text.startsWith("  warning:"))) {
    const label = line.slice(0, 10).trim(), text = line.slice(10);
    const last = shown[shown.length - 1];
    if (/\S {2,}\S/.test(text) && last && last.tagName === "PRE") last.textContent += "\n" + text;
    else if (/\S {2,}\S/.test(text)) shown.push(made("pre", { className: "whole", textContent: text }));
    else shown.push(made("dt", { textContent: label }), made("dd", { textContent: text.trim() }));
  }
  element("sheet").replaceChildren(...shown);
  element("sheet").classList.remove("old");
}

async function take(name) {
  Object.assign(state, { name, changes: {} });
  const sheet = await ask("case", { case: name, changes: {} });
  Object.assign(state, { entries: sheet.entries, given: new Map(sheet.entries.map((entry) => [entry.key, entry.value])), demonstration: sheet.demonstration });
  element("tables").replaceChildren();
  element("sheet").replaceChildren();
  showForm();
  showChanges();
  await check();
}

async function start() {
  const { number } = await ask("run", asked());
  choose("runs");
  await look();
  document.querySelector(`[data-run="${number}"]`).scrollIntoView({ block: "nearest" });
}

async function save(event) {
  event.preventDefault();
  const name = element("name").value.trim(), { file } = await ask("save", { ...asked(), file: name.endsWith(".toml") ? name : name + ".toml" });
  await showCases();
  element("machine").value = file;
  element("name").value = "";
  await take(file);
}

async function showCases() {
  const { version, folder, cases, first } = await ask("start");
  element("version").textContent = version;
  element("folder").textContent = folder;
  const options = (some) => some.map((one) => made("option", { value: one.name, textContent: one.name, title: one.title }));
  const own = cases.filter((one) => !one.title), shipped = cases.filter((one) => one.title);
  element("machine").replaceChildren(...(own.length ? [made("optgroup", { label: "in this folder" }, ...options(own))] : []), made("optgroup", { label: "of the package" }, ...options(shipped)));
  return first;
}

// Runs
const GOING = ["running", "stopping"];
const number = (value, digits) => (value === undefined || value === null ? "–" : value.toFixed(digits));

function duration(seconds) {
  if (seconds === undefined) return "–";
  const s = Math.round(seconds);
  return s < 60 ? `${s} s` : s < 3600 ? `${Math.floor(s / 60)} min ${s % 60} s` : `${Math.floor(s / 3600)} h ${Math.floor((s % 3600) / 60)} min`;
}

function card(run) {
  const one = made("article", { className: "card" }, made("h2", {}, made("span", { textContent: run.title }), made("span", { className: "state" })), made("progress", { max: 1 }), made("div", { className: "readings" }), made("canvas", { className: "chart" }), made("pre", { className: "lines" }), made("div", { className: "bar" }));
  one.dataset.run = run.number;
  return one;
}

function fillCard(one, run) {
  const going = GOING.includes(run.state), now = run.progress, find = (name) => one.querySelector(name);
  Object.assign(find(".state"), { textContent: run.state, className: "state " + run.state.split(",")[0] });
  const settling = now.phase === "settle", share = now.end_time ? now.time / now.end_time : 0;
  Object.assign(find("progress"), { value: settling ? now.fraction || 0 : share, hidden: !going });
  const spread = (mean, width, digits) => (mean === undefined ? "" : `, mean ${number(mean, digits)}${width === undefined ? "" : " ± " + number(width, digits)}`);
  const texts = !now.phase ? [["", going ? "starting; the first start of a version compiles kernels, which takes minutes" : ""]]
    : settling ? [["charge comes to rest", `${number(100 * now.fraction, 0)} %`], ["left", duration(now.time_left)]]
    : [["t", `${number(now.time, 3)} of ${number(now.end_time, 2)} s`], ["left", duration(now.time_left)],
      ...(now.crank_pin_force === undefined ? [] : [["crank-pin force", `${number(now.crank_pin_force, 0)} N${spread(now.mean_force, now.mean_force_half_width, 1)}`], ["shaft torque", `${number(now.shaft_torque, 2)} N m${spread(now.mean_torque, now.mean_torque_half_width, 2)}`]]),
      ...(now.ledger_residual === undefined ? [] : [["not accounted for", `${number(100 * now.ledger_residual, 3)} %`]])];
  find(".readings").replaceChildren(...texts.map(([label, text]) => made("span", {}, label + " ", made("b", { textContent: text }))));
  Object.assign(find(".lines"), { textContent: run.lines.join("\n"), hidden: !run.lines.length });
  const buttons = going ? [made("button", { textContent: "Stop and save", disabled: run.state === "stopping", onclick: trying(() => ask("stop", { number: run.number }).then(look)) })] : links(run.file);
  const kind = going + run.state;
  if (one.dataset.kind !== kind) find(".bar").replaceChildren(...buttons);
  one.dataset.kind = kind;
}

const links = (file) => ["view", "report"].map((kind) => made("a", { href: `page?kind=${kind}&file=${encodeURIComponent(file)}`, target: "_blank", rel: "noopener", textContent: kind }));

function drawCards() {
  if (element("runs").hidden) return;
  for (const run of state.runs) {
    const traces = state.traces[run.file], canvas = document.querySelector(`[data-run="${run.number}"] canvas`), recorded = traces && traces.time.length;
    const after = recorded ? traces.time[traces.time.length - 1] : -1, late = run.points.filter(([time]) => time > after);
    const panels = recorded ? traces.traces.map((trace, k) => ({ label: trace.label, lines: [{ time: traces.time, values: trace.values, colour: colourOf(LINES[k]) }] })) : [];
    if (!panels.length && run.points.length) panels.push(...["crank-pin force (N)", "shaft torque (N m)"].map((label) => ({ label, lines: [] })));
    const named = !recorded || traces.traces[0].name === "crank_pin_force_resultant";
    if (late.length && named) panels.forEach((panel, k) => panel.lines.push({ time: late.map((one) => one[0]), values: late.map((one) => one[1 + k]), colour: colourOf(LINES[k]) }));
    canvas.hidden = !panels.length;
    if (panels.length) drawChart(canvas, panels, GOING.includes(run.state) ? run.progress.end_time : 0);
  }
}

async function look() {
  state.runs = await ask("runs");
  const cards = element("cards"), going = state.runs.filter((run) => GOING.includes(run.state)).length;
  element("none").hidden = state.runs.length > 0;
  Object.assign(element("going"), { textContent: going, hidden: !going });
  for (const run of [...state.runs].reverse()) {
    let one = cards.querySelector(`[data-run="${run.number}"]`);
    if (!one) cards.prepend((one = card(run)));
    fillCard(one, run);
    await lookAtTraces(run);
  }
  drawCards();
  return going;
}

// The file of a run grows every few seconds; its traces are read as often, and once more at its end.
async function lookAtTraces(run) {
  const last = state.traces[run.file], key = GOING.includes(run.state) ? Math.floor(Date.now() / 5000) : run.state;
  if ((GOING.includes(run.state) && !run.progress.phase) || run.progress.phase === "settle" || (last && last.key === key)) return;
  try {
    state.traces[run.file] = { ...(await ask("traces?file=" + encodeURIComponent(run.file))), key };
  } catch {
    state.traces[run.file] = { ...(last || { time: [], traces: [] }), key };
  }
}

async function watch() {
  try {
    await look();
  } catch (error) {
    trouble(error);
  }
  setTimeout(watch, LOOK);
}

// Results
const marked = () => [...document.querySelectorAll("#files input:checked")].map((box) => box.value);

async function showResults() {
  try {
    const before = new Set(marked()), files = await ask("results");
    document.querySelector("#files tbody").replaceChildren(...files.map((one) => made("tr", {},
      made("td", {}, made("input", { type: "checkbox", value: one.file, checked: before.has(one.file), onchange: mark, ariaLabel: "compare " + one.file })),
      made("td", {}, made("span", { className: "file", textContent: one.file })), made("td", { textContent: one.title }), made("td", { textContent: one.state }),
      made("td", { className: "number", textContent: one.end.toFixed(3) }), made("td", { className: "open" }, ...links(one.file).flatMap((link) => [link, " "])))));
    mark();
  } catch (error) {
    trouble(error);
  }
}
const mark = () => { const count = marked().length; Object.assign(element("compare"), { disabled: !count, textContent: count > 1 ? `Compare ${count}` : "Show" }); };

async function compare() {
  const files = marked(), answer = await ask("compare", { files });
  const line = (label, cells, kind = "") => made("tr", { className: kind }, made("td", { textContent: label }), ...cells.map((cell) => made("td", { className: kind === "differs" || !label ? "" : "number", textContent: cell })));
  const head = made("tr", {}, made("th"), ...files.map((file) => made("th", { className: "number", textContent: file.split("/").pop().replace(/\.h5$/, "") })));
  const verdicts = line("steadiness", answer.verdicts);
  const warnings = answer.warnings.some((some) => some.length) ? [line("warnings", answer.warnings.map((some) => some.join("; ").replaceAll("warning: ", "")))] : [];
  element("means").replaceChildren(head, ...answer.means.map((one) => line(one.label, one.values)), verdicts, ...warnings, ...answer.differences.map((one) => line(one.label, one.values, "differs")));
  const all = await Promise.all(files.map((file) => ask("traces?file=" + encodeURIComponent(file))));
  const known = all[0].known.filter((name) => all.every((one) => one.known.includes(name))), before = element("series").value;
  element("series").replaceChildren(...known.map((name) => made("option", { textContent: name, value: name })));
  element("series").value = known.includes(before) ? before : (all[0].traces[0] || { name: known[0] }).name;
  state.compared = files;
  element("comparison").hidden = false;
  await overlay();
  element("comparison").scrollIntoView({ block: "nearest" });
}

async function overlay() {
  if (!state.compared) return;
  const name = element("series").value, all = await Promise.all(state.compared.map((file) => ask(`traces?file=${encodeURIComponent(file)}&series=${name}`)));
  const lines = all.map((one, k) => ({ time: one.time, values: one.traces[0].values, colour: colourOf(LINES[k % LINES.length]) }));
  drawChart(element("overlay"), [{ label: all[0].traces[0].label, lines }]);
  element("key").replaceChildren(...state.compared.map((file, k) => {
    const colour = made("i");
    colour.style.background = lines[k].colour;
    return made("span", {}, colour, file.split("/").pop().replace(/\.h5$/, ""));
  }));
}

async function begin() {
  for (const name of ["case", "runs", "results"]) element("tab-" + name).onclick = () => choose(name);
  element("machine").onchange = trying((event) => take(event.target.value));
  element("find").oninput = find;
  element("quick").onchange = trying(check);
  element("undo").onclick = trying(() => take(state.name));
  element("run").onclick = trying(start);
  element("save").onsubmit = trying(save);
  element("compare").onclick = trying(compare);
  element("reload").onclick = showResults;
  element("series").onchange = trying(overlay);
  window.onresize = () => { drawCards(); overlay().catch(trouble); };
  element("machine").value = await showCases();
  await take(element("machine").value);
}

trying(begin)();
watch();
