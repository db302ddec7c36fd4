// Data of the page, and words for numbers.
const $ = id => document.getElementById(id), D = JSON.parse($("data").textContent);
const N = D.axis.length, S = D.s.length, F = D.fibres.length, MOVES = N > 1, TURNS = D.kind === "turn";

// 16-bit second differences along each curve, low bytes first, deflated; see `packed`.
async function unpacked({ row, scale, data }) {
  const zipped = Uint8Array.from(atob(data), letter => letter.charCodeAt(0));
  const opened = new Blob([zipped]).stream().pipeThrough(new DecompressionStream("deflate"));
  const bytes = new Uint8Array(await new Response(opened).arrayBuffer()), count = bytes.length / 2;
  const values = new Float32Array(count);
  for (let column = 0, i = 0; column < row; column++) {
    for (let k = 0, step = 0, sum = 0; k < N; k++, i++) {
      step += bytes[i] | bytes[count + i] << 8;
      sum = (sum + step) << 16 >> 16;
      values[k * row + column] = sum * scale;
    }
  }
  return { row, values };
}
const A = {};
await Promise.all(Object.entries(D.arrays).map(async ([name, array]) => { A[name] = await unpacked(array); }));

// The value of an array's column between two positions.
function at(array, place, column) {
  const k = Math.floor(place), share = place - k, { row, values } = array;
  const here = values[(k % N) * row + column];
  return share ? here * (1 - share) + values[((k + 1) % N) * row + column] * share : here;
}
const history = column => Array.from({ length: N }, (_, k) => column(k));
const cell = (m, j, f) => (m * S + j) * F + f;

const MORE = []; // what else is drawn anew with the plots

// Drive angle (degrees) or time (s) of a place, and back.
function along(place) {
  const k = Math.min(Math.floor(place), N - 1), next = (k + 1) % N;
  const step = TURNS ? ((D.axis[next] - D.axis[k]) % 360 + 360) % 360 : D.axis[next] - D.axis[k];
  return place === k ? D.axis[k] : D.axis[k] + (place - k) * step;
}
function placeOf(value) {
  if (TURNS && value < D.axis[0]) value += 360;
  let low = 0, high = N - 1;
  while (low < high) { const middle = (low + high + 1) >> 1; if (D.axis[middle] <= value) low = middle; else high = middle - 1; }
  if (!TURNS && low === N - 1) return N - 1;
  const step = (low < N - 1 ? D.axis[low + 1] : 360 + D.axis[0]) - D.axis[low]; // 0 from a peak just before 360
  return Math.max(0, Math.min(TURNS ? N - 1e-6 : N - 1, low + (step && (value - D.axis[low]) / step)));
}
const FROM = TURNS ? 0 : D.axis[0], TO = TURNS ? 360 : D.axis[N - 1];

function number(value, digits = 3) {
  if (!value) return "0";
  value = +value.toPrecision(digits); // so that one number has one rounding everywhere
  const size = Math.abs(value);
  if (size >= 1e6 || size < 1e-4) return value.toExponential(digits - 1).replaceAll("-", "\u2212");
  return (size >= 10 ** (digits - 1) ? value.toFixed(0) : value.toPrecision(digits)).replace("-", "\u2212");
}
const told = place => TURNS || !MOVES ? `${along(place).toFixed(0) % 360}°` : `${number(along(place))} s`;
const stationOf = (m, j) => j === 0 || j === S - 1 ? `at ${D.ends[m][j ? 1 : 0]}` : `${number(D.s[j] * D.lengths[m])} ${D.units.length} from ${D.ends[m][0]}`;

// What is shown now.
const peakStress = D.peaks.map(([k, j, f], m) => Math.abs(at(A.stress, k, cell(m, j, f))));
const BENDS = D.members.length > 0, LIMIT = Math.max(...peakStress, 0) || 1, WORST = peakStress.indexOf(Math.max(...peakStress));
const shown = { place: BENDS ? D.peaks[WORST][0] : 0, member: WORST, unit: "stress", other: -1, magnify: D.magnify, playing: false };
// What is shown of a member: stress or strain of a side, or a force in its sections.
const sentence = text => text[0].toUpperCase() + text.slice(1);
const whatOf = name => sentence(D.sections[name]?.[0] ?? name), unitOf = name => D.sections[name]?.[1] ?? D.units[name];
const unitName = () => unitOf(shown.unit), sided = name => !(name in D.sections);
const valueOf = (name, place, m, j, f) => at(A[name], place, sided(name) ? cell(m, j, f) : m * S + j);
const value = (place, m, j, f) => valueOf(shown.unit, place, m, j, f);
// Position, station and side where it is largest: of stresses and strains those of the peak stress.
const found = {};
function peakOf(m, name = shown.unit) {
  if (sided(name)) return D.peaks[m];
  return found[`${name} ${m}`] ??= (() => {
    let best = [0, 0, 0], most = -1;
    for (let k = 0; k < N; k++) for (let j = 0; j < S; j++) {
      const size = Math.abs(valueOf(name, k, m, j));
      if (size > most) [most, best] = [size, [k, j, 0]];
    }
    return best;
  })();
}
