// The mechanism in its plane: each side of a member in the colour of its stress.
const PIECES = 3; // of a ribbon between two stations

// Where a station, a pin or the end of a bar is drawn (m), its deflection magnified.
function station(place, m, j, times = shown.magnify) {
  const s = D.s[j], end = 4 * m, bent = 2 * (m * S + j);
  return [0, 1].map(c => (1 - s) * at(A.ends, place, end + c) + s * at(A.ends, place, end + 2 + c) + times * at(A.bent, place, bent + c));
}
const moved = (rigid, bent) => (place, n, times = shown.magnify) => [0, 1].map(c => at(rigid, place, 2 * n + c) + times * at(bent, place, 2 * n + c));
const pin = moved(A.pins, A.pins_bent), corner = moved(A.bars, A.bars_bent);
const tracer = moved(A.traced, A.traced_bent), rail = moved(A.rails, A.rails_bent), RAILS = A.rails.row / 4, BARS = A.bars.row / 4;

// The scale that holds the mechanism in all places.
function fit() {
  let [left, right, low, high] = [Infinity, -Infinity, Infinity, -Infinity];
  const see = ([x, y]) => { left = Math.min(left, x); right = Math.max(right, x); low = Math.min(low, y); high = Math.max(high, y); };
  for (let k = 0; k < N; k += Math.max(1, N >> 7)) {
    for (let m = 0; m < D.members.length; m++) for (const j of [0, S >> 1, S - 1]) see(station(k, m, j));
    for (let n = 0; n < 2 * BARS; n++) see(corner(k, n));
    D.names.forEach((_, n) => see(pin(k, n)));
    for (let n = 0; n < 2 * RAILS; n++) see(rail(k, n));
    D.traced.forEach((_, n) => see(tracer(k, n)));
  }
  D.ground.forEach(see);
  D.tracks.flat().forEach(see);
  const width = canvas.clientWidth || 500, pad = 34, sharp = Math.max(devicePixelRatio, 2);
  const most = window.innerWidth < 900 ? window.innerHeight * .5 : 470;
  const height = Math.max(220, Math.min((width - 2 * pad) * (high - low) / (right - left || 1) + 2 * pad, most + 20));
  const scale = Math.min((width - 2 * pad) / (right - left || 1e-9), (height - 2 * pad) / (high - low || 1e-9));
  canvas.style.height = `${height}px`;
  canvas.width = width * sharp;
  canvas.height = height * sharp;
  const x = v => width / 2 + (v - (left + right) / 2) * scale, y = v => height / 2 - (v - (low + high) / 2) * scale;
  frame = { width, height, sharp, to: ([a, b]) => [x(a), y(b)], half: Math.max(3, Math.min(7, width / 80, 260 / (D.members.length + BARS))) };
}
function support(point) {
  const [x, y] = frame.to(point), u = 2.2 * frame.half;
  Object.assign(pen, { strokeStyle: inks.soft, fillStyle: inks.line, lineWidth: 1.4 });
  pen.beginPath();
  pen.moveTo(x, y);
  pen.lineTo(x - u * .8, y + u * 1.4);
  pen.lineTo(x + u * .8, y + u * 1.4);
  pen.closePath();
  pen.fill();
  pen.stroke();
  pen.beginPath();
  for (let i = -4; i < 4; i++) { pen.moveTo(x + i * u * .3, y + u * 1.9); pen.lineTo(x + (i + 1.2) * u * .3, y + u * 1.4); }
  pen.moveTo(x - u * 1.2, y + u * 1.4);
  pen.lineTo(x + u * 1.2, y + u * 1.4);
  pen.stroke();
}
function block(place, n, i) {
  const [x, y] = frame.to(pin(place, n)), w = frame.half;
  pen.save();
  pen.translate(x, y);
  pen.rotate(-Math.atan2(at(A.guides, place, 2 * i + 1), at(A.guides, place, 2 * i)));
  Object.assign(pen, { fillStyle: inks.line, strokeStyle: inks.ink, lineWidth: 1.4 });
  pen.beginPath();
  pen.rect(-3.4 * w, -2.1 * w, 6.8 * w, 4.2 * w);
  pen.fill();
  pen.stroke();
  pen.restore();
}

