#!/usr/bin/env python3
"""Runs the commands of a page one after the other and compares what they print. In the page `...` stands for any text, at
the end of a line or as a line of its own.

usage: tests/cli/tutorial_test.py REPOSITORY PROGRAMS [PAGE]
  PAGE  of docs/ (tutorial.md)"""

import os
import pathlib
import re
import subprocess
import sys
import tempfile


def steps(page: str):
    """Yields (command, expected output) of the ```console blocks."""
    for block in re.findall(r"^```console\n(.*?)^```", page, re.M | re.S):
        command, expected = "", []
        for line in block.splitlines():
            if line.startswith("$ "):
                if command:
                    yield command, expected
                command, expected = line[2:], []
            elif line.startswith("> ") and not expected:
                command += "\n" + line[2:]
            else:
                expected.append(line)
        yield command, expected


def pattern_of(lines: list[str]) -> str:
    out = ""
    for line in lines:
        out += r"(?:.*\n)*" if line == "..." else re.escape(line).replace(r"\.\.\.", ".*") + r"\n"
    return out


def main():
    repository, programs = (pathlib.Path(argument).resolve() for argument in sys.argv[1:3])
    environment = dict(os.environ, PATH=f"{programs}:/usr/bin:{os.environ['PATH']}")  # Debian's python3 first
    name = sys.argv[3] if len(sys.argv) > 3 else "tutorial.md"
    done = 0
    with tempfile.TemporaryDirectory() as folder:
        os.symlink(repository / "sample-dem", f"{folder}/sample-dem")
        for command, expected in steps((repository / "docs" / name).read_text()):
            run = subprocess.run(["bash", "-ec", command], cwd=folder, env=environment, capture_output=True, text=True)
            if run.returncode or not re.fullmatch(pattern_of(expected), run.stdout):
                sys.exit(f"docs/{name}: $ {command}\nexpected exit code 0 and\n" + "\n".join(expected) +
                         f"\nfound exit code {run.returncode} and\n{run.stdout}{run.stderr}")
            done += 1
    if done < 8:
        sys.exit(f"docs/{name}: expected 8 commands or more, found {done}")


if __name__ == "__main__":
    main()
