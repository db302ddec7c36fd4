// The canvas of a mechanism: colours of stresses, and what every drawing has.
const canvas = $("mechanism"), pen = canvas.getContext("2d");
let palette = [], inks = {}, frame = null;

// A colour of the style sheet as the browser resolves it, light or dark.
function resolved(name) {
  canvas.style.color = `var(${name})`;
  return getComputedStyle(canvas).color;
}
const channels = name => resolved(name).match(/[\d.]+/g).slice(0, 3).map(Number);

// Blue for compression, red for tension, strong already at 40 % of the peak.
function mixColours() {
  inks = Object.fromEntries(["ink", "soft", "card", "line", "c1", "c2"].map(name => [name, resolved(`--${name}`)]));
  const middle = channels("--mid"), negative = ["--neg", "--neg-most"].map(channels), positive = ["--pos", "--pos-most"].map(channels);
  palette = Array.from({ length: 513 }, (_, i) => {
    const v = (i - 256) / 256, size = Math.abs(v), [half, most] = v < 0 ? negative : positive;
    const [from, to, share] = size < .4 ? [middle, half, size / .4] : [half, most, (size - .4) / .6];
    return `rgb(${from.map((c, n) => Math.round(c + (to[n] - c) * share)).join()})`;
  });
  const bar = $("scale")?.getContext("2d");
  if (!bar) return;
  for (let i = 0; i < 512; i++) { bar.fillStyle = palette[D.upwards ? 256 + (i >> 1) : i]; bar.fillRect(i, 0, 1, 1); }
}
const colourOf = stress => palette[Math.max(0, Math.min(512, Math.round(256 + 256 * stress / LIMIT)))];
function stroke(points, colour, width, dash = []) {
  pen.beginPath();
  points.forEach((p, i) => pen[i ? "lineTo" : "moveTo"](...frame.to(p)));
  Object.assign(pen, { strokeStyle: colour, lineWidth: width });
  pen.setLineDash(dash);
  pen.stroke();
  pen.setLineDash([]);
}
function disc([x, y], radius, fill, outline, width = 2) {
  pen.beginPath();
  pen.arc(x, y, radius, 0, 7);
  if (fill) { pen.fillStyle = fill; pen.fill(); }
  Object.assign(pen, { strokeStyle: outline, lineWidth: width });
  pen.stroke();
}
function label(text, x, y, align) {
  Object.assign(pen, { font: "600 13px system-ui, sans-serif", textAlign: align, textBaseline: "middle", lineWidth: 4, strokeStyle: inks.card, fillStyle: inks.ink });
  pen.strokeText(text, x, y);
  pen.fillText(text, x, y);
}
