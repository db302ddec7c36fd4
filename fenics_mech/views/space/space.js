// The linkage in space on a canvas: turned by the pointer, zoomed by the wheel or two fingers, played over the cycle.
const PIECES = 3, JOINTS = D.joints.length; // pieces of a member between two stations
const EYES = { x: [0, 0], y: [-90, 0], z: [-90, 90], isometric: [-45, 35.264] }; // azimuth and height of the eye (degrees)
const eye = { turn: -52, tilt: 24, zoom: 1, right: [], up: [], toward: [] };
const dot3 = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];

function look(turn, tilt) {
  const [a, b] = [turn, Math.max(-90, Math.min(90, tilt))].map(v => v * Math.PI / 180);
  const [ca, sa, cb, sb] = [Math.cos(a), Math.sin(a), Math.cos(b), Math.sin(b)];
  Object.assign(eye, { turn, tilt: b * 180 / Math.PI, right: [-sa, ca, 0], up: [-ca * sb, -sa * sb, cb], toward: [ca * cb, sa * cb, sb] });
}
look(eye.turn, eye.tilt);

// Where a station, or a joint's point on its first (2 n) or second link, is drawn (m), its deflection magnified.
function station(place, m, j, times = shown.magnify) {
  const s = D.s[j], end = 6 * m, bent = 3 * (m * S + j);
  return [0, 1, 2].map(c => (1 - s) * at(A.ends, place, end + c) + s * at(A.ends, place, end + 3 + c) + times * at(A.bent, place, bent + c));
}
const point = (place, n, times = shown.magnify) => [0, 1, 2].map(c => at(A.pins, place, 3 * n + c) + times * at(A.pins_bent, place, 3 * n + c));
const pin = (place, n, times) => point(place, 2 * n + 1, times);

let box = null; // corners of all places
function everyPlace() {
  const found = [...D.ground];
  for (let k = 0; k < N; k += Math.max(1, N >> 6)) {
    for (let m = 0; m < D.members.length; m++) for (const j of [0, S >> 1, S - 1]) found.push(station(k, m, j));
    for (let n = 0; n < 2 * JOINTS; n++) found.push(point(k, n));
  }
  return found;
}
function fit() {
  const places = everyPlace(), low = [0, 1, 2].map(c => Math.min(...places.map(p => p[c]))), high = [0, 1, 2].map(c => Math.max(...places.map(p => p[c])));
  const centre = low.map((v, c) => (v + high[c]) / 2), width = canvas.clientWidth || 500, sharp = Math.max(devicePixelRatio, 2), pad = 40;
  const height = window.innerWidth < 900 ? Math.max(240, Math.min(width * .8, window.innerHeight * .5)) : Math.max(320, Math.min(width * .75, 470));
  for (const x of [low[0], high[0]]) for (const y of [low[1], high[1]]) places.push([x, y, low[2]]); // the floor
  const reach = axis => Math.max(...places.map(p => Math.abs(dot3(p, axis) - dot3(centre, axis))), 1e-9);
  const scale = Math.min((width / 2 - pad) / reach(eye.right), (height / 2 - pad) / reach(eye.up));
  box = { low, high };
  canvas.style.height = `${height}px`;
  canvas.width = width * sharp;
  canvas.height = height * sharp;
  const along = (p, axis) => (dot3(p, axis) - dot3(centre, axis)) * scale * eye.zoom;
  frame = { width, height, sharp, to: p => [width / 2 + along(p, eye.right), height / 2 - along(p, eye.up)], half: Math.max(3, Math.min(6, width / 90)) };
}

