// Plots of the chosen member at the place of its peak, all with the same place of the motion.
function titled(name, title, where) {
  $(`${name}-title`).textContent = title;
  $(`${name}-where`).textContent = where;
}
// The chosen member, and one to compare with it where there is one.
const compared = () => [shown.member, ...(shown.other >= 0 && shown.other !== shown.member ? [shown.other] : [])];
const sideOf = (f, name = shown.unit) => sided(name) && D.fibres[f] ? `, ${D.fibres[f]} side` : "";
function memberPlots() {
  const m = shown.member, [k, j, f] = peakOf(m), what = whatOf(shown.unit), second = compared()[1];
  if (MOVES) {
    const curves = compared().map(i => { const [, a, b] = peakOf(i); return history(place => value(place, i, a, b)); });
    const still = A[`${shown.unit}_still`], without = still && history(place => at(still, place, m)), place = sided(shown.unit) ? "the peak’s place" : "its largest";
    const beside = second === undefined ? "" : `; orange: ${D.members[second]}, ${stationOf(second, peakOf(second)[1])}${sideOf(peakOf(second)[2])}`;
    titled("curve", `${what} at ${place}`, `${D.members[m]}, ${stationOf(m, j)}${sideOf(f)}${still ? "; dashed: without vibration" : ""}${beside}`);
    const plot = overMotion($("curve"), { y: range([...curves, ...(without ? [without] : [])]), yName: unitName() });
    if (without) curve(plot, without, { still: true, name: "without vibration", unit: unitName() });
    if (second !== undefined) curve(plot, curves[1], { colour: 1, name: D.members[second], unit: unitName() });
    curve(plot, curves[0], { tell: unitName(), name: second === undefined ? "" : D.members[m] });
    ring(plot, D.axis[k], curves[0][k], `${number(curves[0][k])} at ${told(k)}`);
    once(plot);
    map(m, f, k, j);
  }
  profile(m, f, k, j, what);
  sections();
}
// Every place of a member over the motion, in the colours of the drawing, or to its largest force.
function map(m, f, k, j) {
  const [first, second] = D.ends[m], picture = document.createElement("canvas"), brush = picture.getContext("2d");
  const stresses = sided(shown.unit), name = stresses ? "stress" : shown.unit;
  const most = stresses ? LIMIT : Math.abs(value(k, m, j, f)) || 1;
  picture.width = Math.min(N, 720);
  picture.height = 2 * S - 1;
  for (let i = 0; i < picture.width; i++) {
    const place = placeOf(FROM + (i + .5) * (TO - FROM) / picture.width);
    for (let n = 0; n < 2 * S - 1; n++) {
      const here = valueOf(name, place, m, n >> 1, f), next = valueOf(name, place, m, (n + 1) >> 1, f);
      brush.fillStyle = colourOf((here + next) / 2 * LIMIT / most);
      brush.fillRect(i, 2 * S - 2 - n, 1, 1);
    }
  }
  const colours = stresses ? "colours as in the drawing" : `blue negative, red positive, to ${number(most)} ${unitName()}`;
  titled("map", "Where and when", `${D.members[m]}${sideOf(f)}; ${first} below, ${second} above; ${colours}`);
  const plot = overMotion($("map"), { y: [0, D.lengths[m]], yName: `${D.units.length} from ${first}`, height: 170 }), { box } = plot;
  const image = { x: box.left, y: box.top, width: box.right - box.left, height: box.bottom - box.top, preserveAspectRatio: "none", href: picture.toDataURL() };
  plot.svg.prepend(draw("image", image));
  ring(plot, D.axis[k], D.s[j] * D.lengths[m]);
  plot.read.push((v, high) => high < 0 || high > D.lengths[m] ? null : {
    text: `${number(high)} ${D.units.length} from ${first}: ${number(stationed(valueOf, name, placeOf(v), m, f, high / D.lengths[m]))} ${unitOf(name)}`, y: high,
  });
}
// A value between two stations.
function stationed(of, name, place, m, f, share) {
  const after = Math.max(1, D.s.findIndex(s => s >= share)), [a, b] = [D.s[after - 1], D.s[after]];
  const weight = Math.max(0, Math.min(1, (share - a) / (b - a || 1)));
  return of(name, place, m, after - 1, f) * (1 - weight) + of(name, place, m, after, f) * weight;
}
// Along the member at the place that is shown, inside all that the motion reaches.
function profile(m, f, k, j, what) {
  const second = compared()[1];
  const where = `${D.members[m]}${sideOf(f)}${MOVES ? "; shaded: all that the motion reaches" : ""}${second === undefined ? "" : `; orange: ${D.members[second]}${sideOf(peakOf(second)[2])}`}`;
  titled("along", MOVES ? "Along the member now" : `${what} along the member`, where);
  const plot = alongMembers($("along"), shown.unit, 180, unitName());
  ring(plot, D.s[j] * D.lengths[m], value(k, m, j, f), MOVES ? "" : `${number(value(k, m, j, f))} ${unitName()}`);
}
// A quantity along the chosen members, each from its first end.
function alongMembers(host, name, height, yName) {
  const members = compared(), m = shown.member, reach = members.map(i => {
    const f = peakOf(i, name)[2], low = Array(S).fill(Infinity), high = Array(S).fill(-Infinity);
    for (let place = 0; place < N; place++) for (let n = 0; n < S; n++) {
      const v = valueOf(name, place, i, n, f);
      low[n] = Math.min(low[n], v);
      high[n] = Math.max(high[n], v);
    }
    return { i, f, low, high, x: D.s.map(s => s * D.lengths[i]) };
  });
  const xName = members.length > 1 ? `${D.units.length} from the first end` : `${D.units.length} from ${D.ends[m][0]} to ${D.ends[m][1]}`;
  const plot = axes(host, { x: [0, Math.max(...members.map(i => D.lengths[i]))], y: range(reach.flatMap(({ low, high }) => [low, high])), xName, yName, height });
  plot.where = v => `${number(v)} ${D.units.length}`;
  reach.forEach(({ i, f, low, high, x }, colour) => {
    const around = [...high.map((v, n) => [plot.X(x[n]), plot.Y(v)]), ...low.map((v, n) => [plot.X(x[n]), plot.Y(v)]).reverse()];
    if (MOVES) draw("path", { class: `band f${colour}`, d: `${path(around)}Z` }, plot.svg);
    const line = draw("path", { class: `curve s${colour}` }, plot.svg);
    views.push(place => line.setAttribute("d", path(x.map((v, n) => [plot.X(v), plot.Y(valueOf(name, place, i, n, f))]))));
    plot.read.push(v => {
      if (v > D.lengths[i]) return null;
      const y = stationed(valueOf, name, shown.place, i, f, v / D.lengths[i]), whole = MOVES ? `, of ${number(stationed((_, end, __, n) => end[n], "", low, i, f, v / D.lengths[i]))} to ${number(stationed((_, end, __, n) => end[n], "", high, i, f, v / D.lengths[i]))}` : "";
      return { text: `${members.length > 1 ? `${D.members[i]} ` : ""}${number(y)}${whole} ${unitOf(name)}`, y, colour };
    });
  });
  return plot;
}
// The forces in the sections of the chosen members, one below the other.
function sections() {
  const host = $("sections");
  if (!host) return;
  host.textContent = "";
  const second = compared()[1];
  $("sections-where").textContent = `of ${D.members[shown.member]}${MOVES ? " now; shaded: all that the motion reaches" : ""}${second === undefined ? "" : `; orange: ${D.members[second]}`}`;
  for (const [name, [what, unit]] of Object.entries(D.sections)) {
    const one = document.createElement("div");
    host.append(one);
    alongMembers(one, name, 150, `${what} (${unit})`);
  }
}
