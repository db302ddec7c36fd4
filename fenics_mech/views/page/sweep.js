// The page of a sweep: peaks over the swept number, and the curves over the cycle at the point of the slider.
const W = D.sweep, P = W.values.length, missing = k => W.state[k] === "no answer", loose = k => W.state[k] === "unstable";
const peakStrain = Array.from({ length: P }, (_, k) => missing(k) || loose(k) ? -1 : Math.max(...W.peaks.strain[k]));
let chosen = peakStrain.indexOf(Math.max(...peakStrain)), of = { member: 0, unit: "stress", joint: 0 };
of.member = W.peaks.strain[chosen].indexOf(Math.max(...W.peaks.strain[chosen]));

function stop() {}
function go(place) {
  shown.place = (place % N + N) % N;
  views.forEach(view => view(shown.place));
}
// Columns of an array at a point, and its values over the cycle.
const overCycle = (name, k, i, count) => history(place => at(A[name], place, k * count + i));
const everywhere = (name, i, count) => W.values.flatMap((_, k) => missing(k) ? [] : overCycle(name, k, i, count));

// A curve over the swept number: whole where motions are stable, dashed with rings where they are not, open where none is.
function overNumber(plot, values, colour, name, unit) {
  const parts = { whole: [], loose: [] };
  values.forEach((v, k) => {
    if (v === null) return;
    const before = k && values[k - 1] !== null, kind = loose(k) || before && loose(k - 1) ? "loose" : "whole";
    parts[kind].push(`${before ? `M${plot.X(W.values[k - 1]).toFixed(1)} ${plot.Y(values[k - 1]).toFixed(1)}L` : "M"}${plot.X(W.values[k]).toFixed(1)} ${plot.Y(v).toFixed(1)}`);
    if (loose(k)) draw("circle", { cx: plot.X(W.values[k]), cy: plot.Y(v), r: 3, class: `open s${colour % 6}` }, plot.svg);
  });
  draw("path", { d: parts.whole.join(""), class: `curve s${colour % 6}` }, plot.svg);
  draw("path", { d: parts.loose.join(""), class: `curve loose s${colour % 6}` }, plot.svg);
  plot.read.push(v => {
    const k = nearest(v);
    return values[k] === null ? null : { text: `${name} ${number(values[k])} ${unit}`, y: values[k], colour };
  });
}
const nearest = v => W.values.reduce((best, x, k) => Math.abs(x - v) < Math.abs(W.values[best] - v) ? k : best, 0);

function overview() {
  const peaks = W.peaks[of.unit], unit = D.units[of.unit], curves = W.members.map((_, i) => peaks.map(line => line[i]));
  titled("over", `Largest ${of.unit} in a cycle`, W.state.some(one => one === "unstable") ? "dashed with rings: unstable motions" : "");
  const plot = axes($("over"), { x: [W.values[0], W.values[P - 1]], y: range(curves.map(values => values.filter(v => v !== null))), xName: W.name, yName: unit, height: 230, right: 84 });
  curves.forEach((values, i) => overNumber(plot, values, i, W.members[i], unit));
  const ends = curves.map((values, i) => ({ i, y: plot.Y(values.findLast(v => v !== null) ?? 0) + 4 })).sort((a, b) => b.y - a.y);
  ends.reduce((below, text) => { text.y = Math.min(text.y, below - 14); return text.y; }, Infinity);
  for (const { i, y } of ends) draw("text", { x: plot.box.right + 6, y, class: `named f${i % 6}` }, plot.svg, W.members[i]);
  W.values.forEach((v, k) => { if (missing(k)) draw("text", { x: plot.X(v), y: plot.box.bottom - 3, "text-anchor": "middle" }, plot.svg, "×"); });
  plot.where = v => W.told[nearest(v)];
  const { svg, box, width } = plot, line = draw("line", { y1: box.top, y2: box.bottom, class: "now" }, svg);
  for (const end of ["x1", "x2"]) line.setAttribute(end, plot.X(W.values[chosen]));
  const drag = event => {
    const frame = svg.getBoundingClientRect(), x = (event.clientX - frame.left) * width / frame.width;
    point(nearest(plot.x[0] + (x - box.left) / (box.right - box.left) * (plot.x[1] - plot.x[0])));
  };
  svg.classList.add("drag");
  svg.addEventListener("pointerdown", drag);
}
function titled(name, title, where) {
  $(`${name}-title`).textContent = title;
  $(`${name}-where`).textContent = where;
}
// Curves at the point, on axes that hold those of all points, so that the slider shows how they grow.
function atPoint(host, curves, yName, titles) {
  const all = curves.flatMap(([name, i, count]) => everywhere(name, i, count));
  const plot = overMotion($(host), { y: range([all]), yName, height: host === "curve" ? 220 : 180 });
  if (missing(chosen)) return draw("text", { x: (plot.box.left + plot.box.right) / 2, y: 90, "text-anchor": "middle" }, plot.svg, "no answer at this point");
  curves.forEach(([name, i, count, said], n) => curve(plot, overCycle(name, chosen, i, count), { colour: n, name: said, unit: yName, point: false }));
}
function plots() {
  views = [];
  $("value").textContent = W.told[chosen];
  $("state").textContent = [W.state[chosen] && sentence(W.state[chosen]), W.message[chosen]].filter(Boolean).join(": ");
  const M = W.members.length, J = W.joints.length;
  overview();
  titled("curve", `${sentence(of.unit)} over the cycle`, `${W.members[of.member]} at ${W.told[chosen]}: highest and lowest of all places`);
  atPoint("curve", [[`${of.unit}_highest`, of.member, M, "highest"], [`${of.unit}_lowest`, of.member, M, "lowest"]], D.units[of.unit]);
  if ($("force")) {
    titled("force", "Joint force over the cycle", `${W.joints[of.joint]} at ${W.told[chosen]}`);
    atPoint("force", [["joint_force", of.joint, J, ""]], D.units.force);
  }
  if ($("torque")) {
    titled("torque", `${sentence(W.effort[0])} over the cycle`, `at ${W.told[chosen]}`);
    atPoint("torque", [["input_torque", 0, 1, ""]], W.effort[1]);
  }
  go(shown.place);
}
function point(k) {
  chosen = $("point").value = k;
  plots();
}
$("point").value = chosen;
$("point").oninput = event => point(+event.target.value);
$("member").value = of.member;
for (const name of ["member", "unit", "joint"]) if ($(name)) $(name).onchange = event => {
  of[name] = name === "unit" ? event.target.value : +event.target.value;
  plots();
};
const dark = matchMedia("(prefers-color-scheme: dark)"), root = document.documentElement;
$("theme").onclick = () => {
  root.dataset.theme = (root.dataset.theme ?? (dark.matches ? "dark" : "light")) === "dark" ? "light" : "dark";
  plots();
};
let width = innerWidth;
addEventListener("resize", () => { if (innerWidth !== width) { width = innerWidth; plots(); } });
document.body.dataset.ready = "";
plots();
document.body.dataset.ready = performance.now().toFixed(0);
