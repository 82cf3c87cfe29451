#!/usr/bin/env python3
"""scripts/layers over small trees: one that is right, and one for each fault that it has to find.

usage: tests/scripts/layers_test.py PATH/TO/scripts/layers"""

import pathlib
import subprocess
import sys
import tempfile
import unittest

LAYERS = pathlib.Path(sys.argv.pop(1)).resolve() if len(sys.argv) > 1 else pathlib.Path("scripts/layers").resolve()

TABLE = """```imports
format/include:
format:
builder/io:
builder: builder/io format
builder/app: builder program
```
"""

CLEAN = {
    "docs/architecture.md": TABLE,
    "format/include/cairn/number.h": "#pragma once\nusing Number = int;\n",
    "format/bytes.h": '#pragma once\n#include "cairn/number.h"\nNumber bytes();\n',
    "format/bytes.cpp": '#include "format/bytes.h"\nNumber bytes() { return 1; }\n',
    "builder/io/file.h": "#pragma once\nint size_of_file();\n",
    "builder/bake.h": '#pragma once\n#include "builder/io/file.h"\n#include "format/bytes.h"\n',
    "builder/app/main.cpp": '#include "builder/bake.h"\nconst char* help = "--force";\n',
}


class LayersTest(unittest.TestCase):
    def run_layers(self, changes, *arguments):
        with tempfile.TemporaryDirectory() as name:
            root = pathlib.Path(name)
            for path, text in {**CLEAN, **changes}.items():
                (root / path).parent.mkdir(parents=True, exist_ok=True)
                (root / path).write_text(text)
            return subprocess.run([sys.executable, LAYERS, "--root", root, *arguments], capture_output=True, text=True)

    def check_fault(self, changes, *words):
        done = self.run_layers(changes)
        self.assertEqual(done.returncode, 1, done.stderr)
        self.assertEqual(len(done.stderr.splitlines()), 1, done.stderr)
        for word in words:
            self.assertIn(word, done.stderr)

    def test_a_tree_that_is_right_passes(self):
        done = self.run_layers({})
        self.assertEqual((done.returncode, done.stderr), (0, ""))

    def test_an_import_that_the_table_does_not_name_is_a_fault(self):
        self.check_fault({"builder/io/file.h": '#pragma once\n#include "format/bytes.h"\n'},
                         "builder/io/file.h", "expected builder/io to include only", "format/bytes.h")

    def test_a_folder_without_a_row_is_a_fault(self):
        self.check_fault({"builder/new/thing.h": "#pragma once\n"}, "builder/new/thing.h", "no row builder/new")

    def test_a_header_that_does_not_compile_alone_is_a_fault(self):
        self.check_fault({"builder/io/file.h": "#pragma once\nstd::string name();\n",
                          "builder/bake.h": '#pragma once\n#include <string>\n#include "builder/io/file.h"\n'},
                         "builder/io/file.h", "expected to compile alone")

    def test_a_header_without_a_guard_is_a_fault(self):
        self.check_fault({"builder/io/file.h": "int size_of_file();\n"}, "builder/io/file.h", "#pragma once")

    def test_a_circle_of_folders_is_a_fault(self):
        table = TABLE.replace("builder/io:", "builder/io: builder")
        self.check_fault({"docs/architecture.md": table,
                          "builder/io/file.h": '#pragma once\n#include "builder/plan.h"\n',
                          "builder/plan.h": "#pragma once\n"},
                         "circle of folders", "builder -> builder/io -> builder")

    def test_a_circle_of_units_in_one_folder_is_a_fault(self):
        self.check_fault({"builder/plan.h": "#pragma once\nint plan();\n",
                          "builder/plan.cpp": '#include "builder/plan.h"\n#include "builder/bake.h"\n',
                          "builder/bake.h": '#pragma once\n#include "builder/plan.h"\n'},
                         "circle of units", "builder/bake", "builder/plan")

    def test_a_command_line_option_in_a_library_is_a_fault(self):
        self.check_fault({"builder/bake.h": '#pragma once\ninline const char* advice = "give --force";\n'},
                         "builder/bake.h", "expected no command-line option", "--force")

    def test_a_graphics_api_outside_its_folders_is_a_fault(self):
        self.check_fault({"builder/bake.h": "#pragma once\n#include <epoxy/gl.h>\n"},
                         "builder/bake.h", "expected no graphics API")


if __name__ == "__main__":
    unittest.main()
