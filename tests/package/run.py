#!/usr/bin/env python3
"""Tests the packages in a bare tree (a minimal Debian installation): they install, run, and are built reproducibly.

    run.py ROOT

Needs root (debootstrap, chroot). Builds the packages of the project ROOT twice and makes a bare tree with debootstrap. In the tree the
release archive must run as it is, and the Debian package after `apt-get install`. Prints one line for each test: `ok ...`, `not ok ...` or
`skip ...`.
"""

import contextlib
import hashlib
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import urllib.error
import urllib.request

failed = 0


@contextlib.contextmanager
def test(name):
    global failed
    try:
        yield
        print(f"ok {name}", flush=True)
    except Exception as error:  # every kind of failure becomes a line `not ok`
        failed += 1
        print(f"not ok {name}\n  {type(error).__name__}: {error}", flush=True)


def run(*command, **options):
    done = subprocess.run([str(c) for c in command], text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE, stdin=subprocess.DEVNULL, **options)
    if done.returncode != 0:
        raise RuntimeError(f"{' '.join(map(str, command))}: status {done.returncode}\n{done.stdout[-1500:]}{done.stderr[-1500:]}")
    return done.stdout


def expect(condition, message):
    if not condition:
        raise AssertionError(message)


def build_packages(root):
    run("scripts/package", cwd=root)
    return {p.suffix: p for p in (root / "build/packages").iterdir()}


def hash_of(text):
    return json.loads(text)["state_hash"]


def enter(tree):
    """Returns the beginning of a command that runs in the tree, with /proc, which programs need to find their own folder."""
    return ["unshare", "--mount", "sh", "-c", 'mount -t proc proc "$0/proc" && exec chroot "$0" env HOME=/root DEBIAN_FRONTEND=noninteractive "$@"', str(tree)]


def check_studio(tree, program):
    """Checks that the studio serves its page, exports the open project, and refuses a request without its token."""
    studio = subprocess.Popen([*enter(tree), program, "studio", "/root/park.ugoki", "--no-open", "--json"],
                              stdout=subprocess.PIPE, text=True)
    try:
        text = ""
        while "}" not in text:
            line = studio.stdout.readline()
            expect(line, f"the studio ended: {text}")
            text += line
        started = json.loads(text)
        base = f"http://127.0.0.1:{started['port']}"
        page = urllib.request.urlopen(f"{base}/", timeout=20).read().decode()
        script = re.search(r'src="\./?(assets/[^"]+\.js)"', page)
        expect(script, page[:500])
        expect(len(urllib.request.urlopen(f"{base}/{script[1]}", timeout=20).read()) > 10000, "the script of the page")
        request = urllib.request.Request(f"{base}/api/export/ugx", headers={"Authorization": f"Bearer {started['token']}"})
        expect(len(urllib.request.urlopen(request, timeout=60).read()) > 10000, "the studio exports the open project")
        with contextlib.suppress(urllib.error.HTTPError):
            urllib.request.urlopen(f"{base}/api/export/ugx", timeout=20)
            raise AssertionError("the studio answers without its token")
    finally:
        studio.terminate()
        studio.wait(20)


def check(root, work):
    first = build_packages(root)
    kept = {suffix: hashlib.sha256(file.read_bytes()).hexdigest() for suffix, file in first.items()}
    packages = build_packages(root)
    with test("the packages are built reproducibly"):
        again = {suffix: hashlib.sha256(file.read_bytes()).hexdigest() for suffix, file in packages.items()}
        expect(again == kept, f"{kept} {again}")
    for file in packages.values():
        print(f"# {file.name} {file.stat().st_size} bytes")

    program = root / "build/release/bin/ugoki"
    run(program, "new", work / "park.ugoki")
    golden = hash_of(run(program, "run", work / "park.ugoki", "--steps", "600", "--json"))

    tree = work / "tree"
    run("debootstrap", "--variant=minbase", "bookworm", tree)
    shutil.copy(work / "park.ugoki", tree / "root")
    inside = lambda *command: run(*enter(tree), *command)

    with test("the release archive runs in a bare tree and gives the same state"):
        run("tar", "-C", tree / "opt", "-xzf", packages[".gz"])
        folder = next(p.name for p in (tree / "opt").iterdir() if p.name.startswith("ugoki"))
        expect(hash_of(inside(f"/opt/{folder}/bin/ugoki", "run", "/root/park.ugoki", "--steps", "600", "--json")) == golden, "another state")
        check_studio(tree, f"/opt/{folder}/bin/ugoki")
        inside(f"/opt/{folder}/bin/ugoki", "export", "/root/park.ugoki", "--html", "/root/park.html", "--native", "/root/park")
        expect(hash_of(inside("/root/park", "--headless", "--steps", "600", "--json")) == golden, "another state of the exported program")

    with test("the Debian package installs in a bare tree, `ugoki studio` works, and `ugoki run` gives the same state"):
        shutil.copy(packages[".deb"], tree / "root/ugoki.deb")
        inside("apt-get", "update")
        inside("apt-get", "-y", "--no-install-recommends", "install", "/root/ugoki.deb")
        expect(hash_of(inside("ugoki", "run", "/root/park.ugoki", "--steps", "600", "--json")) == golden, "another state")
        check_studio(tree, "/usr/bin/ugoki")
        inside("apt-get", "-y", "remove", "ugoki")
        expect(not (tree / "usr/bin/ugoki").exists(), "the program is left after the package was removed")


def main():
    root = pathlib.Path(sys.argv[1]).resolve()
    if os.geteuid() != 0 or not shutil.which("debootstrap"):
        print("skip the packages in a bare tree: needs root and debootstrap")
        return 0
    work = pathlib.Path(tempfile.mkdtemp(prefix="ugoki-package-"))
    try:
        check(root, work)
    except Exception as error:  # for example a package cannot be built
        print(f"not ok the packages are built\n  {error}")
        return 1
    finally:
        shutil.rmtree(work, ignore_errors=True)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
