"use strict";
// Draws the page from the JSON in it. Every plot that is drawn sets data-drawn on its element.

const data = JSON.parse(document.getElementById("data").textContent);
const runs = data.runs;
const colours = ["#0b6bcb", "#d9730d", "#2e7d32", "#7b3fa0", "#8a6d00", "#c2185b"];
const layout = (x, y, more) => Object.assign({
  margin: { l: 64, r: 12, t: 8, b: 46 },
  xaxis: { title: { text: x }, zeroline: false },
  yaxis: { title: { text: y }, zeroline: false },
  legend: { orientation: "h", y: 1.12 },
  paper_bgcolor: "rgba(0,0,0,0)",
}, more);
const config = { responsive: true, displaylogo: false, displayModeBar: false };
const element = (id) => document.getElementById(id);

function draw(id, traces, look) {
  return Plotly.react(id, traces, look, config).then(() => { element(id).dataset.drawn = String(traces.length); });
}

function options(id, names) {
  const select = element(id);
  select.replaceChildren(...names.map((name, k) => new Option(name, k)));
  return select;
}

const precise = (x) => Number(x).toPrecision(4).replace(/\.?0+(e|$)/, "$1");

function summary() {
  element("title").textContent = runs[0].summary.title;
  const failed = runs.filter((run) => !run.summary.converged);
  for (const run of failed) {
    const line = document.createElement("div");
    line.className = "bad";
    line.textContent = `${run.label} ended early: ${run.summary.reason}`;
    element("state").append(line);
  }
  const rows = [
    ["", (run) => run.label],
    ["converged", (run) => (run.summary.converged ? "yes" : "no")],
    ["time reached", (run) => precise(run.summary.time)],
    ["increments", (run) => run.summary.increments],
    ["cut-backs", (run) => run.summary.cutbacks],
    ["Newton iterations", (run) => run.summary.newton_iterations],
    ["largest penetration", (run) => precise(run.summary.max_penetration_ever)],
    ["contact force at the end", (run) => run.summary.contact_force.map(precise).join(", ")],
    ["wall time, s", (run) => precise(run.summary.wall_s)],
    ["share of contact evaluation", (run) => `${(100 * run.summary.contact_share).toFixed(1)} %`],
    ["share of pairing", (run) => `${(100 * run.summary.pairing_share).toFixed(1)} %`],
    ["nodes, elements", (run) => run.summary.size.join(", ")],
  ];
  element("summary").replaceChildren(...rows.map(([name, value], k) => {
    const row = document.createElement("tr");
    const cell = (text) => {
      const made = document.createElement(k === 0 ? "th" : "td");
      made.textContent = text;
      return made;
    };
    row.append(cell(name), ...runs.map((run) => cell(value(run))));
    return row;
  }));
}

// Names of supports that move or carry force, the most moved first.
function supports() {
  const history = runs[0].history;
  const names = Object.keys(history).filter((key) => key.startsWith("reaction_x:")).map((key) => key.slice(11));
  const largest = (name, what) => Math.max(...["x", "y", "z"].flatMap((axis) => history[`${what}_${axis}:${name}`].map(Math.abs)), 0);
  return names.sort((a, b) => largest(b, "displacement") - largest(a, "displacement") || largest(b, "reaction") - largest(a, "reaction"));
}

function force() {
  const name = supportNames[element("support").value];
  const axis = "xyz"[element("axis").value];
  const moved = (run) => run.history[`displacement_${axis}:${name}`] || [];
  const moves = runs.some((run) => moved(run).some((x) => x !== 0));
  const traces = runs.map((run, k) => ({
    x: moves ? moved(run) : run.history.time, y: run.history[`reaction_${axis}:${name}`] || [],
    name: run.label, mode: "lines+markers", marker: { size: 5 }, line: { color: colours[k % colours.length], dash: k ? "dash" : "solid" },
  }));
  return draw("force", traces, layout(moves ? `displacement ${axis}` : "time", `reaction ${axis}`));
}

function iterations() {
  element("totals").textContent = runs.map((run) => `${run.label}: ${run.history.iterations.reduce((a, b) => a + b, 0)} in all`).join(" · ");
  const traces = runs.map((run, k) => ({
    x: run.history.time, y: run.history.iterations, name: run.label, mode: "lines+markers",
    line: { shape: "hvh", color: colours[k % colours.length] }, marker: { size: 5 },
  }));
  return draw("iterations", traces, layout("time", "iterations", { yaxis: { title: { text: "iterations" }, rangemode: "tozero" } }));
}

