"""Build the archives of a release, and try them where nothing else is: ``make packages``.

A source archive is made of the working tree; a wheel is made of that archive for the oldest and the newest Python that
the metadata names, as far as they are here, and installed into an empty environment: with the oldest libraries that the
metadata allows, and with the newest there are. The program does what ``make demo`` does there, without a home folder,
and may change nothing of its installation. Last the archive's own tests are run on the wheel.

PYTHONS="3.12" in the environment names other versions of Python to try.
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import tarfile
import tomllib
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

ROOT = Path(__file__).parent.parent
# Who is root may write everywhere, but for these words.
NO_PRIVILEGES = ["setpriv", "--bounding-set=-all", "--inh-caps=-all"]
RUN = """\
pddecont --version
pddecont run fig4_6 -o fig4_6.h5
pddecont export fig4_6.h5 --table special
pddecont plot fig4_6.h5 -o fig4_6.png
pddecont plot fig4_6.h5 -o fig4_6.svg
pddecont report fig4_6.h5 -o fig4_6.html"""
WRITTEN = {"fig4_6.h5", "fig4_6.png", "fig4_6.svg", "fig4_6.html"}
# Of the archive itself, of the interface in Python and of the command line.
TESTS = ("tests/test_packages.py", "tests/api", "tests/cli/test_new.py", "tests/cli/test_check.py")
LIBRARIES = ("pytest", "hypothesis", "xarray")


def main(folder: Path) -> None:
    """Do all that this module's docstring says, in a folder that is emptied first."""
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    archive = build_archive(folder)
    source = unpack(archive, folder / "source")
    pythons = find_pythons(choose_versions(project))
    oldest, newest = next(iter(pythons)), list(pythons)[-1]
    with ThreadPoolExecutor() as pool:
        wheels = dict(
            zip(pythons, pool.map(lambda v: build_wheel(pythons[v], archive, folder / v), pythons), strict=True)
        )
        call(sys.executable, "-m", "twine", "check", "--strict", archive, *wheels.values())
        floors = {oldest: oldest_libraries(project["dependencies"], folder / "oldest.txt")}
        if newest != oldest:
            floors[newest] = []
        list(pool.map(lambda v: install_and_try(v, pythons[v], wheels[v], floors.get(v, []), folder / v), pythons))
    run_tests(source, folder / newest)
    print(f"packages: {archive.name}, {', '.join(wheel.name for wheel in wheels.values())}: built, checked, tried")


def build_archive(folder: Path) -> Path:
    """Return the source archive of the working tree."""
    call(sys.executable, "-m", "build", "--sdist", "--outdir", folder, ROOT)
    (archive,) = folder.glob("*.tar.gz")
    return archive


def unpack(archive: Path, folder: Path) -> Path:
    """Return the folder that a source archive holds, unpacked in ``folder``, without the package's own code.

    So that its tests can find no package but the one that is installed.
    """
    with tarfile.open(archive) as file:
        file.extractall(folder, filter="data")
    (source,) = folder.iterdir()
    shutil.rmtree(source / "pddecont")
    return source


def choose_versions(project: dict) -> list[str]:
    """Return the oldest and the newest version of Python that the metadata names, or those that PYTHONS does."""
    if "PYTHONS" in os.environ:
        return os.environ["PYTHONS"].split()
    named = re.findall(r"Python :: (3\.\d+)$", "\n".join(project["classifiers"]), re.M)
    return list(dict.fromkeys((named[0], named[-1])))


def find_pythons(versions: list[str]) -> dict[str, str]:
    """Return an interpreter of each version that is there, on the path or among those of pyenv; say which are not.

    The program ends where none of them is.
    """
    found = {version: python for version in versions if (python := find_python(version))}
    for version in versions:
        if version not in found:
            print(f"Python {version} is not here: NOT TRIED (PYTHONS='3.12 3.13' in the environment names others)")
    return found or sys.exit("no Python to try was found")