// A member as a line in the colours of its stress.
function beam(place, m) {
  const points = D.s.map((_, j) => station(place, m, j)), flat = points.map(p => frame.to(p));
  pen.lineCap = "round";
  stroke(points, inks.ink, 2 * frame.half + (m === shown.member ? 5 : 2.6));
  pen.lineCap = "butt";
  for (let j = 0; j < S - 1; j++) for (let q = 0; q < PIECES; q++) {
    const a = at(A.stress, place, cell(m, j, 0)), b = at(A.stress, place, cell(m, j + 1, 0));
    const [from, to] = [q / PIECES, Math.min(1.03, (q + 1.25) / PIECES)].map(share => [0, 1].map(c => flat[j][c] * (1 - share) + flat[j + 1][c] * share));
    Object.assign(pen, { strokeStyle: colourOf(a + (b - a) * (q + .5) / PIECES), lineWidth: 2 * frame.half });
    pen.beginPath();
    pen.moveTo(...from);
    pen.lineTo(...to);
    pen.stroke();
  }
}
function support(p) {
  const [x, y] = frame.to(p), u = 2.2 * frame.half;
  Object.assign(pen, { fillStyle: inks.line, strokeStyle: inks.soft, lineWidth: 1.4 });
  pen.beginPath();
  if (eye.tilt > 60) pen.rect(x - u, y - u, 2 * u, 2 * u);
  else { pen.moveTo(x, y); pen.lineTo(x - u, y + 1.5 * u); pen.lineTo(x + u, y + 1.5 * u); pen.closePath(); }
  pen.fill();
  pen.stroke();
}
function arrow([x, y], [dx, dy], colour, width) {
  const angle = Math.atan2(dy, dx), tip = [x + dx, y + dy], head = Math.min(9, Math.hypot(dx, dy));
  Object.assign(pen, { strokeStyle: colour, fillStyle: colour, lineWidth: width });
  pen.beginPath();
  pen.moveTo(x, y);
  pen.lineTo(...tip);
  pen.stroke();
  pen.beginPath();
  pen.moveTo(...tip);
  for (const turn of [2.7, -2.7]) pen.lineTo(tip[0] + head * Math.cos(angle + turn), tip[1] + head * Math.sin(angle + turn));
  pen.fill();
}
const onScreen = (way, size) => [size * dot3(way, eye.right), -size * dot3(way, eye.up)];
function triad() {
  ["X", "Y", "Z"].forEach((name, c) => {
    const way = [0, 1, 2].map(i => +(i === c)), tip = onScreen(way, 30);
    if (Math.hypot(...tip) < 4) return;
    arrow([44, frame.height - 40], tip, inks.soft, 1.6);
    label(name, 44 + 1.4 * tip[0], frame.height - 40 + 1.4 * tip[1], "center");
  });
}
// The floor below all, with the shadow of the linkage, by which depth is seen.
function floor(place) {
  const [[a, b, c], [d, e]] = [box.low, box.high], down = p => [p[0], p[1], c];
  stroke([[a, b, c], [d, b, c], [d, e, c], [a, e, c], [a, b, c]], inks.line, 1);
  D.members.forEach((_, m) => stroke(D.s.map((_, j) => down(station(place, m, j))), inks.line, 1.4 * frame.half));
  D.bars.forEach(bar => stroke(bar.map(n => down(point(place, n))), inks.line, 1.4 * frame.half));
}
function mechanism(place) {
  pen.setTransform(frame.sharp, 0, 0, frame.sharp, 0, 0);
  pen.clearRect(0, 0, frame.width, frame.height);
  pen.lineJoin = pen.lineCap = "round";
  floor(place);
  if (MOVES) D.joints.forEach((_, n) => stroke(Array.from({ length: 121 }, (_, i) => pin(i * (TURNS ? N : N - 1) / 120, n, 0)), inks.line, 1.2));
  D.members.forEach((_, m) => stroke([station(place, m, 0, 0), station(place, m, S - 1, 0)], inks.soft, 1, [4, 4]));
  D.ground.forEach(support);
  const parts = D.members.map((_, m) => ({ depth: dot3(station(place, m, S >> 1), eye.toward), draw: () => beam(place, m) }));
  D.bars.forEach(bar => parts.push({ depth: dot3(point(place, bar[0] ?? 0), eye.toward), draw: () => { pen.lineCap = "round"; stroke(bar.map(n => point(place, n)), inks.soft, 2 * frame.half); } }));
  parts.sort((a, b) => a.depth - b.depth).forEach(part => part.draw());
  D.joints.map((_, n) => [n, pin(place, n)]).sort(([, a], [, b]) => dot3(a, eye.toward) - dot3(b, eye.toward)).forEach(([n, p]) => {
    stroke([point(place, 2 * n), p], inks.soft, 2);
    disc(frame.to(p), frame.half * .95, D.kinds[n] === "ball" ? inks.ink : inks.card, inks.ink);
  });
  if ($("arrows").checked) jointForces.forEach((force, n) => {
    const most = Math.max(...jointForces.map(one => one.most)) || 1;
    arrow(frame.to(pin(place, n)), onScreen(force.of(place), 90 / most), inks.c2, 2.5);
  });
  const taken = [];
  D.joints.forEach((name, n) => {
    const [x, y] = frame.to(pin(place, n));
    if (taken.some(([across, up]) => Math.abs(across - x) < 18 && Math.abs(up - y) < 13)) return;
    taken.push([x, y]);
    label(name, x - 2.6 * frame.half - 3, y - 2 * frame.half - 3, "center");
  });
  triad();
  if (!BENDS) return;
  const [, j] = D.peaks[WORST], [x, y] = frame.to(station(place, WORST, j)), right = x < frame.width * .6;
  disc([x, y], 2.5 * frame.half, null, inks.ink);
  label(`${number(at(A.stress, place, cell(WORST, j, 0)))} ${D.units.stress}`, x + (right ? 1 : -1) * (2.5 * frame.half + 6), y + 2.6 * frame.half, right ? "left" : "right");
}
function nearestMember(x, y) {
  const far = D.members.map((_, m) => Math.min(...D.s.map((_, j) => { const [a, b] = frame.to(station(shown.place, m, j)); return Math.hypot(a - x, b - y); })));
  const m = far.indexOf(Math.min(...far));
  return far[m] < 25 ? m : -1;
}

