# Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
"""Makes the environment of the ROS 2 peers, or what is missing or out of date of it: a virtual environment with a real ROS 2 distribution
from the Python package index, the interface packages that have no wheel (camwright_msgs and some standard ones), built by the real rosidl,
and, for Jazzy, two folders of packages that only some peers see.

    make_env.py [--distribution jazzy|kilted] ROOT

The packages of a distribution are pinned in `<distribution>_requirements.txt`. Interface files in `<distribution>_interfaces/` replace those
of msgs/standard, which are Jazzy's.

A lock in ROOT keeps others waiting meanwhile. Run with any Python 3.11; only the standard library is needed here.
"""

import argparse
import fcntl
import hashlib
import os
import re
import shutil
import subprocess
import sys
import sysconfig
from pathlib import Path

KINDS = ("msg", "srv", "action")
DISTRIBUTIONS = ("jazzy", "kilted")
SUPPORT = Path(__file__).resolve().parent
MSGS = SUPPORT.parents[1] / "msgs"
# Line of CMake before which all generators are known. C++ types, which take as long as all others, are of no use to Python.
GENERATE = "rosidl_generate_interfaces("
WITHOUT_CPP = 'list(FILTER AMENT_EXTENSIONS_rosidl_generate_idl_interfaces EXCLUDE REGEX "_cpp:")\n'
# Where the machine that built the wheels had its Python; these paths are left over in the CMake files of the wheels.
WHEEL_INCLUDE = "/opt/python/cp311-cp311/include/python3.11"
WHEEL_NUMPY = "/opt/python/cp311-cp311/lib/python3.11/site-packages/numpy/_core/include"


def run(command, **kwargs):
    """Runs a command quietly; shows what it said only if it fails."""
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, **kwargs)
    if done.returncode != 0:
        sys.stderr.write(done.stdout)
        raise SystemExit(f"{' '.join(str(word) for word in command)}: exit code {done.returncode}")


def site_packages(venv):
    return venv / "lib" / "python3.11" / "site-packages"


def install(python, requirements, *options):
    # Python compiles what it imports; of all packages that takes as long as the installation.
    run([str(python), "-m", "pip", "install", "--quiet", "--disable-pip-version-check", "--no-deps", "--no-compile", *options, "-r", str(requirements)])


def make_venv(root, requirements):
    venv = root / "venv"
    shutil.rmtree(venv, ignore_errors=True)
    run([sys.executable, "-m", "venv", str(venv)])
    install(venv / "bin/python", requirements)
    include = sysconfig.get_path("include")
    if not Path(include, "Python.h").is_file():
        raise SystemExit(f"{include}/Python.h is missing: install the development files of Python 3.11 (python3-dev)")
    numpy = site_packages(venv) / "numpy/_core/include"
    for file in (venv / "share").rglob("*.cmake"):
        text = file.read_text(encoding="utf-8")
        fixed = text.replace(WHEEL_NUMPY, str(numpy)).replace(WHEEL_INCLUDE, include)
        if fixed != text:
            file.write_text(fixed, encoding="utf-8")


def interface_files(package):
    return sorted(f for kind in KINDS for f in (package / kind).glob(f"*.{kind}"))


def dependencies(package, name):
    """Packages whose types the interface files name, in the order of the alphabet."""
    found = set()
    for file in interface_files(package):
        for line in file.read_text(encoding="utf-8").splitlines():
            match = re.match(r"\s*([a-z][a-z0-9_]*)/[A-Z]\w*", line.split("#")[0])
            if match:
                found.add(match.group(1))
        if file.suffix == ".action":
            found.add("action_msgs")
    return sorted(found - {name})


