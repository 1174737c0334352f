/** Play on the board with its own actions; a chart shows the bits along the way. */

import type { App, View } from "../core/app";
import type { Asked } from "../core/connection";
import { h } from "../core/elements";
import type { BoardAbout, Grid } from "../core/protocol";
import { createBoard } from "../draw/board";
import { createChart } from "../draw/chart";
import { scaleOf } from "../draw/colours";
import { createScaleBar } from "../draw/scale";
import { NOTHING, type Keeps } from "../keep/dialog";
import { rowsOf } from "../keep/files";
import { button, card, notice, rename, toggle } from "../frame/widgets";
import { createBoardPlayer } from "./game";
import { keysOf } from "./keys";
import { pictureOf } from "./picture";
import type { Question } from "./question";

export function createBoardPlay(app: App, about: BoardAbout, question: Question): View {
  const board = createBoard(`${about.name}, being played`, "board-play", true);
  const chart = createChart("Bits at each step", "board-chart");
  const now = h("span", { class: "number", id: "board-bits" }, "–");
  const state = h("p", { class: "quiet", id: "board-state", "aria-live": "polite" });
  const plan = h("p", { class: "quiet", id: "board-plan", "aria-live": "polite" });
  const scale = createScaleBar("bits if the agent stood there");
  const layer = toggle("Bits", "board-layer", draw);
  const player = createBoardPlayer(app, about, question, draw);
  const keys = keysOf(about.actions);
  let active = false;
  let values: { grid: Grid; least: number; most: number } | null = null;
  let of = ""; // the question that the values answer
  let asked: Asked | null = null;
  let fault = "";

  const show = button("Show me", () => {
    if (player.showing()) player.stop();
    else {
      plan.textContent = "Looking for the shortest plan…";
      player.showPlan((steps) => {
        if (steps === null) notice("The goal is unreachable from here");
        plan.textContent = steps === null
          ? "No plan: the goal is unreachable."
          : `Shortest plan from here: ${steps} ${steps === 1 ? "step" : "steps"}.`;
      });
    }
    draw();
  }, { id: "board-show", kind: "primary", sign: "play" });
  show.disabled = about.random;
  show.title = about.random ? "A stochastic world has no shortest plan" : "";
  const reset = button("Restart", () => {
    plan.textContent = "";
    player.reset();
  }, { id: "board-reset", sign: "reset" });

  /** Requests the landscape with all but the agent where it is now. */
  function underlay(): void {
    const { placement } = player.game();
    const body = { scene: question.message(), placement };
    const next = JSON.stringify([body.scene, about.image === null ? placement.objects : placement.state]);
    if (next === of) return;
    asked?.forget();
    of = next;
    asked = app.connection.ask("landscape", body, (answer) => {
      if (answer.progress !== undefined) return;
      asked?.forget();
      if (answer.lost) return void (of = "");
      const { landscape: grid, least, most } = answer;
      values = grid && least != null && most != null ? { grid, least, most } : null;
      fault = answer.error ?? "";
      draw();
    });
  }

  function draw(): void {
    const { placement, image, bits, ended, error, total } = player.game();
    if (active && layer.on()) underlay();
    else [of, values, fault] = ["", null, ""];
    board.draw({
      ...pictureOf(about, placement, image, values?.grid ?? null),
      values: values && { grid: values.grid, scale: scaleOf(values.least, values.most) },
    });
    scale.show(values);
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
    const after = `${steps} ${steps === 1 ? "step" : "steps"}`;
    const sum = `return ${String(Number(total.toFixed(3))).replace("-", "−")}`;
    state.textContent = error ?? (fault || `${ended ? "The episode has ended after " : ""}${after} · ${sum}`);
    state.classList.toggle("fault", Boolean(error ?? fault));
    state.classList.toggle("good", ended);
    if (player.showing()) rename(show, "Stop", "stop");
    else rename(show, "Show me", "play");
  }

  addEventListener("keydown", (event) => {
    if (!active || event.ctrlKey || event.metaKey || event.altKey) return;
    if ((event.target as Element).closest("input:not([type=checkbox]), select, textarea, dialog")) return;
    const pressed = event.key.length === 1 ? event.key.toLowerCase() : event.key;
    const action = keys.findIndex(({ key }) => key === pressed);
    if (action >= 0) player.act(action);
    else if (pressed === "r") player.reset();
    else if (pressed === "b") layer.turn();
    else return;
    event.preventDefault();
  });

  const buttons = about.actions.map((name, action) =>
    h(
      "button",
      { type: "button", class: "button small", onclick: () => player.act(action), "data-action": name },
      h("kbd", {}, keys[action]!.cap),
      h("span", {}, name),
    ),
  );
  draw();
  const element = h(
    "div",
    { class: "view play" },
    card(
      "Game",
      "world",
      h("div", { class: "card-head" }, h("h2", { class: "board-name" }, about.name), plan),
      board.element,
      scale.element,
      h("div", { class: "card-foot" }, h("div", { class: "buttons" }, show, reset, layer.element)),
    ),
    card(
      "Empowerment",
      "side",
      h("div", { class: "reading" }, now, h("span", { class: "unit" }, "bits here"), state),
      chart.element,
      h("div", { class: "buttons actions", role: "group", "aria-label": "Actions" }, ...buttons),
    ),
  );
  function keeps(): Keeps {
    const { bits, path } = player.game();
    const scene = question.message();
    const puzzle = about.image === null; // environments have neither films nor code here
    return {
      ...NOTHING,
      films: puzzle ? [{ name: "The game so far", film: () => Promise.resolve({ scene, placements: [...path] }) }] : [],
      code: puzzle ? { scene, view: "game", placements: [...path] } : null,
      pictures: [
        { name: "Board", picture: board.picture },
        ...(chart.lines().length ? [{ name: "Bits of the game", picture: chart.picture }] : []),
      ],
      tables: [
        ...(values ? [{ name: "Board", rows: rowsOf(values.grid, "bits") }] : []),
        { name: "Bits of the game", rows: [["step", "bits"], ...bits.map((value, step) => [step, value])] },
      ],
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
