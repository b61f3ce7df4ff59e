# SPDX-License-Identifier: Apache-2.0
"""What the tests of packages share: running programs, and making the packages of a build tree."""
import pathlib
import re
import shutil
import subprocess

TWIN = "datasets/povray-ball-wall/twin.toml"  # with its images, and quick
NAMES = {"program": "fringetwin", "development": "libfringetwin-dev", "python": "python3-fringetwin"}  # by components


class Fault(Exception):
    pass


def expect(condition, sentence):
    if not condition:
        raise Fault(sentence)


def run(command, environment=None, codes=(0,), folder="/", seconds=240):
    """Returns what a command printed; a Fault where it ends with another exit code than one of these."""
    try:
        done = subprocess.run([str(word) for word in command], capture_output=True, text=True, timeout=seconds, check=False, cwd=folder,
                              env=environment)
    except subprocess.TimeoutExpired:
        raise Fault(f"{command}: not done after {seconds} s") from None
    expect(done.returncode in codes, f"{command}: exit code {done.returncode}\n{done.stdout}{done.stderr}")
    return done.stdout


def project_version(source):
    text = pathlib.Path(source, "CMakeLists.txt").read_text(encoding="utf-8")
    return re.search(r"project\(fringetwin VERSION ([\d.]+)", text)[1]


def field(package, name):
    """Returns a field of a package's description; empty where it has none."""
    return run(["dpkg-deb", "-f", package, name]).strip()


def names_in(dependencies):
    """Returns the packages that a field like Depends names, each alternative of a choice as one of its own."""
    return {word.split()[0] for group in dependencies.split(",") for word in group.split("|") if word.strip()}


def make_packages(build, folder):
    """Makes the packages of a build tree in a folder, which is emptied before."""
    shutil.rmtree(folder, ignore_errors=True)
    run(["cpack", "--config", build / "CPackConfig.cmake", "-G", "DEB", "-B", folder], seconds=900)  # 30 s on an idle machine
    shutil.rmtree(folder / "_CPack_Packages")  # what they were made of, unpacked
    packages_in(build, folder)


def packages_in(build, folder):
    """Returns the files of a build tree's packages, which are in that folder, by the names of the packages."""
    packages = {field(file, "Package"): file for file in folder.glob("*.deb")}
    components = re.search('CPACK_COMPONENTS_ALL "(.*)"', (build / "CPackConfig.cmake").read_text(encoding="utf-8"))[1].split(";")
    wanted = {NAMES[component] for component in components}
    expect(set(packages) == wanted, f"made {sorted(packages)}, not {sorted(wanted)}")
    return packages
