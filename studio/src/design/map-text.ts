/** The map as text, to copy, edit and import. The server checks whether text is a map. */

import type { App } from "../core/app";
import { h } from "../core/elements";
import type { ReadAnswer, Scene as SceneMessage } from "../core/protocol";
import { fitted, NO_TOOL } from "../core/scene";
import { drawnOf, worldOf } from "../core/world";
import { openDialog } from "../frame/dialog";
import { button, copyText } from "../frame/widgets";

const BYTES = 4; // at most, per character
const AROUND = 100; // characters of a message around the map

export function openMapText({ hello, connection, store }: App): void {
  const { world, bare } = store.scene();
  const area = h("textarea", { id: "text", spellcheck: "false", "aria-label": "Map text" });
  const holds = (lines: number) => (area.rows = Math.min(Math.max(lines, 8), 22));
  holds(world.height + 2);
  const fault = h("p", { class: "fault", role: "alert" });

  /** The library's reading of a map, drawn or as text. */
  function read(map: SceneMessage, then: (answer: Required<Pick<ReadAnswer, "drawn" | "text">>) => void) {
    const asked = connection.ask("read", { scene: map }, ({ error, drawn, text }) => {
      if (error !== undefined) fault.textContent = error;
      else if (drawn && text !== undefined) {
        asked.forget();
        then({ drawn, text });
      }
    });
  }

  read({ drawn: drawnOf(world), ...(bare ? { tool: NO_TOOL } : {}) }, ({ text }) => {
    if (area.value) return; // the user is typing: leave the field alone
    area.value = text.trimEnd();
    holds(area.value.split("\n").length + 1);
  });

  /** The error for text that is too long to send; the field keeps the text. */
  function tooLong(what: string, text: string): string {
    const [is, most] = [JSON.stringify(text).length, hello.limits.message - AROUND];
    if (is <= most) return "";
    const twice = is > text.length + 2 ? `, which count as ${count(is)}, since line breaks count twice` : "";
    return `${what} has ${count(text.length)} characters${twice}; the studio accepts up to ${count(most)}. Shorten it: a map has at most ${hello.limits.side[1]} rows and columns.`;
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

  const copy = button("Copy", () => copyText(area.value, area));
  const save = button("Save as file", () => {
    const link = h("a", { download: "map.txt" });
    link.href = URL.createObjectURL(new Blob([`${area.value}\n`], { type: "text/plain" }));
    link.click();
    URL.revokeObjectURL(link.href);
  });
  const file = h("input", { type: "file", accept: ".txt,text/plain", hidden: true });
  file.addEventListener("change", () => void open());

  /** Loads the text of a file; if it is too long or unreadable, the field keeps its text. */
  async function open(): Promise<void> {
    const chosen = file.files?.[0];
    if (chosen === undefined) return;
    const name = `The file ${chosen.name}`;
    try {
      if (chosen.size > BYTES * hello.limits.message) {
        fault.textContent = `${name} has ${count(chosen.size)} bytes; the studio accepts up to ${count(hello.limits.message - AROUND)} characters.`;
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
      "One character per cell: # wall, . floor, A agent, P picker, B broom, C can, G bin. Lines above the map define others: R = rake, D = ball, H = goal of D, drop: true.",
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
