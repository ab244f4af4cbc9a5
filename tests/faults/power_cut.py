# SPDX-License-Identifier: Apache-2.0
"""What a disk holds after a loss of power, from the record of what was asked of it (disk_layer.c, SOAK_DISK_RECORD).

What was synced is there. Of what was not, each piece of 4 KiB is there or not, in any order, since a disk writes as it likes; of
names that were made, moved or removed since their folder was synced the first few are, in their order, since file systems keep a
journal of names. A file is synced by itself: its name is not, until its folder is."""
import os
import struct

ENTRY = struct.Struct("<c7xQQII")  # what, inode, place or size, lengths of what follows
PIECE = 4096


def entries(record):
    """(what, inode, place, path or bytes, second path, bytes of the record up to its end) of each change that is whole."""
    with open(record, "rb") as file:
        while len(head := file.read(ENTRY.size)) == ENTRY.size:
            what, inode, at, length, second_length = ENTRY.unpack(head)
            first, second = file.read(length), file.read(second_length)
            yield what.decode(), inode, at, first, second, file.tell()


class Node:
    """A file or folder: what is on the disk for certain, and what was asked since."""

    def __init__(self, is_folder=False):
        self.is_folder = is_folder
        self.kept = bytearray()
        self.pending = []

    def sync(self):
        for change in self.pending:
            carry_out(self.kept, change)
        self.pending.clear()


def carry_out(contents, change):
    at, piece = change
    if piece is None:  # another size
        del contents[at:]
        contents.extend(bytes(at - len(contents)))
        return
    contents.extend(bytes(max(0, at - len(contents))))
    contents[at:at + len(piece)] = piece


def pieces(at, data):
    """A write, cut at the borders of the disk's pieces."""
    begin = 0
    while begin < len(data):
        end = min(len(data), begin + PIECE - (at + begin) % PIECE)
        yield at + begin, data[begin:end]
        begin = end


class Disk:
    """A folder that was empty, or not there, when the record was begun."""

    def __init__(self, folder):
        self.folder = os.fspath(folder)
        self.inodes = {}   # -> node that has this number now
        self.now = {}      # path -> node, as programs see it
        self.kept = {}     # path -> node, on the disk for certain
        self.pending = []  # (folder, changes of names: (path, node or None)...) since its sync

    def apply(self, what, inode, at, first, second):
        if what in "CD":
            node = self.inodes[inode] = Node(is_folder=what == "D")
            self.name(first, [(first, node)])
        elif what == "M":
            self.name(second, [(first, None), (second, self.now[first])])
        elif what == "R":
            self.name(first, [(first, None)])
        elif inode in self.inodes:
            node = self.inodes[inode]
            if what == "W":
                node.pending.extend(pieces(at, first))
            elif what == "T":
                node.pending.append((at, None))
            elif what == "S":
                self.sync(node)

    def name(self, path, changes):
        change_names(self.now, changes)
        if os.fsdecode(path) == self.folder:  # its own name is the business of whoever made it
            change_names(self.kept, changes)
        else:
            self.pending.append((os.path.dirname(path), changes))

    def sync(self, node):
        node.sync()
        if not node.is_folder:
            return
        path = next(path for path, named in self.now.items() if named is node)
        for folder, changes in self.pending:
            if folder == path:
                change_names(self.kept, changes)
        self.pending = [change for change in self.pending if change[0] != path]

    def after_loss_of_power(self, chances, target):
        """Writes what is left into the folder `target`. `chances`: a random.Random."""
        share = chances.choice((0.0, 0.5, 0.9, 1.0))
        names = dict(self.kept)
        for _, changes in self.pending[:chances.randint(0, len(self.pending))]:
            change_names(names, changes)
        os.makedirs(target)
        folders = {path for path, node in names.items() if node.is_folder} | {os.fsencode(self.folder)}
        for path, node in sorted(names.items()):
            if os.path.dirname(path) not in folders or os.fsdecode(path) == self.folder:
                continue
            place = os.path.join(target, os.path.relpath(os.fsdecode(path), self.folder))
            if node.is_folder:
                os.makedirs(place, exist_ok=True)
                continue
            contents = bytearray(node.kept)
            for change in node.pending:
                if chances.random() < share:
                    carry_out(contents, change)
            with open(place, "wb") as file:
                file.write(contents)


def change_names(names, changes):
    for path, node in changes:
        if node is None:
            names.pop(path, None)
        else:
            names[path] = node
