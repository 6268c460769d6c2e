"""Root never runs a submission: make the interpreter reachable for nobody, become nobody, then run the command.

Python often lives where only root may go (below /root, say).  In a mount namespace of our own each closed folder on the
way is covered by an empty one that is open, and only what is needed is bound back into it; the disk stays as it was.
"""

import json
import os
import sys

from . import harden

NOBODY = 65534


def closed_ancestor(path: str) -> str | None:
    """The first folder on the way to `path` that others may not enter."""
    parts = path.split("/")
    for i in range(2, len(parts)):
        if not os.stat(folder := "/".join(parts[:i])).st_mode & 0o001:
            return folder
    return None


def make_way(needed: list[str]) -> None:
    """Make each of the needed folders reachable for everybody, in this process and its children."""
    behind: dict[str, list[str]] = {}
    for path in needed:
        if folder := closed_ancestor(path):
            behind.setdefault(folder, []).append(path)
    if not behind:
        return
    harden.private_mounts()
    for folder, paths in behind.items():
        handles = {path: os.open(path, os.O_PATH) for path in paths}
        harden.mount("tmpfs", folder, "tmpfs", 0, "size=1m,mode=755")
        for path, handle in handles.items():
            os.makedirs(path, exist_ok=True)
            harden.mount(f"/proc/self/fd/{handle}", path, flags=harden.MS_BIND | harden.MS_REC)
            os.close(handle)


def main(needed: list[str], folder: str, command: list[str]) -> None:
    make_way(needed)
    os.setgroups([])
    os.setgid(NOBODY)
    os.setuid(NOBODY)
    os.chdir(folder)
    os.execv(command[0], command)


if __name__ == "__main__":
    try:
        main(json.loads(sys.argv[1]), sys.argv[2], sys.argv[3:])
    except OSError as error:
        sys.exit(f"root could not become nobody here: {error}")
