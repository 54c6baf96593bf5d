// What the page shows, and its numbers: arrays of one base64 buffer, found by place, length and type.
const DATA = JSON.parse(document.getElementById("data").textContent);
const KINDS = {u1: Uint8Array, i1: Int8Array, u2: Uint16Array, u4: Uint32Array};
const BYTES = (() => {
  const text = atob(document.getElementById("buffer").textContent);
  const bytes = new Uint8Array(text.length);
  for (let i = 0; i < text.length; i++) bytes[i] = text.charCodeAt(i);
  return bytes.buffer;
})();
const element = (id) => document.getElementById(id);

function numbers(place) {
  return new KINDS[place.type](BYTES, place.at, place.length);
}

// Coordinates in mm of steps within a box; `from` and `count` choose some of the points.
function points(place, from = 0, count = place.length / 3) {
  const steps = numbers(place), found = new Float32Array(3 * count);
  for (let i = 0; i < found.length; i++) {
    found[i] = place.low[i % 3] + place.step[i % 3] * steps[3 * from + i];
  }
  return found;
}
