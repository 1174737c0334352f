/** Design: the world, its landscape, the question and the comparison of tools. */

import type { App, View } from "../core/app";
import { h } from "../core/elements";
import { message } from "../core/scene";
import type { Keeps } from "../keep/dialog";
import { rowsOf } from "../keep/files";
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
  const [editor, landscape, pairs] = [createEditor(app), createLandscape(app), createPairs(app)];
  const unit = h("span", { class: "quiet" }, "bits, wherever the agent stands");
  const choice = segmented<Values>("Values", { landscape: ["Landscape"], pairs: ["Which tool?"] }, show);
  let shown: Values = "landscape";
  let active = false;

  function show(next: Values): void {
    shown = next;
    choice.show(shown);
    landscape.element.hidden = unit.hidden = shown !== "landscape";
    pairs.element.hidden = shown !== "pairs";
    pairs.turn(active && shown === "pairs");
  }
  show(shown);
  const element = h(
    "div",
    { class: "view design" },
    card("World", "world", bars.above, editor.element, bars.below),
    card(
      "Values",
      "values",
      h("div", { class: "card-head" }, choice.element, unit),
      landscape.element,
      pairs.element,
    ),
    card("Question and answer", "side", createQuestion(app), createAverages(app)),
  );

  function keeps(): Keeps {
    const world = { name: "World", picture: editor.picture };
    if (shown === "pairs") return { ...pairs.keeps(), pictures: [world, ...pairs.keeps().pictures] };
    const { landscape: grid, averages, within, compared, scene } = app.measuring.latest();
    const exact = compared.filter((tool) => averages[tool] != null && !within[tool]);
    return {
      pictures: [
        world,
        { name: "Landscape", picture: landscape.picture },
      ],
      tables: [
        ...(grid ? [{ name: "Landscape", rows: rowsOf(grid, "bits") }] : []),
        {
          name: "Averages",
          rows: [
            ["tool", "bits", "within"],
            ...compared.map((tool) => [tool, averages[tool] ?? null, within[tool] ?? null]),
          ],
        },
      ],
      films: [],
      code: { scene: message(scene ?? app.store.scene()), view: "landscape", tools: exact },
    };
  }

  return {
    element,
    keeps,
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
