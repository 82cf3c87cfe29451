#!/usr/bin/env python3
"""Whether the files that a unity build compiles together have no local name twice: configures one and checks the syntax of
each of its units.

usage: tests/scripts/unity_test.py REPOSITORY"""

import concurrent.futures
import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile


def main():
    repository = pathlib.Path(sys.argv[1]).resolve()
    with tempfile.TemporaryDirectory() as build:
        subprocess.run(["cmake", "-S", repository, "-B", build, "-G", "Ninja", "-D", "CAIRN_UNITY=ON", "-D", "CAIRN_TESTS=OFF",
                        "-D", "CMAKE_EXPORT_COMPILE_COMMANDS=ON"], check=True, capture_output=True)
        commands = json.loads((pathlib.Path(build) / "compile_commands.json").read_text())
        units = [c for c in commands if "/Unity/" in c["file"]]
        if len(units) < 10:
            sys.exit(f"unity: expected 10 units or more, found {len(units)}")

        def check(unit):
            command = re.sub(r" -o \S+ -c ", " -fsyntax-only ", unit["command"])
            done = subprocess.run(command, shell=True, cwd=unit["directory"], capture_output=True, text=True)
            return "" if done.returncode == 0 else "\n".join(l for l in done.stderr.splitlines() if "error" in l)

        with concurrent.futures.ThreadPoolExecutor(min(2, os.cpu_count() or 1)) as pool:
            faults = [fault for fault in pool.map(check, units) if fault]
        if faults:
            sys.exit("unity: expected no local name twice in a unit (rename one, or SKIP_UNITY_BUILD_INCLUSION), found\n" +
                     "\n".join(faults))


if __name__ == "__main__":
    main()
