#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What is installed works wherever it lies, names no place of the build, and the packages say what they need.

install_test.py CHECK --build build --source . --packages build/tests/package/made
  made      the Debian packages are made, for the two checks below and root_test.py: cpack takes long, and runs once
  install   cmake --install into a scratch folder, which is then moved: the program finds modules and data sets there, compares
            an installed example, and is all of it in the list that an uninstaller goes by
  package   the Debian packages, unpacked: fields, dependencies (against what the loader resolves here), files, each in one
            package only; the program and the Python module
  lintian   what lintian says of the packages: nothing
  library   the component "development", moved, too: a program of somebody else (example/) finds headers and libraries there
            by find_package and measures to the last bit what the program does; libfringetwin-dev depends on the packages
            that this takes, and on no others
  configure as the Containerfile configures it, without tests and benchmarks, everything is there that the packages are made of
  module    the Python module built from that component alone, with no sources, and a program's modules beside it
Exit code 77: lintian, pybind11 or a Vulkan device is missing.
"""
import argparse
import ctypes
import json
import os
import pathlib
import re
import shutil
import stat
import sys
import tempfile

from made_packages import Fault, TWIN, expect, field, make_packages, names_in, packages_in, project_version, run


def bare():
    """The environment of somebody who knows nothing of the build."""
    names = ("PATH", "HOME", "FRINGETWIN_CACHE", "VK_DRIVER_FILES", "VK_ICD_FILENAMES")
    return {name: os.environ[name] for name in names if name in os.environ}


def files_below(folder):
    return sorted(path for path in pathlib.Path(folder).rglob("*") if path.is_symlink() or not path.is_dir())


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


def needed_packages(files):
    """Of each library that programs and modules name, as this machine resolves it: the packages that own it."""
    libraries = {}
    for path in files:
        resolved = dict(re.findall(r"(\S+) => (/\S+)", run(["ldd", path])))
        for name in re.findall(r"NEEDED.*\[(.*)\]", run(["readelf", "-d", path])):
            if name in resolved:  # the loader itself is not
                libraries[name] = os.path.basename(os.path.realpath(resolved[name]))
    expect(len(libraries) > 20, f"only {sorted(libraries)} are needed")
    owners = {}
    for line in run(["dpkg", "-S", *(f"*/{file}" for file in sorted(set(libraries.values())))]).splitlines():
        package, _, place = line.partition(": ")
        owners.setdefault(os.path.basename(place), set()).add(package.split(":")[0])
    return {name: owners.get(file, set()) for name, file in libraries.items()}


def check_needs(files, depends):
    for library, owners in needed_packages(files).items():
        expect(owners & names_in(depends), f"{library} is of {owners}, which the package does not depend on")


def check_python_package(package, prefix, program, version):
    """The module says what it needs, and is imported from where it lies; prefix: of both packages, unpacked as one."""
    depends = field(package, "Depends")
    check_needs(prefix.glob("lib/python3/dist-packages/fringetwin/_core*.so"), depends)
    python = re.search(r"\d+\.(\d+)", run(["/usr/bin/python3", "--version"]))
    bounds = {f"fringetwin (= {version})", f"python3 (>= {python[0]})", f"python3 (<< 3.{int(python[1]) + 1})", "python3-numpy"}
    expect(bounds <= set(depends.split(", ")), f"the Python module needs {sorted(bounds)}, not {depends}")
    replaces, breaks = field(package, "Replaces"), field(package, "Breaks")
    expect((replaces, breaks) == ("fringetwin (<= 0.2.0)", ""), f"it replaces {replaces}, and breaks {breaks}")  # cmake/package.cmake says why
    printed = run(["/usr/bin/python3", "-B", "-c", "import fringetwin; print(fringetwin.version())"],
                  {**bare(), "PYTHONPATH": str(prefix / "lib/python3/dist-packages")})
    expect(printed == run([program, "version"], bare()), f"the module is {printed}")


def check_made(build, _source, _scratch, made):
    make_packages(build, made)


def check_package(build, source, scratch, made):
    packages = packages_in(build, made)
    version, architecture = project_version(source), run(["dpkg", "--print-architecture"]).strip()
    places = {}
    for name, package in packages.items():
        found = (field(package, "Version"), field(package, "Architecture"), field(package, "Source"))
        expect(found == (version, architecture, "" if name == "fringetwin" else "fringetwin"), f"{name} is {found}")
        run(["dpkg-deb", "-e", package, scratch / f"{name}.control"])
        control = set(os.listdir(scratch / f"{name}.control")) - {"control", "md5sums"}
        expect(control == ({"postinst", "prerm"} if name == "python3-fringetwin" else set()), f"{name} runs or sets something: {control}")
        unpacked = scratch / "unpacked" / name
        unpacked.mkdir(parents=True)
        run(["dpkg-deb", "-x", package, unpacked])
        check_places(unpacked / "usr", [str(build), str(source), str(made)])
        for file in files_below(unpacked):
            place = str(file.relative_to(unpacked))
            expect(place not in places, f"/{place} is in {name} and {places.get(place)}")
            places[place] = name
        for file in ("copyright", "changelog.gz"):
            expect((unpacked / "usr/share/doc" / name / file).is_file(), f"{name} has no {file}")
    prefix = scratch / "unpacked/fringetwin/usr"
    check_needs(binaries(prefix), field(packages["fringetwin"], "Depends"))
    expect({"libvulkan1", "mesa-vulkan-drivers", "gnuplot-nox"} <= names_in(field(packages["fringetwin"], "Depends")),
           "what is loaded or started by name is not in Depends")
    check_files(prefix, build, source)
    check_program(prefix)
    if "python3-fringetwin" in packages:
        together = scratch / "together"
        for name in ("fringetwin", "python3-fringetwin"):
            run(["dpkg-deb", "-x", packages[name], together])
        check_python_package(packages["python3-fringetwin"], together / "usr", prefix / "bin/fringetwin", version)


def owners_of(files):
    """The packages of this machine that own files, each named as a compiler or CMake has named it."""
    known = {}
    for listed in pathlib.Path("/var/lib/dpkg/info").glob("*.list"):
        for path in listed.read_text(encoding="utf-8").split("\n"):
            known.setdefault(path, set()).add(listed.stem.split(":")[0])
    files = {os.path.normpath(file) for file in files if not os.path.isdir(file)}
    return {owner for file in files for owner in known.get(file) or known.get(file.removeprefix("/usr"), ())}


def files_of_build(folder):
    """What a build by Make read: files of CMake, headers and libraries."""
    read = re.findall(r'"(/usr/.*)"', (folder / "CMakeFiles/Makefile.cmake").read_text(encoding="utf-8"))
    for depfile in folder.rglob("*.d"):
        read += re.findall(r"(/usr/\S+)", depfile.read_text(encoding="utf-8"))
    for command in folder.rglob("link.txt"):
        read += re.findall(r"(/usr/\S+\.(?:so|a))\b", command.read_text(encoding="utf-8"))
    return read


def cached(folder, pattern):
    """What the cache of a build tree holds under names like this."""
    return re.findall(rf"^(?:{pattern}):\w+=(.*)$", (folder / "CMakeCache.txt").read_text(encoding="utf-8"), re.MULTILINE)


def packages_of_compiler(folder):
    """The packages of the compiler of a build tree, g++ or another, and of its OpenMP: both are the choice of who builds."""
    files = [os.path.realpath(path) for path in cached(folder, "CMAKE_CXX_COMPILER")]
    return owners_of([*files, *cached(folder, r"OpenMP_\w+_LIBRARY")])


def check_development_depends(build, example):
    """Who has what libfringetwin-dev depends on, and a compiler, has all that a build reads, and nothing besides."""
    config = (build / "CPackConfig.cmake").read_text(encoding="utf-8")
    depends = names_in(re.search(r'CPACK_DEBIAN_DEVELOPMENT_PACKAGE_DEPENDS "(.*)"', config)[1])
    options = ["--no-recommends", "--no-suggests", "--no-conflicts", "--no-breaks", "--no-replaces", "--no-enhances"]

    def brought(names, *more):
        lines = run(["apt-cache", "depends", *options, *more, *sorted(names)]).splitlines()
        return {re.sub(r"^[ |]*(?:\w+: )?", "", line).strip("<>") for line in lines}
    used = owners_of(files_of_build(example))
    expect(len(used) > 20, f"the build used {used}")
    missing = used - brought({*depends, "g++", "cmake", "make", *packages_of_compiler(example)}, "--recurse")
    expect(not missing, f"a program built with the libraries uses {sorted(missing)}, which libfringetwin-dev does not depend on")
    # what find_library and the like have found must be there, whatever a program takes of it
    used |= owners_of(re.findall(r"=(/usr/.*)", (example / "CMakeCache.txt").read_text(encoding="utf-8")))

    def is_used(name):
        empty = not [path for path in run(["dpkg", "-L", name]).splitlines()[1:] if not re.match("/usr(/share(/(doc|lintian)|$)|$)", path)]
        return bool((brought({name}) if empty else {name}) & used)  # libboost-dev stands for libboost1.74-dev
    idle = sorted(name for name in depends if not is_used(name))
    expect(not idle, f"libfringetwin-dev depends on {idle}, which no build uses")


def install_moved(build, source, scratch, *components):
    first, second = scratch / "first", scratch / "second"
    for component in components:
        run(["cmake", "--install", build, "--component", component, "--prefix", first])
    first.rename(second)
    check_places(second, [str(build), str(source), str(first)])
    return second


def check_library(build, source, scratch):
    own, twin = scratch / "own", source / TWIN
    prefix = install_moved(build, source, scratch, "development")
    shutil.copytree(source / "tests/package/example", own)
    public = re.search(r"set\(headers (.*?)\)", (source / "cmake/development.cmake").read_text(encoding="utf-8"), re.DOTALL)[1]
    included = re.findall(r'#include "(.*)"', (own / "every_header.cpp").read_text(encoding="utf-8"))
    expect(sorted(public.split()) == included, "example/every_header.cpp includes other headers than cmake/development.cmake installs")
    run(["cmake", "-G", "Unix Makefiles", "-S", own, "-B", own / "build", f"-DCMAKE_PREFIX_PATH={prefix}", "-DCMAKE_BUILD_TYPE=Release",
         f"-DCMAKE_CXX_COMPILER={cached(build, 'CMAKE_CXX_COMPILER')[0]}"])  # that of the libraries, whatever CXX says
    run(["cmake", "--build", own / "build"])
    check_development_depends(build, own / "build")
    need_device(build / "fringetwin")
    printed = run([own / "build/example", twin], bare())
    run([build / "fringetwin", "cosim", twin, "--out", scratch / "out"], bare())
    fits = json.loads((scratch / "out/result.json").read_text(encoding="utf-8"))["fits"]
    radii = {fit["object"]: fit["simulated"]["radius_mm"] for fit in fits if "radius_mm" in fit["simulated"]}
    expect(radii, "no sphere was measured")
    own_radii = {line.split()[0]: float(line.split()[1]) for line in printed.splitlines()}
    expect(own_radii == radii, f"the example measures {own_radii}, the program {radii}")


def check_module(build, source, scratch):
    if not (build / "python/fringetwin").is_dir():
        print("skipped: no Python module without pybind11-dev and python3-dev")
        sys.exit(77)
    prefix, made = install_moved(build, source, scratch, "development", "program"), scratch / "made"
    run(["cmake", "-S", prefix / "share/fringetwin/python", "-B", made])
    run(["cmake", "--build", made])
    own = scratch / "own"
    run(["cmake", "--install", made, "--prefix", own])
    check_places(own, [str(build), str(source)])
    folder = own / "lib/python3/dist-packages"
    environment = {**bare(), "PYTHONPATH": str(folder)}
    printed = run(["/usr/bin/python3", "-B", "-c", "import fringetwin; print(fringetwin.__file__, fringetwin.version())"], environment)
    expect(printed == f"{folder}/fringetwin/__init__.py {run([prefix / 'bin/fringetwin', 'version'], bare())}", f"it is {printed}")
    expect((folder / "fringetwin/libfringetwin_image_codecs.so").is_file(), "the program's module for TIFF is not beside the Python module")
    need_device(prefix / "bin/fringetwin")
    example = own / "share/doc/python3-fringetwin/examples/gain.py"
    printed = run(["/usr/bin/python3", "-B", example, source / TWIN, scratch / "out"], environment)
    verdicts = re.findall(r"^\w+ .*: (.*explained.*)", printed, re.MULTILINE)
    expect(verdicts and set(verdicts) == {"explained"}, f"the example says {verdicts}")


def check_configure(_build, source, scratch):
    build_line = "cmake --preset release (.*) && cmake --build build --target packaged"
    options = re.search(build_line, (source / "Containerfile").read_text(encoding="utf-8"))
    expect(options, "the Containerfile builds otherwise than this test")
    run(["cmake", "--preset", "release", "-B", scratch / "build", *options[1].split()], folder=source)
    steps = run(["cmake", "--build", scratch / "build", "--target", "packaged", "--", "-n"])
    expect("Linking CXX executable fringetwin" in steps and "_tests" not in steps, f"it would build {steps}")


def check_lintian(build, _source, _scratch, made):
    if not shutil.which("lintian"):
        print("skipped: lintian is not installed")
        sys.exit(77)
    said = run(["lintian", "--allow-root", "--fail-on", "none", *packages_in(build, made).values()])
    expect(not re.search("^[EW]:", said, re.MULTILINE), said)


CHECKS = {"configure": check_configure, "install": check_install, "library": check_library, "module": check_module}
OF_PACKAGES = {"made": check_made, "package": check_package, "lintian": check_lintian}


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("check", choices=sorted([*CHECKS, *OF_PACKAGES]))
    parser.add_argument("--build", required=True)
    parser.add_argument("--source", required=True)
    parser.add_argument("--packages", type=pathlib.Path, help="folder of the packages, which `made` fills")
    chosen = parser.parse_args()
    with tempfile.TemporaryDirectory() as scratch:
        try:
            places = pathlib.Path(chosen.build).resolve(), pathlib.Path(chosen.source).resolve(), pathlib.Path(scratch)
            if chosen.check in CHECKS:
                CHECKS[chosen.check](*places)
            else:
                OF_PACKAGES[chosen.check](*places, chosen.packages.resolve())
        except Fault as fault:
            print(fault)
            sys.exit(1)
    print(f"{chosen.check}: as it should be")


main()
