/** The board and its question in the link's fragment: `#b=levels.xsb%233&h=2&s=object:b1&x=0.1`. */

import { FRESH_KIND, KIND_NAMES, kindParts } from "../core/kinds";
import type { BoardAbout, Kind } from "../core/protocol";
import type { Asked } from "./question";

/** The readable part of a link to a board. */
export interface OpenedBoard {
  /** Null where the link is none of this board. */
  readonly shown: { readonly scene: Asked; readonly view: string } | null;
  /** Its problems, each a clause. */
  readonly faults: readonly string[];
}

const BOARD = "b";
const FIRST_VIEW = "design";

/** The part after the `#`; defaults are omitted. */
export function toBoardFragment(scene: Asked, first: Asked, board: BoardAbout, view: string): string {
  const parts = [`${BOARD}=${encodeURIComponent(scene.board)}`];
  if (scene.sensor === "factor") parts.push(`s=${encodeURIComponent(board.factors[scene.thing]!)}`);
  if (scene.horizon !== first.horizon) parts.push(`h=${scene.horizon}`);
  parts.push(...kindParts(scene));
  if (scene.only && scene.only.length < board.actions.length) parts.push(`x=${scene.only.join(".")}`);
  if (scene.slip) parts.push(`p=${scene.slip}`);
  if (view !== FIRST_VIEW) parts.push(`v=${view}`);
  return parts.join("&");
}

/** Whether a fragment is a link to a board. */
export function isBoardFragment(fragment: string): boolean {
  return new URLSearchParams(fragment.replace(/^#/, "")).has(BOARD);
}

/** The question and the view of a fragment, and the parts of it that cannot be shown. */
export function fromBoardFragment(
  fragment: string, first: Asked, board: BoardAbout | null, limits: { horizon: number; discount: number; slack: number; slip: number }, views: readonly string[],
): OpenedBoard {
  const fields = new URLSearchParams(fragment.replace(/^#/, ""));
  const name = fields.get(BOARD)!;
  if (board?.name !== name) {
    return { shown: null, faults: [`it shows “${name.slice(0, 60)}”, with which this studio was not started`] };
  }
  const faults: string[] = [];
  const number = (what: string, field: string, fresh: number, most: number, whole: boolean): number => {
    const text = fields.get(field);
    if (text === null) return fresh;
    const value = /^\d+(\.\d+)?$/.test(text) ? Number(text) : NaN;
    if (value <= most && (!whole || Number.isInteger(value))) return value;
    faults.push(`its ${what} “${text.slice(0, 20)}” is not a ${whole ? "whole " : ""}number from 0 to ${most}, and ${fresh} is used`);
    return fresh;
  };
  const horizon = number("horizon", "h", first.horizon, limits.horizon, true);
  const discount = number("discount", "g", FRESH_KIND.discount, limits.discount, false);
  const slack = number("slack", "l", FRESH_KIND.slack, limits.slack, true);
  let kind = (fields.get("k") ?? FRESH_KIND.kind) as Kind;
  if (!(kind in KIND_NAMES)) {
    faults.push(`its kind of empowerment “${kind.slice(0, 20)}” is unknown, and ${FRESH_KIND.kind} is used`);
    kind = FRESH_KIND.kind;
  }
  const slip = number("slip", "p", first.slip, limits.slip, false);
  const factor = fields.get("s");
  const thing = factor === null ? -1 : board.factors.indexOf(factor);
  if (factor !== null && thing < 0) faults.push(`its sensor “${factor.slice(0, 40)}” is unknown, and the state is observed`);
  const text = fields.get("x");
  const only = text?.split(".").map((one) => (/^\d+$/.test(one) ? Number(one) : -1));
  const known = only?.every((action) => action >= 0 && action < board.actions.length);
  if (known === false) faults.push(`its actions “${text!.slice(0, 40)}” are unknown, and all are used`);
  let view = fields.get("v") ?? FIRST_VIEW;
  if (!views.includes(view)) {
    faults.push(`its view “${view.slice(0, 20)}” is unknown, and ${FIRST_VIEW} is used`);
    view = FIRST_VIEW;
  }
  return {
    shown: {
      scene: {
        board: name, horizon, slip, kind, discount, slack,
        ...(thing < 0 ? { sensor: "state", thing: 0 } : { sensor: "factor", thing }),
        ...(only && known ? { only } : {}),
      },
      view,
    },
    faults,
  };
}
