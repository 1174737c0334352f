/** The map as text, to copy, to change and to take in. The server says whether text is a map. */

import type { App } from "../core/app";
import { h } from "../core/elements";
import type { LandscapeAnswer } from "../core/protocol";
import { message } from "../core/scene";
import { mapText, parseMap } from "../core/world";
import { openDialog } from "../frame/dialog";
import { button, notice } from "../frame/widgets";

export function openMapText({ connection, store, hello }: App): void {
  const scene = store.scene();
  const character = Object.entries(hello.tool_characters).find(([, name]) => name === scene.tool);
  const area = h("textarea", { id: "text", spellcheck: "false", "aria-label": "Map text" });
  area.rows = Math.min(Math.max(scene.world.height + 1, 8), 22);
  area.value = mapText(scene.world, character?.[0] ?? "");
  const fault = h("p", { class: "fault", role: "alert" });

  function takeIn(): void {
    fault.textContent = "";
    const map = area.value; // whole, so that the server counts its lines as one sees them
    const { tool } = parseMap(map);
    const name = (tool && hello.tool_characters[tool]) ?? "none";
    const asked = connection.ask<LandscapeAnswer>(
      "landscape",
      { scene: { ...message(scene), map, tool: name, cells: [], sensor: "object", horizon: 0 } },
      (answer) => {
        if (answer.error !== undefined) fault.textContent = answer.error;
        else if (answer.landscape) {
          asked.forget();
          store.change({ world: parseMap(map).world, tool: name, cells: [] });
          close();
        }
      },
    );
  }

  const copy = button("Copy", async () => {
    await navigator.clipboard.writeText(area.value);
    notice("Copied");
  });
  const save = button("Save as file", () => {
    const link = h("a", { download: "map.txt" });
    link.href = URL.createObjectURL(new Blob([`${area.value}\n`], { type: "text/plain" }));
    link.click();
    URL.revokeObjectURL(link.href);
  });
  const file = h("input", { type: "file", accept: ".txt,text/plain", hidden: true });
  file.addEventListener("change", async () => {
    area.value = (await file.files?.[0]?.text()) ?? area.value;
  });
  const close = openDialog(
    "Map text",
    h(
      "p",
      { class: "quiet" },
      "One character a cell: # wall, . floor, A agent, P picker, B broom, C can, G bin.",
    ),
    area,
    fault,
    h(
      "div",
      { class: "buttons" },
      button("Use this map", takeIn, { id: "use-map", kind: "primary" }),
      button("Open file…", () => file.click()),
      save,
      copy,
      file,
    ),
  );
}
