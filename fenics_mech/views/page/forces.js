// Joint forces, torque, frequencies, spectrum and stability: what belongs to the whole machine.
const vector = (array, n, size = array === A.force ? array.row / D.joints.length : 2) => place => Array.from({ length: size }, (_, c) => at(array, place, size * n + c));
function named(name, array, n) {
  const of = vector(array, n), sizes = history(place => Math.hypot(...of(place))), most = Math.max(...sizes);
  return { name, of, most, k: sizes.indexOf(most) };
}
const jointForces = D.joints.map((name, n) => named(name, A.force, n)), frameForce = A.shaking ? [named("on the frame", A.shaking, 0)] : [];
const MOST_FORCE = jointForces.reduce((best, force) => force.most > best.most ? force : best, { most: -1, k: 0 }).k;

// The path of a force's tip: its direction matters to a bearing.
function polar() {
  const host = $("forces");
  if (!host) return;
  host.textContent = "";
  [...frameForce, ...jointForces].forEach(({ name, of, most, k }) => {
    const figure = document.createElement("figure"), caption = document.createElement("figcaption"), R = 100;
    host.append(figure);
    const svg = draw("svg", { viewBox: "-116 -116 232 232", role: "img" }, figure);
    const tip = place => { const [x, y] = of(place); return [R * x / (most || 1), -R * y / (most || 1)]; };
    for (const share of [1, .5]) draw("circle", { r: R * share, class: "grid" }, svg);
    for (const turn of [0, 90]) draw("line", { x1: -R, x2: R, transform: `rotate(${turn})`, class: "grid" }, svg);
    draw("path", { class: "curve s0", d: path(Array.from({ length: TURNS ? N + 1 : N }, (_, i) => tip(i % N))) }, svg);
    const arrow = draw("line", { class: "arrow" }, svg), dot = draw("circle", { r: 5, class: "point" }, svg);
    draw("circle", { cx: tip(k)[0], cy: tip(k)[1], r: 7, class: "ring" }, svg);
    const hover = document.createElement("div");
    hover.className = "tip";
    hover.hidden = true;
    figure.append(hover, caption);
    svg.addEventListener("pointerleave", () => { hover.hidden = true; });
    svg.addEventListener("pointermove", event => { // of the point of the path that is nearest
      const frame = svg.getBoundingClientRect(), [px, py] = [(event.clientX - frame.left) / frame.width * 232 - 116, (event.clientY - frame.top) / frame.height * 232 - 116];
      const far = history(place => { const [x, y] = tip(place); return Math.hypot(x - px, y - py); }), near = far.indexOf(Math.min(...far)), [x, y] = of(near);
      hover.textContent = `${told(near)}: ${number(Math.hypot(x, y))} ${D.units.force} (${number(x)}, ${number(y)})`;
      hover.hidden = false;
    });
    const now = document.createElement("span"), strong = document.createElement("b"), rest = document.createElement("b");
    strong.textContent = name;
    rest.textContent = `${number(most)} ${D.units.force}`;
    caption.append(strong, now, document.createElement("br"), "largest ", rest, ` at ${told(k)}`);
    views.push(place => {
      const [x, y] = tip(place);
      for (const [key, v] of [["x2", x], ["y2", y]]) arrow.setAttribute(key, v);
      for (const [key, v] of [["cx", x], ["cy", y]]) dot.setAttribute(key, v);
      now.textContent = ` ${number(Math.hypot(...of(place)))} ${D.units.force} now`;
    });
  });
}
function effort() {
  if (!$("effort")) return;
  const values = history(place => at(A.effort, place, 0)), k = values.reduce((best, v, i) => Math.abs(v) > Math.abs(values[best]) ? i : best, 0);
  const plot = overMotion($("effort"), { y: range([values]), yName: D.effort[1] });
  curve(plot, values, { tell: D.effort[1] });
  ring(plot, D.axis[k], values[k], `${number(values[k])} at ${told(k)}`);
  once(plot);
}
function freedoms() {
  if (!$("freedoms")) return;
  $("freedoms").textContent = "";
  D.freedoms.forEach(([name, unit], n) => {
    const values = history(place => at(A.freedom, place, n)), host = document.createElement("div");
    $("freedoms").append(host);
    curve(overMotion(host, { y: range([values], false), yName: `${name} (${unit})`, height: 160 }), values, { tell: unit });
  });
}
function frequencies() {
  if (!$("frequency")) return;
  const modes = Array.from({ length: A.frequency.row }, (_, n) => history(place => at(A.frequency, place, n)));
  const plot = overMotion($("frequency"), { y: [0, range(modes)[1]], yName: "Hz", right: 64 });
  modes.forEach((values, n) => curve(plot, values, { colour: n, name: `mode ${n + 1}`, unit: "Hz" }));
  const places = modes.map((values, n) => ({ n, y: plot.Y(values[N - 1]) + 4 })).sort((a, b) => b.y - a.y);
  places.reduce((below, text) => { text.y = Math.min(text.y, below - 14); return text.y; }, Infinity);
  for (const { n, y } of places) draw("text", { x: plot.box.right + 6, y, class: `named f${n % 6}` }, plot.svg, `mode ${n + 1}`);
}
function spectrum() {
  if (!$("spectrum")) return;
  const heights = D.harmonics[shown.member], big = Math.max(...heights.slice(1)) || 1, drive = 1 / D.seconds;
  let last = heights.length - 1;
  while (last > 12 && heights[last] < .01 * big) last--;
  const whole = ticks(0, last, 8).filter(v => v && Number.isInteger(v));
  const plot = axes($("spectrum"), { x: [.4, last + .6], y: [0, big * 1.18], yName: D.units.strain, xName: "multiple of the drive’s frequency", xTicks: whole });
  const { box, svg, X, Y } = plot;
  let least = Infinity;
  for (let n = 0; A.frequency && n < A.frequency.row; n++) {
    const orders = history(place => at(A.frequency, place, n) / drive), from = Math.max(.4, Math.min(...orders)), to = Math.min(last + .6, Math.max(...orders));
    least = Math.min(least, ...orders);
    if (from >= last + .6 || to <= .4) continue;
    draw("rect", { x: X(from), width: Math.max(2, X(to) - X(from)), y: box.top, height: box.bottom - box.top, class: `mode f${(n + 1) % 6}` }, svg);
    draw("text", { x: (X(from) + X(to)) / 2, y: box.top + 12 + 13 * (n % 2), "text-anchor": "middle" }, svg, String(n + 1));
  }
  const modes = !A.frequency ? "" : least < last + .6 ? "; shaded: natural frequencies by mode" : `; natural frequencies lie beyond, from ${number(least)} times the drive on`;
  $("spectrum-where").textContent = `of the strain of ${D.members[shown.member]} where it is largest; drive ${number(drive)} Hz${modes}`;
  for (let n = 1; n <= last; n++) {
    const width = Math.max(2, .7 * (X(2) - X(1)));
    draw("rect", { x: X(n) - width / 2, width, y: Y(heights[n]), height: box.bottom - Y(heights[n]), class: "f0" }, svg);
  }
  plot.where = v => `${Math.round(v)} times the drive, ${number(Math.round(v) * drive)} Hz`;
  plot.read.push(v => heights[Math.round(v)] === undefined ? null : { text: `${number(heights[Math.round(v)])} ${D.units.strain}`, y: heights[Math.round(v)] });
}
function stability() {
  const host = $("stability");
  if (!host) return;
  host.textContent = "";
  const svg = draw("svg", { viewBox: "-130 -116 260 232", height: 220, role: "img" }, host);
  const most = Math.max(1, ...D.multipliers.map(([x, y]) => Math.hypot(x, y))), R = 100 / most;
  draw("circle", { r: R, class: "inside" }, svg);
  for (const turn of [0, 90]) draw("line", { x1: -108, x2: 108, transform: `rotate(${turn})`, class: "grid" }, svg);
  for (const [x, y] of D.multipliers) draw("circle", { cx: R * x, cy: -R * y, r: 5, class: Math.hypot(x, y) > 1 + 1e-6 ? "outside" : "f0" }, svg);
  draw("text", { x: .76 * R, y: -.8 * R }, svg, "1");
}
