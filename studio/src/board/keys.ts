/** The keys of a board's actions, by their names. */

export interface Key {
  /** As keyboard events have it. */
  readonly key: string;
  /** As it is printed. */
  readonly cap: string;
}

const ARROWS: Record<string, Key> = {
  left: { key: "ArrowLeft", cap: "←" }, west: { key: "ArrowLeft", cap: "←" },
  right: { key: "ArrowRight", cap: "→" }, east: { key: "ArrowRight", cap: "→" },
  up: { key: "ArrowUp", cap: "↑" }, north: { key: "ArrowUp", cap: "↑" }, forward: { key: "ArrowUp", cap: "↑" },
  down: { key: "ArrowDown", cap: "↓" }, south: { key: "ArrowDown", cap: "↓" },
};
const TAKEN = ["r", "b"]; // restart, bits
const LETTERS = "abcdefghijklmnopqrstuvwxyz";

/** A key for each action: an arrow, or the first letter of its name that is free. */
export function keysOf(actions: readonly string[]): Key[] {
  const taken = new Set(TAKEN);
  return actions.map((name) => {
    const arrow = ARROWS[name.toLowerCase()];
    if (arrow && !taken.has(arrow.key)) {
      taken.add(arrow.key);
      return arrow;
    }
    const letter = [...name.toLowerCase(), ...LETTERS].find((one) => LETTERS.includes(one) && !taken.has(one)) ?? "";
    taken.add(letter);
    return { key: letter, cap: letter.toUpperCase() };
  });
}
