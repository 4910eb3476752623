"""The command line: a group whose commands are imported only when they run, so that help answers at once."""

from __future__ import annotations

import atexit
import gc
import os
import signal
import sys
from collections.abc import Sequence
from importlib import import_module
from types import MappingProxyType
from typing import Final, NoReturn

import click
from click.core import ParameterSource
from click.shell_completion import CompletionItem, FishComplete, add_completion_class

from drivegate.commands.conduct import conducted, wants_json
from drivegate.commands.options import json_option
from drivegate.laboratory import COMMAND_GROUP, require_from_laboratory
from drivegate.version import __version__

COMMANDS: Final = MappingProxyType(
    {
        "new": "Write a small candidate to start from, with a test and a gate for CI.",
        "check": "Check candidates: a verdict, and a report in a folder.",
        "compare": "Compare candidates: who wins where, and by how much, in one report.",
        "simulate": "Run a candidate once through a scenario: summary, trace and plot.",
        "campaign": "Run many at once: grids of parameters and drives drawn at random, on every processor.",
        "map": "Compute an operating map: of a candidate, of the best there is, or of the plant.",
        "diff": "Compare two candidates step by step, up to the first difference.",
        "replay": "Run a counterexample again: does its check still fail?",
        "report": "Make the reports of a kept result again.",
        "verify": "Check that a kept result is unchanged.",
        "drive": "Show what a drive can do, before anyone is judged on it.",
        "point": "Compute the steady state at one operating point.",
        "selftest": "Check the checks: faulty controllers must be caught, correct ones must pass.",
        "reproduce": "Compute every published figure and number, and compare it with the paper.",
        "bench": "Measure how fast drivegate is on this machine.",
        "checks": "List the checks with their requirements and limits.",
        "schema": "Print the JSON Schema of a file that you write, for editors.",
        "include-dir": "Print the folder of drivegate.h and drivegate_duty.h, for a C compiler.",
        "man": "Write a manual page for each command into a folder.",
        "cases": "List the scenarios, operating points, sweeps and drives that are included.",
    }
)
"""One line about each command, by its name; each is the object `command` in a module of `drivegate.commands`.

Where the name has a hyphen, the module's has an underscore.
"""
LABORATORY_COMMANDS: Final = frozenset({"selftest", "reproduce", "bench"})
"""Commands that are entry points of the laboratory instead."""


_ASKING: Final = {"help": "Print the help of a command, or what a check requires."}
"""Words in the place of a command, which are none."""


@add_completion_class
class _CompletionForFish(FishComplete):
    """Completes lists of checks too: click's own script takes a comma for the end of a value."""

    source_template = FishComplete.source_template.replace('string split ","', 'string split --max 1 ","')


def _complete_topic(context: click.Context, option: click.Parameter, incomplete: str) -> list[CompletionItem]:
    from drivegate.commands.completion import complete_checks

    commands = [
        CompletionItem(name, help=line) for name, line in COMMANDS.items() if name.startswith(incomplete)
    ]
    return [*commands, *complete_checks(context, option, incomplete)]


class LazyGroup(click.Group):
    """A group that imports a command's module only to run it or to show its own help."""

    def list_commands(self, ctx: click.Context) -> list[str]:  # noqa: ARG002  (click's signature)
        return list(COMMANDS)

    def get_command(
        self,
        ctx: click.Context,  # noqa: ARG002  (click's signature)
        cmd_name: str,
    ) -> click.Command | None:
        if cmd_name not in COMMANDS:
            return None
        command: click.Command
        if cmd_name in LABORATORY_COMMANDS:
            command = require_from_laboratory(COMMAND_GROUP, cmd_name, f"the command '{cmd_name}'")
        else:
            command = import_module(f"drivegate.commands.{cmd_name.replace('-', '_')}").command
        return command

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        from drivegate_cases.documents.wording import nearest, one_line

        if ctx.resilient_parsing and args[0] in _ASKING:
            # A shell completes what help is wanted of.
            topic = click.Argument(["topic"], shell_complete=_complete_topic)
            return args[0], click.Command(args[0], params=[topic]), args[1:]
        if args == ["help"]:
            click.echo(ctx.get_help())
            ctx.exit()
        if args[0] == "help" or (args[0] == "explain" and len(args) > 1):
            # Of a command, or of a check.
            args = [*args[1:2], "--help"] if args[1:2] and args[1] in COMMANDS else ["checks", *args[1:]]
        if args[0] not in COMMANDS and not ctx.resilient_parsing and not args[0].startswith("-"):
            raise click.UsageError(
                f"the command '{one_line(args[0])}' is unknown, the nearest is "
                f"'{nearest(args[0], COMMANDS)}'; there are {', '.join(COMMANDS)}",
                ctx,
            )
        return super().resolve_command(ctx, args)

    def shell_complete(self, ctx: click.Context, incomplete: str) -> list[CompletionItem]:
        """Complete the commands without importing them, and the group's own options."""
        if incomplete.startswith("-"):
            return super().shell_complete(ctx, incomplete)
        lines = {**COMMANDS, **_ASKING}
        return [
            CompletionItem(name, help=line) for name, line in lines.items() if name.startswith(incomplete)
        ]

    def format_commands(
        self,
        ctx: click.Context,  # noqa: ARG002  (click's signature)
        formatter: click.HelpFormatter,
    ) -> None:
        """Write the commands into the help without importing them."""
        with formatter.section("Commands"):
            formatter.write_dl(list(COMMANDS.items()))


@click.group(
    cls=LazyGroup,
    invoke_without_command=True,
    no_args_is_help=False,
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 110},
    epilog="Exit codes: 0 pass, 1 the candidate fails, 2 bad usage or input, 3 a fault of drivegate itself.",
)
@click.version_option(__version__, prog_name="drivegate", message="%(prog)s %(version)s")
@click.option("-C", "folder", metavar="FOLDER", help="Start relative paths from FOLDER, as make and git do.")
@json_option
@click.pass_context
def command_line(context: click.Context, folder: str | None) -> None:
    """Verify and benchmark controllers of permanent-magnet brushless drives."""
    if folder is not None:
        _work_in(folder)
    if context.invoked_subcommand is None:
        if context.get_parameter_source("as_json") is ParameterSource.COMMANDLINE:
            raise click.UsageError(f"a command is missing; there are {', '.join(COMMANDS)}", context)
        click.echo(context.get_help())


def _work_in(folder: str) -> None:
    try:
        os.chdir(folder)
    except OSError as error:
        from drivegate_cases.documents.wording import shown_path
        from drivegate_models.errors import InputError

        raise InputError(
            f"the folder {shown_path(folder)} of -C cannot be entered: {error.strerror}; name an existing folder"
        ) from error


def _interrupt_when_ended() -> None:
    """Answer the signals that end a process in an orderly way as Ctrl-C is answered, unless they are ignored."""
    for number in (signal.SIGTERM, signal.SIGHUP):
        if signal.getsignal(number) is signal.SIG_DFL:
            signal.signal(number, signal.default_int_handler)


def main(arguments: Sequence[str] | None = None) -> NoReturn:
    """Run the command line and leave the process with its exit code."""
    words = list(sys.argv[1:] if arguments is None else arguments)

    def work() -> object:
        return command_line.main(words, prog_name="drivegate", standalone_mode=False)

    _interrupt_when_ended()
    # The interpreter would look for cycles in everything that was loaded, on its way out.
    atexit.register(gc.freeze)
    sys.exit(conducted(work, as_json=wants_json(words)))
