/** Design: the world, its landscape, the question and the comparison of tools. */

import type { App, View } from "../core/app";
import { h } from "../core/elements";
import { card } from "../frame/widgets";
import { createAverages } from "./averages";
import { createBars } from "./bar";
import { createEditor } from "./editor";
import { createLandscape } from "./landscape";
import { createQuestion } from "./question";

export function createDesign(app: App): View {
  const bars = createBars(app);
  const element = h(
    "div",
    { class: "view design" },
    card("World", "world", bars.above, createEditor(app).element, bars.below),
    card(
      "Landscape",
      "values",
      h("div", { class: "card-head" }, h("h2", {}, "Landscape"), h("span", { class: "quiet" }, "bits, wherever the agent stands")),
      createLandscape(app),
    ),
    card("Question and answer", "side", createQuestion(app), createAverages(app)),
  );
  return { element };
}
