/** A line chart, crisp at any size: lines with the intervals around them, quiet axes, a legend. */

import { escaped, h, svg } from "../core/elements";

export interface Line {
  label: string;
  x: readonly number[];
  y: readonly number[];
  low?: readonly number[];
  high?: readonly number[];
  /** Its colour and dash pattern. */
  kind: number;
}

export interface ChartData {
  lines: Line[];
  xLabel: string;
  yLabel: string;
  /** A dotted line, and its label. */
  level?: { y: number; label: string } | null;
  /** A step function: the value is held until the next point. */
  steps?: boolean;
  /** Compresses values far below zero, for returns. */
  squeezed?: boolean;
  /** Labels whole numbers only, below the chart. */
  whole?: boolean;
  xMost?: number;
  yLeast?: number;
  yMost?: number;
  empty: string;
}

export interface Chart {
  readonly element: HTMLElement;
  readonly picture: SVGSVGElement;
  /** The drawn lines. */
  lines(): readonly Line[];
  draw(data: ChartData): void;
}

const [LEFT, RIGHT, TOP, BOTTOM] = [52, 22, 14, 40];

export function createChart(name: string, id: string): Chart {
  const picture = svg("svg", { class: "chart", id, role: "img", "aria-label": name });
  const element = h("div", { class: "chart-box" }, picture);
  let shown: ChartData | null = null;

  function draw(data: ChartData): void {
    shown = data;
    const [width, height] = [element.clientWidth, element.clientHeight];
    if (!width || !height) return;
    picture.setAttribute("viewBox", `0 0 ${width} ${height}`);
    picture.innerHTML = markup(data, width, height);
    picture.setAttribute("aria-label", [name, ...data.lines.map(inWords)].join(". "));
  }

  new ResizeObserver(() => shown && draw(shown)).observe(element);
  return { element, picture, lines: () => (shown?.lines ?? []).filter(({ x }) => x.length > 0), draw };
}

/** A line in words, for those who hear it. */
function inWords({ label, x, y }: Line): string {
  if (!x.length) return `${label}: no values yet`;
  const [last, at] = [shortly(Number(y.at(-1)!.toPrecision(3))), shortly(x.at(-1)!)];
  const [least, most] = [Math.min(...y), Math.max(...y)].map((end) => shortly(Number(end.toPrecision(3))));
  return `${label}: ${last} at ${at}, between ${least} and ${most} before`;
}

function markup(data: ChartData, width: number, height: number): string {
  const lines = data.lines.filter((line) => line.x.length > 0);
  if (!lines.length) {
    const at = `x="${width / 2}" y="${height / 2}"`;
    return `<text class="empty" ${at} text-anchor="middle">${escaped(data.empty)}</text>`;
  }
  const warp = data.squeezed ? squeeze : (y: number) => y;
  const xs = lines.flatMap((line) => [line.x[0]!, line.x.at(-1)!]);
  const ys = lines.flatMap((line) => [...line.y, ...(line.low ?? []), ...(line.high ?? [])]);
  if (data.level) ys.push(data.level.y);
  const [x0, x1] = [Math.min(...xs, 0), Math.max(...xs, data.xMost ?? 1)];
  let [y0, y1] = [data.yLeast ?? Math.min(...ys), data.yMost ?? Math.max(...ys)];
  if (y1 - y0 < 1e-9) [y0, y1] = [y0 - 0.5, y1 + 0.5];
  const [low, high] = [warp(y0), warp(y1)];
  const px = (x: number) => LEFT + ((x - x0) / (x1 - x0)) * (width - LEFT - RIGHT);
  const py = (y: number) =>
    height - BOTTOM - ((warp(y) - low) / (high - low)) * (height - TOP - BOTTOM);

  const yTicks = data.squeezed ? squeezedTicks(y0, y1) : ticks(y0, y1, (height - TOP) / 44);
  const parts = yTicks.map(
    (y) =>
      `<line class="rule" x1="${LEFT}" x2="${width - RIGHT}" y1="${py(y)}" y2="${py(y)}"/>` +
      `<text class="tick" x="${LEFT - 8}" y="${py(y) + 4}" text-anchor="end">${shortly(y)}</text>`,
  );
  for (const x of ticks(x0, x1, (width - LEFT) / 90)) {
    if (data.whole && !Number.isInteger(x)) continue;
    const at = `x="${px(x)}" y="${height - BOTTOM + 18}"`;
    parts.push(`<text class="tick" ${at} text-anchor="middle">${shortly(x)}</text>`);
  }
  parts.push(
    `<text class="axis" x="${(LEFT + width - RIGHT) / 2}" y="${height - 4}" text-anchor="middle">${escaped(data.xLabel)}</text>`,
    `<text class="axis" transform="translate(13 ${(TOP + height - BOTTOM) / 2}) rotate(-90)" text-anchor="middle">${escaped(data.squeezed ? `${data.yLabel}, log scale` : data.yLabel)}</text>`,
  );
  if (data.level) {
    const y = py(data.level.y);
    parts.push(
      `<line class="level" x1="${LEFT}" x2="${width - RIGHT}" y1="${y}" y2="${y}"/>`,
      `<text class="level-name" x="${width - RIGHT - 4}" y="${y - 7}" text-anchor="end">${escaped(data.level.label)}</text>`,
    );
  }
  for (const { x, y, low: lows, high: highs, kind } of lines) {
    if (lows && highs) {
      const there = x.map((at, k) => `${px(at).toFixed(1)} ${py(highs[k]!).toFixed(1)}`);
      const back = x.map((at, k) => `${px(at).toFixed(1)} ${py(lows[k]!).toFixed(1)}`).reverse();
      parts.push(`<path class="band k${kind}" d="M${[...there, ...back].join("L")}Z"/>`);
    }
    const path = x.map((at, k) => {
      const point = `${px(at).toFixed(1)} ${py(y[k]!).toFixed(1)}`;
      if (!k) return `M${point}`;
      return data.steps ? `H${px(at).toFixed(1)}V${py(y[k]!).toFixed(1)}` : `L${point}`;
    });
    parts.push(`<path class="line k${kind}" d="${path.join("")}"/>`);
    const [endX, endY] = [px(x.at(-1)!), py(y.at(-1)!)];
    parts.push(`<circle class="end k${kind}" cx="${endX}" cy="${endY}" r="4"/>`);
  }
  return parts.join("");
}

/** Linear near zero, logarithmic far from it. */
function squeeze(y: number): number {
  return Math.sign(y) * Math.log10(1 + Math.abs(y) / 2);
}

function squeezedTicks(least: number, most: number): number[] {
  const all = [0, 2, 5, 10, 20, 50, 100, 200, 500, 1000, 2000, 5000, 10000].map((y) => -y);
  return all.filter((y) => y >= least && y <= most);
}

function ticks(least: number, most: number, count: number): number[] {
  const rough = (most - least) / Math.max(1, count);
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 5, 10].map((k) => k * power).find((size) => size >= rough)!;
  const found: number[] = [];
  for (let k = Math.ceil(least / step - 1e-9); k * step <= most + 1e-9 * step; k++) {
    found.push(Number((k * step).toPrecision(12)));
  }
  return found;
}

function shortly(value: number): string {
  return Number(value.toPrecision(6)).toLocaleString("en-GB").replace("-", "−");
}
