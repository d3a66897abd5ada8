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
  displacement: "length", reaction: "force", von_mises: "force / length²", contact_pressure: "force / length²", contact_gap: "length", contact_slip: "length", contact_friction: "force / length²",
};
const words = { von_mises: "von Mises stress", plastic_strain: "equivalent plastic strain", contact_pressure: "contact pressure", contact_gap: "contact gap", contact_slip: "way from the anchor", contact_friction: "friction traction", contact_status: "contact status (0 no slave, 1 unpaired, 2 open, 3 closed, 4 failed)", friction_status: "friction status (1 sticks, 2 slides)" };
const labelled = (name, axis) => `${words[name] || name}${axis ? ` ${axis}` : ""}${units[name] ? `, ${units[name]}` : ""}`;
// Plots take names for markup.
const plain = (text) => String(text).replaceAll("&", "&amp;").replaceAll("<", "&lt;");
const least = (values, start) => values.reduce((a, b) => (b < a ? b : a), start);
const most = (values, start) => values.reduce((a, b) => (b > a ? b : a), start);

// A plane plot; without a point it says so.
function layout(traces, x, y) {
  const empty = traces.every((trace) => trace.x.length === 0);
  const axis = { zeroline: false, automargin: true, exponentformat: "power", visible: !empty };
  return {
    margin: { l: 64, r: 12, t: 8, b: 46 },
    xaxis: Object.assign({}, axis, { title: { text: x.text, standoff: 12 } }, x.more),
    yaxis: Object.assign({}, axis, { title: { text: y.text, standoff: 12 } }, y.more),
    legend: { orientation: "h", y: 1.12 }, showlegend: true, paper_bgcolor: "rgba(0,0,0,0)",
    annotations: empty ? [{ text: "no finished increment", showarrow: false, xref: "paper", yref: "paper", x: 0.5, y: 0.5 }] : [],
  };
}
// Plotly makes powers of ten a quarter larger than numbers.
const logarithmic = (dtick) => ({ type: "log", dtick, tickfont: { size: 10 } });
// Whole numbers along an axis, some twelve of them.
const counted = (traces) => ({ dtick: Math.ceil(most(traces.map((trace) => trace.x.length), 0) / 12) || 1 });
const whole = (traces) => ({ dtick: Math.ceil(most(traces.flatMap((trace) => trace.y), 0) / 8) || 1 });
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

// Four digits, with the minus sign of the plots.
function precise(x) {
  const rounded = Number(Number(x).toPrecision(4));
  const size = Math.abs(rounded);
  return (size !== 0 && (size < 1e-3 || size >= 1e5) ? rounded.toExponential() : String(rounded)).replaceAll("-", "−").replace("e+", "e");
}

const ofInterfaces = (value) => (run) => Object.values(run.summary.friction).map(value).join("; ");
const frictionRows = [
  ["slaves that stick, that slide, at the end", ofInterfaces((own) => `${own.stuck}, ${own.sliding}`)],
  ["mean friction traction at the end", ofInterfaces((own) => precise(own.traction))],
  ["dissipated energy", ofInterfaces((own) => precise(own.dissipated))],
];

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
    for (const warning of run.summary.warnings) {
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
    ["contact force at the end: x, y, z", (run) => run.summary.contact_force.map(precise).join(", ")],
    ...(runs.some(hasFriction) ? frictionRows : []),
    ["wall time, s", (run) => precise(run.summary.wall_s)],
    ["share of contact evaluation", (run) => `${(100 * run.summary.contact_share).toFixed(1)} %`],
    ["share of pairing", (run) => `${(100 * run.summary.pairing_share).toFixed(1)} %`],
    ["nodes, elements", (run) => run.summary.size.join(", ")],
  ];
  table("summary", rows.map(([name, value]) => [name, ...runs.map(value)]));
  const material = ({ young, poisson, model, plasticity: yields }) =>
    `${model === "neo-hooke" ? "neo-Hooke, " : ""}E\u00a0${precise(young)}, ν\u00a0${precise(poisson)}${yields ? `, yield stress ${precise(yields.yield_stress)}, hardening ${precise(yields.hardening)}` : ""}`;
  const elements = ({ elements: all, incompatible_modes: modes }) =>
    modes ? `${all}, with incompatible modes ${modes === all ? "all" : modes}` : all || "";
  const parts = (run) => [
    ...run.summary.parts.map((part) => [part.name, part.nodes, elements(part), part.material ? material(part.material) : "rigid"]),
    ...run.summary.interfaces.map((each) => [each.interface, "", "", `penalty\u00a0${precise(each.penalty)}${each.adjusted ? `, ${each.adjusted[0]} of ${each.slaves} slaves moved into touch` : ""}`]),
  ];
  // Runs of the same mesh share their lines.
  const seen = new Set();
  const lines = runs.flatMap((run) => parts(run).filter((line) => !seen.has(line.join("\n")) && seen.add(line.join("\n"))));
  table("parts", [["part or interface", "nodes", "elements", "what it is"], ...lines]);
}

