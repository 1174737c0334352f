/** The map as text, to copy, to change and to take in. The server says whether text is a map. */

import type { App } from "../core/app";
import { h } from "../core/elements";
import type { ReadAnswer } from "../core/protocol";
import { fitted, NO_TOOL } from "../core/scene";
import { drawnOf, worldOf } from "../core/world";
import { openDialog } from "../frame/dialog";
import { button, notice } from "../frame/widgets";

export function openMapText({ connection, store }: App): void {
  const { world, bare } = store.scene();
  const area = h("textarea", { id: "text", spellcheck: "false", "aria-label": "Map text" });
  const holds = (lines: number) => (area.rows = Math.min(Math.max(lines, 8), 22));
  holds(world.height + 2);
  const fault = h("p", { class: "fault", role: "alert" });

  /** What the library makes of a map, drawn or as text. */
  function read(map: object, then: (answer: Required<Pick<ReadAnswer, "drawn" | "text">>) => void) {
    const asked = connection.ask<ReadAnswer>("read", { scene: map }, ({ error, drawn, text }) => {
      if (error !== undefined) fault.textContent = error;
      else if (drawn && text !== undefined) {
        asked.forget();
        then({ drawn, text });
      }
    });
  }

  read({ drawn: drawnOf(world), ...(bare ? { tool: NO_TOOL } : {}) }, ({ text }) => {
    area.value ||= text.trimEnd();
    holds(area.value.split("\n").length + 1);
  });

  function takeIn(): void {
    fault.textContent = "";
    read({ map: area.value }, ({ drawn }) => {
      const taken = worldOf(drawn);
      const scene = { ...store.scene(), world: taken, bare: !taken.tools.length };
      store.change(fitted({ ...scene, cells: [], thing: 0 }));
      close();
    });
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
      "One character a cell: # wall, . floor, A agent, P picker, B broom, C can, G bin. Lines above the map bind others: R = rake, D = ball, H = goal of D, drop: true.",
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
