/** The choice between the board that the studio was started with and maps of one's own. */

import type { App, View } from "../core/app";
import { h } from "../core/elements";
import type { BoardAbout } from "../core/protocol";
import { NOTHING } from "../keep/dialog";
import { segmented } from "../frame/widgets";
import { createBoardDesign } from "./design";
import { createBoardPlay } from "./play";
import { createQuestion } from "./question";

type Side = "board" | "maps";

/** The views of maps, each beside the same view of the board. */
export function withBoard(app: App, about: BoardAbout, design: View, play: View): { design: View; play: View } {
  const question = createQuestion(app, about);
  let side: Side = "board";
  const followers: (() => void)[] = [];

  function both(name: string, ofBoard: View, ofMaps: View): View {
    let inside = false;
    const views: Record<Side, View> = { board: ofBoard, maps: ofMaps };
    const choice = segmented<Side>(`Shown in ${name}`, { board: [about.name], maps: ["Maps"] }, (chosen) => {
      if (inside) views[side].left?.();
      side = chosen;
      for (const follow of followers) follow();
      if (inside) views[side].entered?.();
    });
    const follow = () => {
      choice.show(side);
      for (const one of ["board", "maps"] as const) views[one].element.hidden = one !== side;
    };
    followers.push(follow);
    follow();
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
  };
}
