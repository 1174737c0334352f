"""`habilis studio`: the studio's server."""

import argparse
import contextlib
import sys
import tempfile
import threading
import webbrowser
from pathlib import Path

from habilis.cli.arguments import Args
from habilis.cli.output import print_json
from habilis.extras import import_from
from habilis.files import FOLDER

HELP: str = "draw worlds in a browser and see their empowerment live"
EXAMPLE: str = "habilis studio --port 8000"
COMMON: tuple[str, ...] = ("--port", "--tool", "--out")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    source = (
        "what to show: a trained run's folder, a built-in world or a map's file; or, to play and "
        "measure as it is, a puzzle (.pwp, .xsb, levels.xsb#3) or an environment (gym:ID)"
    )
    parser.add_argument("source", nargs="?", metavar="SOURCE", help=source)
    loopback = "address to listen on (default 127.0.0.1: only this machine can reach it)"
    parser.add_argument("--host", default="127.0.0.1", help=loopback)
    parser.add_argument("--port", type=int, default=0, help="port (default 0: any free one)")
    own = "a tool of your own as FILE.py:CLASS, beside picker and broom; repeatable"
    parser.add_argument(
        "--tool", action="append", default=[], dest="tools", metavar="TOOL", help=own
    )
    kept = "folder for runs trained from the page (default: deleted when the studio ends)"
    parser.add_argument("--out", type=Path, metavar="DIR", help=kept)
    parser.set_defaults(writes={"out": FOLDER})
    base = "path at which a proxy serves the studio, such as /user/x/proxy/{port}/"
    parser.add_argument("--base-path", default="/", metavar="PATH", help=base)
    origin = "origin of that proxy, such as https://hub.example.org; repeatable"
    parser.add_argument(
        "--trusted-origin", action="append", default=[], dest="origins", metavar="URL", help=origin
    )
    parser.add_argument("--no-browser", action="store_true", help="only print the address")


def run(args: Args) -> int:
    server = import_from("habilis.studio.server", "studio")
    with tempfile.TemporaryDirectory(prefix="habilis-studio-", ignore_cleanup_errors=True) as place:
        made, found = server.opened(
            *(args.host, args.port, Path(place), tuple(args.tools), args.source, args.out),
            *(args.base_path, args.origins),
        )
        address = made.access.address(args.host)
        if args.json:
            print_json({"address": address})
        else:
            print(f"the studio is at {address} (end it with Ctrl-C)")
        sys.stdout.flush()
        if not args.no_browser:
            threading.Thread(target=webbrowser.open, args=(address,), daemon=True).start()
        with contextlib.suppress(KeyboardInterrupt):
            server.serve(made, found)
    return 0