def copy_standard_package(package, replaced, out):
    """A standard package has only its fields in msgs/standard; rosidl wants a whole ROS package around them. Files of `replaced`, where it
    exists, take the place of those of the same name."""
    name = package.name
    for source in (package, replaced):
        for kind in KINDS:
            if (source / kind).is_dir():
                shutil.copytree(source / kind, out / kind, dirs_exist_ok=True)
    needs = dependencies(out, name)
    files = "\n".join(f'  "{f.relative_to(out)}"' for f in interface_files(out))
    find = "\n".join(f"find_package({need} REQUIRED)" for need in needs)
    (out / "CMakeLists.txt").write_text(
        f"cmake_minimum_required(VERSION 3.8)\nproject({name})\nfind_package(ament_cmake REQUIRED)\n"
        f"find_package(rosidl_default_generators REQUIRED)\n{find}\n"
        f"rosidl_generate_interfaces(${{PROJECT_NAME}}\n{files}\n  DEPENDENCIES {' '.join(needs)})\n"
        "ament_export_dependencies(rosidl_default_runtime)\nament_package()\n", encoding="utf-8")
    depends = "".join(f"  <depend>{need}</depend>\n" for need in needs)
    (out / "package.xml").write_text(
        f'<?xml version="1.0"?>\n<package format="3">\n  <name>{name}</name>\n  <version>0.0.0</version>\n'
        "  <description>standard interfaces for the test peers</description>\n"
        '  <maintainer email="nobody@example.org">nobody</maintainer>\n  <license>Apache-2.0</license>\n'
        "  <buildtool_depend>ament_cmake</buildtool_depend>\n"
        "  <buildtool_depend>rosidl_default_generators</buildtool_depend>\n" + depends +
        "  <exec_depend>rosidl_default_runtime</exec_depend>\n"
        "  <member_of_group>rosidl_interface_packages</member_of_group>\n"
        "  <export><build_type>ament_cmake</build_type></export>\n</package>\n", encoding="utf-8")


def leave_out_cpp(package):
    file = package / "CMakeLists.txt"
    before, generate, after = file.read_text(encoding="utf-8").partition(GENERATE)
    if not generate:
        raise SystemExit(f"{file} has no {GENERATE}…)")
    file.write_text(f"{before}{WITHOUT_CPP}{generate}{after}", encoding="utf-8")


def in_build_order(packages):
    """Packages so that each stands behind those it needs."""
    ordered = []
    left = {path.name: (path, set(needs) & {p.name for p, _ in packages}) for path, needs in packages}
    while left:
        ready = sorted(name for name, (_, needs) in left.items() if needs <= {p.name for p in ordered})
        if not ready:
            raise SystemExit(f"interface packages need each other in a circle: {', '.join(sorted(left))}")
        ordered.extend(left.pop(name)[0] for name in ready)
    return ordered


def make_interfaces(root, interfaces):
    venv, out = root / "venv", root / "interfaces"
    shutil.rmtree(out, ignore_errors=True)
    source, install, parsed = out / "src", out / "install", out / "parsed"
    packages = []
    for package in sorted((MSGS / "standard").iterdir()):
        if interface_files(package) and not (venv / "share" / package.name / "package.xml").is_file():
            copy = source / package.name
            copy.mkdir(parents=True)
            copy_standard_package(package, interfaces / package.name, copy)
            packages.append((copy, dependencies(copy, package.name)))
    own = source / "camwright_msgs"
    own.mkdir(parents=True)
    for part in ("CMakeLists.txt", "package.xml"):
        shutil.copy(MSGS / part, own / part)
    for kind in KINDS:
        shutil.copytree(MSGS / kind, own / kind)
    packages.append((own, dependencies(own, own.name)))

    libraries = [str(install / "lib"), str(venv / "lib"), *map(str, sorted(site_packages(venv).glob("ros_*.libs")))]
    prefixes = os.pathsep.join([str(install), str(venv)])
    environment = dict(
        os.environ,
        PATH=os.pathsep.join([str(venv / "bin"), os.environ.get("PATH", "")]),
        AMENT_PREFIX_PATH=prefixes,
        CMAKE_PREFIX_PATH=prefixes,
        LD_LIBRARY_PATH=os.pathsep.join(libraries),
        PYTHONPATH=os.pathsep.join([str(SUPPORT / "rosidl_cache"), str(install / "lib/python3.11/site-packages")]),
        ROSIDL_CACHE=str(parsed),
        _ROS_WHEELS_BOOTSTRAP_COMPLETE="1",
    )
    python = venv / "bin/python"
    parsed.mkdir(parents=True)
    for package in in_build_order(packages):
        leave_out_cpp(package)
        build = out / "build" / package.name
        run([str(venv / "bin/cmake"), "-S", str(package), "-B", str(build), "-G", "Ninja",
             f"-DCMAKE_INSTALL_PREFIX={install}", f"-DPython3_EXECUTABLE={python}", f"-DPYTHON_EXECUTABLE={python}",
             "-DBUILD_TESTING=OFF", f"-DCMAKE_PROJECT_INCLUDE={SUPPORT / 'faster_build.cmake'}", "-Wno-dev"], env=environment)
        run([str(venv / "bin/cmake"), "--build", str(build), "--target", "install"], env=environment)
    shutil.rmtree(out / "build")
    shutil.rmtree(parsed)