// A member as a ribbon: the + side lies along its normal, 90 degrees counter-clockwise of its axis.
function ribbon(place, m) {
  const points = D.s.map((_, j) => frame.to(station(place, m, j))), w = frame.half;
  const normals = points.map((_, j) => {
    const [a, b] = [points[Math.max(j - 1, 0)], points[Math.min(j + 1, S - 1)]], length = Math.hypot(b[0] - a[0], b[1] - a[1]) || 1;
    return [(b[1] - a[1]) / length, -(b[0] - a[0]) / length];
  });
  pen.beginPath();
  points.forEach((p, j) => pen[j ? "lineTo" : "moveTo"](...p));
  Object.assign(pen, { strokeStyle: inks.ink, lineWidth: 2 * w + (m === shown.member ? 5 : 2.6) });
  pen.stroke();
  const between = (list, j, share) => [0, 1].map(c => list[j][c] * (1 - share) + list[j + 1][c] * share);
  for (let j = 0; j < S - 1; j++) for (let f = 0; f < F; f++) {
    const out = (f ? -1 : 1) * w, a = at(A.stress, place, cell(m, j, f)), b = at(A.stress, place, cell(m, j + 1, f));
    for (let q = 0; q < PIECES; q++) {
      const from = q / PIECES, to = Math.min(1.03, (q + 1.25) / PIECES), p = [from, to].map(share => between(points, j, share));
      const n = [from, Math.min(1, to)].map(share => between(normals, j, share));
      pen.beginPath();
      pen.moveTo(...p[0]);
      pen.lineTo(...p[1]);
      pen.lineTo(p[1][0] + out * n[1][0], p[1][1] + out * n[1][1]);
      pen.lineTo(p[0][0] + out * n[0][0], p[0][1] + out * n[0][1]);
      pen.fillStyle = colourOf(a + (b - a) * (q + .5) / PIECES);
      pen.fill();
    }
  }
}
// Paths of the points that the scene traces, which are not magnified, and where they are now.
function traced(place) {
  const path = n => Array.from({ length: 241 }, (_, i) => tracer(i * (N - (TURNS ? 0 : 1)) / 240, n, 1));
  D.traced.forEach((_, n) => { if (MOVES) stroke(path(n), inks.c1, 1.6); });
  D.traced.forEach((name, n) => {
    const [x, y] = frame.to(tracer(place, n));
    disc([x, y], 4, inks.c1, inks.card);
    label(name, x + 9, y - 9, "left");
  });
}
function arrows(place) {
  const most = Math.max(...jointForces.map(force => force.most)) || 1;
  jointForces.forEach((force, n) => {
    if (D.pin_of[n] < 0) return;
    const [fx, fy] = force.of(place), length = Math.hypot(fx, fy) / most * 90, angle = Math.atan2(-fy, fx);
    const [x, y] = frame.to(pin(place, D.pin_of[n])), tip = [x + length * Math.cos(angle), y + length * Math.sin(angle)];
    Object.assign(pen, { strokeStyle: inks.c2, fillStyle: inks.c2, lineWidth: 2.5 });
    pen.beginPath();
    pen.moveTo(x, y);
    pen.lineTo(...tip);
    pen.stroke();
    pen.beginPath();
    pen.moveTo(...tip);
    for (const turn of [2.7, -2.7]) pen.lineTo(tip[0] + 10 * Math.cos(angle + turn), tip[1] + 10 * Math.sin(angle + turn));
    pen.fill();
  });
}
// Loads end where they act; weights begin at centres of mass. Each kind has its own scale, its largest is named.
function arrow([x, y], [fx, fy], pixels, colour, ends) {
  const size = Math.hypot(fx, fy) * pixels;
  if (size < 2) return null;
  const angle = Math.atan2(-fy, fx), along = [Math.cos(angle), Math.sin(angle)], back = ends ? size : 0, head = Math.min(9, size);
  const tail = [x - back * along[0], y - back * along[1]], tip = [tail[0] + size * along[0], tail[1] + size * along[1]];
  Object.assign(pen, { strokeStyle: colour, fillStyle: colour, lineWidth: 2 });
  pen.beginPath();
  pen.moveTo(...tail);
  pen.lineTo(...tip);
  pen.stroke();
  pen.beginPath();
  pen.moveTo(...tip);
  for (const turn of [2.7, -2.7]) pen.lineTo(tip[0] + head * Math.cos(angle + turn), tip[1] + head * Math.sin(angle + turn));
  pen.fill();
  return ends ? tail : tip;
}
function acting(place) {
  const names = D.acts.loads ?? [], weights = D.acts.weights ?? [], heaviest = weights.length && D.acts.weight_sizes.indexOf(1);
  const where = (rigid, bent, column) => frame.to([0, 1].map(c => at(rigid, place, column + c) + shown.magnify * at(bent, place, 2 * Math.floor(column / 4) + c)));
  names.forEach((name, n) => {
    const force = [0, 1].map(c => at(A.loads, place, 4 * n + 2 + c)), end = arrow(where(A.loads, A.loads_bent, 4 * n), force, 60, inks.c1, true);
    if (end && name) label(name, end[0], Math.max(10, end[1] - 10), "center");
  });
  weights.forEach((text, n) => {
    const at_ = [0, 1].map(c => at(A.weights, place, 2 * n + c) + shown.magnify * at(A.weights_bent, place, 2 * n + c));
    const end = arrow(frame.to(at_), D.acts.down.map(part => part * D.acts.weight_sizes[n]), 50, inks.soft, false);
    if (end && n === heaviest) label(text, end[0] + 8, end[1], "left");
  });
}
function mechanism(place) {
  const w = frame.half;
  pen.setTransform(frame.sharp, 0, 0, frame.sharp, 0, 0);
  pen.clearRect(0, 0, frame.width, frame.height);
  pen.lineJoin = pen.lineCap = "round";
  if (MOVES) D.names.forEach((_, n) => stroke(Array.from({ length: 121 }, (_, i) => pin(i * (N - (TURNS ? 0 : 1)) / 120, n, 0)), inks.line, 1.2));
  D.tracks.forEach(track => stroke(track, inks.soft, 1.6));
  D.members.forEach((_, m) => stroke([station(place, m, 0, 0), station(place, m, S - 1, 0)], inks.soft, 1, [4, 4]));
  for (let n = 0; n < RAILS; n++) stroke([rail(place, 2 * n), rail(place, 2 * n + 1)], inks.soft, 2.4);
  D.ground.forEach(support);
  for (let n = 0; n < BARS; n++) stroke([corner(place, 2 * n), corner(place, 2 * n + 1)], inks.soft, 2 * w);
  D.sliders.forEach((n, i) => block(place, n, i));
  [...D.members.keys()].sort((a, b) => (a === shown.member) - (b === shown.member)).forEach(m => ribbon(place, m));
  D.names.forEach((_, n) => disc(frame.to(pin(place, n)), w * .95, inks.card, inks.ink));
  traced(place);
  if ($("acting")?.checked) acting(place);
  if ($("arrows").checked) arrows(place);
  const taken = [];  // a name that would cover another is left out: at another angle it has room
  D.names.forEach((name, n) => {
    if (D.names.length > 12 && name.length > 2) return;
    const [x, y] = frame.to(pin(place, n));
    if (taken.some(([across, up]) => Math.abs(across - x) < 18 && Math.abs(up - y) < 13)) return;
    taken.push([x, y]);
    label(name, x - 2.6 * w - 3, y - 2 * w - 3, "center");
  });
  if (!BENDS) return;
  const [, j, f] = D.peaks[WORST], [x, y] = frame.to(station(place, WORST, j)), right = x < frame.width * .6;
  disc([x, y], 2.5 * w, null, inks.ink);
  label(`${number(at(A.stress, place, cell(WORST, j, f)))} ${D.units.stress}`, x + (right ? 1 : -1) * (2.5 * w + 6), y + 2.6 * w, right ? "left" : "right");
}
function nearestMember(x, y) {
  const far = D.members.map((_, m) => Math.min(...D.s.map((_, j) => { const [a, b] = frame.to(station(shown.place, m, j)); return Math.hypot(a - x, b - y); })));
  const m = far.indexOf(Math.min(...far));
  return far[m] < 25 ? m : -1;
}