function convergence() {
  const number = element("increment").value;
  element("increment-label").textContent = number;
  const traces = runs.map((run, k) => {
    // The first residual is that before the prescribed nodes move.
    const residuals = (run.residuals[number] || []).slice(1);
    return { x: residuals.map((_, i) => i + 1), y: residuals.map((r) => (r > 0 ? r : null)), name: run.label, mode: "lines+markers", line: { color: colours[k % colours.length] } };
  });
  const axes = { yaxis: { title: { text: "residual over forces" }, type: "log", exponentformat: "power" }, xaxis: { title: { text: "linear solutions" }, dtick: 1 } };
  return draw("convergence", traces, layout("", "", axes));
}

// Faces as triangles, and their edges as one line with gaps.
function triangles(faces) {
  const [i, j, k] = [[], [], []];
  for (const face of faces) {
    for (let corner = 2; corner < face.length; corner += 1) {
      i.push(face[0]); j.push(face[corner - 1]); k.push(face[corner]);
    }
  }
  return { i, j, k };
}

function outline(faces, points) {
  const [x, y, z] = [[], [], []];
  for (const face of faces) {
    for (const corner of [...face, face[0]]) {
      x.push(points[corner][0]); y.push(points[corner][1]); z.push(points[corner][2]);
    }
    x.push(null); y.push(null); z.push(null);
  }
  return { x, y, z };
}

// A scene that holds all points, seen along its shortest side, y up unless that is the side.
function scene(points, revision) {
  const bounds = [0, 1, 2].map((axis) => {
    let [low, high] = [Infinity, -Infinity];
    for (const p of points) { low = Math.min(low, p[axis]); high = Math.max(high, p[axis]); }
    return [low, high];
  });
  const sides = bounds.map(([low, high]) => high - low);
  const largest = Math.max(...sides, 1e-300);
  const margin = 0.03 * largest;
  const depth = sides.indexOf(Math.min(...sides));
  const up = depth === 1 ? 2 : 1;
  const right = 3 - depth - up;
  const along = (weights) => Object.fromEntries(["x", "y", "z"].map((name, axis) => [name, weights[axis]]));
  const direction = [0, 0, 0];
  direction[depth] = 1.15; direction[up] = 0.45; direction[right] = 0.55;
  const axis = (k) => ({ title: { text: "xyz"[k] }, range: [bounds[k][0] - margin, bounds[k][1] + margin], autorange: false });
  return {
    margin: { l: 0, r: 0, t: 0, b: 0 }, uirevision: revision, paper_bgcolor: "rgba(0,0,0,0)", showlegend: false,
    scene: {
      uirevision: revision, aspectmode: "manual", aspectratio: along(sides.map((side) => (1.8 * (side + 2 * margin)) / largest)),
      camera: { eye: along(direction), up: along([0, 1, 2].map((k) => Number(k === up))), projection: { type: "orthographic" } },
      xaxis: axis(0), yaxis: axis(1), zaxis: axis(2),
    },
  };
}

function shape() {
  const run = runs[element("run").value];
  const frames = run.frames;
  element("frame").max = frames.length - 1;
  const frame = frames[Math.min(element("frame").value, frames.length - 1)];
  element("frame-label").textContent = precise(frame.time);
  const field = fieldNames[element("field").value];
  const points = frame.positions;
  const rigid = run.skin.names.length - 1;
  const solid = run.skin.faces.filter((_, k) => run.skin.bodies[k] !== rigid);
  const stiff = run.skin.faces.filter((_, k) => run.skin.bodies[k] === rigid);
  const values = frame.fields[field];
  const range = run.frames.map((each) => each.fields[field]);
  const low = Math.min(0, ...range.map((each) => Math.min(...each)));
  const high = Math.max(...range.map((each) => Math.max(...each)));
  const common = { x: points.map((p) => p[0]), y: points.map((p) => p[1]), z: points.map((p) => p[2]), type: "mesh3d", hoverinfo: "text", flatshading: true, lighting: { ambient: 0.75, diffuse: 0.5, specular: 0.05 } };
  const traces = [Object.assign({}, common, triangles(solid), {
    intensity: values, cmin: low, cmax: high > low ? high : low + 1, colorscale: "Viridis", colorbar: { title: { text: field }, thickness: 14 },
    text: values.map((value, k) => `node ${run.skin.nodes[k]}<br>${field} ${precise(value)}`),
  })];
  if (stiff.length > 0) {
    traces.push(Object.assign({}, common, triangles(stiff), { color: "#b8c4ce", opacity: 0.6, hoverinfo: "skip" }));
  }
  if (element("edges").checked) {
    traces.push(Object.assign({ type: "scatter3d", mode: "lines", line: { color: "#33414d", width: 1.5 }, hoverinfo: "skip" }, outline(run.skin.faces, points)));
  }
  return draw("shape", traces, scene(frames.flatMap((each) => each.positions), `shape ${element("run").value}`));
}

