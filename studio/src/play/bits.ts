/** The landscape over the board: the bits of every cell, tool and can being where they are now. */

import type { App } from "../core/app";
import type { Asked, Heard } from "../core/connection";
import type { Grid, Placement } from "../core/protocol";
import { message } from "../core/scene";
import { scaleOf } from "../draw/colours";
import { createScaleBar } from "../draw/scale";
import type { Picture } from "../draw/board";
import { toggle } from "../frame/widgets";

export interface Bits {
  readonly toggle: HTMLElement;
  readonly scale: HTMLElement;
  /** Switches the landscape on or off. */
  turn(): void;
  /** The values to draw under the given placement; requests them if they are not known yet. */
  under(placement: Placement): NonNullable<Picture["values"]> | null;
  /** The drawn values, if there are some. */
  grid(): Grid | null;
  /** Whether the drawn values belong to an earlier placement. */
  late(): boolean;
  /** The error, if there is one. */
  fault(): string;
}

export function createBits({ connection, store }: App, onChange: () => void): Bits {
  const scale = createScaleBar("bits if the agent stood there");
  const shown = toggle("Bits", "bits-layer", onChange);
  let answer: Heard<"landscape"> | null = null;
  let asked: Asked | null = null;
  let of = ""; // the last question
  let late = false;

  function ask(placement: Placement): void {
    const scene = store.scene();
    const body = { scene: message(scene), placement };
    const question = JSON.stringify([body.scene, { ...placement, agent: null, held: null }]);
    if (question === of) return;
    asked?.forget();
    [of, late] = [question, true];
    asked = connection.ask("landscape", body, (next) => {
      if (next.progress !== undefined) return;
      asked?.forget();
      if (next.lost) {
        of = ""; // ask again
        return;
      }
      [answer, late] = [next, false];
      onChange();
    });
  }

  return {
    toggle: shown.element,
    scale: scale.element,
    turn: shown.turn,
    under(placement) {
      if (shown.on()) ask(placement);
      else [of, answer] = ["", null];
      const { landscape, least, most } = answer ?? {};
      const ends = landscape && least != null && most != null ? { least, most } : null;
      scale.show(ends);
      return ends && landscape ? { grid: landscape, scale: scaleOf(ends.least, ends.most) } : null;
    },
    grid: () => (shown.on() ? (answer?.landscape ?? null) : null),
    late: () => shown.on() && late,
    fault: () => answer?.error ?? "",
  };
}
