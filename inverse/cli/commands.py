"""The command line. Human words go to stderr, results to stdout; the exit code says how it went."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated, Literal

from cyclopts import App, CycloptsError, Parameter, UnusedCliTokensError

from inverse import interrupts
from inverse.cli.draw import draw
from inverse.cli.export import export
from inverse.cli.fold import fold
from inverse.cli.output import DONE, NOT_DONE, WRONG_INPUT, motion
from inverse.cli.repair import repair
from inverse.cli.solve import solve
from inverse.cli.terminal import ProgressLine
from inverse.errors import InputError
from inverse.files.atomic import json_text

app = App(
    name="inverse",
    default_parameter=Parameter(negative=(), show_default=False),
    help="Design rigid-foldable structures backwards: from a target surface to a certified pattern.",
    help_epilogue="Exit codes: 0 foldable, optimal and as asked, 1 ran but not all, 2 wrong input, 3 interrupted.",
    version_flags=["--version"],
    result_action="return_value",
    suppress_keyboard_interrupt=False,
)
app.command(solve)


@app.command
def check(design: Path, /, *, as_json: Annotated[bool, Parameter(name="--json", negative=())] = False) -> int:
    """Certify a design file independently, trusting no claim in it.

    Args:
        design: FOLD file.
        as_json: print the certificate as JSON.
    """
    from inverse.certify import check as certify
    from inverse.results.folder import settle

    settle(design.parent)
    with ProgressLine() as line:
        line.phase(f"certifying {design}")
        certificate = certify(design, lambda done, of: line.share("certifying, states of the motion", done, of))
    if as_json:
        print(json_text(certificate.document()))
    else:
        for one in certificate.checks.values():
            print(one.sentence)
        for sentence in (*motion(certificate), *(loop.sentence for loop in certificate.loops)):
            print(sentence)
        print(certificate.sentence)
    return DONE if certificate.certified else NOT_DONE


app.command(repair)
app.command(fold)
app.command(export)
app.command(draw)


@app.command
def schema(file: Literal["spec", "report", "certificate"] = "spec", /) -> int:
    """Print a JSON schema, of specifications if nothing else is asked for.

    Args:
        file: spec, report (report.json) or certificate (certificate.json).
    """
    if file == "spec":
        from inverse.spec import Specification

        print(json_text(Specification.model_json_schema()))
    else:
        from inverse.results import schema as schemas

        print(json_text(schemas.report() if file == "report" else schemas.certificate()))
    return 0


def run(arguments: list[str]) -> int:
    """Run the command line; wrong input becomes a message and a code, never a traceback."""
    try:
        with interrupts.raised():
            result = app(arguments, exit_on_error=False, print_error=False)
    except UnusedCliTokensError as error:
        words = " ".join(error.unused_tokens or ())
        command = " ".join(["inverse", *(error.command_chain or ()), "--help"])
        print(f"error: no argument or option takes {words}", file=sys.stderr)
        print(f"What may be repeated is named anew for each value; `{command}` lists what there is.", file=sys.stderr)
        return WRONG_INPUT
    except CycloptsError as error:
        print(f"error: {error}", file=sys.stderr)
        return WRONG_INPUT
    except InputError as error:
        print(f"error: {error}", file=sys.stderr)
        return WRONG_INPUT
    except KeyboardInterrupt:
        return interrupts.told()
    return result if isinstance(result, int) else 0