// Turning and zooming.
const fingers = new Map();
let dragged = false;
const zoom = factor => { eye.zoom = Math.max(.3, Math.min(20, eye.zoom * factor)); mechanism(shown.place); };
canvas.addEventListener("pointerdown", event => { fingers.set(event.pointerId, [event.clientX, event.clientY]); canvas.setPointerCapture(event.pointerId); dragged = false; });
canvas.addEventListener("pointermove", event => {
  const before = fingers.get(event.pointerId), now = [event.clientX, event.clientY];
  if (!before) return;
  const [other] = [...fingers].filter(([id]) => id !== event.pointerId).map(([, p]) => p);
  if (other) zoom(Math.hypot(now[0] - other[0], now[1] - other[1]) / (Math.hypot(before[0] - other[0], before[1] - other[1]) || 1));
  else if (dragged || Math.hypot(now[0] - before[0], now[1] - before[1]) > 3) {
    dragged = true;
    look(eye.turn - .5 * (now[0] - before[0]), eye.tilt + .5 * (now[1] - before[1]));
    mechanism(shown.place);
  } else return;
  fingers.set(event.pointerId, now);
});
for (const ended of ["pointerup", "pointercancel"]) canvas.addEventListener(ended, event => fingers.delete(event.pointerId));
canvas.addEventListener("click", event => { if (dragged) event.stopImmediatePropagation(); }, true);
canvas.addEventListener("wheel", event => { event.preventDefault(); zoom(Math.exp(-event.deltaY / 500)); }, { passive: false });
for (const name of Object.keys(EYES)) $(`eye-${name}`).onclick = () => { look(...EYES[name]); eye.zoom = 1; fit(); show(); };

// Curves of several names over the cycle, in one plot.
function curvesIn(id, array, names, unit, withZero) {
  if (!$(id)) return;
  const all = names.map((_, n) => history(place => at(array, place, n))), many = names.length > 1;
  const plot = overMotion($(id), { y: range(all, withZero), yName: unit, right: many ? 64 : 12 });
  all.forEach((values, n) => curve(plot, values, { colour: n, name: many ? names[n] : "", unit, tell: many ? undefined : unit }));
  const places = many ? all.map((values, n) => ({ n, y: plot.Y(values[N - 1]) + 4 })).sort((a, b) => b.y - a.y) : [];
  places.reduce((below, text) => { text.y = Math.min(text.y, below - 14); return text.y; }, Infinity);
  for (const { n, y } of places) draw("text", { x: plot.box.right + 6, y, class: `named f${n % 6}` }, plot.svg, names[n]);
}
MORE.push(() => curvesIn("joint-forces", A.size, D.joints, D.units.force));
D.efforts.forEach(([, unit], n) => MORE.push(() => curvesIn(`effort-${n}`, A[`effort_${n}`], [""], unit)));
