/** What stands around the map: built-in worlds, undo, text, tool and size. */

import type { App } from "../core/app";
import { h } from "../core/elements";
import { mapText, parseMap, resized, rowsOf, withToolPlace } from "../core/world";
import { drawingOf, icon } from "../draw/shapes";
import { iconButton, segmented, select } from "../frame/widgets";
import { openMapText } from "./map-text";

const OWN = "your own";

export function createBars(app: App): { above: HTMLElement; below: HTMLElement } {
  const { hello, store } = app;
  const names = Object.keys(hello.worlds);
  const codes = new Map(names.map((name) => [rowsOf(hello.worlds[name]!).join("\n"), name]));

  const worlds = select("Built-in worlds", { "": OWN, ...Object.fromEntries(names.map((n) => [n, n])) }, load);
  worlds.id = "worlds";
  worlds.options[0]!.hidden = true;
  function load(name: string): void {
    const text = hello.worlds[name];
    if (text === undefined) return;
    const { world, tool } = parseMap(text);
    const known = (tool && hello.tool_characters[tool]) ?? "none";
    store.change({ world, tool: known, cells: [] });
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
        tool === "none" ? ["No tool"] : [icon(drawingOf(tool), 20), nameOfTool(tool)],
      ]),
    ),
    (tool) => {
      const { world, sensor } = store.scene();
      if (tool !== "none") store.change({ tool, world: withToolPlace(world) });
      else store.change({ tool, sensor: sensor === "tool" ? "object" : sensor });
    },
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

  store.watch(({ world, tool }) => {
    const character = Object.entries(hello.tool_characters).find(([, name]) => name === tool)?.[0];
    worlds.value = codes.get(mapText(world, character ?? "P")) ?? "";
    if (!worlds.value && tool === "none") worlds.value = codes.get(mapText(world, "P")) ?? "";
    undo.disabled = !store.canUndo();
    redo.disabled = !store.canRedo();
    tools.show(tool);
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
      tools.element,
      h("div", { class: "size" }, rows, h("span", {}, "×"), columns),
    ),
  };
}

/** A tool of one's own goes by its file and class; the class says enough. */
export function nameOfTool(tool: string): string {
  const name = tool.split(":").at(-1)!;
  return name === "none" ? "No tool" : name[0]!.toUpperCase() + name.slice(1);
}
