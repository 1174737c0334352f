/** The board as a picture: its things where a placement has them, or the image of a state. */

import type { BoardAbout, Cell, Drawing, Grid, Placement } from "../core/protocol";
import type { Picture } from "../draw/board";
import { same } from "../draw/cells";
import { rowColumn, type Stood } from "../draw/things";

const OURS = "agent"; // the library's drawing of the agent

/** The drawings of a board's things, by the names that `pictureOf` uses. */
export function shapesOf({ objects, still, agent }: BoardAbout): Record<string, Drawing> {
  const found: Record<string, Drawing> = { "board agent": agent.drawing };
  objects.forEach(({ drawing, filled }, of) => {
    found[`board ${of}`] = drawing;
    found[`board ${of} filled`] = filled ?? drawing;
  });
  still.forEach(({ drawing }, of) => (found[`board still ${of}`] = drawing));
  return found;
}

/** The board with things where a placement has them. */
export function pictureOf(
  board: BoardAbout, placement: Placement, image: string | null, grid: Grid | null,
): Picture {
  const rows = board.ground.split("\n");
  const world = {
    height: rows.length,
    width: rows[0]!.length,
    walls: [...rows.join("")].map((mark) => mark === "#"),
  };
  const plain = { turn: 0, badge: null, hidden: false };
  const things: Stood[] = [];
  if (image === null) {
    board.objects.forEach(({ goals }, of) => {
      const cell = placement.objects[of]!;
      const filled = goals.some((goal) => same(goal, cell)) ? " filled" : "";
      things.push({ ...plain, whole: true, thing: { what: "object", of }, cell, drawing: `board ${of}${filled}` });
    });
    const small = board.agent.drawing.length === 0;
    things.push({
      ...plain, whole: !small, thing: { what: "agent", of: 0 }, cell: placement.agent,
      drawing: small ? OURS : "board agent",
    });
  }
  return {
    world, things, image,
    still: board.still.map(({ cell }, of) => ({ cell, drawing: `board still ${of}` })),
    label: (cell) => labelOf(board, world.walls[cell[0] * world.width + cell[1]]!, placement, cell, grid),
  };
}

function labelOf(
  board: BoardAbout, wall: boolean, { agent, objects }: Placement, cell: Cell, grid: Grid | null,
): string {
  const there = objects.flatMap((at, of) => (same(at, cell) ? [board.objects[of]!.name] : []));
  if (same(agent, cell)) there.push("agent");
  if (wall) there.push("wall");
  const bits = grid?.[cell[0]]?.[cell[1]] ?? null;
  if (bits !== null) there.push(`${bits.toFixed(2)} bits`);
  return [rowColumn(cell), there.join(", ")].filter(Boolean).join(": ");
}
