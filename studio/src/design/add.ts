/** A menu of what can be put on the map: tools, objects, bins, and whether tools can be put down. */

import type { App } from "../core/app";
import { h } from "../core/elements";
import { namesOf, withGoal, withObject, withTool, type World } from "../core/world";
import { NO_TOOL } from "../core/scene";
import { nameOf } from "../core/words";
import { drawingOf, icon } from "../draw/shapes";

export function createAdd({ hello, store }: App): HTMLElement {
  const { things } = hello.limits;
  const change = (world: World) => store.change({ world, bare: false });
  const entry = (drawing: string, name: string, put: () => void) =>
    h("button", { type: "button", role: "menuitem", onclick: put }, icon(drawing, 20), name);

  const tools = hello.tools
    .filter((tool) => tool !== NO_TOOL)
    .map((tool) => entry(drawingOf(tool), nameOf(tool), () => change(withTool(store.scene().world, tool))));
  const objects = hello.objects.map((kind) =>
    entry(kind, nameOf(kind), () => store.change({ world: withObject(store.scene().world, kind) })),
  );
  const bins = h("div", { class: "menu-part" });
  const drop = h("input", {
    type: "checkbox",
    id: "drop",
    onchange: () => store.change({ world: { ...store.scene().world, drop: drop.checked } }),
  });
  const menu = h(
    "div",
    { class: "menu", role: "menu", "aria-label": "Add to the map" },
    h("h3", {}, "Tools"),
    h("div", { class: "menu-part" }, ...tools),
    h("h3", {}, "Objects"),
    h("div", { class: "menu-part" }, ...objects, bins),
    h("label", { class: "menu-check" }, drop, "The tool in hand can be dropped"),
    h("p", { class: "quiet" }, "To remove a thing, drag it off the map or press Delete on it."),
  );
  const element = h("details", { class: "add" }, h("summary", { class: "button", id: "add" }, "Add"), menu);
  document.addEventListener("pointerdown", (event) => {
    if (!element.contains(event.target as Node)) element.open = false;
  });
  document.addEventListener("keydown", (event) => {
    if (event.key !== "Escape" || !element.open) return;
    element.open = false;
    element.querySelector("summary")!.focus();
  });

  store.watch(({ world }) => {
    const names = namesOf(world.objects);
    for (const button of tools) button.disabled = world.tools.length >= things;
    for (const button of objects) button.disabled = world.objects.length >= things;
    bins.replaceChildren(
      ...world.objects.flatMap(({ goal }, of) =>
        goal === null
          ? [entry("bin", `Bin of the ${names[of]}`, () => store.change({ world: withGoal(store.scene().world, of) }))]
          : [],
      ),
    );
    drop.checked = world.drop;
    drop.disabled = !world.tools.length;
  });
  return element;
}
