// What the reader moves: position, member, unit, magnification, theme.
const TURN_SECONDS = 6, FACTORS = [0, 1, 2, 2.5, 5, 10, 15, 20, 25, 30, 40, 50, 75, 100];
const sliders = ["position", "dock-position"].map($).filter(Boolean), plays = ["play", "dock-play"].map($).filter(Boolean);
const steps = [...new Set([0, 1, ...FACTORS.map(factor => factor * D.magnify / 10)])].sort((a, b) => a - b);

function show() {
  views.forEach(view => view(shown.place));
  for (const slider of sliders) slider.value = along(shown.place);
  for (const name of ["told", "dock-told"]) if ($(name)) $(name).textContent = told(shown.place);
}
function go(place) {
  shown.place = TURNS ? (place % N + N) % N : Math.max(0, Math.min(N - 1, place));
  show();
}
function plots() {
  views = [];
  if (BENDS) memberPlots();
  polar();
  effort();
  freedoms();
  frequencies();
  spectrum();
  stability();
  for (const more of MORE) more();
  document.querySelectorAll("tr[data-member]").forEach(row => row.classList.toggle("chosen", +row.dataset.member === shown.member));
  views.push(mechanism);
  show();
}
function paint() {
  mixColours();
  fit();
  plots();
}
function compare(member) {
  shown.other = +member;
  plots();
}
function choose(member) {
  shown.member = $("member").value = member;
  plots();
}
function magnify(step) {
  shown.magnify = steps[step];
  $("times").textContent = `${+shown.magnify.toPrecision(3)} times`;
}

let last = 0;
function stop() {
  shown.playing = false;
  for (const button of plays) button.textContent = "▶";
}
function tick(now) {
  if (!shown.playing) return;
  const next = along(shown.place) + D.direction * Math.min(now - last, 50) / 1000 * (TO - FROM) / TURN_SECONDS;
  go(TURNS ? placeOf((next + 360) % 360) : next >= TO ? 0 : placeOf(next));
  last = now;
  requestAnimationFrame(tick);
}
function play() {
  if (shown.playing) return stop();
  shown.playing = true;
  last = performance.now();
  for (const button of plays) button.textContent = "❚❚";
  requestAnimationFrame(tick);
}
// The shown curve as a table; a text that a spreadsheet would take for a formula is made none.
function csv() {
  const m = shown.member, [, j, f] = peakOf(m), quoted = text => `"${text.replace(/^[=+\-@\t\r]/, "'$&").replaceAll('"', '""')}"`;
  const head = [TURNS ? "drive angle (deg)" : "time (s)", `${D.members[m]}, ${stationOf(m, j)}${sideOf(f)} (${unitName()})`];
  const rows = D.axis.map((v, k) => `${v},${+value(k, m, j, f).toPrecision(6)}`);
  const link = document.createElement("a");
  link.href = URL.createObjectURL(new Blob([`${head.map(quoted).join()}\n${rows.join("\n")}\n`], { type: "text/csv" }));
  link.download = `${D.title}_${D.members[m]}_${shown.unit}.csv`.replace(/[^\w.-]+/g, "_");
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 1000);
}

for (const slider of sliders) {
  [slider.min, slider.max] = [FROM, TO];
  slider.oninput = event => { stop(); go(placeOf(+event.target.value)); };
}
for (const button of plays) button.onclick = play;
if ($("to-peak")) $("to-peak").onclick = () => { stop(); go(BENDS ? peakOf(shown.member)[0] : MOST_FORCE); };
if ($("csv")) $("csv").onclick = csv;
if ($("arrows")) $("arrows").onchange = show;
if ($("acting")) $("acting").onchange = show;
if (BENDS) {
  $("magnify").max = steps.length - 1;
  $("magnify").value = steps.indexOf(D.magnify);
  $("magnify").oninput = event => { magnify(+event.target.value); fit(); show(); };
  magnify(steps.indexOf(D.magnify));
  $("member").value = shown.member;
  $("member").onchange = event => choose(+event.target.value);
  if ($("other")) $("other").onchange = event => compare(event.target.value);
  $("unit").onchange = event => { shown.unit = event.target.value; plots(); };
  $("least").textContent = D.upwards ? "0" : `\u2212${number(LIMIT)} ${D.units.stress}`;
  $("most").textContent = `${D.upwards ? "" : "+"}${number(LIMIT)} ${D.units.stress}`;
} else shown.place = MOST_FORCE;
document.querySelectorAll("tr[data-member]").forEach(row => { row.onclick = () => choose(+row.dataset.member); });
canvas.onclick = event => {
  const box = canvas.getBoundingClientRect(), member = nearestMember(event.clientX - box.left, event.clientY - box.top);
  if (member >= 0) choose(member);
};

const dark = matchMedia("(prefers-color-scheme: dark)"), root = document.documentElement;
$("theme").onclick = () => {
  root.dataset.theme = (root.dataset.theme ?? (dark.matches ? "dark" : "light")) === "dark" ? "light" : "dark";
  paint();
};
dark.onchange = paint;
$("print").onclick = () => print();
for (const [event, printing] of [["beforeprint", true], ["afterprint", false]]) addEventListener(event, () => {
  stop();
  document.body.classList.toggle("printing", printing); // as wide as paper, so that letters keep their size
  paint();
});
let width = innerWidth;
addEventListener("resize", () => { if (innerWidth !== width) { width = innerWidth; paint(); } });

function pace() { // beside the machine, of what is moved by hand nothing
  if (D.seconds === null) return "";
  const slow = TURN_SECONDS / D.seconds, near = Math.abs(Math.log(slow)) < 0.05;
  if (near) return "Played as fast as the machine. ";
  return `Played ${number(Math.max(slow, 1 / slow), 2)} times ${slow > 1 ? "slower" : "faster"} than the machine. `;
}
const hints = [MOVES && `${pace()}Drag in any plot to move it.`, BENDS && "Click a member to choose it."];
$("hint").textContent = hints.filter(Boolean).join(" ");
document.body.dataset.ready = "";
if (MOVES) document.body.dataset.moves = "";
paint();
document.body.dataset.ready = performance.now().toFixed(0);
