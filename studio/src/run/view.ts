/** Run: a trained agent acted out, with what it thinks of every action and every cell. */

import type { App, View } from "../core/app";
import { h } from "../core/elements";
import type { Cell, Placement, RunAnswer } from "../core/protocol";
import { cellOf, indexOf, inWords, placementOf } from "../core/scene";
import { worldOf, type Standing, type World } from "../core/world";
import { createBoard } from "../draw/board";
import { same } from "../draw/cells";
import { createChart } from "../draw/chart";
import { letDrag } from "../draw/dragging";
import { stood } from "../draw/things";
import { scaleOf } from "../draw/heat";
import { createScaleBar } from "../draw/scale";
import { rowColumn } from "../design/editor";
import { button, card, rename, segmented, select, slider } from "../frame/widgets";

const PACE = 420;
const SHOWN = { policy: ["Policy"], values: ["Values"], both: ["Both"] };

export function createRun({ hello, connection, acted }: App): View {
  const board = createBoard("The agent at work", "run-board", true);
  const chart = createChart("Learning curve of the run", "run-curve");
  const title = h("h2", {}, "Run");
  const told = h("p", { class: "quiet", id: "run-told", "aria-live": "polite" });
  const bars = h("ul", { class: "bars actions", id: "action-bars" });
  const index = h("span", { class: "run-index" });
  const scale = createScaleBar("value, with tool and can as they start", 1);
  let which = 0;
  let elsewhere: Placement | null = null; // where it is to begin, if not where the map has it
  let answer: RunAnswer | null = null;
  let map: World; // there is one as soon as there is a run
  let shown: keyof typeof SHOWN = "both";
  let step = 0;
  let moved: Placement | null = null; // while things are dragged
  let timer = 0;
  let active = false;

  const layers = segmented("Shown", SHOWN, (chosen) => {
    shown = chosen;
    draw();
  });
  layers.show(shown);
  const steps = slider("Step", { id: "step", least: 0, most: 1, step: 1 }, String, (value) => {
    stop();
    step = value;
    draw();
  });
  const back = button("From the start", () => begin(null), { id: "run-back", sign: "reset" });
  const play = button("Play", () => (timer ? stop() : go()), { id: "run-play", kind: "primary", sign: "play" });

  /** Acts it out from there, or from where the map has everything. */
  function begin(placement: Placement | null): void {
    elsewhere = placement;
    load();
  }

  function load(): void {
    stop();
    told.textContent = "Acting it out…";
    told.className = "quiet";
    const name = acted.current()?.asked;
    const body = {
      index: which,
      ...(name === undefined ? {} : { name }),
      ...(elsewhere === null ? {} : { placement: said(elsewhere) }),
    };
    const asked = connection.ask<RunAnswer>("run", body, (next) => {
      if (next.progress !== undefined) return;
      asked.forget();
      full.classList.toggle("failed", next.error !== undefined && answer === null);
      told.className = next.error === undefined ? "quiet" : "fault";
      if (next.error !== undefined) {
        told.textContent = next.error;
        return;
      }
      [answer, step, moved] = [next, 0, null];
      if (next.drawn) map = worldOf(next.drawn);
      steps.input.max = String(Math.max(1, last()));
      draw();
      if (active) go();
    });
  }

  /** Where things are now, dragged or not. */
  function here(): Placement | null {
    const words = answer?.episode?.placements[step];
    return moved ?? (words ? placementOf(map, map.tools, words) : null);
  }
  /** In the server's words; what was dragged is in nobody's hand by history. */
  function said({ agent, tools, objects }: Placement) {
    return inWords(map, map.tools, { agent, tools, objects });
  }

  const last = () => (answer?.episode?.placements.length ?? 1) - 1;

  function go(): void {
    if (step >= last()) step = 0;
    const forward = () => {
      step += 1;
      draw();
      if (step >= last()) stop();
    };
    clearInterval(timer);
    timer = window.setInterval(forward, PACE);
    draw();
  }

  function stop(): void {
    clearInterval(timer);
    timer = 0;
    draw();
  }

  function draw(): void {
    const about = acted.current();
    if (timer) rename(play, "Pause", "pause");
    else rename(play, "Play", "play");
    if (about === null || !answer?.episode) return;
    back.hidden = elsewhere === null;
    const values = answer.values?.flat().filter((value) => value !== null) ?? [];
    const [least, most] = [Math.min(...values), Math.max(...values)];
    const withValues = shown !== "policy" && values.length > 0;
    board.draw({
      world: map,
      things: stood(map, map.tools, here()!),
      values: withValues
        ? { grid: answer.values!, scale: scaleOf(least, most), unlabelled: shown === "both" }
        : null,
      arrows: shown === "values" ? null : (answer.policy?.cells ?? null),
      now: step < last() ? (answer.policy?.episode[step] ?? null) : null,
      label: rowColumn,
    });
    scale.show(withValues ? { least, most } : null);
    steps.show(step);
    drawBars(answer.policy?.episode[step] ?? null, answer.episode.actions[step]);
    const length = answer.episode.actions.length;
    const { finished, return: worth } = answer.episode;
    const best = answer.episode.best_return ?? worth;
    const outcome = finished
      ? `the can is in the bin: return ${signed(worth)}, the best possible is ${signed(best)}`
      : answer.episode.best_return === null
        ? "from where there is no way to the bin"
        : "and it goes in circles: the can never gets to the bin";
    told.textContent = `${length} ${length === 1 ? "step" : "steps"}, ${outcome}.`;
    const curve = answer.curve;
    chart.draw({
      lines: curve ? [{ label: about.name, x: curve.x, y: curve.mean, low: curve.low, high: curve.high, kind: 0 }] : [],
      xLabel: "episodes",
      yLabel: "return",
      level: answer.best_return === undefined ? null : { y: answer.best_return, label: "best possible" },
      squeezed: true,
      yMost: 0,
      empty: "There is no curve yet.",
    });
  }

  function drawBars(probabilities: number[] | null, taken: number | undefined): void {
    bars.replaceChildren(
      ...(probabilities ?? []).map((probability, action) => {
        const fill = h("span", { class: "bar" });
        fill.style.setProperty("--share", String(probability));
        return h(
          "li",
          { class: action === taken ? "chosen" : "" },
          h("span", { class: "name" }, hello.actions[action] ?? String(action)),
          h("span", { class: "track" }, fill),
          h("span", { class: "bits" }, `${Math.round(100 * probability)} %`),
        );
      }),
    );
  }

  /** Whether a thing may be put down there. */
  function free({ what, of }: Standing, cell: Cell, among: Placement): boolean {
    const taken = [among.agent, ...among.tools, ...among.objects].some((other) => same(other, cell));
    const goal = what === "object" ? map.objects[of]!.goal : null;
    const done = goal !== null && same(cell, cellOf(map, goal));
    return !taken && !done && !map.walls[indexOf(map, cell)];
  }

  /** What may be dragged from there: all but bins. */
  function thingIn(cell: Cell): Standing | null {
    const now = active ? here() : null;
    const there = now === null ? [] : stood(map, map.tools, now);
    return there.find((one) => same(one.cell, cell) && one.thing.what !== "goal")?.thing ?? null;
  }

  function move(thing: Standing, cell: Cell): void {
    if (timer) stop();
    const now = here()!;
    if (!free(thing, cell, now)) return;
    const { agent, tools, objects } = now;
    if (thing.what === "agent") moved = { agent: cell, tools, objects };
    else if (thing.what === "tool") moved = { agent, tools: tools.with(thing.of, cell), objects };
    else moved = { agent, tools, objects: objects.with(thing.of, cell) };
    draw();
  }

  letDrag(
    board,
    (cell) => {
      const thing = thingIn(cell);
      return thing && {
        kind: "thing",
        move: (path) => move(thing, path.at(-1)!),
        drop: () => moved && begin(moved),
      };
    },
    (cell) => (thingIn(cell) ? "thing" : ""),
  );

  const full = h(
    "div",
    { class: "view run" },
    card(
      "Episode",
      "world",
      h("div", { class: "card-head" }, title, index),
      board.element,
      scale.element,
      h("div", { class: "card-foot" }, h("div", { class: "buttons" }, play, back), layers.element),
      steps.element,
      h("p", { class: "quiet" }, "Drag the agent, the tool or the can: it begins from there."),
    ),
    card(
      "What it learned",
      "side",
      h("h3", {}, "What it would do"),
      bars,
      told,
      h("h3", {}, "How it learned"),
      chart.element,
    ),
  );
  const empty = h(
    "div",
    { class: "nothing" },
    h("h2", {}, "There is no agent to watch yet"),
    h("p", {}, "Train an agent in this page, press Watch beside one of an earlier training there, or start the studio with a folder that habilis train wrote:"),
    h("code", {}, "habilis studio FOLDER"),
  );
  const element = h("div", { class: "run-place" }, empty, full);

  acted.watch((about) => {
    empty.hidden = about !== null;
    full.hidden = about === null;
    if (about === null) return;
    [answer, moved, elsewhere, which] = [null, null, null, 0];
    map = worldOf(about.drawn);
    title.textContent = title.title = about.name;
    const runs = Object.fromEntries(
      Array.from({ length: about.runs }, (_, k) => [String(k), `run ${k + 1} of ${about.runs}`]),
    );
    index.replaceChildren(select("Which run", runs, (chosen) => {
      which = Number(chosen);
      load();
    }));
    if (active) load();
  });
  return {
    element,
    entered() {
      active = true;
      if (acted.current() !== null && answer === null) load();
      else draw();
    },
    left() {
      active = false;
      stop();
    },
  };
}

function signed(value: number): string {
  return value.toFixed(0).replace("-", "−");
}
