/** The controls around the map: built-in worlds, undo, text, tool and size. */

import type { App } from "../core/app";
import { h } from "../core/elements";
import { fitted, NO_TOOL, toolOf } from "../core/scene";
import { nameOf } from "../core/words";
import { drawnOf, resized, withTool, worldOf } from "../core/world";
import { drawingOf, icon } from "../draw/shapes";
import { iconButton, segmented, select } from "../frame/widgets";
import { createAdd } from "./add";
import { openMapText } from "./map-text";

const OWN = "your own";

export function createBars(app: App): { above: HTMLElement; below: HTMLElement } {
  const { hello, store } = app;
  const names = Object.keys(hello.worlds);
  const code = (drawn: object) => JSON.stringify(drawn);
  const codes = new Map(names.map((name) => [code(drawnOf(worldOf(hello.worlds[name]!))), name]));

  const worlds = select("Built-in worlds", { "": OWN, ...Object.fromEntries(names.map((n) => [n, n])) }, load);
  worlds.id = "worlds";
  worlds.options[0]!.hidden = true;
  function load(name: string): void {
    const drawn = hello.worlds[name];
    if (drawn === undefined) return;
    const world = worldOf(drawn);
    store.change(fitted({ ...store.scene(), world, bare: !world.tools.length, cells: [] }));
  }

  const undo = iconButton("undo", "Undo (Ctrl+Z)", store.undo, "undo");
  const redo = iconButton("redo", "Redo (Ctrl+Shift+Z)", store.redo, "redo");
  const text = iconButton("text", "Map text: import and export", () => openMapText(app), "map-text");
  const clear = iconButton("eraser", "Erase all walls", () => {
    const { world } = store.scene();
    store.change({ world: { ...world, walls: world.walls.map(() => false) } });
  }, "erase");

  const tools = segmented(
    "Tool",
    Object.fromEntries(
      hello.tools.map((tool) => [
        tool,
        tool === NO_TOOL
          ? ["None"]
          : [icon(drawingOf(tool), 20), h("span", { class: "segment-name" }, nameOf(tool))],
      ]),
    ),
    (tool) => {
      const scene = store.scene();
      const { world } = scene;
      if (tool === NO_TOOL) return store.change(fitted({ ...scene, bare: true }));
      const next = world.tools.length
        ? { ...world, tools: world.tools.with(0, { ...world.tools[0]!, kind: tool }) }
        : withTool(world, tool);
      store.change(fitted({ ...scene, world: next, bare: false }));
    },
  );
  tools.element.classList.add("tools");
  const inUse = segmented("Tools", { all: ["All tools"], none: ["No tool"] }, (chosen) =>
    store.change(fitted({ ...store.scene(), bare: chosen === NO_TOOL })),
  );

  const [least, most] = hello.limits.side;
  const side = (label: string, id: string) =>
    h("input", { type: "number", id, "aria-label": label, min: least, max: most, title: label });
  const rows = side(`Rows, ${least} to ${most}`, "rows");
  const columns = side(`Columns, ${least} to ${most}`, "columns");
  const resize = () => {
    const { world } = store.scene();
    const within = (value: number, now: number) =>
      Number.isInteger(value) && value ? Math.min(Math.max(value, least), most) : now;
    const height = within(Number(rows.value), world.height);
    const width = within(Number(columns.value), world.width);
    if (height !== world.height || width !== world.width) {
      store.change({ world: resized(world, height, width), cells: [] }, "resize");
    }
    rows.value = String(height);
    columns.value = String(width);
  };
  rows.addEventListener("change", resize);
  columns.addEventListener("change", resize);

  store.watch((scene) => {
    const { world, bare } = scene;
    worlds.value = codes.get(code(drawnOf(world))) ?? "";
    undo.disabled = !store.canUndo();
    redo.disabled = !store.canRedo();
    tools.element.hidden = world.tools.length > 1;
    inUse.element.hidden = !tools.element.hidden;
    tools.show(toolOf(scene) ?? "");
    inUse.show(bare ? NO_TOOL : "all");
    rows.value = String(world.height);
    columns.value = String(world.width);
  });

  return {
    above: h(
      "div",
      { class: "card-head" },
      h("h2", {}, "World"),
      worlds,
      h("div", { class: "icons" }, undo, redo, clear, text),
    ),
    below: h(
      "div",
      { class: "card-foot" },
      h("div", { class: "buttons" }, tools.element, inUse.element, createAdd(app)),
      h("div", { class: "size" }, rows, h("span", {}, "×"), columns),
    ),
  };
}
