/** The map as text, to copy, to change and to take in. The server says whether text is a map. */

import type { App } from "../core/app";
import { h } from "../core/elements";
import type { ReadAnswer } from "../core/protocol";
import { fitted, NO_TOOL } from "../core/scene";
import { drawnOf, worldOf } from "../core/world";
import { openDialog } from "../frame/dialog";
import { button, notice } from "../frame/widgets";

const BYTES = 4; // of a character at most
const AROUND = 100; // characters of a message that are not the map's

export function openMapText({ hello, connection, store }: App): void {
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
    if (area.value) return; // it is being written in: nothing under the pointer moves
    area.value = text.trimEnd();
    holds(area.value.split("\n").length + 1);
  });

  /** What is wrong with text that is too long to be sent, whatever it is; the field keeps it. */
  function tooLong(what: string, text: string): string {
    const [is, most] = [JSON.stringify(text).length, hello.limits.message - AROUND];
    if (is <= most) return "";
    const twice = is > text.length + 2 ? `, which count as ${count(is)}, for a line break counts twice` : "";
    return `${what} has ${count(text.length)} characters${twice}; the studio takes up to ${count(most)}. Shorten it: a map has at most ${hello.limits.side[1]} rows of ${hello.limits.side[1]}.`;
  }

  function takeIn(): void {
    fault.textContent = tooLong("The text", area.value);
    if (fault.textContent) return;
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
  file.addEventListener("change", () => void open());

  /** Takes the text of a file, unless it is none of a map: then what the field has stays. */
  async function open(): Promise<void> {
    const chosen = file.files?.[0];
    if (chosen === undefined) return;
    const name = `The file ${chosen.name}`;
    try {
      if (chosen.size > BYTES * hello.limits.message) {
        fault.textContent = `${name} has ${count(chosen.size)} bytes; the studio takes up to ${count(hello.limits.message - AROUND)} characters.`;
        return;
      }
      const text = await chosen.text();
      fault.textContent = tooLong(name, text);
      if (!fault.textContent) area.value = text;
    } catch (error) {
      fault.textContent = `${name} cannot be read (${String(error)}).`;
    } finally {
      file.value = ""; // so that the same file can be chosen again
    }
  }

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

const count = (value: number) => value.toLocaleString("en-GB");
