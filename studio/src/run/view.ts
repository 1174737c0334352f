/** Run: episodes of a trained agent, with its action probabilities and state values. */

import type { App, View } from "../core/app";
import { h } from "../core/elements";
import type { Cell, Placement, RunAnswer } from "../core/protocol";
import { cellOf, indexOf } from "../core/scene";
import { drawnOf, worldOf, type Standing, type World } from "../core/world";
import { createBoard } from "../draw/board";
import { same } from "../draw/cells";
import { createChart } from "../draw/chart";
import { letDrag } from "../draw/dragging";
import { labelOf, stood, type Stood } from "../draw/things";
import { scaleOf } from "../draw/colours";
import { createScaleBar } from "../draw/scale";
import { button, card, rename, segmented, select, slider } from "../frame/widgets";
import { NOTHING, type Keeps } from "../keep/dialog";
import { pointsOf, rowsOf } from "../keep/files";

const PACE = 420;
const HINT = "Drag the agent, the tool or the can to start the episode from there.";
const EMPTY =
  "Cells without a value: away from its own cell, the tool is in hand, so the agent is next to it.";
const SHOWN = { policy: ["Policy"], values: ["Values"], both: ["Both"] };

export function createRun({ hello, connection, watched }: App): View {
  const board = createBoard("The trained agent", "run-board", true);
  const chart = createChart("Learning curve of the run", "run-curve");
  const title = h("h2", {}, "Run");
  const caption = h("p", { class: "quiet", id: "run-caption", "aria-live": "polite" });
  const bars = h("ul", { class: "bars actions", id: "action-bars" });
  const index = h("span", { class: "run-index" });
  const scale = createScaleBar("state value, with tool and can at their starts");
  const hint = h("span", {}, HINT);
  let which = 0;
  let elsewhere: Placement | null = null; // the start, if it differs from the map's
  let answer: RunAnswer | null = null;
  let map: World; // set as soon as there is a run
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
  const back = button("Back to the start", () => begin(null), { id: "run-back", sign: "reset" });
  const play = button("Play", () => (timer ? stop() : go()), { id: "run-play", kind: "primary", sign: "play" });

  /** Plays an episode from the placement, or from the map's. */
  function begin(placement: Placement | null): void {
    elsewhere = placement;
    load();
  }

  function load(): void {
    stop();
    caption.textContent = "Playing the episode…";
    caption.className = "quiet";
    const name = watched.current()?.asked;
    const body = {
      index: which,
      ...(name === undefined ? {} : { name }),
      ...(elsewhere === null ? {} : { placement: elsewhere }),
    };
    const asked = connection.ask("run", body, (next) => {
      if (next.progress !== undefined) return;
      asked.forget();
      full.classList.toggle("failed", next.error !== undefined && answer === null);
      caption.className = next.error === undefined ? "quiet" : "fault";
      if (next.error !== undefined) {
        caption.textContent = next.error;
        return;
      }
      [answer, step, moved] = [next, 0, null];
      if (next.drawn) map = worldOf(next.drawn);
      steps.input.max = String(Math.max(1, last()));
      draw();
      if (active) go();
    });
  }

  /** The current placement, including drags. */
  function here(): Placement | null {
    return moved ?? answer?.episode?.placements[step] ?? null;
  }

  /** Whether free cells have no value, which is so where a tool lies in a cell that is not its own. */
  function partial(): boolean {
    const start = answer?.episode?.placements[0];
    if (start === undefined || !answer?.values || !map.tools.length) return false;
    return map.tools.some(({ cell }, of) => !same(cellOf(map, cell), start.tools[of]!));
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
    const about = watched.current();
    if (timer) rename(play, "Pause", "pause");
    else rename(play, "Play", "play");
    if (about === null || !answer?.episode) return;
    back.hidden = elsewhere === null;
    const values = answer.values?.flat().filter((value) => value !== null) ?? [];
    const [least, most] = [Math.min(...values), Math.max(...values)];
    const withValues = shown !== "policy" && values.length > 0;
    const things = stood(map, map.tools, here()!);
    board.draw({
      world: map,
      things,
      values: withValues
        ? { grid: answer.values!, scale: scaleOf(least, most), unlabelled: shown === "both" }
        : null,
      arrows: shown === "values" ? null : (answer.policy?.cells ?? null),
      now: step < last() ? (answer.policy?.episode[step] ?? null) : null,
      label: (cell) => labelIn(things, cell),
    });
    scale.show(withValues ? { least, most } : null);
    hint.textContent = partial() ? EMPTY : HINT;
    steps.show(step);
    drawBars(answer.policy?.episode[step] ?? null, answer.episode.actions[step]);
    const length = answer.episode.actions.length;
    const { finished, return: total } = answer.episode;
    const best = answer.episode.best_return ?? total;
    const outcome = finished
      ? `the can is in the bin: return ${signed(total)}, best possible ${signed(best)}`
      : answer.episode.best_return === null
        ? "the bin is unreachable from the start"
        : "then it goes in circles: the can never reaches the bin";
    caption.textContent = `${length} ${length === 1 ? "step" : "steps"}, ${outcome}.`;
    const curve = answer.curve;
    chart.draw({
      lines: curve ? [{ label: about.name, x: curve.x, y: curve.mean, low: curve.low, high: curve.high, kind: 0 }] : [],
      xLabel: "episodes",
      yLabel: "return",
      level: answer.best_return == null ? null : { y: answer.best_return, label: "best possible" },
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

  /** A cell, its contents, its value and the most probable action there. */
  function labelIn(things: readonly Stood[], cell: Cell): string {
    const words = labelOf(map, things, cell, answer?.values, "expected return");
    const shares = answer?.policy?.cells[cell[0]]?.[cell[1]];
    if (!shares) return words;
    const likeliest = shares.indexOf(Math.max(...shares));
    return `${words}, ${hello.actions[likeliest]} ${Math.round(100 * shares[likeliest]!)} %`;
  }

  /** Whether a thing may be put into a cell. */
  function free({ what, of }: Standing, cell: Cell, among: Placement): boolean {
    const taken = [among.agent, ...among.tools, ...among.objects].some((other) => same(other, cell));
    const goal = what === "object" ? map.objects[of]!.goal : null;
    const done = goal !== null && same(cell, cellOf(map, goal));
    return !taken && !done && !map.walls[indexOf(map, cell)];
  }

  /** The draggable thing in a cell: anything but a bin. */
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
      h("div", { class: "card-foot" }, h("div", { class: "buttons" }, play, back), steps.element, layers.element),
      h("p", { class: "quiet", id: "run-hint" }, hint),
    ),
    card(
      "Trained agent",
      "side",
      h("h3", {}, "Action probabilities"),
      bars,
      caption,
      h("h3", {}, "Learning curve"),
      chart.element,
    ),
  );
  const empty = h(
    "div",
    { class: "nothing" },
    h("h2", {}, "There is no agent to watch yet"),
    h("p", {}, "Train an agent in the Train tab, press Watch beside an earlier training there, or start the studio with a folder written by habilis train:"),
    h("code", {}, "habilis studio FOLDER"),
  );
  const element = h("div", { class: "run-place" }, empty, full);

  watched.watch((about) => {
    empty.hidden = about !== null;
    full.hidden = about === null;
    if (about === null) return;
    [answer, moved, elsewhere, which] = [null, null, null, 0];
    map = worldOf(about.drawn);
    title.textContent = title.title = about.name;
    const runs = Object.fromEntries(
      Array.from({ length: about.runs }, (_, k) => [String(k), `run ${k + 1} of ${about.runs}`]),
    );
    index.replaceChildren(select("Run number", runs, (chosen) => {
      which = Number(chosen);
      load();
    }));
    if (active) load();
  });
  function keeps(): Keeps {
    const about = watched.current();
    if (about === null || !answer?.episode) return NOTHING;
    const { values, episode } = answer;
    const scene = { drawn: drawnOf(map) };
    return {
      pictures: [
        { name: "Episode", picture: board.picture },
        ...(answer.curve ? [{ name: "Learning curve", picture: chart.picture }] : []),
      ],
      tables: [
        ...(values ? [{ name: "State values", rows: rowsOf(values, "value") }] : []),
        ...(answer.curve ? [{ name: "Learning curve", rows: pointsOf(chart.lines(), "episode", "return") }] : []),
      ],
      films: [{ name: "Episode", film: () => Promise.resolve({ scene, placements: episode.placements }) }],
      code: {
        scene,
        view: "run",
        index: which,
        ...(about.asked === undefined ? {} : { name: about.asked }),
        ...(elsewhere === null ? {} : { placements: [elsewhere] }),
      },
    };
  }

  return {
    element,
    keeps,
    entered() {
      active = true;
      if (watched.current() !== null && answer === null) load();
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
