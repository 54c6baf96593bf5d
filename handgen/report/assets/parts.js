// The parts of the shown scene: switched, pulled apart, cut open, seen through.
const geometries = new Map();
const cutter = new THREE.Plane();
let scene = null, nodes = [], exploded = 0, cutShare = 0, cutAxis = null;

function geometry(number) {
  if (!geometries.has(number)) {
    const place = DATA.meshes[number], made = new THREE.BufferGeometry();
    made.setAttribute("position", new THREE.BufferAttribute(points(place.points), 3));
    const normals = Float32Array.from(numbers(place.normals), (n) => n / 127);
    made.setAttribute("normal", new THREE.BufferAttribute(normals, 3));
    made.setIndex(new THREE.BufferAttribute(numbers(place.faces), 1));
    geometries.set(number, made);
  }
  return geometries.get(number);
}

function showScene(name) {
  for (const {mesh} of nodes) world.remove(mesh);
  scene = DATA.scenes.find((each) => each.name === name) || DATA.scenes[0];
  nodes = scene.nodes.map(placed);
  element("scene").value = scene.name;
  element("exploding").hidden = !scene.nodes.some((row) => row.apart.some((way) => way));
  setCut(0);
  setOpacity(+element("opacity").value / 100);
  listParts();
  enterPressure();
  setExplode(["hand", "bend"].includes(scene.name) ? 0 : 1);
  placeMarkers();
  look({hand: "start", bend: "bend"}[scene.name] || "mould");
}

function placed(row, order) {
  const material = new THREE.MeshStandardMaterial({color: tinted(row), roughness: 0.7, metalness: 0});
  // A core fills its cavity: of two surfaces in one place always the same one is seen.
  Object.assign(material, {polygonOffset: true, polygonOffsetFactor: order / 4, polygonOffsetUnits: 8 * order});
  const mesh = new THREE.Mesh(row.states && row.states.length ? moving(row) : geometry(row.mesh), material);
  mesh.matrixAutoUpdate = false;
  mesh.visible = row.shown;
  mesh.name = row.name;
  world.add(mesh);
  return {row, mesh, base: new THREE.Matrix4().fromArray(row.matrix)};
}

function tinted(row) {
  return new THREE.Color(row.colour).convertSRGBToLinear();
}

function setExplode(share) {
  exploded = share;
  for (const {row, mesh, base} of nodes) {
    const way = new THREE.Vector3(...row.apart).multiplyScalar(share);
    mesh.matrix.makeTranslation(way.x, way.y, way.z).multiply(base);
  }
  element("explode").value = 100 * share;
  element("explode-value").textContent = `${Math.round(100 * share)} %`;
  measure();
  fit();
}

// The box of what is shown.
function measure() {
  box.makeEmpty();
  for (const {mesh} of nodes) {
    if (!mesh.visible) continue;
    mesh.geometry.computeBoundingBox();
    mesh.updateMatrixWorld(true);
    box.union(mesh.geometry.boundingBox.clone().applyMatrix4(mesh.matrix));
  }
  if (box.isEmpty()) box.set(new THREE.Vector3(-50, -50, -50), new THREE.Vector3(50, 50, 50));
}

function setVisible(name, shown) {
  for (const {row, mesh} of nodes) if (row.name === name) mesh.visible = shown;
  const tick = document.querySelector(`#parts input[data-part="${CSS.escape(name)}"]`);
  if (tick) tick.checked = shown;
  measure();
  placeMarkers();
  redraw();
}

function listParts() {
  const list = element("parts");
  list.replaceChildren();
  const all = document.createElement("span");
  all.className = "all buttons";
  for (const [word, shown] of [["all", true], ["none", false]]) {
    const button = document.createElement("button");
    button.type = "button";
    button.textContent = word;
    button.addEventListener("click", () => scene.nodes.forEach((row) => setVisible(row.name, shown)));
    all.append(button);
  }
  list.append(all);
  for (const row of scene.nodes) {
    const label = document.createElement("label"), tick = document.createElement("input"), patch = document.createElement("i");
    tick.type = "checkbox";
    tick.checked = row.shown;
    tick.dataset.part = row.name;
    tick.addEventListener("change", () => setVisible(row.name, tick.checked));
    patch.style.background = row.colour;
    label.append(tick, patch, row.name);
    list.append(label);
  }
}

// Takes away what lies nearer than a plane across the main axis that the camera looked along when it began.
function setCut(share) {
  if (share > 0 && !cutShare) {
    const from = camera.position.clone().sub(controls.target);
    const axis = ["x", "y", "z"].reduce((a, b) => Math.abs(from[b]) > Math.abs(from[a]) ? b : a);
    cutAxis = [axis, Math.sign(from[axis])];
  }
  cutShare = share;
  if (share > 0) {
    const [axis, side] = cutAxis, near = side > 0 ? box.max[axis] : box.min[axis];
    const span = box.max[axis] - box.min[axis];
    cutter.normal.set(0, 0, 0)[axis] = -side;
    cutter.constant = side * (near - side * share * span);
  }
  renderer.clippingPlanes = share > 0 ? [cutter] : [];
  for (const {mesh} of nodes) mesh.material.side = share > 0 ? THREE.DoubleSide : THREE.FrontSide;
  for (const {mesh} of nodes) mesh.material.needsUpdate = true;
  element("cut").value = 100 * share;
  element("cut-value").textContent = `${Math.round(100 * share)} %`;
  redraw();
}

function setOpacity(share) {
  for (const {row, mesh} of nodes) {
    if (row.role !== "exoskeleton") continue;
    Object.assign(mesh.material, {transparent: share < 1, opacity: share, depthWrite: share === 1, needsUpdate: true});
    mesh.renderOrder = share < 1 ? 1 : 0;
  }
  element("opacity").value = 100 * share;
  element("opacity-value").textContent = share < 1 ? `${Math.round(100 * share)} %` : "solid";
  redraw();
}
