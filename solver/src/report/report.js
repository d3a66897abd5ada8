"use strict";
// Draws the page from the JSON in it. Every plot that is drawn sets data-drawn on its element, the page data-ready on its body when
// all are, and data-error if anything fails.

for (const event of ["error", "unhandledrejection"]) {
  window.addEventListener(event, (failed) => { document.body.dataset.error = String(failed.message || failed.reason); });
}

const data = JSON.parse(document.getElementById("data").textContent);
const runs = data.runs;
const colours = ["#0b6bcb", "#d9730d", "#2e7d32", "#7b3fa0", "#8a6d00", "#c2185b"];
// What a quantity is measured in: the deck does not know more.
const units = {
  displacement: "length", reaction: "force", von_mises: "force / length²", contact_pressure: "force / length²", contact_gap: "length", contact_slip: "length",
};
const words = { von_mises: "von Mises stress", plastic_strain: "equivalent plastic strain", contact_pressure: "contact pressure", contact_gap: "contact gap", contact_slip: "way from the anchor" };
const labelled = (name, axis) => `${words[name] || name}${axis ? ` ${axis}` : ""}${units[name] ? `, ${units[name]}` : ""}`;
const least = (values, start) => values.reduce((a, b) => (b < a ? b : a), start);
const most = (values, start) => values.reduce((a, b) => (b > a ? b : a), start);

// A plane plot; without a point it says so.
function layout(traces, x, y) {
  const axis = { zeroline: false, automargin: true, exponentformat: "power" };
  const empty = traces.every((trace) => trace.x.length === 0);
  return {
    margin: { l: 64, r: 12, t: 8, b: 46 },
    xaxis: Object.assign({}, axis, { title: { text: x.text } }, x.more),
    yaxis: Object.assign({}, axis, { title: { text: y.text } }, y.more),
    legend: { orientation: "h", y: 1.12 }, showlegend: true, paper_bgcolor: "rgba(0,0,0,0)",
    annotations: empty ? [{ text: "no finished increment", showarrow: false, xref: "paper", yref: "paper", x: 0.5, y: 0.5 }] : [],
  };
}
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

// Four digits.
function precise(x) {
  const rounded = Number(Number(x).toPrecision(4));
  const size = Math.abs(rounded);
  return size !== 0 && (size < 1e-3 || size >= 1e5) ? rounded.toExponential() : String(rounded);
}

