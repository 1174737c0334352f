/** The idea in a minute, and every key. */

import { h } from "../core/elements";
import type { Hello } from "../core/protocol";
import { openDialog } from "./dialog";

const KEYS: [string, string][] = [
  ["1 2 3 4", "Design, Play, Train, Run"],
  ["Ctrl Z, Ctrl Shift Z", "undo, redo"],
  ["?", "this page"],
  ["Design: arrows", "go from cell to cell"],
  ["Space", "wall or floor; in the landscape: choose a cell"],
  ["A T C B", "put agent, tool, can, bin there"],
  ["Delete", "take away what is there"],
  ["Play: arrows", "move the agent"],
  ["W A S D", "put the tool north, west, south, east"],
  ["B", "the bits of every cell"],
  ["Q", "put the tool down, where that is allowed"],
  ["R", "start again"],
];

export function openHelp({ limits, version }: Hello): void {
  openDialog(
    "What is this?",
    h(
      "p",
      {},
      "An agent that can bring about many different futures has power over its world; one that is stuck has none. Count the futures it could choose among within a few steps, take the logarithm, and you have its ",
      h("strong", {}, "empowerment"),
      ": 1 bit is a choice of two, 3 bits a choice of eight.",
    ),
    h(
      "p",
      {},
      "Looking at the can alone counts what the agent could do ",
      h("em", {}, "to the can"),
      ". Where that is 0, it can do nothing to it. A good tool raises it; a bad one is in the way. Draw walls, drag things, and see.",
    ),
    h(
      "dl",
      { class: "keys" },
      ...KEYS.flatMap(([keys, words]) => [h("dt", {}, keys), h("dd", {}, words)]),
    ),
    h(
      "p",
      { class: "quiet" },
      `Maps of ${limits.side[0]} to ${limits.side[1]} cells a side, up to ${limits.horizon} steps ahead, slip up to ${Math.round(100 * limits.slip)} %. Habilis ${version}; this page asks nobody but your own studio.`,
    ),
  );
}
