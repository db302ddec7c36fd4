// Axes and curves as SVG, which stays sharp on paper.
const SVG = "http://www.w3.org/2000/svg";
let views = []; // what is moved when the place changes

function draw(name, attributes, parent, text) {
  const made = document.createElementNS(SVG, name);
  for (const key in attributes) made.setAttribute(key, attributes[key]);
  if (text !== undefined) made.textContent = text;
  parent?.append(made);
  return made;
}
function ticks(low, high, count) {
  const raw = (high - low) / count || 1, decade = 10 ** Math.floor(Math.log10(raw));
  const step = [1, 2, 2.5, 5, 10].find(factor => factor * decade >= raw * (1 - 1e-9)) * decade, found = [];
  for (let v = Math.ceil(low / step - 1e-9) * step; v <= high + 1e-9 * step; v += step) found.push(Math.abs(v) < step / 1e6 ? 0 : v);
  return found;
}
const plain = v => String(+v.toPrecision(6)).replace("-", "\u2212");
const path = points => points.map(([x, y], i) => `${i ? "L" : "M"}${x.toFixed(1)} ${y.toFixed(1)}`).join("");

function axes(host, { x, y, xName, yName, xTicks, height = 190, left = 52, right = 12 }) {
  host.textContent = "";
  const width = host.clientWidth || 500, box = { left, right: width - right, top: 20, bottom: height - 36 };
  const svg = draw("svg", { viewBox: `0 0 ${width} ${height}`, height, role: "img" }, host);
  const X = v => box.left + (v - x[0]) / (x[1] - x[0] || 1) * (box.right - box.left);
  const Y = v => box.bottom - (v - y[0]) / (y[1] - y[0] || 1) * (box.bottom - box.top);
  for (const v of ticks(...y, 4)) {
    draw("line", { x1: box.left, x2: box.right, y1: Y(v), y2: Y(v), class: v ? "grid" : "axis" }, svg);
    draw("text", { x: box.left - 7, y: Y(v) + 4, "text-anchor": "end" }, svg, plain(v));
  }
  for (const v of xTicks ?? ticks(...x, width < 450 ? 4 : 6)) {
    draw("line", { x1: X(v), x2: X(v), y1: box.bottom, y2: box.bottom + 4, class: "axis" }, svg);
    draw("text", { x: X(v), y: box.bottom + 17, "text-anchor": "middle" }, svg, plain(v));
  }
  draw("line", { x1: box.left, x2: box.right, y1: box.bottom, y2: box.bottom, class: "axis" }, svg);
  draw("text", { x: (box.left + box.right) / 2, y: height - 3, "text-anchor": "middle" }, svg, xName);
  draw("text", { x: 0, y: 11 }, svg, yName);
  const plot = { host, svg, X, Y, box, width, x, y, read: [], where: v => number(v) };
  readOut(plot);
  return plot;
}
// The values of all curves of a plot at the pointer: each entry of `read` gives a text, and where its point is.
function readOut(plot) {
  const { host, svg, box, width } = plot;
  host.classList.add("plot");
  const hair = draw("line", { y1: box.top, y2: box.bottom, class: "hair", visibility: "hidden" }, svg);
  const dots = draw("g", {}, svg), tip = document.createElement("div");
  tip.className = "tip";
  tip.hidden = true;
  host.append(tip);
  const leave = () => { tip.hidden = true; dots.textContent = ""; hair.setAttribute("visibility", "hidden"); };
  svg.addEventListener("pointerleave", leave);
  svg.addEventListener("pointercancel", leave);
  svg.addEventListener("pointermove", event => {
    const frame = svg.getBoundingClientRect(), scale = width / frame.width;
    const px = (event.clientX - frame.left) * scale, py = (event.clientY - frame.top) * scale;
    if (!plot.read.length || px < box.left || px > box.right) return leave();
    const share = (px - box.left) / (box.right - box.left), v = plot.x[0] + share * (plot.x[1] - plot.x[0]);
    const high = plot.y[0] + (box.bottom - py) / (box.bottom - box.top) * (plot.y[1] - plot.y[0]);
    const lines = plot.read.map(read => read(v, high)).filter(Boolean);
    if (!lines.length) return leave();
    for (const end of ["x1", "x2"]) hair.setAttribute(end, px);
    hair.setAttribute("visibility", "visible");
    dots.textContent = "";
    tip.textContent = plot.where(v);
    for (const { text, y, colour = 0 } of lines) {
      if (y !== undefined) draw("circle", { cx: px, cy: plot.Y(y), r: 3.5, class: `f${colour % 6}` }, dots);
      const line = document.createElement("div");
      line.textContent = text;
      line.className = `t${colour % 6}`;
      tip.append(line);
    }
    tip.hidden = false;
    tip.style.left = `${Math.max(0, Math.min(px / scale + 12, frame.width - tip.offsetWidth))}px`;
    if (px / scale + 12 + tip.offsetWidth > frame.width) tip.style.left = `${Math.max(0, px / scale - 12 - tip.offsetWidth)}px`;
    tip.style.top = `${box.top / scale}px`;
  });
}
function ring(plot, x, y, text) {
  draw("circle", { cx: plot.X(x), cy: plot.Y(y), r: 6, class: "ring" }, plot.svg);
  if (!text) return;
  const before = plot.X(x) > plot.width * .66; // beyond the ring, where the curve is not
  draw("text", { x: plot.X(x) + (before ? -8 : 8), y: plot.Y(y) + (y < 0 ? 17 : -8), class: "value", "text-anchor": before ? "end" : "start" }, plot.svg, text).setAttribute("data-at", x);
}
// Hide the text of a ring where the value that is shown above the plot is that of the ring.
function once(plot) {
  const text = plot.svg.querySelector("text[data-at]");
  if (text) views.push(place => { text.style.visibility = Math.abs(plot.X(along(place)) - plot.X(+text.dataset.at)) < .5 ? "hidden" : ""; });
}

