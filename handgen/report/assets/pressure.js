// The fingers under pressure: shapes and numbers of the points that were solved, straight lines between them.
const HEAT = [[255, 255, 204], [254, 217, 118], [253, 141, 60], [227, 26, 28], [128, 0, 38]].map(
  (rgb) => new THREE.Color(...rgb.map((c) => c / 255)).convertSRGBToLinear());
let pressure = 0;

function moving(row) {
  const source = geometry(row.mesh), made = new THREE.BufferGeometry();
  made.setIndex(source.index);
  for (const name of ["position", "normal"]) made.setAttribute(name, source.attributes[name].clone());
  made.setAttribute("color", new THREE.BufferAttribute(new Float32Array(source.attributes.position.array.length), 3));
  return made;
}

// The vertices of a moving part in all its states, one state behind the other.
const swept = new Map();
function everyState(row) {
  if (!swept.has(row)) swept.set(row, points(row.moves));
  return swept.get(row);
}

// The two points around a pressure, and how far it is from the first to the second; beyond the last, the last.
function between(states, value) {
  let after = states.findIndex((state) => state >= value);
  if (after < 0) after = states.length - 1;
  const before = Math.max(after - 1, 0), span = states[after] - states[before];
  return [before, after, span > 0 ? Math.min(Math.max((value - states[before]) / span, 0), 1) : 0];
}

function enterPressure() {
  const moves = scene.nodes.some((row) => row.states && row.states.length);
  element("pressing").hidden = !moves;
  element("stretch").parentElement.hidden = !moves;
  if (moves) {
    const [low, high] = scene.stretch;
    element("scale").textContent = `${low.toFixed(2)} to ${high.toFixed(2)}`;
    setPressure(pressure);
  } else {
    element("readout").textContent = "";
  }
}

function setPressure(value) {
  pressure = value;
  element("pressure").value = value;
  element("pressure-value").textContent = `${value} kPa`;
  for (const {row, mesh} of nodes) if (row.states && row.states.length) shape(row, mesh);
  measure();
  follow();
  redraw();
}

function shape(row, mesh) {
  const [before, after, share] = between(row.states, pressure);
  const position = mesh.geometry.attributes.position, count = position.count;
  const a = points(row.moves, before * count, count), b = points(row.moves, after * count, count);
  for (let i = 0; i < a.length; i++) position.array[i] = a[i] + share * (b[i] - a[i]);
  position.needsUpdate = true;
  mesh.geometry.computeVertexNormals();
  mesh.geometry.boundingSphere = null;
  paint(row, mesh, before, after, share);
}

function paint(row, mesh, before, after, share) {
  const wanted = element("stretch").checked;
  element("scale").hidden = !wanted;
  if (mesh.material.vertexColors !== wanted) {
    mesh.material.vertexColors = wanted;
    mesh.material.color.copy(wanted ? new THREE.Color(1, 1, 1) : tinted(row));
    mesh.material.needsUpdate = true;
  }
  if (!wanted) return;
  const stretch = numbers(row.stretch), count = mesh.geometry.attributes.position.count;
  const colour = mesh.geometry.attributes.color, tint = new THREE.Color();
  for (let i = 0; i < count; i++) {
    const heat = (stretch[before * count + i] * (1 - share) + stretch[after * count + i] * share) / 255 * (HEAT.length - 1);
    const lower = Math.min(Math.floor(heat), HEAT.length - 2);
    tint.lerpColors(HEAT[lower], HEAT[lower + 1], heat - lower);
    colour.setXYZ(i, tint.r, tint.g, tint.b);
  }
  colour.needsUpdate = true;
}

// The curves' dots and the numbers below the view go with the slider.
function follow() {
  const words = [];
  for (const [finger, curve] of Object.entries(DATA.curves)) {
    if (!curve.pressures.length) continue;
    const [before, after, share] = between(curve.pressures, pressure);
    const at = (values) => values[before] + share * (values[after] - values[before]);
    const last = curve.pressures[curve.pressures.length - 1];
    for (const [key, places] of Object.entries(curve.places)) {
      const dot = element(`dot-${finger}-${key}`);
      dot.setAttribute("cx", at(places.map((place) => place[0])));
      dot.setAttribute("cy", at(places.map((place) => place[1])));
    }
    const beyond = pressure > last ? ` (no solution beyond ${last} kPa)` : "";
    words.push(`${finger} ${at(curve.values.bend_angle_deg).toFixed(0)}°${beyond}`);
  }
  if (scene && scene.name === "bend") element("readout").textContent = `${pressure} kPa: ${words.join(", ")}`;
}
