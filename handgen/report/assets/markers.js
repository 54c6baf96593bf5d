// Findings of the rules as numbered markers on the model: buttons, so that a keyboard and a screen reader reach them.
let shownMarkers = [], chosen = null;

function placeMarkers() {
  const layer = element("markers");
  layer.replaceChildren();
  shownMarkers = [];
  if (!scene || !element("marking").checked) return;
  for (const {finding, at} of scene.markers) {
    const found = DATA.findings[finding];
    const node = nodes.find((each) => each.row.name === found.part);
    if (node && !node.mesh.visible) continue;
    const button = document.createElement("button");
    button.type = "button";
    button.className = found.severity;
    button.textContent = DATA.ranks[finding];
    button.dataset.finding = finding;
    button.title = `${found.rule}, ${found.part}: ${found.message}`;
    button.setAttribute("aria-label", `Finding ${DATA.ranks[finding]}, ${found.severity}: ${button.title}`);
    button.addEventListener("click", () => choose(finding, false));
    layer.append(button);
    shownMarkers.push({finding, button, at: new THREE.Vector3(...at), apart: node ? node.row.apart : [0, 0, 0]});
  }
  mark();
  moveMarkers();
}

function moveMarkers() {
  for (const {button, at, apart} of shownMarkers) {
    const [x, y] = onto(at.clone().addScaledVector(new THREE.Vector3(...apart), exploded));
    button.style.left = `${x}px`;
    button.style.top = `${y}px`;
  }
}

function mark() {
  for (const {finding, button} of shownMarkers) button.classList.toggle("chosen", finding === chosen);
  for (const item of document.querySelectorAll("ol.findings li")) {
    item.classList.toggle("chosen", +item.dataset.finding === chosen);
  }
}

// Shows a finding: its scene, its part, its place in the middle; `travel` brings the view to the reader.
function choose(finding, travel) {
  const home = DATA.scenes.find((each) => each.markers.some((marker) => marker.finding === finding));
  chosen = finding;
  if (home) {
    if (home !== scene) showScene(home.name);
    const found = DATA.findings[finding];
    element("marking").checked = true;
    if (nodes.some((each) => each.row.name === found.part && !each.mesh.visible)) setVisible(found.part, true);
    placeMarkers();
    const marker = shownMarkers.find((each) => each.finding === finding);
    if (marker && travel) {
      const middle = marker.at.clone().addScaledVector(new THREE.Vector3(...marker.apart), exploded);
      camera.position.add(middle.clone().sub(controls.target));
      controls.target.copy(middle);
      camera.zoom = Math.max(camera.zoom, 1.6);
      camera.updateProjectionMatrix();
      stage.scrollIntoView({block: "nearest"});
    }
  }
  mark();
  const item = document.querySelector(`ol.findings li[data-finding="${finding}"]`), folded = item && item.closest("details");
  if (folded) folded.open = true;
  if (item && !travel && matchMedia("(min-width: 901px)").matches) item.scrollIntoView({block: "nearest"});
  say(DATA.findings[finding]);
  redraw();
}

function say(found) {
  element("readout").textContent = `${found.severity} ${found.rule}, ${found.part}: ${found.message}`;
}
