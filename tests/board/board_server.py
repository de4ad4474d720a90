# SPDX-License-Identifier: MIT
"""The simulated boards of usbip_server.js as a process of a test: started, told things, ended."""
import json
import os
import socket
import subprocess
import sys

HERE = os.path.dirname(os.path.abspath(__file__))
SKIPPED = 77


class BoardServer:
    """with BoardServer("glint-sync.uf2") as boards: boards.port is for usbip_attach, boards.ask("status") for the test.

    Without firmware the boards are blank and show the boot ROM. Ends the test with 77 where there is no node."""

    def __init__(self, firmware=None, boards=1):
        command = [os.path.join(HERE, "with_node.sh"), os.path.join(HERE, "usbip_server.js"), "--boards", str(boards)]
        self._process = subprocess.Popen([*command, *([firmware] if firmware else [])], stdout=subprocess.PIPE, text=True)
        line = self._process.stdout.readline()
        if not line.startswith("{"):
            print(line, end="")
            sys.exit(SKIPPED if self._process.wait() == SKIPPED else 1)
        said = json.loads(line)
        self.port, self.control_port = said["port"], said["control_port"]
        self._socket = socket.create_connection(("127.0.0.1", said["control_port"]))
        self._answers = self._socket.makefile("r", encoding="utf-8")

    def ask(self, line):
        """Result of a line that usbip/control_lines.js knows, such as "adc 0 1800" or "1 unplug"."""
        self._socket.sendall(f"{line}\n".encode())
        answer = self._answers.readline().rstrip("\n")
        if not answer.startswith("ok"):
            raise RuntimeError(f"{line}: {answer or 'the server has ended'}")
        return json.loads(answer[3:]) if len(answer) > 3 else None

    def close(self):
        self._socket.close()
        self._process.terminate()
        self._process.wait()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()
