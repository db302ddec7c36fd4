// Plots of the chosen member at the place of its peak, all with the same place of the motion.
function titled(name, title, where) {
  $(`${name}-title`).textContent = title;
  $(`${name}-where`).textContent = where;
}
function memberPlots() {
  const m = shown.member, [k, j, f] = D.peaks[m], name = D.members[m], side = `${D.fibres[f]} side`;
  const what = shown.unit === "stress" ? "Stress" : "Strain";
  if (MOVES) {
    const values = history(place => value(place, m, j, f)), still = A[`${shown.unit}_still`];
    const without = still && history(place => at(still, place, m));
    titled("curve", `${what} at the peak’s place`, `${name}, ${stationOf(m, j)}, ${side}${still ? "; dashed: without vibration" : ""}`);
    const plot = overMotion($("curve"), { y: range(without ? [values, without] : [values]), yName: unitName() });
    if (without) curve(plot, without, { still: true });
    curve(plot, values, { tell: unitName() });
    ring(plot, D.axis[k], values[k], `${number(values[k])} at ${told(k)}`);
    once(plot);
    map(m, f, k, j);
  }
  profile(m, f, k, j, what);
}
// Every place of a member over the motion, in the colours of the drawing.
function map(m, f, k, j) {
  const [first, second] = D.ends[m], picture = document.createElement("canvas"), brush = picture.getContext("2d");
  picture.width = Math.min(N, 720);
  picture.height = 2 * S - 1;
  for (let i = 0; i < picture.width; i++) {
    const place = placeOf(FROM + (i + .5) * (TO - FROM) / picture.width);
    for (let n = 0; n < 2 * S - 1; n++) {
      const stress = at(A.stress, place, cell(m, n >> 1, f)), next = at(A.stress, place, cell(m, (n + 1) >> 1, f));
      brush.fillStyle = colourOf((stress + next) / 2);
      brush.fillRect(i, 2 * S - 2 - n, 1, 1);
    }
  }
  titled("map", "Where and when", `${D.members[m]}, ${D.fibres[f]} side; ${first} below, ${second} above; colours as in the drawing`);
  const plot = overMotion($("map"), { y: [0, D.lengths[m]], yName: `${D.units.length} from ${first}`, height: 170 }), { box } = plot;
  const image = { x: box.left, y: box.top, width: box.right - box.left, height: box.bottom - box.top, preserveAspectRatio: "none", href: picture.toDataURL() };
  plot.svg.prepend(draw("image", image));
  ring(plot, D.axis[k], D.s[j] * D.lengths[m]);
}
// Along the member at the place that is shown, inside all that the motion reaches.
function profile(m, f, k, j, what) {
  const x = D.s.map(s => s * D.lengths[m]), low = Array(S).fill(Infinity), high = Array(S).fill(-Infinity);
  for (let place = 0; place < N; place++) for (let n = 0; n < S; n++) {
    const v = value(place, m, n, f);
    low[n] = Math.min(low[n], v);
    high[n] = Math.max(high[n], v);
  }
  titled("along", MOVES ? "Along the member now" : `${what} along the member`, `${D.members[m]}, ${D.fibres[f]} side${MOVES ? "; shaded: all that the motion reaches" : ""}`);
  const plot = axes($("along"), { x: [0, D.lengths[m]], y: range([low, high]), xName: `${D.units.length} from ${D.ends[m][0]} to ${D.ends[m][1]}`, yName: unitName(), height: 180 });
  const around = [...high.map((v, n) => [plot.X(x[n]), plot.Y(v)]), ...low.map((v, n) => [plot.X(x[n]), plot.Y(v)]).reverse()];
  if (MOVES) draw("path", { class: "band", d: `${path(around)}Z` }, plot.svg);
  const line = draw("path", { class: "curve s0" }, plot.svg);
  ring(plot, x[j], value(k, m, j, f), MOVES ? "" : `${number(value(k, m, j, f))} ${unitName()}`);
  views.push(place => line.setAttribute("d", path(x.map((v, n) => [plot.X(v), plot.Y(value(place, m, n, f))]))));
}
