/** A short introduction, and all keys. */

import { h } from "../core/elements";
import type { Hello } from "../core/protocol";
import { openDialog } from "./dialog";
import { button } from "./widgets";

const KEYS: [string, string][] = [
  ["1 2 3 4", "Design, Play, Train, Run"],
  ["Ctrl Z, Ctrl Shift Z", "undo, redo"],
  ["?", "this help"],
  ["Design: arrows", "move between cells"],
  ["Space", "toggle wall and floor; in the landscape, choose a cell"],
  ["A T C B", "put agent, tool, can, bin into the cell"],
  ["Delete", "remove what is in the cell"],
  ["Play: arrows", "move the agent"],
  ["W A S D", "put the tool north, west, south, east"],
  ["B", "show the bits of every cell"],
  ["Q", "drop the tool, if the map allows it"],
  ["R", "restart"],
];

export function openHelp({ limits, version }: Hello, beginTour: () => void): void {
  const close = openDialog(
    "What is this?",
    h(
      "p",
      {},
      "An agent that can reach many different futures has control over its world; one that is stuck has none. Count the distinguishable futures it can choose from within a few steps and take the logarithm: this is its ",
      h("strong", {}, "empowerment"),
      ". 1 bit is a choice of two, 3 bits a choice of eight.",
    ),
    h(
      "p",
      {},
      "With the can as the only observation, it counts what the agent can do ",
      h("em", {}, "to the can"),
      ". Where it is 0, the agent cannot affect the can. A good tool raises it; a bad one gets in the way. Draw walls and drag things to explore.",
    ),
    button("Take the one-minute tour", () => (close(), beginTour()), { id: "tour-again", kind: "small" }),
    h(
      "dl",
      { class: "keys" },
      ...KEYS.flatMap(([keys, words]) => [h("dt", {}, keys), h("dd", {}, words)]),
    ),
    h(
      "p",
      { class: "quiet" },
      `Maps of ${limits.side[0]} to ${limits.side[1]} rows and columns, up to ${limits.horizon} steps ahead, slip up to ${Math.round(100 * limits.slip)} %. Rows and columns are counted from 0. Habilis ${version}; this page contacts no server but your own studio.`,
    ),
  );
}
