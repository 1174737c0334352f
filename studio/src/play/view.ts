/** Play: the arrow keys move the agent, W A S D the tool; a chart shows the bits along the way. */

import type { App, View } from "../core/app";
import { h } from "../core/elements";
import { message, toolsOf } from "../core/scene";
import { namesOf } from "../core/world";
import { createBoard } from "../draw/board";
import { same } from "../draw/cells";
import { createChart } from "../draw/chart";
import { labelOf, stood } from "../draw/things";
import { button, card, notice, rename } from "../frame/widgets";
import { ARROWS } from "../design/editor";
import type { Keeps } from "../keep/dialog";
import { rowsOf } from "../keep/files";
import { createBits } from "./bits";
import { createPlayer } from "./game";

const KEYS: Record<string, number> = {
  ArrowUp: 0, ArrowRight: 1, ArrowDown: 2, ArrowLeft: 3, w: 4, d: 5, s: 6, a: 7,
};
const CAPS = [["↑", "→", "↓", "←"], ["W", "D", "S", "A"]] as const;
const SIDES = ["north", "east", "south", "west"];
const MOVES = Object.values(ARROWS);

export function createPlay(app: App): View {
  const { store } = app;
  const board = createBoard("The world being played", "play-board", true);
  const chart = createChart("Bits at each step", "bits-chart");
  const now = h("span", { class: "number", id: "bits-now" }, "–");
  const state = h("p", { class: "quiet", id: "play-state", "aria-live": "polite" });
  const task = h("p", { class: "quiet" });
  const plan = h("p", { class: "quiet", id: "plan", "aria-live": "polite" });
  const player = createPlayer(app, draw);
  const layer = createBits(app, draw);
  let active = false;

  const show = button("Show me", () => {
    if (player.showing()) player.stop();
    else {
      announce("Looking for the shortest plan…");
      player.showPlan(showPlanLength);
    }
    draw();
  }, { id: "show-me", kind: "primary", sign: "play" });
  const reset = button("Restart", player.reset, { id: "reset", sign: "reset" });

  function showPlanLength(steps: number | null): void {
    if (steps === null) notice("The goal is unreachable from here");
    announce(
      steps === null
        ? "No plan: the bin is unreachable."
        : `Shortest plan from here: ${steps} ${steps === 1 ? "step" : "steps"}.`,
    );
  }

  /** Shows a message about a plan in place of the task. */
  function announce(words: string): void {
    plan.textContent = words;
    plan.hidden = words === "";
    task.hidden = !plan.hidden;
  }

  const drop = button("Drop", () => player.act(8), { id: "put-down" });
  drop.title = "Drop the tool in hand (Q)";
  const pads = CAPS.map((caps, of) =>
    h(
      "div",
      { class: "pad", role: "group", "aria-label": of ? "Put the tool" : "Move the agent" },
      ...caps.map((cap, side) =>
        h(
          "button",
          {
            type: "button",
            class: `key ${SIDES[side]}`,
            "aria-label": `${of ? "tool" : "agent"} ${SIDES[side]}`,
            onclick: () => player.act(4 * of + side),
          },
          cap,
        ),
      ),
      h("span", { class: "pad-name" }, of ? "tool" : "agent"),
    ),
  );

  function draw(): void {
    const scene = store.scene();
    const { world } = scene;
    const tools = toolsOf(scene);
    const { placement, bits, equipped, attached, ended, error } = player.game();
    const things = stood(world, tools, placement);
    const values = active ? layer.under(placement) : null;
    board.draw({
      world, things, values,
      label: (cell) => labelOf(world, things, cell, values?.grid, "bits"),
    });
    board.picture.classList.toggle("waiting", layer.late());
    const steps = bits.length - 1;
    const last = bits.at(-1) ?? null;
    now.textContent = last === null ? "–" : last.toFixed(2);
    const known = bits.map((value, step) => [step, value] as const).filter(([, b]) => b !== null);
    chart.draw({
      lines: [{ label: "bits", x: known.map(([k]) => k), y: known.map(([, b]) => b!), kind: 0 }],
      xLabel: "step",
      yLabel: "bits",
      steps: false,
      xMost: Math.max(10, steps),
      yLeast: 0,
      yMost: Math.max(1, ...known.map(([, b]) => b!)),
      empty: "",
    });
    const [many, object] = [world.objects.length > 1, namesOf(world.objects)[0]!];
    const held = tools.length > 1 && placement.held !== undefined && placement.held >= 0
      ? namesOf(tools)[placement.held]!
      : "tool";
    const hand = attached
      ? `${many ? "an object" : `the ${object}`} is attached`
      : equipped ? `the ${held} is in hand` : "";
    const after = `${steps} ${steps === 1 ? "step" : "steps"}`;
    const fault = error ?? layer.fault();
    state.textContent = fault || (ended ? `${many ? "Every object is in its bin" : `The ${object} is in the bin`} after ${after}.` : [after, hand].filter(Boolean).join(" · "));
    state.classList.toggle("fault", Boolean(fault));
    state.classList.toggle("good", ended);
    pads[1]!.classList.toggle("off", !tools.length);
    for (const key of pads[1]!.querySelectorAll("button")) key.disabled = !tools.length;
    drop.hidden = !world.drop || !tools.length;
    task.textContent = many ? "bring every object to its bin" : `bring the ${object} to the bin`;
    if (player.showing()) rename(show, "Stop", "stop");
    else rename(show, "Show me", "play");
    if (!steps && !player.showing()) announce("");
  }

  /** The move into the cell under the pointer, if it is next to the agent. */
  function moveUnder(event: PointerEvent): number {
    const cell = board.cellAt(event);
    const [row, column] = player.game().placement.agent;
    return MOVES.findIndex(([down, right]) => cell !== null && same(cell, [row + down, column + right]));
  }
  board.picture.addEventListener("pointerdown", (event) => {
    const action = moveUnder(event);
    if (action >= 0 && event.button === 0) player.act(action);
  });
  board.picture.addEventListener("pointermove", (event) => {
    board.picture.dataset.over = moveUnder(event) >= 0 ? "beside" : "";
  });

  addEventListener("keydown", (event) => {
    if (!active || event.ctrlKey || event.metaKey || event.altKey) return;
    const target = event.target as Element;
    if (target.closest("input:not([type=checkbox]), select, textarea, dialog")) return;
    const action = KEYS[event.key.length === 1 ? event.key.toLowerCase() : event.key];
    if (action !== undefined && allowed(action)) player.act(action);
    else if (event.key === "r") player.reset();
    else if (event.key === "b") layer.turn();
    else return;
    event.preventDefault();
  });

  /** Whether the action exists: without a tool there are only moves. */
  function allowed(action: number): boolean {
    const scene = store.scene();
    const tools = toolsOf(scene).length > 0;
    return action < 4 || (tools && (action < 8 || scene.world.drop));
  }

  draw();
  const element = h(
    "div",
    { class: "view play" },
    card(
      "Game",
      "world",
      h("div", { class: "card-head" }, h("h2", {}, "Play"), task, plan),
      board.element,
      layer.scale,
      h("div", { class: "card-foot" }, h("div", { class: "buttons" }, show, reset, drop, layer.toggle)),
    ),
    card(
      "Empowerment",
      "side",
      h("div", { class: "reading" }, now, h("span", { class: "unit" }, "bits here"), state),
      chart.element,
      h("div", { class: "pads" }, ...pads),
    ),
  );
  function keeps(): Keeps {
    const { path, bits } = player.game();
    const scene = message(store.scene());
    const grid = layer.grid();
    return {
      pictures: [
        { name: "Board", picture: board.picture },
        ...(chart.lines().length ? [{ name: "Bits of the game", picture: chart.picture }] : []),
      ],
      tables: [
        ...(grid ? [{ name: "Board", rows: rowsOf(grid, "bits") }] : []),
        { name: "Bits of the game", rows: [["step", "bits"], ...bits.map((value, step) => [step, value])] },
      ],
      films: [
        { name: "The game so far", film: () => Promise.resolve({ scene, placements: path }) },
        { name: "A shortest plan from here", film: () => player.plan().then((placements) => ({ scene, placements })) },
      ],
      code: { scene, view: "game", placements: path },
    };
  }

  return {
    element,
    keeps,
    entered() {
      active = true;
      player.seen(true);
      board.picture.focus({ preventScroll: true });
      draw();
    },
    left() {
      active = false;
      player.seen(false);
    },
  };
}
