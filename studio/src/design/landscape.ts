/** The values over the map; pointing at a cell shows the futures reachable from there. */

import type { App } from "../core/app";
import type { Asked } from "../core/connection";
import { h } from "../core/elements";
import { hintOf } from "../core/kinds";
import type { Measured } from "../core/measuring";
import type { Cell, FuturesAnswer } from "../core/protocol";
import { cellOf, indexOf, message, objectOf, startOf, toolsOf, type Scene, type Sensor } from "../core/scene";
import { namesOf } from "../core/world";
import { createBoard, type Mark } from "../draw/board";
import { letDrag } from "../draw/dragging";
import { labelOf, rowColumn, stood } from "../draw/things";
import { same } from "../draw/cells";
import { scaleOf } from "../draw/colours";
import { createScaleBar } from "../draw/scale";
import { ARROWS } from "./editor";

const HOVER_WAIT = 40;

const COUNTED: Record<Sensor, (count: number, name: string) => string> = {
  object: (n, name) => `${n} reachable ${n === 1 ? "cell" : "cells"} for the ${name}`,
  tool: (n, name) => `${n} reachable ${n === 1 ? "cell" : "cells"} for the ${name}`,
  agent: (n) => `the agent can reach ${n} ${n === 1 ? "cell" : "cells"}`,
  state: (n, name) => `${n} reachable ${n === 1 ? "state" : "states"}; marked: the cells of the ${name}`,
  cells: (n, name) => `${n} ${n === 1 ? "observation" : "different observations"} of the ${name}`,
};

/** The name of the observed thing. */
function sensed(scene: Scene): string {
  const { world, sensor, thing } = scene;
  if (sensor !== "tool") return objectOf(scene);
  return world.tools.length > 1 ? namesOf(world.tools)[thing]! : "tool";
}

export function createLandscape({ connection, store, measuring }: App): { element: HTMLElement; picture: SVGSVGElement } {
  const board = createBoard("The landscape: bits for every cell of the agent", "landscape-board");
  const { picture } = board;
  const caption = h("p", { class: "caption", id: "caption", "aria-live": "polite" });
  const scale = createScaleBar("bits");
  const progress = h("div", { class: "progress", role: "progressbar", "aria-label": "computing" });
  const fault = h("p", { class: "fault", role: "alert", id: "fault" });

  let hovered: Cell | null = null;
  let marks: Mark[] | null = null;
  let asked: Asked | null = null;
  let timer = 0;
  let drags = 0;

  function draw(): void {
    const scene = store.scene();
    const { world } = scene;
    const start = startOf(scene);
    const { landscape, least, most, scene: of } = measuring.latest();
    const fits = of?.world.height === world.height && of.world.width === world.width;
    const grid = landscape && fits ? landscape : null;
    picture.classList.toggle("choosing", choosing());
    const things = stood(world, toolsOf(scene), hovered && marks ? { ...start, agent: hovered } : start);
    board.draw({
      world,
      things,
      values: grid && { grid, scale: scaleOf(least, most) },
      chosen: scene.sensor === "cells" ? scene.cells.map((cell) => cellOf(world, cell)) : [],
      marks,
      label: (cell) => labelOf(world, things, cell, grid, "bits"),
    });
  }

  function update({ pending, progress: share, error, landscape, ...values }: Measured): void {
    picture.classList.toggle("waiting", pending);
    progress.classList.toggle("going", pending);
    progress.classList.toggle("measured", share !== null);
    progress.style.setProperty("--share", String(share ?? 0));
    fault.textContent = error ?? "";
    caption.hidden = error !== null;
    if (hovered === null) caption.textContent = hint();
    scale.show(error === null && landscape ? values : null);
    picture.dataset.pending = String(pending);
    draw();
  }

  function hint(): string {
    const scene = store.scene();
    return scene.sensor === "cells" && scene.kind === "open-loop"
      ? `Click cells to choose where the ${objectOf(scene)} is observed; point at one to see its futures.`
      : hintOf(scene.kind, measuring.latest().gap);
  }

  function hover(cell: Cell | null): void {
    if (hovered && cell && same(hovered, cell)) return;
    hovered = cell;
    clearTimeout(timer);
    asked?.forget();
    const bits = cell && (measuring.latest().landscape?.[cell[0]]?.[cell[1]] ?? null);
    if (cell === null || bits === null) {
      const had = marks !== null;
      marks = null;
      caption.textContent = hint();
      if (had) draw();
      return;
    }
    if (store.scene().kind !== "open-loop") {
      caption.replaceChildren(`At ${rowColumn(cell)}: `, h("strong", {}, `${bits.toFixed(3)} bits`), ".");
      return;
    }
    timer = window.setTimeout(() => {
      const body = { scene: message(store.scene()), agent: cell };
      asked = connection.ask("futures", body, (answer) => show(cell, answer));
    }, HOVER_WAIT);
  }

  function show(cell: Cell, { bits, things, count, error }: FuturesAnswer): void {
    if (error !== undefined) caption.textContent = error;
    if (bits === undefined || things === undefined) return;
    asked?.forget();
    const likeliest = Math.max(...things.map(([, , probability]) => probability));
    marks = things.map(([row, column, probability]) => ({
      cell: [row, column],
      weight: probability / likeliest,
    }));
    const words = COUNTED[store.scene().sensor](count ?? things.length, sensed(store.scene()));
    caption.replaceChildren(
      `From ${rowColumn(cell)}: `,
      h("strong", {}, `${bits.toFixed(2)} bits`),
      `, ${words}.`,
    );
    draw();
  }

  const choosing = () => store.scene().sensor === "cells";
  const isChosen = (cell: Cell) => store.scene().cells.includes(indexOf(store.scene().world, cell));
  function choose(path: Cell[], wanted: boolean, gesture?: string): void {
    const { cells, world } = store.scene();
    const next = new Set(cells);
    for (const cell of path) next[wanted ? "add" : "delete"](indexOf(world, cell));
    if (next.size === cells.length) return;
    store.change({ cells: [...next].sort((a, b) => a - b) }, gesture);
  }

  letDrag(
    board,
    (cell) => {
      board.moveCursor(cell);
      if (!choosing()) {
        hover(cell); // a finger's tap
        return null;
      }
      const [wanted, gesture] = [!isChosen(cell), `choose ${(drags += 1)}`];
      return { kind: "sight", move: (path) => choose(path, wanted, gesture) };
    },
    (cell) => {
      hover(cell);
      return "cell";
    },
  );
  picture.addEventListener("pointerleave", (event) => {
    if (event.pointerType !== "touch") hover(null); // a finger leaves with every tap
  });
  picture.addEventListener("focus", () => picture.matches(":focus-visible") && hover(board.cursor()));
  picture.addEventListener("blur", () => hover(null));
  picture.addEventListener("keydown", (event) => {
    const step = ARROWS[event.key];
    if (step && !event.ctrlKey) {
      const [row, column] = board.cursor();
      board.moveCursor([row + step[0], column + step[1]]);
      hover(board.cursor());
    } else if ((event.key === " " || event.key === "Enter") && choosing()) {
      choose([board.cursor()], !isChosen(board.cursor()));
    } else return;
    event.preventDefault();
  });

  measuring.watch(update);
  store.watch(() => {
    clearTimeout(timer);
    asked?.forget();
    marks = hovered = null;
    caption.textContent = hint();
    draw();
  });
  const element = h("div", { class: "landscape" }, progress, board.element, scale.element, caption, fault);
  return { element, picture };
}
