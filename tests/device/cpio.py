# SPDX-License-Identifier: MIT
"""Writes archives that the kernel unpacks as an initial file system (cpio, "newc" layout)."""
import stat


class Archive:
    """Folders must be added before what lies in them."""

    def __init__(self):
        self._parts = []
        self._entries = 0

    def folder(self, path):
        self._add(path, stat.S_IFDIR | 0o755, b"")

    def file(self, path, content, mode):
        self._add(path, stat.S_IFREG | mode, content)

    def link(self, path, target):
        self._add(path, stat.S_IFLNK | 0o777, target.encode())

    def bytes(self):
        """The whole archive, a multiple of 512 bytes, so that another can follow."""
        self._entries += 1
        return self._padded(b"".join(self._parts) + self._entry("TRAILER!!!", 0, b""), 512)

    def write(self, path):
        with open(path, "wb") as file:
            file.write(self.bytes())

    def _add(self, path, mode, content):
        self._entries += 1
        self._parts.append(self._entry(path, mode, content))

    def _entry(self, path, mode, content):
        name = path.encode() + b"\0"
        # Inode, mode, owner, group, links, time, size, four device numbers, length of the name, no checksum.
        fields = (self._entries, mode, 0, 0, 1, 0, len(content), 0, 0, 0, 0, len(name), 0)
        header = b"070701" + b"".join(b"%08X" % field for field in fields)
        return self._padded(header + name, 4) + self._padded(content, 4)

    @staticmethod
    def _padded(data, multiple):
        return data + b"\0" * (-len(data) % multiple)
