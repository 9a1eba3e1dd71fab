"""Makes the environment of the ROS 2 peers: a virtual environment with real ROS 2 Jazzy from the Python package index, and the
interface packages that have no wheel (camwright_msgs and some standard ones), built by the real rosidl.

    make_env.py venv       ROOT REQUIREMENTS
    make_env.py interfaces ROOT MSGS

ROOT/venv and ROOT/interfaces are made from nothing; the caller (tests/support/env.rs) holds the lock and writes the stamps.
Run with any Python 3.11; only the standard library is needed here.
"""

import os
import re
import shutil
import subprocess
import sys
import sysconfig
from pathlib import Path

KINDS = ("msg", "srv", "action")
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


def make_venv(root, requirements):
    venv = root / "venv"
    shutil.rmtree(venv, ignore_errors=True)
    run([sys.executable, "-m", "venv", str(venv)])
    run([str(venv / "bin/python"), "-m", "pip", "install", "--quiet", "--disable-pip-version-check", "--no-deps", "-r", str(requirements)])
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


def copy_standard_package(package, out):
    """A standard package has only its fields in msgs/standard; rosidl wants a whole ROS package around them."""
    name = package.name
    needs = dependencies(package, name)
    for kind in KINDS:
        if (package / kind).is_dir():
            shutil.copytree(package / kind, out / kind)
    files = "\n".join(f'  "{f.relative_to(package)}"' for f in interface_files(package))
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


def make_interfaces(root, msgs):
    venv, out = root / "venv", root / "interfaces"
    shutil.rmtree(out, ignore_errors=True)
    source, install = out / "src", out / "install"
    packages = []
    standard = msgs / "standard"
    for package in sorted(standard.iterdir()) if standard.is_dir() else []:
        if interface_files(package) and not (venv / "share" / package.name / "package.xml").is_file():
            copy = source / package.name
            copy.mkdir(parents=True)
            copy_standard_package(package, copy)
            packages.append((copy, dependencies(package, package.name)))
    own = source / "camwright_msgs"
    own.mkdir(parents=True)
    for part in ("CMakeLists.txt", "package.xml"):
        shutil.copy(msgs / part, own / part)
    for kind in KINDS:
        shutil.copytree(msgs / kind, own / kind)
    packages.append((own, dependencies(own, own.name)))

    libraries = [str(install / "lib"), str(venv / "lib"), *map(str, sorted(site_packages(venv).glob("ros_*.libs")))]
    prefixes = os.pathsep.join([str(install), str(venv)])
    environment = dict(
        os.environ,
        PATH=os.pathsep.join([str(venv / "bin"), os.environ.get("PATH", "")]),
        AMENT_PREFIX_PATH=prefixes,
        CMAKE_PREFIX_PATH=prefixes,
        LD_LIBRARY_PATH=os.pathsep.join(libraries),
        PYTHONPATH=str(install / "lib/python3.11/site-packages"),
        _ROS_WHEELS_BOOTSTRAP_COMPLETE="1",
    )
    python = venv / "bin/python"
    for package in in_build_order(packages):
        build = out / "build" / package.name
        run([str(venv / "bin/cmake"), "-S", str(package), "-B", str(build), "-G", "Ninja",
             f"-DCMAKE_INSTALL_PREFIX={install}", f"-DPython3_EXECUTABLE={python}", f"-DPYTHON_EXECUTABLE={python}",
             "-DBUILD_TESTING=OFF", f"-DCMAKE_PROJECT_INCLUDE={Path(__file__).resolve().parent / 'faster_build.cmake'}", "-Wno-dev"], env=environment)
        run([str(venv / "bin/cmake"), "--build", str(build), "--target", "install"], env=environment)
    shutil.rmtree(out / "build")


def main():
    if sys.version_info[:2] != (3, 11):
        raise SystemExit(f"Python 3.11 is needed (the wheels are built for it), this is {sys.version.split()[0]}")
    what, root, source = sys.argv[1], Path(sys.argv[2]).resolve(), Path(sys.argv[3]).resolve()
    root.mkdir(parents=True, exist_ok=True)
    if what == "venv":
        make_venv(root, source)
    elif what == "interfaces":
        make_interfaces(root, source)
    else:
        raise SystemExit(f"unknown step {what}")


main()
