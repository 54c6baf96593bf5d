// The 3D view: camera, light, turning by pointer and keys. Drawn when something changed, not all the time.
const TURN = 12 * Math.PI / 180;
const FILLED = 0.92;
const LOOKS = {  // from where, and what points up, in the scene's axes: x to the fingertips, z dorsal
  palm: [[0, 0, -1], [1, 0, 0]], back: [[0, 0, 1], [1, 0, 0]], side: [[0, 1, 0.0001], [0, 0, 1]], tip: [[1, 0, 0], [0, 0, 1]],
  start: [[-0.25, 0.55, -0.8], [1, 0, 0]], mould: [[-0.3, -0.85, 0.5], [0, 0, 1]], bend: [[0.45, -0.8, 0.3], [0, 0, 1]],
};
const LETTERS = {p: "palm", b: "back", s: "side", t: "tip"};
const stage = element("stage");
const world = new THREE.Scene();
const camera = new THREE.OrthographicCamera(-1, 1, 1, -1, -5000, 5000);
const box = new THREE.Box3();  // of what is shown, as it stands
const onDraw = [];
let renderer = null, controls = null, stale = true;

function openStage() {
  renderer = new THREE.WebGLRenderer({antialias: true, alpha: true, preserveDrawingBuffer: true});
  renderer.outputEncoding = THREE.sRGBEncoding;
  renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
  renderer.domElement.setAttribute("aria-hidden", "true");
  stage.prepend(renderer.domElement);
  const lamp = new THREE.DirectionalLight(0xffffff, 0.8);
  lamp.position.set(-0.4, 0.7, 1.2);
  camera.add(lamp);
  world.add(camera, new THREE.HemisphereLight(0xffffff, 0xa8a4b0, 0.5));
  controls = new THREE.TrackballControls(camera, stage);
  Object.assign(controls, {staticMoving: true, rotateSpeed: 3, zoomSpeed: 1.4, keys: ["", "", ""], minZoom: 0.2});
  controls.addEventListener("change", redraw);
  stage.addEventListener("keydown", pressed);
  new ResizeObserver(resized).observe(stage);
  resized();
  const step = () => {
    controls.update();
    if (stale) draw();
    requestAnimationFrame(step);
  };
  requestAnimationFrame(step);
}

function redraw() {
  stale = true;
}

function draw() {
  stale = false;
  camera.updateMatrixWorld();
  renderer.render(world, camera);
  for (const each of onDraw) each();
}

function resized() {
  const {clientWidth: wide, clientHeight: high} = stage;
  if (!wide || !high) return;
  renderer.setSize(wide, high, false);
  const tall = (camera.top - camera.bottom) / 2;
  camera.left = -tall * wide / high;
  camera.right = tall * wide / high;
  camera.updateProjectionMatrix();
  controls.handleResize();
  redraw();
}

// Looks at everything that is shown, from where the name says.
function look(name) {
  const [from, up] = LOOKS[name];
  aim(new THREE.Vector3(...from), new THREE.Vector3(...up));
  fit();
}

function aim(from, up) {
  const far = 1000;
  camera.position.copy(controls.target).addScaledVector(from.clone().normalize(), far);
  camera.up.copy(up);
  camera.lookAt(controls.target);
  redraw();
}

// Everything that is shown into the middle, by its corners as the camera sees them; what moves in all its states.
function fit() {
  camera.updateMatrixWorld();
  const low = new THREE.Vector2(Infinity, Infinity), high = new THREE.Vector2(-Infinity, -Infinity);
  const corner = new THREE.Vector3(), seen = new THREE.Matrix4();
  for (const {row, mesh} of nodes) {
    if (!mesh.visible) continue;
    const places = row.states && row.states.length ? everyState(row) : mesh.geometry.attributes.position.array;
    const count = places.length / 3, stride = Math.ceil(count / 2000);
    seen.multiplyMatrices(camera.matrixWorldInverse, mesh.matrix);
    for (let i = 0; i < count; i += stride) {
      corner.fromArray(places, 3 * i).applyMatrix4(seen);
      low.min(corner);
      high.max(corner);
    }
  }
  if (low.x > high.x) return;
  const shift = new THREE.Vector3((low.x + high.x) / 2, (low.y + high.y) / 2, 0);
  shift.applyMatrix4(camera.matrixWorld).sub(camera.position);
  camera.position.add(shift);
  controls.target.add(shift);
  const wide = (high.x - low.x) / 2, half = (high.y - low.y) / 2;
  const tall = Math.max(half, wide * stage.clientHeight / Math.max(stage.clientWidth, 1), 1) / FILLED;
  Object.assign(camera, {top: tall, bottom: -tall, zoom: 1});
  resized();
}

// Turns about an axis of the screen.
function turn(x, y, angle) {
  const axis = new THREE.Vector3(x, y, 0).transformDirection(camera.matrixWorld);
  const away = camera.position.clone().sub(controls.target).applyAxisAngle(axis, angle);
  camera.position.copy(controls.target).add(away);
  camera.up.applyAxisAngle(axis, angle);
  camera.lookAt(controls.target);
  redraw();
}

function closer(factor) {
  camera.zoom = Math.min(Math.max(camera.zoom * factor, 0.2), 60);
  camera.updateProjectionMatrix();
  redraw();
}

// Pixels of the stage, from its upper left, of a place in the scene.
function onto(place) {
  const seen = place.clone().project(camera);
  return [(seen.x + 1) / 2 * stage.clientWidth, (1 - seen.y) / 2 * stage.clientHeight];
}

function pressed(event) {
  if (event.ctrlKey || event.metaKey || event.altKey) return;
  const moves = {
    ArrowLeft: () => turn(0, 1, -TURN), ArrowRight: () => turn(0, 1, TURN),
    ArrowUp: () => turn(1, 0, -TURN), ArrowDown: () => turn(1, 0, TURN),
    "+": () => closer(1.2), "=": () => closer(1.2), "-": () => closer(1 / 1.2), 0: fit,
    e: () => setExplode(exploded > 0 ? 0 : 1),
  };
  const key = event.key.length === 1 ? event.key.toLowerCase() : event.key;
  const move = moves[key] || (LETTERS[key] && (() => look(LETTERS[key])));
  if (!move) return;
  event.preventDefault();
  move();
}
