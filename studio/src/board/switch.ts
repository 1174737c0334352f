/** The choice between the board that the studio was started with and maps of one's own. */

import type { App, View } from "../core/app";
import { h } from "../core/elements";
import type { BoardAbout } from "../core/protocol";
import { NOTHING } from "../keep/dialog";
import { segmented } from "../frame/widgets";
import { createBoardDesign } from "./design";
import { createBoardPlay } from "./play";
import { createQuestion, type Question } from "./question";

type Side = "board" | "maps";

/** The board beside the maps. */
export interface Boards {
  readonly design: View;
  readonly play: View;
  readonly question: Question;
  /** Whether the board is shown, and not a map. */
  showing(): boolean;
  show(board: boolean): void;
  /** Calls back when the question changes, or the choice between board and maps. */
  watch(watcher: () => void): void;
}

/** The views of maps, each beside the same view of the board. */
export function withBoard(app: App, about: BoardAbout, design: View, play: View): Boards {
  const question = createQuestion(app, about);
  let side: Side = "board";
  const followers: ((before: Side) => void)[] = [];
  const watchers: (() => void)[] = [];

  function turn(next: Side): void {
    const before = side;
    side = next;
    for (const follow of followers) follow(before);
  }

  function both(name: string, ofBoard: View, ofMaps: View): View {
    let inside = false;
    const views: Record<Side, View> = { board: ofBoard, maps: ofMaps };
    const choice = segmented<Side>(`Shown in ${name}`, { board: [about.name], maps: ["Maps"] }, (chosen) => {
      turn(chosen);
      for (const watcher of watchers) watcher();
    });
    const follow = (before: Side) => {
      const changed = inside && before !== side;
      if (changed) views[before].left?.();
      choice.show(side);
      for (const one of ["board", "maps"] as const) views[one].element.hidden = one !== side;
      if (changed) views[side].entered?.();
    };
    followers.push(follow);
    follow(side);
    return {
      element: h("div", {}, h("div", { class: "board-or-maps" }, choice.element), ofBoard.element, ofMaps.element),
      entered() {
        inside = true;
        views[side].entered?.();
      },
      left() {
        inside = false;
        views[side].left?.();
      },
      keeps: () => views[side].keeps?.() ?? NOTHING,
      again() {
        ofBoard.again?.();
        ofMaps.again?.();
      },
    };
  }

  return {
    design: both("Design", createBoardDesign(app, about, question), design),
    play: both("Play", createBoardPlay(app, about, question), play),
    question,
    showing: () => side === "board",
    show: (board) => turn(board ? "board" : "maps"),
    watch(watcher) {
      watchers.push(watcher);
      question.watch(watcher);
    },
  };
}
