#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What is installed works wherever it lies, names no place of the build, and the package says what it needs.

install_test.py CHECK --build build --source .
  install   cmake --install into a scratch folder, which is then moved: the program finds modules and data sets there, compares
            an installed example, and is all of it in the list that an uninstaller goes by
  package   the Debian package, unpacked: fields, dependencies (against what the loader resolves here), files, the program
  lintian   what lintian says of the package: nothing
  library   the component "development", moved, too: a program of somebody else (example/) finds headers and libraries there
            by find_package and measures to the last bit what the program does
Exit code 77: lintian or a Vulkan device is missing.
"""
import argparse
import ctypes
import json
import os
import pathlib
import re
import shutil
import stat
import subprocess
import sys
import tempfile


TWIN = "datasets/povray-ball-wall/twin.toml"  # with its images, and quick


class Fault(Exception):
    pass


def expect(condition, sentence):
    if not condition:
        raise Fault(sentence)


def run(command, environment=None, codes=(0,), folder="/"):
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True, timeout=240, check=False, cwd=folder,
                          env=environment)
    expect(done.returncode in codes, f"{command}: exit code {done.returncode}\n{done.stdout}{done.stderr}")
    return done.stdout


def bare():
    """The environment of somebody who knows nothing of the build."""
    names = ("PATH", "HOME", "FRINGETWIN_CACHE", "VK_DRIVER_FILES", "VK_ICD_FILENAMES")
    return {name: os.environ[name] for name in names if name in os.environ}


def files_below(folder):
    return sorted(path for path in pathlib.Path(folder).rglob("*") if path.is_symlink() or not path.is_dir())


def project_version(source):
    text = pathlib.Path(source, "CMakeLists.txt").read_text(encoding="utf-8")
    return re.search(r"project\(fringetwin VERSION ([\d.]+)", text)[1]


def binaries(prefix):
    return [*prefix.glob("bin/fringetwin"), *prefix.glob("lib/fringetwin/modules/*.so")]


def check_places(prefix, forbidden):
    """No file holds a path of the build, and no program or module looks for libraries where it was built."""
    for path in files_below(prefix):
        if path.is_symlink():
            expect(not os.readlink(path).startswith("/"), f"{path} links to {os.readlink(path)}")
            expect(path.exists(), f"{path} leads nowhere")
        elif path.suffix not in (".png", ".gz"):
            content = path.read_bytes()
            for place in forbidden:
                expect(os.fsencode(place) not in content, f"{path} holds {place}")
    for path in binaries(prefix):
        expect(not re.search("RPATH|RUNPATH", run(["readelf", "-d", path])), f"{path} has an RPATH")


def check_files(prefix, build, source):
    modules = {path.name for path in pathlib.Path(build).glob("libfringetwin_*.so")}
    expect({path.name for path in (prefix / "lib/fringetwin/modules").iterdir()} == modules, f"not the modules {modules}")
    pages = {line.split()[0] + ".gz" for line in run([prefix / "bin/fringetwin", "man", "--list"]).splitlines()}
    expect({path.name for path in (prefix / "share/man/man1").iterdir()} == pages, f"not the pages {pages}")
    for file in ("bash-completion/completions/fringetwin", "zsh/vendor-completions/_fringetwin",
                 "fish/vendor_completions.d/fringetwin.fish", "fringetwin/datasets/povray-ball-wall/twin.toml",
                 "fringetwin/demo.sh", "doc/fringetwin/docs/FORMATS.md"):
        expect((prefix / "share" / file).is_file(), f"{file} is not installed")
    readme = (prefix / "share/doc/fringetwin/README.md").read_text(encoding="utf-8")
    for link in re.findall(r"\]\(([^):#]+)\)", readme):
        expect((prefix / "share/doc/fringetwin" / link).exists(), f"README.md links to {link}, which is not installed")
    expect(project_version(source) in run([prefix / "bin/fringetwin", "version"], bare()), "another version")
    for path in files_below(prefix):
        if not path.is_symlink():
            expect(not path.stat().st_mode & (stat.S_IWGRP | stat.S_IWOTH), f"{path} can be written by others")


def check_program(prefix):
    """The program finds its data and modules beside itself."""
    program = prefix / "bin/fringetwin"
    info = json.loads(run([program, "info", "--json"], bare()))
    expect(info["datasets_root"] == str(prefix / "share/fringetwin/datasets"), f"data sets at {info['datasets_root']}")
    for module in binaries(prefix)[1:]:
        ctypes.CDLL(str(module))  # every library and symbol of it is there
    # Windows are listed by a module: without it, and only then, the list says that it cannot be loaded.
    lists = [program, "capture", "--list"]
    expect("cannot be loaded" not in run(lists, bare()), "the module of windows is not found")
    (prefix / "lib/fringetwin").rename(prefix / "lib/away")
    without = run(lists, bare(), codes=(0, 2, 3, 4))
    (prefix / "lib/away").rename(prefix / "lib/fringetwin")
    expect("cannot be loaded" in without, f"modules come from elsewhere: {without}")


def need_device(program):
    devices = json.loads(run([program, "info", "--json"], bare()))["devices"]
    if not devices and not (os.environ.get("CI") or os.environ.get("FRINGETWIN_REQUIRE_DEVICE")):
        print("skipped: no Vulkan device for the example")
        sys.exit(77)


def check_cosim(prefix, scratch):
    before = files_below(prefix)
    twin = prefix / "share/fringetwin" / TWIN
    run([prefix / "bin/fringetwin", "cosim", twin, "--out", scratch / "out"], bare())
    verdicts = [row["state"] for row in json.loads((scratch / "out/result.json").read_text(encoding="utf-8"))["explained"]]
    expect(set(verdicts) == {"explained"}, f"the installed example is {verdicts}")
    expect((scratch / "out/report.html").is_file(), "no report")
    expect(files_below(prefix) == before, "the program wrote into its installation")


def check_install(build, source, scratch):
    first, second = scratch / "first", scratch / "second"
    run(["cmake", "--install", build, "--prefix", first])
    listed = (pathlib.Path(build) / "install_manifest.txt").read_text(encoding="utf-8").split("\n")
    left = sorted(set(map(str, files_below(first))) - set(listed))
    expect(not left, f"an uninstaller would leave {left}")
    first.rename(second)
    check_places(second, [str(build), str(source), str(first)])
    check_files(second, build, source)
    check_program(second)
    need_device(second / "bin/fringetwin")
    check_cosim(second, scratch)


def make_package(build, scratch):
    run(["cpack", "--config", build / "CPackConfig.cmake", "-G", "DEB", "-B", scratch])
    packages = list(scratch.glob("*.deb"))
    expect(len(packages) == 1, f"made {packages}")
    return packages[0]


def needed_packages(prefix):
    """Of each library that the program and its modules name, as this machine resolves it: the packages that own it."""
    files = {}
    for path in binaries(prefix):
        resolved = dict(re.findall(r"(\S+) => (/\S+)", run(["ldd", path])))
        for name in re.findall(r"NEEDED.*\[(.*)\]", run(["readelf", "-d", path])):
            if name in resolved:  # the loader itself is not
                files[name] = os.path.basename(os.path.realpath(resolved[name]))
    expect(len(files) > 20, f"only {sorted(files)} are needed")
    owners = {}
    for line in run(["dpkg", "-S", *(f"*/{file}" for file in sorted(set(files.values())))]).splitlines():
        package, _, place = line.partition(": ")
        owners.setdefault(os.path.basename(place), set()).add(package.split(":")[0])
    return {name: owners.get(file, set()) for name, file in files.items()}


def check_package(build, source, scratch):
    package = make_package(build, scratch)
    field = {name: run(["dpkg-deb", "-f", package, name]).strip() for name in ("Package", "Version", "Architecture", "Depends")}
    wanted = {"Package": "fringetwin", "Version": project_version(source),
              "Architecture": run(["dpkg", "--print-architecture"]).strip()}
    expect({name: field[name] for name in wanted} == wanted, f"fields {field}")
    run(["dpkg-deb", "-e", package, scratch / "control"])
    control = sorted(os.listdir(scratch / "control"))
    expect(control == ["control", "md5sums"], f"the package runs or sets something: {control}")
    unpacked = scratch / "unpacked"
    run(["dpkg-deb", "-x", package, unpacked])
    prefix = unpacked / "usr"
    depends = {word.split()[0] for group in field["Depends"].split(",") for word in group.split("|")}
    for library, owners in needed_packages(prefix).items():
        expect(owners & depends, f"{library} is of {owners}, which the package does not depend on")
    if list(prefix.rglob("_core*.so")):
        expect({"python3", "python3-numpy"} <= depends, f"the Python module needs more than {sorted(depends)}")
    check_places(prefix, [str(build), str(source), str(scratch)])
    check_files(prefix, build, source)
    check_program(prefix)
    for name in ("copyright", "changelog.gz"):
        expect((prefix / "share/doc/fringetwin" / name).is_file(), f"no {name}")


def check_library(build, source, scratch):
    first, second, own, twin = scratch / "first", scratch / "second", scratch / "own", source / TWIN
    run(["cmake", "--install", build, "--component", "development", "--prefix", first])
    first.rename(second)
    check_places(second, [str(build), str(source), str(first)])
    shutil.copytree(source / "tests/package/example", own)
    public = re.search(r"set\(headers (.*?)\)", (source / "cmake/development.cmake").read_text(encoding="utf-8"), re.DOTALL)[1]
    included = re.findall(r'#include "(.*)"', (own / "every_header.cpp").read_text(encoding="utf-8"))
    expect(sorted(public.split()) == included, "example/every_header.cpp includes other headers than cmake/development.cmake installs")
    run(["cmake", "-S", own, "-B", own / "build", f"-DCMAKE_PREFIX_PATH={second}", "-DCMAKE_BUILD_TYPE=Release"])
    run(["cmake", "--build", own / "build"])
    need_device(build / "fringetwin")
    printed = run([own / "build/example", twin], bare())
    run([build / "fringetwin", "cosim", twin, "--out", scratch / "out"], bare())
    fits = json.loads((scratch / "out/result.json").read_text(encoding="utf-8"))["fits"]
    radii = {fit["object"]: fit["simulated"]["radius_mm"] for fit in fits if "radius_mm" in fit["simulated"]}
    expect(radii, "no sphere was measured")
    own_radii = {line.split()[0]: float(line.split()[1]) for line in printed.splitlines()}
    expect(own_radii == radii, f"the example measures {own_radii}, the program {radii}")


def check_lintian(build, _source, scratch):
    if not shutil.which("lintian"):
        print("skipped: lintian is not installed")
        sys.exit(77)
    said = run(["lintian", "--allow-root", "--fail-on", "none", make_package(build, scratch)])
    expect(not re.search("^[EW]:", said, re.MULTILINE), said)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("check", choices=["install", "package", "lintian", "library"])
    parser.add_argument("--build", required=True)
    parser.add_argument("--source", required=True)
    chosen = parser.parse_args()
    check = {"install": check_install, "package": check_package, "lintian": check_lintian, "library": check_library}[chosen.check]
    with tempfile.TemporaryDirectory() as scratch:
        try:
            check(pathlib.Path(chosen.build).resolve(), pathlib.Path(chosen.source).resolve(), pathlib.Path(scratch))
        except Fault as fault:
            print(fault)
            sys.exit(1)
    print(f"{chosen.check}: as it should be")


main()