function summary() {
  element("title").textContent = runs[0].summary.title;
  const failed = runs.filter((run) => !run.summary.converged);
  for (const run of failed) {
    const line = document.createElement("div");
    line.className = "bad";
    line.textContent = `${run.label} ended early: ${run.summary.reason}`;
    element("state").append(line);
  }
  for (const run of runs) {
    const { augmentations_short: short, contacts_lost: lost, interfaces_without_force: idle } = run.summary;
    const warnings = [
      short > 0 && `rounds of augmentation were over before the tolerance was met in ${short} of ${run.summary.increments} increments`,
      lost > 0 && `${lost} contacts that carried force lost their element (contact_status 4)`,
      idle.length > 0 && `interfaces that never carried force: ${idle.join(", ")}`,
    ];
    for (const warning of warnings.filter(Boolean)) {
      const line = document.createElement("div");
      line.className = "bad";
      line.textContent = `${run.label}: ${warning}`;
      element("state").append(line);
    }
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
  const largest = (name, what) => most(["x", "y", "z"].flatMap((axis) => history[`${what}_${axis}:${name}`].map(Math.abs)), 0);
  return names.sort((a, b) => largest(b, "displacement") - largest(a, "displacement") || largest(b, "reaction") - largest(a, "reaction"));
}

function force() {
  const name = supportNames[element("support").value || 0];
  const axis = "xyz"[element("axis").value];
  const moved = (run) => run.history[`displacement_${axis}:${name}`] || [];
  const moves = runs.some((run) => moved(run).some((x) => x !== 0));
  const traces = runs.map((run, k) => ({
    x: moves ? moved(run) : run.history.time, y: run.history[`reaction_${axis}:${name}`] || [],
    name: run.label, mode: "lines+markers", marker: { size: 5 }, line: { color: colours[k % colours.length], dash: k ? "dash" : "solid" },
  }));
  return draw("force", traces, layout(traces, { text: moves ? labelled("displacement", axis) : "time" }, { text: labelled("reaction", axis) }));
}

function iterations() {
  element("totals").textContent = runs.map((run) => `${run.label}: ${run.history.iterations.reduce((a, b) => a + b, 0)} in finished increments`).join(" · ");
  const traces = runs.map((run, k) => ({
    x: run.history.time, y: run.history.iterations, name: run.label, mode: "lines+markers",
    line: { shape: "hvh", color: colours[k % colours.length] }, marker: { size: 5 },
  }));
  return draw("iterations", traces, layout(traces, { text: "time" }, { text: "iterations", more: { rangemode: "tozero" } }));
}

function convergence() {
  const number = element("increment").value;
  element("increment-label").textContent = number;
  const traces = runs.map((run, k) => {
    // The first residual is that before the prescribed nodes move.
    const residuals = (run.residuals[number] || []).slice(1);
    return { x: residuals.map((_, i) => i + 1), y: residuals.map((r) => (r > 0 ? r : null)), name: run.label, mode: "lines+markers", line: { color: colours[k % colours.length] } };
  });
  const count = most(traces.map((trace) => trace.x.length), 0);
  const x = { text: "linear solutions", more: { dtick: Math.ceil(count / 12) || 1 } };
  return draw("convergence", traces, layout(traces, x, { text: "residual over forces", more: { type: "log", dtick: 2 } }));
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

const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const unit = (a) => a.map((x) => x / Math.sqrt(dot(a, a)));
// What of a scene is in view from the bottom to its top, in plotly's units, with a margin.
const VIEW = 1.6;

// A scene that holds all points and fills the element, seen along its shortest side, y up unless that is the side.
function scene(id, points, revision) {
  const bounds = [0, 1, 2].map((axis) => {
    const values = points.map((p) => p[axis]);
    return [least(values, Infinity), most(values, -Infinity)];
  });
  const largest = most(bounds.map(([low, high]) => high - low), 1e-300);
  const margin = 0.03 * largest;
  const sides = bounds.map(([low, high]) => (high - low + 2 * margin) / largest);
  const depth = sides.indexOf(Math.min(...sides));
  const up = depth === 1 ? 2 : 1;
  const right = 3 - depth - up;
  const along = (weights) => Object.fromEntries(["x", "y", "z"].map((name, axis) => [name, weights[axis]]));
  const direction = [0, 0, 0];
  direction[depth] = 1.15; direction[up] = 0.45; direction[right] = 0.55;
  const toEye = unit(direction);
  const aside = unit(cross([0, 1, 2].map((k) => Number(k === up)), toEye));
  const extent = (axis) => sides.reduce((sum, side, k) => sum + side * Math.abs(axis[k]), 0);
  const shape = (0.8 * element(id).clientWidth) / element(id).clientHeight || 1;
  const scale = Math.min(VIEW / extent(cross(toEye, aside)), (VIEW * shape) / extent(aside));
  // Numbers along a short side would lie on each other.
  const axis = (k) => ({
    title: { text: "xyz"[k] }, range: [bounds[k][0] - margin, bounds[k][1] + margin], autorange: false,
    nticks: 6, showticklabels: sides[k] > 0.4, showspikes: false,
  });
  return {
    margin: { l: 0, r: 0, t: 0, b: 0 }, uirevision: revision, paper_bgcolor: "rgba(0,0,0,0)", showlegend: false,
    scene: {
      uirevision: revision, aspectmode: "manual", aspectratio: along(sides.map((side) => scale * side)),
      camera: { eye: along(direction), up: along([0, 1, 2].map((k) => Number(k === up))), projection: { type: "orthographic" } },
      xaxis: axis(0), yaxis: axis(1), zaxis: axis(2),
    },
  };
}

function shape() {
  const run = shapes[element("run").value];
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
  const low = least(range.map((each) => least(each, 0)), 0);
  const high = most(range.map((each) => most(each, 0)), low);
  const common = { x: points.map((p) => p[0]), y: points.map((p) => p[1]), z: points.map((p) => p[2]), type: "mesh3d", hoverinfo: "text", flatshading: true, lighting: { ambient: 0.75, diffuse: 0.5, specular: 0.05 } };
  const traces = [Object.assign({}, common, triangles(solid), {
    intensity: values, cmin: low, cmax: high > low ? high : low + 1, colorscale: "Viridis", colorbar: { title: { text: labelled(field), side: "right" }, thickness: 14, exponentformat: "power" },
    text: values.map((value, k) => `node ${run.skin.nodes[k]}<br>${words[field] || field} ${precise(value)}`),
  })];
  if (stiff.length > 0) {
    traces.push(Object.assign({}, common, triangles(stiff), { color: "#b8c4ce", opacity: 0.6, hoverinfo: "skip" }));
  }
  if (element("edges").checked) {
    traces.push(Object.assign({ type: "scatter3d", mode: "lines", line: { color: "#33414d", width: 1.5 }, hoverinfo: "skip" }, outline(run.skin.faces, points)));
  }
  return draw("shape", traces, scene("shape", frames.flatMap((each) => each.positions), `shape ${element("run").value}`));
}

function surfaces() {
  const [run, index] = surfaceList[element("surface").value];
  const surface = runs[run].surfaces[index];
  // Rounding alone is no distance.
  const far = most(surface.distance, 0);
  const top = far > 1e-9 * most(surface.flat.flat().map(Math.abs), 0) ? far : 1;
  const distance = surface.distance.map((d) => (top === far ? d : 0));
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
    traces.push(mesh(surface.smooth, { intensity: distance, cmin: 0, cmax: top, colorscale: "Portland", colorbar: { title: { text: "distance, length", side: "right" }, thickness: 14, exponentformat: "power" } }));
    traces.push(Object.assign(lines(surface.smooth), { line: { color: "#1c2733", width: 2 } }));
  }
  return draw("surfaces", traces, scene("surfaces", surface.flat.concat(surface.smooth), `surface ${element("surface").value}`));
}

summary();
const supportNames = supports();
options("support", supportNames);
const axisSelect = options("axis", ["x", "y", "z"]);
if (supportNames.length > 0) {
  // The axis along which the first support moves or carries most.
  const size = (what) => ["x", "y", "z"].map((axis) => most(runs[0].history[`${what}_${axis}:${supportNames[0]}`].map(Math.abs), 0));
  const sizes = size("displacement").some((x) => x > 0) ? size("displacement") : size("reaction");
  axisSelect.value = sizes.indexOf(Math.max(...sizes));
}
// Some are too large for a page.
const shapes = runs.filter((run) => run.frames.length > 0);
options("run", shapes.map((run) => run.label));
// Those that all of them have.
const fieldNames = shapes.length === 0 ? [] : Object.keys(shapes[0].frames[0].fields).filter((name) => shapes.every((run) => name in run.frames[0].fields));
const fieldSelect = options("field", fieldNames.map((name) => words[name] || name));
if (shapes.length > 0) {
  fieldSelect.value = Math.max(0, fieldNames.indexOf(shapes[0].skin.shown));
  element("frame").max = most(shapes.map((run) => run.frames.length - 1), 0);
  element("frame").value = element("frame").max;
}
element("notes").textContent = runs.flatMap((run) => run.notes.map((note) => (runs.length > 1 ? `${run.label}: ${note}` : note))).join(" ");
element("increment").max = most(runs.flatMap((run) => run.history.increment), 1);
// At first the one that took most, among those that all runs have.
const common = Math.min(...runs.map((run) => run.history.increment.length));
const taken = runs[0].history.iterations.slice(0, common);
element("increment").value = 1 + Math.max(0, taken.lastIndexOf(most(taken, 0)));
const surfaceList = runs.flatMap((run, r) => run.surfaces.map((_, k) => [r, k]));
options("surface", surfaceList.map(([r, k]) => (runs.length > 1 ? `${runs[r].surfaces[k].name} (${runs[r].label})` : runs[r].surfaces[k].name)));

for (const [id, redraw, event] of [
  ["support", force, "change"], ["axis", force, "change"], ["increment", convergence, "input"], ["run", shape, "change"],
  ["field", shape, "change"], ["frame", shape, "input"], ["edges", shape, "change"], ["surface", surfaces, "change"],
  ["show-flat", surfaces, "change"], ["show-smooth", surfaces, "change"],
]) {
  element(id).addEventListener(event, redraw);
}
const drawn = [iterations(), convergence(), force()];
if (shapes.length > 0) drawn.push(shape()); else element("shape-section").remove();
if (surfaceList.length > 0) drawn.push(surfaces()); else element("surface-section").remove();
Promise.all(drawn).then(() => { document.body.dataset.ready = "true"; });
