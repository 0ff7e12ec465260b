"""Style and script of the page of a sweep."""

STYLE = """
body{font:15px/1.45 system-ui,sans-serif;color:#222;margin:0}main{max-width:1100px;margin:0 auto;padding:1em}
h1{font-size:1.3em}h2{font-size:1.05em;margin-top:1.6em}.figures{display:flex;flex-wrap:wrap;gap:1em}
figure{margin:0;flex:1 1 420px;max-width:560px}figure svg{width:100%;height:auto}
.both{display:flex;flex-wrap:wrap;gap:1em}#plot{flex:2 1 420px;align-self:flex-start;border:1px solid #ddd}
#one{flex:1 1 260px}
#plot text{font-size:12px;fill:#333}circle{fill:#0072b2;cursor:pointer}circle.lost{fill:#d55e00}
circle.chosen{stroke:#000;stroke-width:2.5}.wide{overflow-x:auto}table{border-collapse:collapse;font-size:13px}
th{cursor:pointer;text-align:left;border-bottom:1px solid #999;white-space:nowrap}td,th{padding:.15em .6em}
td{white-space:nowrap;max-width:32em;overflow:hidden;text-overflow:ellipsis}
td.number{text-align:right;font-variant-numeric:tabular-nums}tr.lost td{color:#9a4300}tr.chosen td{background:#eef4fa}
tbody tr{cursor:pointer}code{background:#f3f3f3;padding:.2em .4em;display:block;overflow-x:auto;user-select:all}
dt{font-weight:600}dd{margin:0 0 .3em}
"""

SCRIPT = """
"use strict";
const data = JSON.parse(document.getElementById("data").textContent);
const ending = data.columns.indexOf("ending"), plot = document.getElementById("plot");
const numberOf = v => typeof v === "number" ? v : (/^\\s*[-+]?[0-9.]/.test(v ?? "") ? parseFloat(v) : null);
const shown = v => v === null || v === "" ? "-" : typeof v === "number" ? String(+v.toPrecision(6))
  : typeof v === "object" ? JSON.stringify(v) : v;
let chosen = data.best, order = data.rows.map((_, i) => i), sorted = null, rising = true;
function element(name, attributes, text) {
  const made = document.createElementNS("http://www.w3.org/2000/svg", name);
  for (const key in attributes) made.setAttribute(key, attributes[key]);
  if (text !== undefined) made.textContent = text;
  return made;
}
function places(column) {
  const values = data.rows.map(row => row[column]);
  const numbers = values.map(numberOf);
  if (values.every((v, i) => v === null || numbers[i] !== null)) return {at: numbers, words: null};
  const words = [...new Set(values.map(shown))];
  return {at: values.map(v => words.indexOf(shown(v))), words};
}
function draw() {
  const across = places(+document.getElementById("across").value), up = places(+document.getElementById("up").value);
  plot.replaceChildren();
  const scale = (list, from, to) => {
    const known = list.filter(v => v !== null), least = Math.min(...known), most = Math.max(...known);
    return {of: v => most > least ? from + (v - least) / (most - least) * (to - from) : (from + to) / 2, least, most};
  };
  const x = scale(across.at, 70, 620), y = scale(up.at, 350, 20);
  const tick = (axis, s, value) => axis.words ? axis.words[Math.round(value)] ?? "" : shown(value);
  for (let i = 0; i <= 4; i++) {
    const u = x.least + (x.most - x.least) * i / 4, v = y.least + (y.most - y.least) * i / 4;
    plot.append(element("text", {x: x.of(u), y: 370, "text-anchor": "middle"}, tick(across, x, u)));
    plot.append(element("text", {x: 64, y: y.of(v) + 4, "text-anchor": "end"}, tick(up, y, v)));
    plot.append(element("line", {x1: 70, x2: 620, y1: y.of(v), y2: y.of(v), stroke: "#e3e3e3"}));
  }
  data.rows.forEach((row, i) => {
    if (across.at[i] === null) return;
    const lost = row[ending] !== "planned", high = up.at[i] === null ? 390 : y.of(up.at[i]);
    const look = (lost ? "lost " : "") + (i === chosen ? "chosen" : "");
    const point = element("circle", {cx: x.of(across.at[i]), cy: high, r: 5, class: look, "data-i": i});
    point.append(element("title", {}, data.columns.slice(0, 6).map((c, k) => c + ": " + shown(row[k])).join("\\n")));
    point.addEventListener("click", () => choose(i));
    plot.append(point);
  });
}
function mark(i) {
  for (const found of document.querySelectorAll(".chosen")) found.classList.remove("chosen");
  for (const found of document.querySelectorAll(`[data-i="${i}"]`)) found.classList.add("chosen");
}
function choose(i) {
  chosen = i; mark(i);
  const one = document.getElementById("one");
  one.replaceChildren();
  if (i !== null) {
    const list = document.createElement("dl");
    data.columns.forEach((name, k) => {
      if (data.rows[i][k] === null || data.rows[i][k] === "") return;
      const term = document.createElement("dt"), text = document.createElement("dd");
      term.textContent = name; text.textContent = shown(data.rows[i][k]); list.append(term, text);
    });
    if (data.open[i].link) {
      const link = document.createElement("a");
      link.href = data.open[i].link; link.textContent = "open the plan folder"; one.append(link);
    }
    const command = document.createElement("code");
    command.textContent = data.open[i].command;
    one.append(command, list);
  }
}
const AT_ONCE = 60;
let later = 0;
function table() {
  const place = document.getElementById("table");
  const head = document.createElement("thead"), top = document.createElement("tr");
  data.columns.forEach((name, k) => {
    const cell = document.createElement("th");
    cell.textContent = name + (sorted === k ? (rising ? " ↑" : " ↓") : "");
    cell.addEventListener("click", () => {
      rising = sorted === k ? !rising : true; sorted = k;
      const at = places(k).at;
      order.sort((a, b) => ((at[a] ?? Infinity) - (at[b] ?? Infinity)) * (rising ? 1 : -1)); table();
    });
    top.append(cell);
  });
  head.append(top);
  const body = document.createElement("tbody");
  place.replaceChildren(head, body);
  clearTimeout(later);
  rows(body, 0);
}
function rows(body, first) {
  // so many at a time, so that the page is there before its last row
  for (const i of order.slice(first, first + AT_ONCE)) {
    const row = document.createElement("tr");
    row.dataset.i = i;
    row.className = (data.rows[i][ending] !== "planned" ? "lost " : "") + (i === chosen ? "chosen" : "");
    for (const value of data.rows[i]) {
      const cell = document.createElement("td");
      cell.textContent = cell.title = shown(value);
      if (typeof value === "number") cell.className = "number";
      row.append(cell);
    }
    row.addEventListener("click", () => choose(i));
    body.append(row);
  }
  if (first + AT_ONCE < order.length) later = setTimeout(() => rows(body, first + AT_ONCE));
}
for (const [name, chosenColumn] of [["across", data.axes[0]], ["up", data.goal]]) {
  const select = document.getElementById(name);
  data.columns.forEach((column, k) => {
    const option = document.createElement("option");
    option.value = k; option.textContent = column; option.selected = column === chosenColumn; select.append(option);
  });
  select.addEventListener("change", draw);
}
if (data.rows.length) { draw(); table(); choose(chosen); }
"""
