#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The packages in a fresh Debian 12 that has nothing else: what a user gets who types apt install.

root_test.py CHECK --build build --source . [--packages FOLDER] [--downloads FOLDER] [--mirror URL]
  program      fringetwin and python3-fringetwin: apt finds all they need without recommends; a plain user runs the demo and
               an example of the Python module; there is no compiler; purged, they leave nothing
  development  libfringetwin-dev with g++ and CMake, and no other library: tests/package/example is built, and measures there;
               purged, it leaves nothing (676 MB of downloads)

debootstrap makes the root below a scratch folder. Its mounts are of a mount namespace that ends with this program. Each step
prints how long it took, and of the processors; those marked * are what a user waits for beside the downloads, at most 120 s
together. On a machine with other work the processors' time counts where it is the shorter one.
Exit code 77: not root, no debootstrap, or no Debian mirror within reach.
"""
import argparse
import html.parser
import os
import pathlib
import re
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import urllib.request

from made_packages import Fault, TWIN, expect, field, make_packages, names_in, packages_in, project_version, run

SUITE = "bookworm"
LONGEST = 120  # s, of what a user waits for (the bound that the program was asked to keep)
COMPILERS = ("cc", "gcc", "c++", "g++", "clang", "c99", "as", "ld", "make", "cmake", "ninja")
# Of the root: where nothing is installed, and where apt and dpkg keep their own records; dpkg's info/ has files of packages.
NOT_COMPARED = ("proc", "sys", "dev", "run", "tmp", "home", "packages", "var/log", "var/cache/apt", "var/lib/apt", "var/lib/dpkg")
COMPARED = "var/lib/dpkg/info"


def processor_seconds():
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


class Page(html.parser.HTMLParser):
    """How many pictures a page has in it, and the files that it shows or links to."""

    def __init__(self, page):
        super().__init__()
        self.names, self.pictures = set(), 0
        self.feed(page.read_text(encoding="utf-8"))

    def handle_starttag(self, tag, attrs):
        self.pictures += tag in ("img", "svg")
        for name, value in attrs:
            if name in ("src", "href") and value and not re.match(r"#|data:|https?:", value):
                self.names.add(value.split("#")[0])


class Root:
    """A fresh Debian below a folder, with the packages in /packages and a user who may do nothing special."""

    def __init__(self, folder, downloads, mirror):
        self.folder, self.counted, self.waited = folder, 0.0, 0.0
        self.timed("Debian 12 is unpacked", False, lambda: run(
            ["debootstrap", "--variant=minbase", f"--cache-dir={downloads}", SUITE, folder, mirror], seconds=900))
        security = mirror.rstrip("/") + "-security"
        (folder / "etc/apt/sources.list").write_text(
            f"deb {mirror} {SUITE} main\ndeb {mirror} {SUITE}-updates main\ndeb {security} {SUITE}-security main\n", encoding="utf-8")
        run(["mount", "-t", "proc", "proc", folder / "proc"])
        run(["mount", "--bind", downloads, folder / "var/cache/apt/archives"])
        self.timed("package lists are fetched, Debian is brought up to date", False, lambda: (
            self.call("apt-get", "update", "-qq"), self.apt("dist-upgrade")))
        self.call("useradd", "--create-home", "--shell", "/bin/bash", "user")

    def timed(self, what, counts, action):
        begin, before = time.monotonic(), processor_seconds()
        result = action()
        seconds, of_processors = time.monotonic() - begin, processor_seconds() - before
        if counts:
            self.waited += seconds
            self.counted += min(seconds, of_processors)
        print(f"{seconds:7.1f} s, {of_processors:6.1f} s of the processors {'*' if counts else ' '} {what}", flush=True)
        return result

    def call(self, *command, user="root", seconds=900, folder="/"):
        home = "/root" if user == "root" else "/home/user"
        environment = {"PATH": "/usr/local/bin:/usr/bin:/bin:/usr/sbin:/sbin", "HOME": home, "LANG": "C.UTF-8",
                       "DEBIAN_FRONTEND": "noninteractive"}
        return run(["chroot", f"--userspec={user}:{user}", self.folder, "env", "-C", folder, *command], environment, seconds=seconds)

    def apt(self, action, *words):
        return self.call("apt-get", action, "--yes", "--no-install-recommends", *words)

    def files(self):
        """Every file of the root that is no record of apt's or dpkg's own."""
        found = set()
        for place, folders, files in os.walk(self.folder):
            below = os.path.relpath(place, self.folder)
            folders[:] = [name for name in folders if os.path.normpath(os.path.join(below, name)) not in NOT_COMPARED]
            found |= {os.path.normpath(os.path.join(below, name)) for name in files + folders}
        return found | {f"{COMPARED}/{name}" for name in os.listdir(self.folder / COMPARED)}

    def put(self, packages):
        (self.folder / "packages").mkdir()
        for file in packages:
            shutil.copy(file, self.folder / "packages")

    def install(self, packages):
        """What they depend on first, so that the files are known that were there before them."""
        own = {field(file, "Package") for file in packages}
        groups = [group.strip() for file in packages for group in field(file, "Depends").split(",")]
        needs = ", ".join(group for group in groups if not names_in(group) & own)
        self.timed("what they need is fetched", False, lambda: self.apt("satisfy", "--download-only", needs))
        self.timed("what they need is installed", True, lambda: self.apt("satisfy", needs))
        before = self.files()
        self.put(packages)
        said = self.timed("apt install", True, lambda: self.apt("install", *(f"/packages/{file.name}" for file in packages)))
        expect(f"0 upgraded, {len(packages)} newly installed" in said, f"apt wants more than the packages say:\n{said}")
        for name in own:
            files = self.call("dpkg", "-L", name).split("\n")
            expect(len(files) > 5, f"{name} installed {files}")
        return before

    def purge(self, names, before):
        self.timed("apt purge", False, lambda: self.call("apt-get", "purge", "--yes", *names))
        after = self.files()
        expect(after == before, f"purged, the packages leave {sorted(after - before)} and lack {sorted(before - after)}")


def check_page(file, pictures):
    """The page is whole, has that many pictures at least, and all that it links to."""
    expect(file.is_file() and file.read_text(encoding="utf-8").rstrip().endswith("</html>"), f"no whole page {file}")
    page = Page(file)
    expect(page.pictures >= pictures, f"{file} has {page.pictures} pictures")
    missing = [name for name in sorted(page.names) if not (file.parent / name).exists()]
    expect(not missing, f"{file} links to {missing}, which are missing")


def check_program(root, packages, source):
    installed = [packages["fringetwin"], packages["python3-fringetwin"]]
    before = root.install(installed)
    there = [name for name in COMPILERS for place in ("usr/bin", "usr/local/bin", "usr/sbin") if (root.folder / place / name).exists()]
    expect(not there, f"the packages brought compilers: {there}")
    said = root.timed("fringetwin --version", False, lambda: root.call("fringetwin", "--version", user="user"))
    expect(project_version(source) in said, f"another version: {said}")
    root.timed("the demo", True, lambda: root.call(
        "bash", "/usr/share/fringetwin/demo.sh", "/home/user/demo", user="user", folder="/home/user"))
    demo = root.folder / "home/user/demo"
    check_page(demo / "index.html", 0)
    reports = sorted(demo.glob("*/report.html"))
    expect(len(reports) == len(Page(demo / "index.html").names) == 4, f"the demo made {reports}")
    for report in reports:
        check_page(report, 10)
    said = root.timed("an example of the Python module", False, lambda: root.call(
        "python3", "/usr/share/doc/python3-fringetwin/examples/gain.py", f"/usr/share/fringetwin/{TWIN}", "/home/user/gain", user="user"))
    expect("DN" in said, f"the example says {said}")
    check_page(root.folder / "home/user/gain/report.html", 10)
    root.call("python3", "-c", "import fringetwin")  # as root, who may write beside the module
    root.purge(["fringetwin", "python3-fringetwin"], before)


def check_development(root, packages, source):
    package = packages["libfringetwin-dev"]
    root.apt("install", "g++", "cmake", "make", "mesa-vulkan-drivers", "gnuplot-nox")
    before = root.install([package])
    shutil.copytree(source / "tests/package/example", root.folder / "home/user/example")
    shutil.copytree(source / os.path.dirname(TWIN), root.folder / "home/user/twin")
    root.call("chown", "-R", "user:user", "/home/user")
    root.timed("a program of somebody else is built", False, lambda: root.call(
        "sh", "-c", "cmake -S example -B build -DCMAKE_BUILD_TYPE=Release && cmake --build build", user="user", folder="/home/user"))
    said = root.timed("it measures", False, lambda: root.call("/home/user/build/example", "/home/user/twin/twin.toml", user="user"))
    expect(re.match(r"\w+ \d+\.\d+", said), f"the example says {said}")
    root.purge(["libfringetwin-dev"], before)


def skip(why):
    print(f"skipped: {why}")
    sys.exit(77)


def can_run(mirror):
    if os.geteuid() != 0:
        skip("only root makes a root of its own (chroot, mounts)")
    if not shutil.which("debootstrap"):
        skip("debootstrap is not installed (apt install debootstrap)")
    if subprocess.run(["unshare", "--mount", "--pid", "--fork", "true"], check=False, capture_output=True).returncode != 0:
        skip("this machine allows no mount namespaces (unshare)")
    try:
        urllib.request.urlopen(f"{mirror}/dists/{SUITE}/Release", timeout=20).close()
    except OSError as fault:
        skip(f"no Debian mirror at {mirror}: {fault}")


def inside(chosen):
    """In namespaces of its own: what is mounted and started here ends with it."""
    build, source, scratch = pathlib.Path(chosen.build), pathlib.Path(chosen.source), pathlib.Path(chosen.scratch)
    downloads = pathlib.Path(chosen.downloads) if chosen.downloads else scratch / "downloads"
    downloads.mkdir(parents=True, exist_ok=True)
    if not chosen.packages:
        make_packages(build, scratch / "made")
    packages = packages_in(build, pathlib.Path(chosen.packages or scratch / "made"))
    if chosen.check == "program" and "python3-fringetwin" not in packages:
        skip("the Python module was not built")
    root = Root(scratch / "root", downloads.resolve(), chosen.mirror)
    {"program": check_program, "development": check_development}[chosen.check](root, packages, source)
    print(f"{root.waited:7.1f} s * together; {root.counted:.1f} s count, of at most {LONGEST} s")
    expect(chosen.check != "program" or root.counted <= LONGEST, "a user waits too long")


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("check", choices=["program", "development"])
    parser.add_argument("--build", required=True)
    parser.add_argument("--source", required=True)
    parser.add_argument("--downloads", help="keeps the Debian packages here, for the next time")
    parser.add_argument("--packages", help="the folder that install_test.py made has filled; without one they are made")
    parser.add_argument("--mirror", default="http://deb.debian.org/debian")
    parser.add_argument("--scratch", help=argparse.SUPPRESS)
    chosen = parser.parse_args()
    if chosen.scratch:
        try:
            inside(chosen)
        except Fault as fault:
            print(fault)
            sys.exit(1)
        print(f"{chosen.check}: as it should be")
        return
    can_run(chosen.mirror)
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(1))  # so that the scratch folder is removed
    places = [f"--{name}={pathlib.Path(getattr(chosen, name)).resolve()}" for name in ("build", "source", "downloads", "packages")
              if getattr(chosen, name)]
    with tempfile.TemporaryDirectory() as scratch:
        sys.exit(subprocess.run(
            ["unshare", "--mount", "--pid", "--fork", "--kill-child", "--mount-proc", sys.executable, __file__, chosen.check, *places,
             f"--mirror={chosen.mirror}", f"--scratch={scratch}"], check=False).returncode)


main()
