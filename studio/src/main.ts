/** The page: the server's greeting defines the choices; all views share one scene. */

import { shapesOf } from "./board/picture";
import { fromBoardFragment, isBoardFragment, toBoardFragment } from "./board/address";
import { withBoard, type Boards } from "./board/switch";
import { createWatched } from "./core/watched";
import { FRESH, fromFragment, toFragment, type Opened } from "./core/address";
import type { App, View } from "./core/app";
import { connect, type Status } from "./core/connection";
import { byId, h } from "./core/elements";
import { createNotebook, type Notebook } from "./core/notebook";
import { FRESH_KIND } from "./core/kinds";
import { createMeasuring } from "./core/measuring";
import type { Hello } from "./core/protocol";
import type { Scene } from "./core/scene";
import { createStore } from "./core/store";
import { worldOf } from "./core/world";
import { createDesign } from "./design/view";
import { keepShapes } from "./draw/shapes";
import { createFrame, type Frame } from "./frame/frame";
import { createPlay } from "./play/view";
import { createRun } from "./run/view";
import { createTrain } from "./train/view";
import "./style/base.css";
import "./style/controls.css";
import "./style/pictures.css";
import "./style/views.css";
import "./style/boards.css";
import "./style/pairs.css";
import "./style/portrait.css";
import "./style/phone.css";
import "./style/embedded.css";

const VIEWS = ["design", "play", "train", "run"];
const BOARD_VIEWS = ["design", "play"]; // the others are of maps
const NO_BOARD = { board: "", sensor: "state", thing: 0, horizon: 0, slip: 0, ...FRESH_KIND } as const;
const MOST_FAULTS = 5; // of a link, reported in a line

let app: App | null = null;
let boards: Boards | null = null;
let views: Record<string, View> = {};
let status: Status = "connecting";
let frame: Frame | null = null;
let notebook: Notebook | null = null;
/** Whether the address has a link that could not be shown completely: it stays until the first change. */
let held = false;

const connection = connect(
  (hello) => {
    if (app === null) start(hello);
    else {
      if (hello.shown !== null) notebook?.show(hello.shown);
      app.measuring.again();
      for (const view of Object.values(views)) view.again?.();
    }
  },
  (next) => {
    status = next;
    document.documentElement.dataset.connection = status;
    frame?.showStatus(status);
  },
  (shown) => notebook?.show(shown),
);
byId("app").replaceChildren(h("p", { class: "opening" }, "Opening the studio…"));

function start(hello: Hello): void {
  keepShapes({ ...hello.shapes, ...(hello.board ? shapesOf(hello.board) : {}) });
  const toBoard = isBoardFragment(location.hash);
  const opened = fromFragment(toBoard ? "" : location.hash, hello, VIEWS);
  const store = createStore(opened.shown?.scene ?? firstScene(hello));
  const measuring = createMeasuring(connection, store);
  notebook = createNotebook(hello, connection, store);
  app = { hello, connection, store, measuring, watched: createWatched(hello.run) };
  const [design, play] = [createDesign(app), createPlay(app)];
  boards = hello.board ? withBoard(app, hello.board, design, play) : null;
  views = {
    design: boards?.design ?? design,
    play: boards?.play ?? play,
    train: createTrain(app, () => frame?.open("run")),
    run: createRun(app),
  };
  frame = createFrame(app, views, keepAddress, { address, show: letGo });
  byId("app").replaceChildren(frame.element);
  frame.showStatus(status);
  let opening = true;
  const first = hello.board
    ? hello.board.name
    : hello.run ? "the world of the run" : hello.world ? "the studio's map" : `the built-in world ${firstWorld(hello)}`;
  boards?.show(opened.shown === null);
  if (toBoard) openBoard(first);
  else report(opened, first);
  if (frame.view() === "") frame.open(opened.shown?.view ?? (hello.run ? "run" : "design"));
  if (!hello.board) frame.offerTour();
  store.watch(() => (opening ? keepAddress() : letGo()));
  boards?.watch(() => (opening ? keepAddress() : letGo()));
  opening = false;
  addEventListener("hashchange", () => {
    if (isBoardFragment(location.hash)) {
      opening = true;
      openBoard("the previous world");
      opening = false;
      return;
    }
    const next = fromFragment(location.hash, hello, VIEWS);
    report(next, "the previous world");
    if (next.shown === null) return;
    const { scene, view } = next.shown;
    if (!boards?.showing() && toFragment(scene, view) === toFragment(store.scene(), frame!.view())) return;
    opening = true;
    boards?.show(false);
    store.show(scene);
    frame!.open(view);
    opening = false;
  });
}

/** Shows the board as the address has it. */
function openBoard(instead: string): void {
  const { board, limits } = app!.hello;
  const first = boards?.question.first ?? NO_BOARD;
  const opened = fromBoardFragment(location.hash, first, board, limits, VIEWS);
  report(opened, instead);
  if (opened.shown === null) return;
  boards!.show(true);
  boards!.question.show(opened.shown.scene);
  frame!.open(opened.shown.view);
}

/** Reports the parts of a link that cannot be shown, and what is shown instead. */
function report({ shown, faults }: Pick<Opened, "faults"> & { readonly shown: unknown }, instead: string): void {
  held = faults.length > 0;
  const [some, others] = [faults.slice(0, MOST_FAULTS).join("; "), faults.length - MOST_FAULTS];
  const what = `${some}${others > 0 ? `; and ${others} more` : ""}`;
  const now = shown === null
    ? `The link cannot be opened: ${what}. Showing ${instead} instead.`
    : `The link can only be shown in part: ${what}.`;
  frame!.showLink(held ? `${now} The address keeps the link until your first change.` : null);
}

/** The link to the current scene and view. */
function address(): string {
  const [view, board] = [frame!.view(), app!.hello.board];
  const ofBoard = boards !== null && board !== null && boards.showing() && BOARD_VIEWS.includes(view);
  const fragment = ofBoard
    ? toBoardFragment(boards!.question.scene(), boards!.question.first, board, view)
    : toFragment(app!.store.scene(), view);
  return new URL(`#${fragment}`, location.href).href;
}

/** Updates the address bar, unless it holds a link that was not understood. */
function keepAddress(): void {
  if (app === null || frame === null || held || app.hello.shown !== null) return; // a notebook keeps its world
  history.replaceState(null, "", address());
}

/** Replaces a link that was not understood after the user's first change; Back returns to it. */
function letGo(): void {
  if (held) {
    history.pushState(null, "", location.href);
    held = false;
    frame?.showLink(null);
  }
  keepAddress();
}

function firstWorld({ worlds }: Hello): string {
  return "yard" in worlds ? "yard" : Object.keys(worlds)[0]!;
}

function firstScene(hello: Hello): Scene {
  const drawn = hello.shown?.drawn ?? hello.run?.drawn ?? hello.world ?? hello.worlds[firstWorld(hello)]!;
  const world = worldOf(drawn);
  return { ...FRESH, world, bare: !world.tools.length };
}
