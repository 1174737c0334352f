/** Which tool? Every tool with every object, each pair alone, as a matrix and over the steps ahead. */

import type { App } from "../core/app";
import type { Asked } from "../core/connection";
import { h } from "../core/elements";
import type { Pair, PairTool } from "../core/protocol";
import { message, NO_TOOL } from "../core/scene";
import { capital, nameOf } from "../core/words";
import { createChart } from "../draw/chart";
import { colourOf, inkOn, scaleOf } from "../draw/colours";
import { drawingOf, icon } from "../draw/shapes";
import { NOTHING, type Keeps } from "../keep/dialog";
import { pointsOf } from "../keep/files";

export interface PairsView {
  readonly element: HTMLElement;
  /** Switches it on or off: it is computed only while it is visible. */
  turn(on: boolean): void;
  /** What is on the screen. */
  keeps(): Keeps;
  /** Repeats the request after the connection was lost. */
  again(): void;
}

const COLOURS = 7; // of lines; the bare agent has one of its own
const BARE = 7;
const HINT = "Point at a value for range, latency, persistence and reliability.";

export function createPairs({ connection, store }: App): PairsView {
  const table = h("table", { class: "pairs", id: "pairs" });
  const about = h("p", { class: "caption", id: "pair", "aria-live": "polite" }, HINT);
  const fault = h("p", { class: "fault", role: "alert", id: "pairs-fault" });
  const progress = h("div", { class: "progress", role: "progressbar", "aria-label": "computing" });
  const heading = h("h3", {});
  const chart = createChart("Average object empowerment over the steps ahead", "pairs-chart");
  let tools: readonly PairTool[] = [];
  let objects: readonly string[] = [];
  let horizon = 1;
  let pairs: readonly (Pair | null)[] = []; // row by row
  let fresh = 0; // how many of them are of the current scene
  let cells: readonly HTMLButtonElement[] = [];
  let shown = 0; // the object of the chart
  let pointed: number | null = null;
  let on = false;
  let due = false;
  let asked: Asked | null = null;
  let question = ""; // the last one

  const kindOf = (row: number) => (tools[row]!.kind === NO_TOOL ? BARE : row % COLOURS);
  const bitsOf = (pair: Pair | null | undefined) => pair?.averages?.at(-1) ?? null;

  function ask(): void {
    due = false;
    if (!on) return;
    const { drawn, tool, horizon: steps, slip } = message(store.scene());
    const scene = { drawn, horizon: steps, slip, ...(tool === undefined ? {} : { tool }) };
    const next = JSON.stringify(scene);
    if (next === question) return draw(); // of the sensor and the actions it does not depend
    question = next;
    asked?.forget();
    wait(true);
    asked = connection.ask("pairs", { scene }, (answer) => {
      if (answer.lost) return void (question = "");
      fault.textContent = answer.error ?? "";
      if (answer.error !== undefined) wait(false);
      if (answer.tools && answer.objects) begin(answer.tools, answer.objects, answer.horizon ?? 1);
      if (answer.pair) {
        pairs = pairs.with(answer.pair.tool * objects.length + answer.pair.object, answer.pair);
        fresh += 1;
        if (fresh === pairs.length) wait(false);
        draw();
      }
    });
  }

  /** Rows and columns; values of the same tools and objects stay until they are renewed. */
  function begin(nextTools: readonly PairTool[], nextObjects: readonly string[], most: number): void {
    const same = JSON.stringify([nextTools, nextObjects]) === JSON.stringify([tools, objects]);
    [horizon, fresh] = [most, 0];
    if (same) return draw();
    [tools, objects] = [nextTools, nextObjects];
    pairs = Array.from({ length: tools.length * objects.length }, () => null);
    shown = Math.min(shown, objects.length - 1);
    pointed = null;
    cells = pairs.map((_, at) => {
      const button = h("button", { type: "button", class: "pair-value" });
      const point = () => {
        [pointed, shown] = [at, at % objects.length];
        draw();
      };
      for (const event of ["pointerenter", "focus", "click"]) button.addEventListener(event, point);
      return button;
    });
    table.replaceChildren(
      h("thead", {}, h("tr", {}, h("td", {}), ...objects.map((name) => h("th", { scope: "col" }, capital(name))))),
      h("tbody", {}, ...tools.map(({ name, kind }, row) => h(
        "tr",
        { class: `k${kindOf(row)}`, "data-tool": name },
        h(
          "th",
          { scope: "row" },
          h("span", { class: "swatch", "aria-hidden": "true" }),
          kind === NO_TOOL ? h("span", { class: "no-icon" }) : icon(drawingOf(kind), 20),
          h("span", {}, name === kind ? nameOf(kind) : capital(name)),
        ),
        ...objects.map((_, column) => h("td", {}, cells[row * objects.length + column]!)),
      ))),
    );
    draw();
  }

  function draw(): void {
    const known = pairs.flatMap((pair) => bitsOf(pair) ?? []);
    const scale = scaleOf(0, Math.max(...known, 1e-9));
    pairs.forEach((pair, at) => {
      const cell = cells[at]!;
      const bits = bitsOf(pair);
      const column = pairs.filter((_, other) => other % objects.length === at % objects.length);
      const best = bits !== null && column.every((other) => (bitsOf(other) ?? 0) <= bits);
      cell.textContent = bits === null ? "–" : bits.toFixed(2);
      cell.style.background = bits === null ? "" : colourOf(bits, scale);
      cell.style.color = bits === null ? "" : inkOn(bits, scale);
      cell.classList.toggle("best", best && bits > 0);
      cell.title = sentenceOf(at);
      cell.setAttribute("aria-label", sentenceOf(at));
      cell.parentElement!.dataset.fresh = String(at < fresh);
    });
    about.textContent = pointed === null ? HINT : sentenceOf(pointed);
    const object = objects[shown];
    heading.textContent = object === undefined ? "" : `The ${object}, over the steps ahead${store.scene().kind === "open-loop" ? "" : ", open loop"}`;
    chart.draw({
      lines: tools.flatMap(({ name, kind }, row) => {
        const averages = pairs[row * objects.length + shown]?.averages;
        const label = name === kind ? nameOf(kind) : capital(name);
        return averages ? [{ label, x: averages.map((_, k) => k + 1), y: averages, kind: kindOf(row) }] : [];
      }),
      xLabel: "steps ahead",
      yLabel: "bits on average",
      whole: true,
      xMost: Math.max(2, horizon),
      yLeast: 0,
      empty: "",
    });
  }

  /** A pair and all its measures. */
  function sentenceOf(at: number): string {
    const [{ name, kind }, pair] = [tools[Math.floor(at / objects.length)]!, pairs[at]];
    const tool = name === kind ? nameOf(kind) : capital(name);
    const who = `${tool}, ${objects[at % objects.length]!}`;
    if (!pair) return `${who}: not computed yet`;
    if (pair.why !== undefined) return `${who}: ${pair.why}`;
    const count = (value: number | null | undefined, word: string) =>
      value == null ? "none" : `${value} ${value === 1 ? word : `${word}s`}`;
    const median = pair.median_latency == null ? "none" : String(pair.median_latency);
    const reliability = pair.reliability == null ? "undefined" : pair.reliability.toFixed(2);
    return [
      `${who}: ${bitsOf(pair)!.toFixed(2)} bits at ${count(pair.averages!.length, "step")}`,
      `range ${count(pair.range, "cell")}`,
      `latency ${count(pair.latency, "action")} (median ${median})`,
      `persistence ${(pair.persistence ?? 0).toFixed(2)} bits`,
      `reliability ${reliability}`,
    ].join(" · ");
  }

  function wait(pending: boolean): void {
    progress.classList.toggle("going", pending);
    table.dataset.pending = String(pending);
  }

  /** Requests the pairs of the current scene, at most once per frame. */
  function soon(): void {
    if (!on || due) return;
    due = true;
    requestAnimationFrame(ask);
  }

  store.watch(soon);
  return {
    element: h(
      "div",
      { class: "which-tool" },
      progress,
      h("p", { class: "quiet" }, "Mean bits over each object, every pair alone; framed: the best tool."),
      h("div", { class: "pairs-box" }, table),
      about,
      fault,
      heading,
      chart.element,
    ),
    turn(next) {
      on = next;
      if (on) soon();
      else if (fresh < pairs.length) {
        asked?.forget();
        question = ""; // the rest is asked for again
      }
    },
    keeps() {
      const { drawn, tool, horizon: steps, slip } = message(store.scene());
      const names = tools.map(({ name }) => name);
      const measures = ["range", "latency", "median_latency", "persistence", "reliability"] as const;
      return {
        ...NOTHING,
        pictures: tools.length ? [{ name: "Steps ahead", picture: chart.picture }] : [],
        tables: [
          {
            name: "Pairs",
            rows: [
              ["tool", "object", "bits", ...measures],
              ...pairs.map((pair, at) => [
                names[Math.floor(at / objects.length)]!,
                objects[at % objects.length]!,
                bitsOf(pair),
                ...measures.map((measure) => pair?.[measure] ?? null),
              ]),
            ],
          },
          { name: "Steps ahead", rows: pointsOf(chart.lines(), "steps ahead", "bits") },
        ],
        code: {
          scene: { drawn, horizon: steps, slip, ...(tool === undefined ? {} : { tool }) },
          view: "pairs",
          tools: names,
        },
      };
    },
    again: soon,
  };
}
