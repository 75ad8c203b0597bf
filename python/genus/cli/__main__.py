"""Entry of the command line: picks the command, turns every error into one line and a status."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from typing import TYPE_CHECKING, NoReturn

if TYPE_CHECKING:
    import argparse

DONE, AT_FAULT, USAGE, INTERRUPTED = 0, 1, 2, 130


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line; the exit status, see `genus --help`."""
    arguments = list(sys.argv[1:] if argv is None else argv)
    if arguments == ["--version"]:  # the usual question, answered before anything is imported
        from genus._core import __version__

        print(f"genus {__version__}")
        return DONE
    try:
        return run(arguments)
    except KeyboardInterrupt:
        return complain("interrupted", INTERRUPTED)
    except BrokenPipeError:  # whoever read our output has gone; keep the interpreter from retrying
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return AT_FAULT
    except MemoryError:
        return complain("out of memory", AT_FAULT)


def run(arguments: Sequence[str]) -> int:
    """Parse and dispatch; errors of genus and of the system become one line."""
    import genus

    stop_on_termination()
    args = parser().parse_args(arguments)
    try:
        status: int = args.run(args)
        sys.stdout.flush()
        return status
    except BrokenPipeError:
        raise
    except (genus.Error, OSError) as error:
        return complain(text_of(error), AT_FAULT)
    except RecursionError:
        return complain("nested too deeply", AT_FAULT)


def text_of(error: BaseException) -> str:
    """The error as one line; system errors begin with their file."""
    if isinstance(error, OSError) and error.filename is not None and error.strerror:
        return f"{os.fsdecode(error.filename)}: {error.strerror}"
    return " ".join(str(error).split("\n"))


def complain(text: str, status: int) -> int:
    """Print the one line, return the status."""
    print(f"genus: {text}", file=sys.stderr)
    return status


def stop_on_termination() -> None:
    """Let SIGTERM end a call as Ctrl-C does, so that no partial file stays behind."""
    import signal

    def stop(_signal: int, _frame: object) -> NoReturn:
        raise KeyboardInterrupt

    signal.signal(signal.SIGTERM, stop)


def parser() -> argparse.ArgumentParser:
    """All commands and their options."""
    import argparse

    from genus import __version__
    from genus.cli import build, convert, info

    class Parser(argparse.ArgumentParser):
        def error(self, message: str) -> NoReturn:
            self.exit(USAGE, f"genus: {message} ({self.prog} --help)\n")

    top = Parser(
        prog="genus",
        description="Solids to closed meshes within a tolerance, with error and time reported.",
        epilog="Exit status: 0 done; 1 the model or file is at fault, or the tolerance was not"
        " met; 2 the command line is at fault.",
    )
    top.add_argument("--version", action="version", version=f"genus {__version__}")
    commands = top.add_subparsers(dest="command", required=True, metavar="COMMAND")
    for module in (build, convert, info):
        name = module.__name__.rpartition(".")[2]
        doc = (module.__doc__ or "").strip()
        sub = commands.add_parser(
            name,
            help=doc.splitlines()[0].rstrip("."),
            description=doc,
            formatter_class=argparse.RawDescriptionHelpFormatter,
        )
        module.add_arguments(sub)
        sub.set_defaults(run=module.run)
    return top


if __name__ == "__main__":
    sys.exit(main())
