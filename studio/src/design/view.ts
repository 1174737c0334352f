/** Design: the world, its landscape, the question and the comparison of tools. */

import type { App, View } from "../core/app";
import { h } from "../core/elements";
import { card, segmented } from "../frame/widgets";
import { createAverages } from "./averages";
import { createBars } from "./bar";
import { createEditor } from "./editor";
import { createLandscape } from "./landscape";
import { createPairs } from "./pairs";
import { createQuestion } from "./question";

type Values = "landscape" | "pairs";

export function createDesign(app: App): View {
  const bars = createBars(app);
  const [landscape, pairs] = [createLandscape(app), createPairs(app)];
  const unit = h("span", { class: "quiet" }, "bits, wherever the agent stands");
  const choice = segmented<Values>("Values", { landscape: ["Landscape"], pairs: ["Which tool?"] }, show);
  let shown: Values = "landscape";
  let active = false;

  function show(next: Values): void {
    shown = next;
    choice.show(shown);
    landscape.hidden = unit.hidden = shown !== "landscape";
    pairs.element.hidden = shown !== "pairs";
    pairs.turn(active && shown === "pairs");
  }
  show(shown);
  const element = h(
    "div",
    { class: "view design" },
    card("World", "world", bars.above, createEditor(app).element, bars.below),
    card(
      "Values",
      "values",
      h("div", { class: "card-head" }, choice.element, unit),
      landscape,
      pairs.element,
    ),
    card("Question and answer", "side", createQuestion(app), createAverages(app)),
  );
  return {
    element,
    entered() {
      active = true;
      pairs.turn(shown === "pairs");
    },
    left() {
      active = false;
      pairs.turn(false);
    },
    again: pairs.again,
  };
}
