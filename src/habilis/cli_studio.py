"""The verb of the command line that serves the studio."""

import contextlib
import sys
import tempfile
import threading
import webbrowser
from pathlib import Path

from habilis.cli_arguments import Args
from habilis.cli_output import print_json
from habilis.extras import import_from


def studio(args: Args) -> int:
    server = import_from("habilis.studio.server", "studio")
    with tempfile.TemporaryDirectory(prefix="habilis-studio-", ignore_cleanup_errors=True) as place:
        made, found = server.opened(
            args.host, args.port, Path(place), tuple(args.tools), args.run, args.out
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