// Rows of cells, the first of them the head.
function table(id, rows) {
  element(id).replaceChildren(...rows.map((cells, k) => {
    const row = document.createElement("tr");
    row.append(...cells.map((text) => {
      const made = document.createElement(k === 0 ? "th" : "td");
      made.textContent = text;
      return made;
    }));
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
  // Towards where it goes from left to right.
  const far = most(runs.flatMap(moved), 0);
  const sign = -least(runs.flatMap(moved), 0) > far ? -1 : 1;
  const along = sign < 0 ? `−${axis}` : axis;
  const signed = (values) => values.map((value) => sign * value);
  const traces = runs.map((run, k) => ({
    x: moves ? signed(moved(run)) : run.history.time, y: signed(run.history[`reaction_${axis}:${name}`] || []),
    name: plain(run.label), mode: "lines+markers", marker: { size: 5 }, line: { color: colours[k % colours.length], dash: k ? "dash" : "solid" },
  }));
  return draw("force", traces, layout(traces, { text: moves ? labelled("displacement", along) : "time" }, { text: labelled("reaction", along) }));
}

// What interfaces exert over time: of each a line for each run.
const overArea = (at, force) => at(force).map((sum, k) => (at("contact_area")[k] > 0 ? sum / at("contact_area")[k] : 0));
const ofContact = [
  ["mean pressure, force / length²", (at) => overArea(at, "contact_normal_force")],
  ["area, length²", (at) => at("contact_area")],
  ...["x", "y", "z"].map((axis) => [`force ${axis}, force`, (at) => at(`contact_force_${axis}`)]),
  ...["x", "y", "z"].map((axis) => [`moment about ${axis} through the origin, force · length`, (at) => at(`contact_moment_${axis}`)]),
  ...["x", "y", "z"].map((axis) => [`centre of pressure ${axis}, length`, (at) => at(`contact_centre_${axis}`).map((x, k) => (at("contact_area")[k] > 0 ? x : null))]),
];
const ofFriction = [
  ["dissipated energy, force · length", (at) => at("dissipated")],
  ["mean friction traction, force / length²", (at) => overArea(at, "friction_force")],
  ["slaves that stick", (at) => at("stuck")],
  ["slaves that slide", (at) => at("sliding")],
];
const hasFriction = (run) => Object.keys(run.summary.friction).length > 0;
const quantities = runs.some(hasFriction) ? [...ofContact, ...ofFriction] : ofContact;
const interfacesOf = (run) => Object.keys(run.history).filter((key) => key.startsWith("contact_area:")).map((key) => key.slice(13));

function contact() {
  const [title, values] = quantities[element("quantity").value];
  const traces = runs.flatMap((run, r) => interfacesOf(run).map((name, k) => ({
    x: run.history.time, y: values((what) => run.history[`${what}:${name}`] || []), name: plain(runs.length > 1 ? `${name} (${run.label})` : name),
    mode: "lines+markers", marker: { size: 5 }, line: { color: colours[(k + r * interfacesOf(run).length) % colours.length], dash: r ? "dash" : "solid" },
  })));
  return draw("contact", traces, layout(traces, { text: "time" }, { text: title }));
}

// Where a run that ended early got stuck.
function failed() {
  const traces = failures.map((run, k) => ({
    x: run.failed.residuals.map((_, i) => run.failed.iterations[i] ?? i), y: run.failed.residuals.map((r) => (r > 0 ? r : null)), name: plain(run.label), mode: "lines+markers", line: { color: colours[k % colours.length] },
  }));
  element("failed-reason").textContent = failures.map((run) => `${run.label}: from ${precise(run.failed.time - run.failed.length)} to ${precise(run.failed.time)}: ${run.failed.reason}`).join(" · ");
  const point = (x) => `(${x.map(precise).join(", ")})`;
  table("worst", [
    ["part", "node", "position", "residual, force"],
    ...failures.flatMap((run) => run.failed.worst.map((node) => [failures.length > 1 ? `${node.part} (${run.label})` : node.part, node.node, point(node.position), point(node.residual)])),
  ]);
  return draw("failed", traces, layout(traces, { text: "linear solutions", more: counted(traces) }, { text: "residual over forces", more: logarithmic(1) }));
}

function iterations() {
  element("totals").textContent = `in finished increments: ${runs.map((run) => `${run.label} ${run.history.iterations.reduce((a, b) => a + b, 0)}`).join(", ")}`;
  const traces = runs.map((run, k) => ({
    x: run.history.time, y: run.history.iterations, name: plain(run.label), mode: "lines+markers",
    line: { shape: "hvh", color: colours[k % colours.length] }, marker: { size: 5 },
  }));
  return draw("iterations", traces, layout(traces, { text: "time" }, { text: "iterations", more: { rangemode: "tozero", ...whole(traces) } }));
}

function convergence() {
  const number = element("increment").value;
  element("increment-label").textContent = number;
  const traces = runs.map((run, k) => {
    // A round of augmentation begins with a second residual after as many solutions.
    const residuals = run.residuals[number] || [];
    return { x: residuals.map(([solutions]) => solutions), y: residuals.map(([, r]) => (r > 0 ? r : null)), name: plain(run.label), mode: "lines+markers", line: { color: colours[k % colours.length] } };
  });
  const x = { text: "linear solutions", more: counted(traces) };
  const met = { type: "line", xref: "paper", x0: 0, x1: 1, y0: 1, y1: 1, line: { color: "#66737f", width: 1, dash: "dot" } };
  return draw("convergence", traces, { ...layout(traces, x, { text: "residual over what is allowed", more: logarithmic(2) }), shapes: [met] });
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
// A scale below a scene, pixels.
const SCALE = 76;

// Whether an element is too narrow for a scale beside its scene: it goes below then.
const isNarrow = (id) => element(id).clientWidth < 560;
const scaleBar = (id, text) => Object.assign({ title: { text, side: "right" }, thickness: 14, exponentformat: "power" },
  isNarrow(id) ? { orientation: "h", title: { text, side: "top" }, len: 0.96, x: 0.5, y: 0, yanchor: "bottom", nticks: 5 } : {});

// A scene that holds all points and fills the element, the axis of the load up if there is one. It is seen along its shortest side, but not
// along the load; without a load y is up unless that is the side.
function scene(id, points, revision, load) {
  const bounds = [0, 1, 2].map((axis) => {
    const values = points.map((p) => p[axis]);
    return [least(values, Infinity), most(values, -Infinity)];
  });
  const largest = most(bounds.map(([low, high]) => high - low), 1e-300);
  const margin = 0.03 * largest;
  const sides = bounds.map(([low, high]) => (high - low + 2 * margin) / largest);
  const shortest = [0, 1, 2].filter((axis) => axis !== load).sort((a, b) => sides[a] - sides[b])[0];
  const depth = load === undefined ? sides.indexOf(Math.min(...sides)) : shortest;
  const up = load === undefined ? (depth === 1 ? 2 : 1) : load;
  const right = 3 - depth - up;
  const along = (weights) => Object.fromEntries(["x", "y", "z"].map((name, axis) => [name, weights[axis]]));
  const direction = [0, 0, 0];
  direction[depth] = 1.15; direction[up] = 0.45; direction[right] = 0.55;
  const toEye = unit(direction);
  const aside = unit(cross([0, 1, 2].map((k) => Number(k === up)), toEye));
  const extent = (axis) => sides.reduce((sum, side, k) => sum + side * Math.abs(axis[k]), 0);
  const [across, upward] = isNarrow(id) ? [0.85, 1 - SCALE / element(id).clientHeight] : [0.8, 1];
  const shape = (across * element(id).clientWidth) / (upward * element(id).clientHeight) || 1;
  const scale = Math.min(VIEW / extent(cross(toEye, aside)), (VIEW * shape) / extent(aside));
  // Numbers along a short side would lie on each other.
  const axis = (k) => ({
    title: { text: "xyz"[k] }, range: [bounds[k][0] - margin, bounds[k][1] + margin], autorange: false,
    nticks: 6, showticklabels: sides[k] > 0.4, showspikes: false,
  });
  return {
    margin: { l: 0, r: 0, t: 0, b: 0 }, uirevision: revision, paper_bgcolor: "rgba(0,0,0,0)", showlegend: false,
    scene: {
      domain: { y: [1 - upward, 1] },
      uirevision: revision, aspectmode: "manual", aspectratio: along(sides.map((side) => scale * side)),
      camera: { eye: along(direction), up: along([0, 1, 2].map((k) => Number(k === up))), projection: { type: "orthographic" } },
      xaxis: axis(0), yaxis: axis(1), zaxis: axis(2),
    },
  };
}

// Frames of a run; that of the increment that failed is the last.
const framesOf = (run) => (run.failed && run.failed.frame ? [...run.frames, run.failed.frame] : run.frames);

// How a part is shown: a click leads to the next state.
const states = ["shown", "faded", "hidden"];
const partStates = new Map();

function partList(run) {
  element("part-list").replaceChildren(...run.skin.names.map((name) => {
    const button = document.createElement("button");
    button.className = "part";
    button.textContent = name;
    const show = (state) => {
      button.dataset.state = state;
      button.setAttribute("aria-label", `${name}: ${state}`);
    };
    show(partStates.get(name) || states[0]);
    button.addEventListener("click", () => {
      const state = states[(states.indexOf(button.dataset.state) + 1) % states.length];
      partStates.set(name, state);
      show(state);
      shape();
    });
    return button;
  }));
}

// Whether a face lies on the side of the clipping plane that is shown.
function clipped(points, bounds) {
  const axis = element("clip").value - 1;
  if (axis < 0) return () => true;
  const [low, high] = bounds[axis];
  const limit = low + (element("clip-at").value / 100) * (high - low) * (1 + 1e-9);
  return (face) => face.reduce((sum, corner) => sum + points[corner][axis], 0) <= limit * face.length;
}

// Plotly takes normals of faces with less than a part of the largest extent for none, which makes them dark.
const lighting = { ambient: 0.75, diffuse: 0.5, specular: 0.05, facenormalsepsilon: 0, vertexnormalsepsilon: 0 };

function shape() {
  const run = shapes[element("run").value];
  const frames = framesOf(run);
  element("frame").max = frames.length - 1;
  const frame = frames[Math.min(element("frame").value, frames.length - 1)];
  element("frame-label").textContent = `${precise(frame.time)}${run.failed && frame === run.failed.frame ? ", failed" : ""}`;
  const field = fieldNames[element("field").value];
  const points = frame.positions;
  // Where an increment failed nodes may be anywhere: axes and colours are those of what has converged.
  const all = run.frames.flatMap((each) => each.positions);
  const bounds = [0, 1, 2].map((axis) => [least(all.map((p) => p[axis]), Infinity), most(all.map((p) => p[axis]), -Infinity)]);
  const isKept = clipped(points, bounds);
  const state = (k) => partStates.get(run.skin.names[run.skin.parts[k]]) || states[0];
  const faces = (deformable, wanted) => run.skin.faces.filter((face, k) => run.skin.parts[k] < run.skin.deformable === deformable && state(k) === wanted && isKept(face));
  const known = frame.fields[field];
  // A gap is that of a slave with a contact element, open or closed; elsewhere there is a zero in the results. Old ones do not say.
  const status = field === "contact_gap" && frame.fields.contact_status;
  const hasValue = (k) => !status || status[k] === 2 || status[k] === 3;
  const values = known || points.map(() => 0);
  const range = run.frames.map((each) => each.fields[field]);
  const low = least(range.map((each) => least(each, 0)), 0);
  const high = most(range.map((each) => most(each, 0)), low);
  const common = { x: points.map((p) => p[0]), y: points.map((p) => p[1]), z: points.map((p) => p[2]), type: "mesh3d", hoverinfo: "text", flatshading: true, lighting };
  const coloured = (list, more) => Object.assign({}, common, triangles(list), {
    intensity: values, cmin: low, cmax: high > low ? high : low + 1, colorscale: "Viridis", colorbar: scaleBar("shape", labelled(field)),
    text: values.map((value, k) => `node ${run.skin.nodes[k]}<br>${words[field] || field} ${hasValue(k) ? precise(value) : "none"}`),
  }, more);
  const solid = faces(true, "shown");
  const isColoured = (face) => face.every(hasValue);
  const traces = [coloured(solid.filter(isColoured), {})];
  const add = (list, more) => { if (list.length > 0) traces.push(Object.assign({}, common, triangles(list), { hoverinfo: "skip" }, more)); };
  const faded = faces(true, "faded");
  if (faded.some(isColoured)) traces.push(coloured(faded.filter(isColoured), { opacity: 0.25, showscale: false }));
  const isPlain = (face) => !isColoured(face);
  add(solid.filter(isPlain), { color: "#e3e7ea" });
  add(faded.filter(isPlain), { color: "#e3e7ea", opacity: 0.25 });
  add(faces(false, "shown"), { color: "#b8c4ce", opacity: 0.6 });
  add(faces(false, "faded"), { color: "#b8c4ce", opacity: 0.15 });
  if (element("edges").checked) {
    const visible = run.skin.faces.filter((face, k) => state(k) !== "hidden" && isKept(face));
    traces.push(Object.assign({ type: "scatter3d", mode: "lines", line: { color: "#33414d", width: 1.5 }, hoverinfo: "skip" }, outline(visible, points)));
  }
  const corners = [...new Set(solid.flat())].filter(hasValue);
  const at = (k) => `${precise(values[k])} at node ${run.skin.nodes[k]} (${points[k].map(precise).join(", ")})`;
  const lowest = corners.reduce((a, b) => (values[b] < values[a] ? b : a), corners[0]);
  const highest = corners.reduce((a, b) => (values[b] > values[a] ? b : a), corners[0]);
  if (!known) element("extremes").textContent = `There is no ${words[field] || field} where the increment was left.`;
  else element("extremes").textContent = corners.length > 0 ? `${words[field] || field} of the parts shown: least ${at(lowest)}, largest ${at(highest)}.` : "";
  return draw("shape", traces, scene("shape", all, `shape ${element("run").value}`, loadAxis));
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
    lighting: { facenormalsepsilon: 0, vertexnormalsepsilon: 0 },
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
    traces.push(mesh(surface.smooth, { intensity: distance, cmin: 0, cmax: top, colorscale: "Portland", colorbar: scaleBar("surfaces", "distance, length") }));
    traces.push(Object.assign(lines(surface.smooth), { line: { color: "#1c2733", width: 2 } }));
  }
  return draw("surfaces", traces, scene("surfaces", surface.flat.concat(surface.smooth), `surface ${element("surface").value}`, loadAxis));
}

summary();
const supportNames = supports();
options("support", supportNames);
const axisSelect = options("axis", ["x", "y", "z"]);
// A load along z has shapes with z up.
let loadAxis;
if (supportNames.length > 0) {
  // The axis along which the first support moves or carries most.
  const size = (what) => ["x", "y", "z"].map((axis) => most(runs[0].history[`${what}_${axis}:${supportNames[0]}`].map(Math.abs), 0));
  const sizes = size("displacement").some((x) => x > 0) ? size("displacement") : size("reaction");
  axisSelect.value = sizes.indexOf(Math.max(...sizes));
  if (Math.max(...sizes) > 0 && axisSelect.value === "2") loadAxis = 2;
}
options("quantity", quantities.map(([name]) => name));
options("clip", ["no", "x", "y", "z"]);
const failures = runs.filter((run) => run.failed);
// Some are too large for a page.
const shapes = runs.filter((run) => run.frames.length > 0);
options("run", shapes.map((run) => run.label));
// Those that all of them have.
const fieldNames = shapes.length === 0 ? [] : Object.keys(shapes[0].frames[0].fields).filter((name) => shapes.every((run) => name in run.frames[0].fields));
const fieldSelect = options("field", fieldNames.map((name) => words[name] || name));
if (shapes.length > 0) {
  fieldSelect.value = Math.max(0, fieldNames.indexOf(shapes[0].skin.shown));
  element("frame").max = most(shapes.map((run) => framesOf(run).length - 1), 0);
  // At first the last one that has converged.
  element("frame").value = shapes[0].frames.length - 1;
  partList(shapes[0]);
  element("run").addEventListener("change", () => partList(shapes[element("run").value]));
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
  ["quantity", contact, "change"], ["clip", shape, "change"], ["clip-at", shape, "input"], ["field", shape, "change"], ["frame", shape, "input"], ["edges", shape, "change"], ["surface", surfaces, "change"],
  ["show-flat", surfaces, "change"], ["show-smooth", surfaces, "change"],
]) {
  element(id).addEventListener(event, redraw);
}
// What a plot shows, as a picture or as columns.
function saved(name, type, text) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(new Blob([text], { type }));
  link.download = name;
  link.click();
  URL.revokeObjectURL(link.href);
}

function csv(id) {
  // Names are those of the plots, which take them for markup.
  const quoted = (text) => `"${String(text).replaceAll("&lt;", "<").replaceAll("&amp;", "&").replaceAll('"', '""')}"`;
  if (id === "shape") {
    const run = shapes[element("run").value];
    const frames = framesOf(run);
    const frame = frames[Math.min(element("frame").value, frames.length - 1)];
    const rows = frame.positions.map((p, k) => [run.skin.nodes[k], ...p, ...fieldNames.map((name) => (frame.fields[name] || [])[k] ?? "")]);
    return [["node", "x", "y", "z", ...fieldNames], ...rows].map((row) => row.join(",")).join("\n");
  }
  const lines = element(id).data.filter((trace) => trace.type !== "mesh3d");
  const rows = lines.flatMap((trace) => trace.x.map((x, k) => [quoted(trace.name || id), x ?? "", trace.y[k] ?? "", ...(trace.z ? [trace.z[k] ?? ""] : [])]));
  const { xaxis, yaxis } = element(id).layout;
  const titles = xaxis ? [xaxis.title.text, yaxis.title.text] : ["x", "y", "z"];
  return [["line", ...titles.map(quoted)], ...rows].map((row) => row.join(",")).join("\n");
}

for (const place of document.querySelectorAll(".export")) {
  const id = place.dataset.plot;
  const button = (text, action) => {
    const made = document.createElement("button");
    made.textContent = text;
    made.setAttribute("aria-label", `${id} as ${text}`);
    made.addEventListener("click", action);
    return made;
  };
  const picture = () => Plotly.downloadImage(id, { format: "png", filename: id, width: element(id).clientWidth, height: element(id).clientHeight, scale: 2 });
  place.append(button("CSV", () => saved(`${id}.csv`, "text/csv", csv(id))), button("PNG", picture));
}

// Scenes and their scales lie otherwise in another width.
const width = () => document.documentElement.clientWidth;
let drawnAt = width();
window.addEventListener("resize", () => {
  if (width() === drawnAt) return;
  drawnAt = width();
  if (shapes.length > 0) shape();
  if (surfaceList.length > 0) surfaces();
});

const drawn = [iterations(), convergence(), force()];
if (runs.some((run) => interfacesOf(run).length > 0)) drawn.push(contact()); else element("contact-section").remove();
if (failures.length > 0) drawn.push(failed()); else element("failed-section").remove();
if (shapes.length > 0) drawn.push(shape()); else element("shape-section").remove();
if (surfaceList.length > 0) drawn.push(surfaces()); else element("surface-section").remove();
Promise.all(drawn).then(() => { document.body.dataset.ready = "true"; });
