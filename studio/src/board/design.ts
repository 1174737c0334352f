/** The board as it is, its landscape, and the question. */

import type { App, View } from "../core/app";
import { h } from "../core/elements";
import type { BoardAbout } from "../core/protocol";
import { createBoard } from "../draw/board";
import { card } from "../frame/widgets";
import { NOTHING, type Keeps } from "../keep/dialog";
import { rowsOf } from "../keep/files";
import { keysOf } from "./keys";
import { createBoardLandscape } from "./landscape";
import { pictureOf } from "./picture";
import type { Question } from "./question";

export function createBoardDesign(app: App, about: BoardAbout, question: Question): View {
  const board = createBoard(`${about.name}, as it begins`, "board-start");
  board.draw(pictureOf(about, about.start, about.image, null));
  const landscape = createBoardLandscape(app, about, question);
  const facts = [
    about.states === null ? null : `${about.states.toLocaleString("en-GB")} states`,
    about.objects.length ? `${about.objects.length} ${about.objects.length === 1 ? "movable" : "movables"}` : null,
    about.random ? "random outcomes" : null,
    `actions: ${about.actions.map((name, action) => `${name} (${keysOf(about.actions)[action]!.cap})`).join(", ")}`,
  ];
  const element = h(
    "div",
    { class: "view design" },
    card(
      "World",
      "world",
      h("div", { class: "card-head" }, h("h2", { class: "board-name" }, about.name)),
      board.element,
      h("p", { class: "quiet", id: "board-facts" }, facts.filter(Boolean).join(" · ")),
      h("p", { class: "quiet" }, "Only maps can be edited."),
    ),
    card(
      "Landscape",
      "values",
      h("div", { class: "card-head" }, h("h2", {}, "Landscape"), h("span", { class: "quiet" }, "bits, wherever the agent stands")),
      landscape.element,
    ),
    card("Question", "side", question.element),
  );
  function keeps(): Keeps {
    const grid = landscape.grid();
    return {
      ...NOTHING,
      pictures: [
        { name: "World", picture: board.picture },
        { name: "Landscape", picture: landscape.picture },
      ],
      tables: grid ? [{ name: "Landscape", rows: rowsOf(grid, "bits") }] : [],
      code: about.image === null ? { scene: question.message(), view: "landscape" } : null,
    };
  }

  return { element, keeps, again: landscape.again };
}