def make_folder(root, name, requirements):
    install(root / "venv/bin/python", requirements, "--upgrade", "--target", str(root / name))


def hash_of(first, files):
    """Hash of the files and of what they belong to."""
    digest = hashlib.sha256(first.encode())
    for file in files:
        content = file.read_bytes()
        digest.update(f"{file} {len(content)} ".encode())
        digest.update(content)
    return digest.hexdigest()


def steps(root, distribution):
    """Name, hash of the sources and function of each step, in order."""
    requirements, cyclone, tables = (SUPPORT / f"{name}_requirements.txt" for name in (distribution, "cyclone", "tables"))
    interfaces = SUPPORT / f"{distribution}_interfaces"
    # A virtual environment cannot be moved, so its place is part of what it is made from.
    venv = hash_of(str(root), [Path(__file__).resolve(), requirements])
    sources = [SUPPORT / "faster_build.cmake", SUPPORT / "rosidl_cache/sitecustomize.py", MSGS / "package.xml", MSGS / "CMakeLists.txt"]
    folders = [*(MSGS / kind for kind in (*KINDS, "standard")), interfaces]
    sources += sorted(file for folder in folders for file in folder.rglob("*") if file.is_file())
    common = [
        ("venv", venv, lambda: make_venv(root, requirements)),
        ("interfaces", hash_of(venv, sources), lambda: make_interfaces(root, interfaces)),
    ]
    # Cyclone DDS and the readers of tables are no part of a distribution.
    of_jazzy = [
        ("cyclone", hash_of(venv, [cyclone]), lambda: make_folder(root, "cyclone", cyclone)),
        ("tables", hash_of(venv, [tables]), lambda: make_folder(root, "tables", tables)),
    ]
    return common + (of_jazzy if distribution == "jazzy" else [])


def main():
    if sys.version_info[:2] != (3, 11):
        raise SystemExit(f"Python 3.11 is needed (the wheels are built for it), this is {sys.version.split()[0]}")
    parser = argparse.ArgumentParser(description="Makes the environment of the ROS 2 peers of the tests.")
    parser.add_argument("--distribution", choices=DISTRIBUTIONS, default="jazzy")
    parser.add_argument("root", type=Path)
    arguments = parser.parse_args()
    root = arguments.root.resolve()
    root.mkdir(parents=True, exist_ok=True)

    def missing():
        stamped = [(root / f"{step}.stamp", made_from, make) for step, made_from, make in steps(root, arguments.distribution)]
        return [(stamp, made_from, make) for stamp, made_from, make in stamped
                if not stamp.is_file() or stamp.read_text(encoding="utf-8") != made_from]

    if not missing():
        return
    with open(root / "lock", "w", encoding="utf-8") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        # Another process may have made it while this one waited.
        for stamp, made_from, make in missing():
            # Half a step has no stamp.
            stamp.unlink(missing_ok=True)
            make()
            stamp.write_text(made_from, encoding="utf-8")


main()