// Axes over the drive angle or time, on which the place is shown and dragged.
function overMotion(host, options) {
  const degrees = host.clientWidth < 440 ? [0, 90, 180, 270, 360] : [0, 45, 90, 135, 180, 225, 270, 315, 360];
  const plot = axes(host, { x: [FROM, TO], xName: TURNS ? "drive angle (°)" : "time (s)", xTicks: TURNS ? degrees : undefined, ...options });
  const { svg, box, width } = plot;
  plot.where = v => TURNS ? `${v.toFixed(0) % 360}°` : `${number(v)} s`;
  const line = draw("line", { y1: box.top, y2: box.bottom, class: "now" }, svg);
  views.push(place => { for (const end of ["x1", "x2"]) line.setAttribute(end, plot.X(along(place))); });
  const drag = event => {
    const frame = svg.getBoundingClientRect(), x = (event.clientX - frame.left) * width / frame.width;
    go(placeOf(Math.max(FROM, Math.min(TO, FROM + (x - box.left) / (box.right - box.left) * (TO - FROM)))));
  };
  svg.classList.add("drag");
  svg.addEventListener("pointerdown", event => { stop(); drag(event); svg.setPointerCapture(event.pointerId); svg.onpointermove = drag; });
  svg.addEventListener("pointerup", () => { svg.onpointermove = null; });
  svg.addEventListener("pointercancel", () => { svg.onpointermove = null; });
  return plot;
}
// A curve over the motion, with a point at the place that is shown.
function curve(plot, values, { still = false, colour = 0, point = !still, tell, name = "", unit = tell ?? "" } = {}) {
  const points = values.map((v, k) => [plot.X(D.axis[k]), plot.Y(v)]);
  if (TURNS) points.unshift([plot.X(D.axis[N - 1] - 360), plot.Y(values[N - 1])]), points.push([plot.X(360 + D.axis[0]), plot.Y(values[0])]);
  const inside = points.filter(([x]) => x >= plot.box.left - .01 && x <= plot.box.right + .01);
  draw("path", { d: path(inside), class: still ? "still" : `curve s${colour % 6}` }, plot.svg);
  const between = place => {
    const k = Math.floor(place), share = place - k;
    return values[k % N] * (1 - share) + values[(k + 1) % N] * share;
  };
  plot.read.push(v => ({ text: [name, number(between(placeOf(v))), unit].filter(Boolean).join(" "), y: between(placeOf(v)), colour }));
  if (!point) return;
  const dot = draw("circle", { r: 4.5, class: "point" }, plot.svg);
  const text = tell && draw("text", { class: "value", y: 11, "text-anchor": "end", x: plot.box.right }, plot.svg);
  views.push(place => {
    const v = between(place);
    dot.setAttribute("cx", plot.X(along(place)));
    dot.setAttribute("cy", plot.Y(v));
    if (text) text.textContent = `${number(v)} ${tell} at ${told(place)}`;
  });
}
function range(curves, withZero = true) {
  let low = withZero ? 0 : Infinity, high = withZero ? 0 : -Infinity;
  for (const values of curves) for (const v of values) { if (v < low) low = v; if (v > high) high = v; }
  const room = (high - low || 1) * .15;
  return [low < 0 || !withZero ? low - 1.35 * room : low, high > 0 || !withZero ? high + room : high];
}
