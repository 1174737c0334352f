/** The page: what the server says first decides what there is; then the views share one scene. */

import { createActed } from "./core/acted";
import { FRESH, fromFragment, toFragment } from "./core/address";
import type { App, View } from "./core/app";
import { connect, type Status } from "./core/connection";
import { byId, h } from "./core/elements";
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
import "./style/portrait.css";

let app: App | null = null;
let status: Status = "connecting";
let frame: Frame | null = null;

const connection = connect(
  (hello) => {
    if (app === null) start(hello);
    else app.measuring.again();
  },
  (next) => {
    status = next;
    document.documentElement.dataset.connection = status;
    frame?.showStatus(status);
  },
);
byId("app").replaceChildren(h("p", { class: "opening" }, "Opening the studio…"));

function start(hello: Hello): void {
  keepShapes(hello.shapes);
  const said = fromFragment(location.hash, hello);
  const store = createStore(said?.scene ?? firstScene(hello));
  const measuring = createMeasuring(connection, store);
  app = { hello, connection, store, measuring, acted: createActed(hello.run) };
  const views: Record<string, View> = {
    design: createDesign(app),
    play: createPlay(app),
    train: createTrain(app, () => frame?.open("run")),
    run: createRun(app),
  };
  frame = createFrame(app, views, keepAddress);
  byId("app").replaceChildren(frame.element);
  frame.showStatus(status);
  frame.open(said?.view ?? (hello.run ? "run" : "design"));
  store.watch(keepAddress);
  addEventListener("hashchange", () => {
    const next = fromFragment(location.hash, hello);
    if (next === null) return;
    if (toFragment(next.scene, next.view) === toFragment(store.scene(), frame!.view())) return;
    store.show(next.scene);
    frame!.open(next.view);
  });
}

/** The link in the address bar always says what is shown. */
function keepAddress(): void {
  if (app === null || frame === null) return;
  history.replaceState(null, "", `#${toFragment(app.store.scene(), frame.view())}`);
}

function firstScene(hello: Hello): Scene {
  const drawn = hello.run?.drawn ?? hello.worlds["yard"] ?? Object.values(hello.worlds)[0]!;
  const world = worldOf(drawn);
  return { ...FRESH, world, bare: !world.tools.length };
}
