// Asks the server of `handgen view`: tells what is wrong with the file, and takes up a newer page when there is one.
const EVERY = 700;
const news = document.getElementById("news");
const mine = +document.documentElement.dataset.serial;
const KEPT = "handgen-view";

function tell(title, lines, busy) {
  const content = [title, ...lines].join("\n");
  if (news.dataset.content === content) return;
  news.dataset.content = content;
  const head = document.createElement("b"), list = document.createElement("pre");
  head.textContent = title;
  list.textContent = lines.join("\n");
  news.replaceChildren(head, ...(lines.length ? [list] : []));
  news.classList.toggle("busy", busy);
  news.hidden = !title;
}

async function ask() {
  try {
    const state = await (await fetch("state", {cache: "no-store"})).json();
    if (state.serial > mine && !state.problems.length) return renew();
    if (state.problems.length) tell("The file has errors; below is the last design that had none.", state.problems, false);
    else tell(state.busy, [], true);
  } catch {
    tell("The server has ended: start `handgen view` again.", [], false);
  }
  setTimeout(ask, EVERY);
}

// The new page looks at the same scene from the same side.
function renew() {
  const page = window.handgen;
  if (page) {
    const {camera, controls} = page;
    sessionStorage.setItem(KEPT, JSON.stringify({
      scene: page.scene().name, from: camera.position.clone().sub(controls.target).toArray(), up: camera.up.toArray(),
      pressure: document.getElementById("pressure").value,
    }));
  }
  location.reload();
}

function restore() {
  const kept = sessionStorage.getItem(KEPT), page = window.handgen;
  if (!kept || !page) return;
  const {scene, from, up, pressure} = JSON.parse(kept);
  page.showScene(scene);
  page.setPressure(+pressure);
  page.camera.position.fromArray(from).add(page.controls.target);
  page.camera.up.fromArray(up);
  page.camera.lookAt(page.controls.target);
  page.fit();
}

restore();
ask();
