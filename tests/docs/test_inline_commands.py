# SPDX-License-Identifier: Apache-2.0
"""Commands in the prose of all pages, and those of other programs. Every command of ours that a page names, in a sentence or a block,
exists, and so does every option beside it: the programs' own --help is asked. The commands of the READMEs for developers are held
against the build, the scripts that they run are run in a copy."""
import functools
import os
import pathlib
import re
import shlex
import shutil
import subprocess
import tempfile
import unittest

from test_commands import BIN, PROGRAMS, ROOT, commands_of

BUILD = pathlib.Path(os.environ["SOAK_BUILD_FOLDER"])
NOT_OURS = ("--gtest_", "--no-")  # options of other programs that a page names alone


def all_pages():
    """All that is documentation. Not the record of the past: CHANGELOG.md and the decisions."""
    pages = [ROOT / "README.md", ROOT / "CONTRIBUTING.md"]
    for folder in ("anfis", "base", "bench", "calib", "db", "docs", "hal", "nav", "procedures", "settings", "station", "tests"):
        pages += sorted(page for page in (ROOT / folder).rglob("*.md") if "node_modules" not in page.parts)
    return [page for page in pages if "decisions" not in page.parts]


@functools.cache
def help_of(*command):
    done = subprocess.run([BIN / command[0], *command[1:], "--help"], capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == 0, f"{command}: {done.stderr}"
    return done.stdout


def subcommands_of(*command):
    listed = re.search(r"^Subcommands:\n((?:  .*\n)+)", help_of(*command), re.M)
    return re.findall(r"^  (\S+)", listed[1], re.M) if listed else []


def has_option(text, option):
    return re.search(rf"(?<![\w-]){re.escape(option)}(?![\w-])", text) is not None


def mistake_in(words):
    """What is wrong with a command line of ours; None: its subcommands and options exist. It may end in mid-way."""
    command, rest = [words[0]], list(words[1:])
    while rest and (known := subcommands_of(*command)):
        if rest[0] == "COMMAND":
            return None
        if rest[0].startswith("-"):
            break
        if rest[0] not in known:
            return f"'{' '.join(command)}' has no command '{rest[0]}'"
        command.append(rest.pop(0))
    for word in rest:
        option = re.match(r"\[?(--?[a-z][\w-]*)", word)
        if option and not has_option(help_of(*command), option[1]):
            return f"'{' '.join(command)}' has no option '{option[1]}'"
    return None


def spans_of(page):
    """What stands between backquotes, outside of blocks; a span may go on in the next line."""
    prose = "\n".join(line for line in page.read_text(encoding="utf-8").splitlines() if not line.startswith("    "))
    for paragraph in re.split(r"\n\s*\n|\n(?=[|#-])", prose):
        for span in re.findall(r"`([^`]+)`", paragraph):
            yield " ".join(span.split())


def words_of(line):
    """The words of a command up to a pipe, a redirection or the next command."""
    line = re.split(r"\s[|&;>]|…", line)[0]
    try:
        return shlex.split(line)
    except ValueError:
        return line.split()


class OwnCommands(unittest.TestCase):
    def test_every_command_and_option_that_a_page_names_exists(self):
        seen = 0
        for page in all_pages():
            for line in [*spans_of(page), *commands_of(page)]:
                words = words_of(line)
                if not words or words[0] not in PROGRAMS or len(words) < 2:
                    continue
                seen += 1
                with self.subTest(page=str(page.relative_to(ROOT)), command=line):
                    self.assertIsNone(mistake_in(words))
        self.assertGreater(seen, 150)

    def test_every_option_that_stands_alone_is_one_of_some_command(self):
        commands = [(program,) for program in PROGRAMS]
        texts = [path.read_text(encoding="utf-8") for path in [ROOT / "tests" / "blind" / "benchmark.py", *(ROOT / "tools" / "prove").iterdir()]]
        while commands:
            command = commands.pop()
            texts.append(help_of(*command))
            commands += [(*command, name) for name in subcommands_of(*command)]
        self.assertGreater(len(texts), 60)
        for page in all_pages():
            for span in spans_of(page):
                option = re.match(r"--[a-z][\w-]*", span)
                if not option or span.startswith(NOT_OURS):
                    continue
                with self.subTest(page=str(page.relative_to(ROOT)), option=span):
                    self.assertTrue(any(has_option(text, option[0]) for text in texts))

    def test_a_command_or_an_option_that_does_not_exist_is_found(self):
        self.assertIsNone(mistake_in(["soak", "fit", "--unit", "SN0042"]))
        self.assertIsNone(mistake_in(["soak", "COMMAND", "--help"]))
        for wrong in ("soak fitt", "soak gap look", "soak fit --uni", "soak chamber make-safe --unit", "soaksim --unit", "soak -q"):
            self.assertIsNotNone(mistake_in(wrong.split()), wrong)

    def test_every_command_of_run_exists(self):
        usage = subprocess.run([ROOT / "run", "help"], capture_output=True, text=True, check=True).stdout
        known = re.findall(r"^  (\w+)", usage, re.M)
        self.assertIn("prove", known)
        for page in all_pages():
            for command, name in re.findall(r"\./run (\w+)(?: ([\w-]+))?", page.read_text(encoding="utf-8")):
                with self.subTest(page=str(page.relative_to(ROOT)), command=f"{command} {name}"):
                    self.assertIn(command, known)
                    if command == "prove" and name not in ("", "NAME"):
                        self.assertTrue((ROOT / "tools" / "prove" / name).is_file())


class DevelopersCommands(unittest.TestCase):
    """Of the READMEs of tests/: what they name is there and matches something. The build folder is that of this test."""

    def lines_of(self, page, beginning):
        lines = [re.sub(r"\s+#( .*)?$", "", line).strip() for line in (ROOT / page).read_text(encoding="utf-8").splitlines()
                 if line.startswith("    ")]
        lines = [line for line in lines if line.startswith(beginning)]
        self.assertTrue(lines, f"{page}: {beginning}")
        return [line.replace("build/check", str(BUILD)) for line in lines]

    def run_line(self, line, **options):
        done = subprocess.run(line, shell=True, executable="/bin/bash", capture_output=True, text=True, timeout=120, check=False,
                              **{"cwd": ROOT, **options})
        self.assertEqual(done.returncode, 0, f"{line}\n{done.stdout}\n{done.stderr}")
        return done.stdout

    def test_ctest_finds_what_the_page_names(self):
        for line in self.lines_of("tests/README.md", "ctest "):
            self.assertGreater(int(re.search(r"Total Tests: (\d+)", self.run_line(line + " -N"))[1]), 0, line)

    def test_filters_match_tests(self):
        for page in ("tests/README.md", "tests/data/golden/README.md"):
            for line in self.lines_of(page, "build/check/bin/"):
                if not pathlib.Path(line.split()[0]).exists():
                    self.skipTest(f"not built: {line.split()[0]}")
                self.assertRegex(self.run_line(line + " --gtest_list_tests"), r"(?m)^  \w", line)

    def test_a_python_test_begins_as_the_page_says(self):
        for line in self.lines_of("tests/README.md", "SOAK_BIN="):
            self.run_line(line.replace("build/release/bin", str(BIN)) + " -k no_test_has_this_name")

    def test_the_golden_values_are_those_that_their_script_makes(self):
        with tempfile.TemporaryDirectory(prefix="soak-golden-") as folder:
            copy = pathlib.Path(folder) / "tests" / "data" / "golden"
            shutil.copytree(ROOT / "tests" / "data" / "golden", copy)
            for path in copy.glob("*.values.json"):
                path.unlink()
            for line in self.lines_of("tests/data/golden/README.md", "python3 "):
                self.run_line(line, cwd=folder)
            made = {path.name: path.read_bytes() for path in copy.glob("*.values.json")}
        kept = {path.name: path.read_bytes() for path in (ROOT / "tests" / "data" / "golden").glob("*.values.json")}
        self.assertEqual(made, kept)


if __name__ == "__main__":
    unittest.main()
