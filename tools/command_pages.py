#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Man pages, completion for bash and the configuration to begin with, made from the programs' own help.

    tools/command_pages.py BIN FOLDER [--prefix PREFIX]

Writes FOLDER/man1/*.1 (one page a program, and one a command: soak-fit.1, soak-campaign-start.1), FOLDER/soak.bash and
FOLDER/station.toml, whose maps are those in PREFIX/share/soak (default /usr).
"""
import argparse
import os
import pathlib
import re
import shutil
import subprocess
import tempfile

SECTIONS = ("Positionals:", "Options:", "Subcommands:", "Example:", "Examples:")
OPTION = re.compile(r"^ {2}((?:-\w,)?--[\w-]+|-\w)")
COMMAND = re.compile(r"^ {2}(\w[\w-]*) {2,}\S")


def help_of(program, words):
    return subprocess.run([program, *words, "--help"], capture_output=True, text=True, check=True).stdout


class Command:
    """A command as its help describes it, with those below it."""

    def __init__(self, program, words=()):
        self.words = [pathlib.Path(program).name, *words]
        self.text = help_of(program, words)
        self.options, names = [], []
        section = ""
        for line in self.text.splitlines():
            if line in SECTIONS:
                section = line
            elif section == "Options:" and (found := OPTION.match(line)):
                self.options += found.group(1).split(",")
            elif section == "Subcommands:" and (found := COMMAND.match(line)):
                names.append(found.group(1))
        self.commands = [Command(program, (*words, name)) for name in names]

    @property
    def summary(self):
        """The first line that is no usage, up to its colon."""
        return next(line for line in self.text.splitlines() if not re.match(r"usage:| ", line)).partition(": a ")[0]

    def all(self):
        yield self
        for command in self.commands:
            yield from command.all()


def roff(text):
    """Lines as they are: a point or an apostrophe at the beginning would be a request, a backslash an escape."""
    return "\n".join(re.sub(r"^([.'])", r"\\&\1", line) for line in text.replace("\\", "\\e").replace("-", "\\-").splitlines())


def man_page(command, version):
    name = "-".join(command.words)
    below = [f".BR {'-'.join(c.words)} (1)" for c in command.commands]
    above = [f".BR {'-'.join(command.words[:-1])} (1)"] if len(command.words) > 1 else []
    lines = [f'.TH "{name.upper()}" 1 "" "Soak {version}" "Soak"', ".SH NAME", roff(f"{name} - {command.summary}"), ".SH DESCRIPTION", ".nf",
             roff(command.text.removeprefix(command.summary + "\n")), ".fi"]
    if above or below:
        lines += [".SH SEE ALSO", *",\n".join(above + below).splitlines()]
    return "\n".join(lines) + "\n"


def completion(root):
    """One function for bash: the words before the cursor choose what can come next; else files."""
    cases = []
    for command in root.all():
        words = [c.words[-1] for c in command.commands] + [option for option in command.options if option.startswith("--")]
        cases.append(f'    "{" ".join(command.words)}") words="{" ".join(words)}" ;;')
    known = " ".join(sorted({" ".join(command.words).replace(" ", "_") for command in root.all()}))
    return f"""# Completion of soak's commands and options for bash.
_soak() {{
  local current=${{COMP_WORDS[COMP_CWORD]}} path=soak words= word
  local known=" {known} "
  for word in "${{COMP_WORDS[@]:1:COMP_CWORD-1}}"; do
    [[ $known != *" ${{path// /_}}_$word "* ]] || path="$path $word"
  done
  case $path in
{chr(10).join(cases)}
  esac
  mapfile -t COMPREPLY < <(compgen -W "$words" -- "$current")
}}
complete -o default -F _soak soak
"""


def configuration(soakd, prefix):
    with tempfile.TemporaryDirectory() as folder:
        environment = {**os.environ, "SOAK_PROCEDURES": f"{prefix}/share/soak/procedures", "SOAK_DATA": folder}
        return subprocess.run([soakd, "--write-config"], env=environment, capture_output=True, text=True, check=True).stdout


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("bin", type=pathlib.Path, help="folder of the programs")
    parser.add_argument("folder", type=pathlib.Path, help="where to write")
    parser.add_argument("--prefix", default="/usr", help="where the programs will be installed (default /usr)")
    options = parser.parse_args()
    shutil.rmtree(options.folder, ignore_errors=True)
    (options.folder / "man1").mkdir(parents=True)
    soak = Command(options.bin / "soak")
    version = subprocess.run([options.bin / "soak", "--version"], capture_output=True, text=True, check=True).stdout.split()[-1]
    for command in [*soak.all(), Command(options.bin / "soakd"), Command(options.bin / "soaksim")]:
        (options.folder / "man1" / ("-".join(command.words) + ".1")).write_text(man_page(command, version), encoding="utf-8")
    (options.folder / "soak.bash").write_text(completion(soak), encoding="utf-8")
    (options.folder / "station.toml").write_text(configuration(options.bin / "soakd", options.prefix), encoding="utf-8")


if __name__ == "__main__":
    main()
