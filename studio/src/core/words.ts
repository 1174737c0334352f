/** Names of things on the page. */

import { NO_TOOL } from "./scene";

export function capital(word: string): string {
  return word[0]!.toUpperCase() + word.slice(1);
}

/** The kind of a thing; a custom tool is named by its file and class, of which the class suffices. */
export function nameOf(kind: string): string {
  if (kind === NO_TOOL) return "No tool";
  return capital(kind.split(":").at(-1)!) + (kind.includes(":") ? " (yours)" : "");
}