def find_python(version: str) -> str | None:
    """Return an interpreter of a version that can make environments, None where there is none."""
    pyenv = Path(os.environ.get("PYENV_ROOT", Path.home() / ".pyenv")) / "versions"
    known = [shutil.which(f"python{version}"), *sorted(pyenv.glob(f"{version}.*/bin/python{version}"))]
    return next((path for path in map(str, filter(None, known)) if succeeds(path, "-c", "import venv")), None)


def choose_privileges() -> list[str]:
    """Return what goes before commands so that they may not write where files say so, as far as that can be had."""
    wanted = os.getuid() == 0 and shutil.which(NO_PRIVILEGES[0]) and succeeds(*NO_PRIVILEGES, "true")
    return NO_PRIVILEGES if wanted else []


def succeeds(*words: str) -> bool:
    """Return whether a command can be run."""
    return subprocess.run(words, capture_output=True).returncode == 0


def build_wheel(python: str, archive: Path, folder: Path) -> Path:
    """Return the wheel of a source archive for a Python; ``folder/env`` becomes an environment without libraries."""
    call(python, "-m", "venv", folder / "env")
    call(folder / "env/bin/python", "-m", "pip", "wheel", "--quiet", "--no-deps", "-w", folder, archive)
    (wheel,) = folder.glob("*.whl")
    return wheel


def oldest_libraries(dependencies: list[str], file: Path) -> list[str]:
    """Return pip's option that holds every library at the oldest version that is allowed, written to a file."""
    limits = [re.fullmatch(r"([\w-]+)>=([\d.]+)", text).groups() for text in dependencies]
    file.write_text("".join(f"{name}=={version}.*\n" for name, version in limits))
    return ["--constraint", str(file)]


def install_and_try(version: str, python: str, wheel: Path, options: list[str], folder: Path) -> None:
    """Install a wheel into its empty environment, and run the demo, a picture and a report with nothing else."""
    program = folder / "env/bin/python"
    call(program, "-m", "pip", "install", "--quiet", *options, wheel)
    call(program, "-m", "pip", "check")
    place = folder / "elsewhere"
    place.mkdir()
    call("chmod", "-R", "a-w", folder / "env")
    before = list_files(folder / "env")
    privileges = choose_privileges()
    environment = {"PATH": f"{folder / 'env/bin'}:/usr/bin:/bin"}
    for line in RUN.splitlines():
        done = subprocess.run([*privileges, *line.split()], cwd=place, env=environment, capture_output=True, text=True)
        print(f"{version}$ {line}\n{done.stdout}{done.stderr}", end="")
        if done.returncode:
            sys.exit(f"Python {version}: {line}: exit code {done.returncode}")
    written = {path.name for path in place.iterdir()}
    if written != WRITTEN:
        sys.exit(f"Python {version}: written were {sorted(written)}, not {sorted(WRITTEN)}")
    if list_files(folder / "env") != before:
        sys.exit(f"Python {version}: the installation has changed")
    call("chmod", "-R", "u+w", folder / "env")


def list_files(folder: Path) -> set[tuple[str, int]]:
    """Return every file under a folder with its time of change."""
    return {(str(path), path.stat().st_mtime_ns) for path in folder.rglob("*") if path.is_file()}


def run_tests(source: Path, folder: Path) -> None:
    """Run the tests of an unpacked source archive on the wheel that is installed in an environment."""
    program = folder / "env/bin/python"
    call(program, "-m", "pip", "install", "--quiet", *LIBRARIES)
    call(program, "-m", "pytest", "-m", "not slow", *TESTS, cwd=source)


def call(*words: object, **options: object) -> None:
    """Run a command, or end the program."""
    command = [str(word) for word in words]
    print("$", " ".join(command), flush=True)
    if subprocess.run(command, **options).returncode:
        sys.exit(f"failed: {' '.join(command)}")


if __name__ == "__main__":
    main(Path(sys.argv[1]).resolve())
