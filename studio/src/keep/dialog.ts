/** Keep and share: everything on the screen as files, and as code that computes the same numbers. */

import type { Connection } from "../core/connection";
import { h } from "../core/elements";
import type { Code, Film } from "../core/protocol";
import { openDialog } from "../frame/dialog";
import { button, copyText } from "../frame/widgets";
import { blobOf, csvOf, saveFile } from "./files";
import { pngOf, svgOf } from "./pictures";

/** What a view has to keep. Names become names of files, too. */
export interface Keeps {
  readonly pictures: readonly { name: string; picture: SVGSVGElement }[];
  readonly tables: readonly { name: string; rows: readonly (readonly (string | number | null)[])[] }[];
  readonly films: readonly { name: string; film: () => Promise<Asked<Film>> }[];
  /** The request for the code, if there is something to compute. */
  readonly code: Asked<Code> | null;
}

/** A request without its number and its name. */
export type Asked<Request> = Omit<Request, "id" | "do">;

export const NOTHING: Keeps = { pictures: [], tables: [], films: [], code: null };

export function openKeep(connection: Connection, keeps: Keeps): void {
  const fault = h("p", { class: "fault", role: "alert" });
  const small = (label: string, name: string, act: () => void | Promise<void>) => {
    const made = button(label, async () => {
      fault.textContent = "";
      made.disabled = true;
      try {
        await act();
      } catch (error) {
        fault.textContent = error instanceof Error ? error.message : String(error);
      }
      made.disabled = false;
    }, { kind: "small" });
    made.setAttribute("aria-label", `${name} as ${label}`);
    return made;
  };
  const row = (name: string, ...buttons: HTMLElement[]) =>
    h("li", {}, h("span", { class: "name" }, name), h("div", { class: "buttons" }, ...buttons));
  const fileOf = (name: string, suffix: string) => `${name.toLowerCase().replaceAll(/\W+/g, "-")}.${suffix}`;

  const names = [...new Set([...keeps.pictures, ...keeps.tables, ...keeps.films].map(({ name }) => name))];
  const rows = names.map((name) => {
    const buttons: HTMLElement[] = [];
    const picture = keeps.pictures.find((one) => one.name === name)?.picture;
    if (picture) {
      const vector = () => new Blob([svgOf(picture)], { type: "image/svg+xml" });
      buttons.push(
        small("PNG", name, async () => saveFile(fileOf(name, "png"), await pngOf(picture))),
        small("SVG", name, () => saveFile(fileOf(name, "svg"), vector())),
      );
    }
    const table = keeps.tables.find((one) => one.name === name);
    if (table) buttons.push(small("CSV", name, () => saveFile(fileOf(name, "csv"), csvOf(table.rows))));
    const film = keeps.films.find((one) => one.name === name);
    if (film) {
      buttons.push(small("GIF", name, async () => {
        const gif = await filmed(connection, await film.film());
        saveFile(fileOf(name, "gif"), blobOf(gif, "image/gif"));
      }));
    }
    return row(name, ...buttons);
  });
  const code = h("div", { class: "code", id: "code" });
  openDialog(
    "Keep and share",
    rows.length ? h("ul", { class: "keeps" }, ...rows) : h("p", { class: "quiet" }, "There is nothing to keep here yet."),
    fault,
    code,
  );
  if (keeps.code !== null) showCode(connection, keeps.code, code);
}

/** Adds the code to the dialog, once the server has written it. */
function showCode(connection: Connection, request: Asked<Code>, into: HTMLElement): void {
  const block = (title: string, id: string, text: string) => {
    const shown = h("pre", { id, tabindex: 0, "aria-labelledby": `${id}-title` }, text);
    const copy = button("Copy", () => copyText(text, shown), { id: `copy-${id}`, kind: "small" });
    return [h("div", { class: "code-head" }, h("h3", { id: `${id}-title` }, title), copy), shown];
  };
  const asked = connection.ask("code", request, ({ python, command, error, progress }) => {
    if (progress !== undefined) return;
    asked.forget();
    if (error !== undefined) into.replaceChildren(h("p", { class: "fault" }, error));
    else if (python !== undefined) {
      into.replaceChildren(
        ...block("The same in Python", "python", python),
        ...(command ? block("The same as a command", "command", command) : []),
      );
    }
  });
}

/** A film of placements, as the base64 text of a GIF. */
function filmed(connection: Connection, film: Asked<Film>): Promise<string> {
  return new Promise((resolve, reject) => {
    const asked = connection.ask("film", film, ({ gif, error, progress }) => {
      if (progress !== undefined) return;
      asked.forget();
      if (gif !== undefined) resolve(gif);
      else reject(new Error(error ?? "there is no film"));
    });
  });
}
