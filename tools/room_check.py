#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Compiler launcher that enforces cmake/rooms.toml.

    room_check.py --room calib -- ccache g++ ... -MF x.o.d -o x.o -c x.cpp

Runs the compilation, reads the dependency file that the compiler wrote, and fails (removing the object) if it names a
header that the room may not include. A pure room is also checked for direct includes of clocks, files and streams.
"""
import os
import re
import subprocess
import sys
import tomllib

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))


def load_table():
    with open(os.path.join(ROOT, "cmake", "rooms.toml"), "rb") as f:
        return tomllib.load(f)


def room_of(path, table):
    """The room that a path relative to the project root lies in, and the rest of the path."""
    for room in sorted(table["room"], key=len, reverse=True):
        if path.startswith(room + "/"):
            return room, path[len(room) + 1:]
    return None, path


def library_of(path, table):
    tail = re.sub(r"^/usr(/local)?/(include|lib)/(x86_64-linux-gnu/|aarch64-linux-gnu/)?", "", path)
    for name, prefixes in table["library"].items():
        if any(tail.startswith(p) for p in prefixes):
            return name
    return None


def closure(room, table):
    """Rooms and libraries that come along with the room's own: {room: "public"|"vocabulary"}, {library}."""
    rooms, libraries, queue = {}, set(table["room"][room]["libraries"]), list(table["room"][room]["rooms"])
    while queue:
        entry = queue.pop()
        name, _, part = entry.partition(":")
        if rooms.get(name) == "public" or (part and name in rooms):
            continue
        rooms[name] = part or "public"
        if not part:
            libraries |= set(table["room"][name]["libraries"])
            queue += table["room"][name]["rooms"]
    return rooms, libraries


def violations(room, dependencies, table):
    """One message for each header among `dependencies` that the room may not include."""
    rooms, libraries = closure(room, table)
    private = table["room"][room].get("private", False)
    found = []
    for path in dependencies:
        full = os.path.normpath(os.path.join(os.getcwd(), path))
        if full.startswith(ROOT + os.sep):
            relative = full[len(ROOT) + 1:]
            other, rest = room_of(relative, table)
            if other is None or other == room:
                continue
            kind = rooms.get(other)
            if kind is None:
                found.append(f"room '{room}' may not include '{relative}': it does not depend on '{other}'")
            elif kind == "vocabulary" and not relative.startswith(table["vocabulary"]):
                found.append(f"room '{room}' may not include '{relative}': only the vocabulary of '{other}'")
            elif "/detail/" in "/" + rest and not private:
                found.append(f"room '{room}' may not include '{relative}': it is a private part of '{other}'")
        else:
            library = library_of(full, table)
            if library and library not in libraries:
                found.append(f"room '{room}' may not include '{full}': library '{library}' is not allowed there")
    return found


def impure_includes(room, source, table):
    if not table["room"][room].get("pure") or not os.path.isfile(source):
        return []
    with open(source, encoding="utf-8") as f:
        names = re.findall(r'^\s*#\s*include\s*<([^>]+)>', f.read(), re.M)
    return [f"{source}: room '{room}' is pure and may not include <{n}>" for n in names
            if n in table["pure"]["forbidden"]]


def read_depfile(path):
    with open(path, encoding="utf-8") as f:
        text = f.read().replace("\\\n", " ")
    _, _, right = text.partition(": ")
    return [p.replace("\\ ", " ") for p in re.findall(r"(?:\\ |\S)+", right)]


def argument_after(command, flag):
    return command[command.index(flag) + 1] if flag in command else None


def main():
    split = sys.argv.index("--")
    room = sys.argv[sys.argv.index("--room") + 1]
    command = sys.argv[split + 1:]
    status = subprocess.call(command)
    depfile, source = argument_after(command, "-MF"), argument_after(command, "-c")
    if status != 0 or depfile is None:
        return status
    table = load_table()
    dependencies = read_depfile(depfile)
    found = violations(room, dependencies, table)
    for path in dependencies:
        full = os.path.normpath(os.path.join(os.getcwd(), path))
        if full.startswith(ROOT + os.sep) and room_of(full[len(ROOT) + 1:], table)[0] == room:
            found += impure_includes(room, full, table)
    if not found:
        return 0
    for message in sorted(set(found)):
        print(f"{source}: include rule broken: {message} (cmake/rooms.toml)", file=sys.stderr)
    target = argument_after(command, "-o")
    if target and os.path.exists(target):
        os.remove(target)
    return 1


if __name__ == "__main__":
    sys.exit(main())
