/** The landscape over the board; pointing at a cell shows the futures reachable from there. */

import type { App } from "../core/app";
import type { Asked as Request } from "../core/connection";
import { h } from "../core/elements";
import { hintOf } from "../core/kinds";
import type { BoardAbout, Cell, FuturesAnswer, Grid } from "../core/protocol";
import { ARROWS } from "../design/editor";
import { createBoard, type Mark } from "../draw/board";
import { same } from "../draw/cells";
import { scaleOf } from "../draw/colours";
import { createScaleBar } from "../draw/scale";
import { rowColumn } from "../draw/things";
import { pictureOf } from "./picture";
import type { Question } from "./question";

const HOVER_WAIT = 40;

export interface BoardLandscape {
  readonly element: HTMLElement;
  readonly picture: SVGSVGElement;
  /** The values, if there are some. */
  grid(): Grid | null;
  /** Repeats the request after the connection was lost. */
  again(): void;
}

export function createBoardLandscape({ connection }: App, about: BoardAbout, question: Question): BoardLandscape {
  const board = createBoard("The landscape: bits for every cell of the agent", "board-landscape");
  const { picture } = board;
  const caption = h("p", { class: "caption", id: "board-caption", "aria-live": "polite" });
  const scale = createScaleBar("bits");
  const progress = h("div", { class: "progress", role: "progressbar", "aria-label": "computing" });
  const fault = h("p", { class: "fault", role: "alert", id: "board-fault" });
  let values: { grid: Grid; least: number; most: number } | null = null;
  let gap = 0; // by how much a value may be too low
  let marks: Mark[] | null = null;
  let hovered: Cell | null = null;
  let asked: Request | null = null;
  let future: Request | null = null;
  let timer = 0;
  let due = false;

  function draw(): void {
    board.draw({
      ...pictureOf(about, about.start, about.image, values?.grid ?? null),
      values: values && { grid: values.grid, scale: scaleOf(values.least, values.most) },
      marks,
    });
  }

  function wait(pending: boolean, share: number | null = null): void {
    picture.classList.toggle("waiting", pending);
    picture.dataset.pending = String(pending);
    progress.classList.toggle("going", pending);
    progress.classList.toggle("measured", share !== null);
    progress.style.setProperty("--share", String(share ?? 0));
  }

  function ask(): void {
    due = false;
    asked = connection.ask("measure", { scene: question.message() }, (answer) => {
      if (answer.lost) return;
      if (answer.progress !== undefined) return wait(true, answer.progress);
      asked?.forget();
      fault.textContent = answer.error ?? "";
      caption.hidden = answer.error !== undefined;
      const { landscape: grid, least, most } = answer;
      values = grid && least != null && most != null ? { grid, least, most } : null;
      gap = answer.gap ?? 0;
      if (hovered === null) caption.textContent = hintOf(question.scene().kind, gap);
      scale.show(values);
      wait(false);
      draw();
    });
  }

  /** Sends at most one request per frame. */
  function soon(): void {
    hover(null);
    wait(true);
    if (due) return;
    due = true;
    asked?.forget();
    requestAnimationFrame(ask);
  }

  function hover(cell: Cell | null): void {
    if (hovered && cell && same(hovered, cell)) return;
    hovered = cell;
    clearTimeout(timer);
    future?.forget();
    if (cell === null || (values?.grid[cell[0]]?.[cell[1]] ?? null) === null) {
      if (marks !== null) [marks] = [null, draw()];
      marks = null;
      caption.textContent = hintOf(question.scene().kind, gap);
      return;
    }
    if (question.scene().kind !== "open-loop") {
      const bits = values!.grid[cell[0]]![cell[1]]!;
      caption.replaceChildren(`At ${rowColumn(cell)}: `, h("strong", {}, `${bits.toFixed(3)} bits`), ".");
      return;
    }
    timer = window.setTimeout(() => {
      future = connection.ask("futures", { scene: question.message(), agent: cell }, (answer) => show(cell, answer));
    }, HOVER_WAIT);
  }

  function show(cell: Cell, { bits, things, count, error }: FuturesAnswer): void {
    if (error !== undefined) caption.textContent = error;
    if (bits === undefined || things === undefined) return;
    future?.forget();
    const likeliest = Math.max(...things.map(([, , probability]) => probability));
    marks = things.map(([row, column, probability]) => ({ cell: [row, column], weight: probability / likeliest }));
    const reached = count === 1 ? "1 reachable observation" : `${count} reachable observations`;
    caption.replaceChildren(
      `From ${rowColumn(cell)}: `,
      h("strong", {}, `${bits.toFixed(2)} bits`),
      `, ${reached} of the ${question.sensed()}.`,
    );
    draw();
  }

  picture.addEventListener("pointermove", (event) => hover(board.cellAt(event)));
  picture.addEventListener("pointerdown", (event) => {
    const cell = board.cellAt(event);
    if (cell) board.moveCursor(cell);
    hover(cell); // a finger's tap
  });
  picture.addEventListener("pointerleave", (event) => {
    if (event.pointerType !== "touch") hover(null);
  });
  picture.addEventListener("focus", () => picture.matches(":focus-visible") && hover(board.cursor()));
  picture.addEventListener("blur", () => hover(null));
  picture.addEventListener("keydown", (event) => {
    const step = ARROWS[event.key];
    if (!step || event.ctrlKey) return;
    const [row, column] = board.cursor();
    board.moveCursor([row + step[0], column + step[1]]);
    hover(board.cursor());
    event.preventDefault();
  });

  question.watch(soon);
  draw();
  soon();
  return {
    element: h("div", { class: "landscape" }, progress, board.element, scale.element, caption, fault),
    picture,
    grid: () => values?.grid ?? null,
    again: soon,
  };
}
