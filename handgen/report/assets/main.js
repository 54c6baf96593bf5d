// Start: controls, lists, theme. `window.handgen` is for scripts: the same functions that the controls call.
function setTheme(name) {
  document.documentElement.dataset.theme = name;
}

// As the reader chose, else as the system is and becomes.
function openTheme() {
  const system = matchMedia("(prefers-color-scheme: dark)"), key = "handgen-theme";
  const ofSystem = () => system.matches ? "dark" : "light";
  let kept = null;
  try { kept = localStorage.getItem(key); } catch { /* a page without storage */ }
  setTheme(kept || ofSystem());
  system.addEventListener("change", () => { if (!kept) setTheme(ofSystem()); });
  element("theme").addEventListener("click", () => {
    kept = document.documentElement.dataset.theme === "dark" ? "light" : "dark";
    setTheme(kept);
    try { localStorage.setItem(key, kept); } catch { /* a page without storage */ }
  });
}

function openDownloads() {
  for (const button of document.querySelectorAll("button[data-download]")) {
    button.addEventListener("click", () => {
      const {name, type, text} = DATA.downloads[button.dataset.download];
      const link = document.createElement("a");
      link.href = URL.createObjectURL(new Blob([text], {type}));
      link.download = name;
      link.click();
      setTimeout(() => URL.revokeObjectURL(link.href), 1000);
    });
  }
}

function openFindings() {
  for (const item of document.querySelectorAll("ol.findings li[data-finding]")) {
    item.querySelector("button").addEventListener("click", () => choose(+item.dataset.finding, true));
  }
}

function openControls() {
  for (const each of DATA.scenes) element("scene").append(new Option(each.title, each.name));
  element("scene").addEventListener("change", (event) => showScene(event.target.value));
  for (const button of document.querySelectorAll("[data-look]")) {
    button.addEventListener("click", () => look(button.dataset.look));
  }
  const slide = (id, set) => element(id).addEventListener("input", (event) => set(+event.target.value));
  slide("explode", (value) => setExplode(value / 100));
  slide("cut", (value) => setCut(value / 100));
  slide("opacity", (value) => setOpacity(value / 100));
  slide("pressure", setPressure);
  element("stretch").addEventListener("change", () => setPressure(pressure));
  element("marking").addEventListener("change", placeMarkers);
  for (const button of document.querySelectorAll("[data-scene]")) {
    button.addEventListener("click", () => { showScene(button.dataset.scene); stage.scrollIntoView({block: "nearest"}); });
  }
}

function start() {
  openTheme();
  openDownloads();
  try {
    openStage();
  } catch (error) {
    element("failure").textContent = "This browser draws no 3D (WebGL is off); everything else on the page works.";
    element("failure").hidden = false;
    return;
  }
  openControls();
  openFindings();
  onDraw.push(moveMarkers);
  showScene(DATA.scenes[0].name);
  draw();
  window.handgen = {
    showScene, look, fit, setExplode, setPressure, setCut, setOpacity, setVisible, choose,
    camera, controls, box, stage, nodes: () => nodes, scene: () => scene, onto: (at) => onto(new THREE.Vector3(...at)),
  };
  performance.mark("handgen-ready");
}

start();