function surfaces() {
  const [run, index] = surfaceList[element("surface").value];
  const surface = runs[run].surfaces[index];
  const distance = surface.flat.map((p, k) => Math.hypot(...p.map((x, axis) => x - surface.smooth[k][axis])));
  const mesh = (points, more) => Object.assign({
    type: "mesh3d", x: points.map((p) => p[0]), y: points.map((p) => p[1]), z: points.map((p) => p[2]),
    i: surface.triangles.map((t) => t[0]), j: surface.triangles.map((t) => t[1]), k: surface.triangles.map((t) => t[2]),
  }, more);
  const lines = (points) => {
    const [x, y, z] = [[], [], []];
    for (const [a, b] of surface.edges) {
      for (const p of [points[a], points[b]]) { x.push(p[0]); y.push(p[1]); z.push(p[2]); }
      x.push(null); y.push(null); z.push(null);
    }
    return { type: "scatter3d", mode: "lines", hoverinfo: "skip", x, y, z };
  };
  const traces = [];
  if (element("show-flat").checked) {
    traces.push(mesh(surface.flat, { color: "#c7d0d8", opacity: element("show-smooth").checked ? 0.5 : 1, flatshading: true, hoverinfo: "skip" }));
    traces.push(Object.assign(lines(surface.flat), { line: { color: "#66737f", width: 2 } }));
  }
  if (element("show-smooth").checked) {
    traces.push(mesh(surface.smooth, { intensity: distance, colorscale: "Portland", colorbar: { title: { text: "distance" }, thickness: 14 } }));
    traces.push(Object.assign(lines(surface.smooth), { line: { color: "#1c2733", width: 2 } }));
  }
  return draw("surfaces", traces, scene(surface.flat.concat(surface.smooth), `surface ${element("surface").value}`));
}

summary();
const supportNames = supports();
options("support", supportNames);
const axisSelect = options("axis", ["x", "y", "z"]);
if (supportNames.length > 0) {
  // The axis along which the first support moves or carries most.
  const size = (what) => ["x", "y", "z"].map((axis) => Math.max(...runs[0].history[`${what}_${axis}:${supportNames[0]}`].map(Math.abs), 0));
  const sizes = size("displacement").some((x) => x > 0) ? size("displacement") : size("reaction");
  axisSelect.value = sizes.indexOf(Math.max(...sizes));
}
options("run", runs.map((run) => run.label));
const fieldNames = Object.keys(runs[0].frames[0].fields);
const fieldSelect = options("field", fieldNames);
fieldSelect.value = Math.max(0, fieldNames.indexOf("von_mises"));
element("increment").max = Math.max(...runs.flatMap((run) => run.history.increment), 1);
element("increment").value = element("increment").max;
element("frame").max = runs[0].frames.length - 1;
element("frame").value = element("frame").max;
const surfaceList = runs.flatMap((run, r) => run.surfaces.map((_, k) => [r, k]));
options("surface", surfaceList.map(([r, k]) => (runs.length > 1 ? `${runs[r].surfaces[k].name} (${runs[r].label})` : runs[r].surfaces[k].name)));

for (const [id, redraw, event] of [
  ["support", force, "change"], ["axis", force, "change"], ["increment", convergence, "input"], ["run", shape, "change"],
  ["field", shape, "change"], ["frame", shape, "input"], ["edges", shape, "change"], ["surface", surfaces, "change"],
  ["show-flat", surfaces, "change"], ["show-smooth", surfaces, "change"],
]) {
  element(id).addEventListener(event, redraw);
}
const drawn = [iterations(), convergence(), shape()];
if (supportNames.length > 0) drawn.push(force());
if (surfaceList.length > 0) drawn.push(surfaces()); else element("surface-section").remove();
Promise.all(drawn).then(() => { document.body.dataset.ready = "true"; });
