#!/usr/bin/env python3
# Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
"""Builds the release tarball and the .deb of camwright.

    nodes/camwright/packaging/build.py              # builds the binaries, writes to target/package
    nodes/camwright/packaging/build.py --binaries target/debug --out /tmp/package

Both packages hold the same tree below their prefix: binaries, params, displays, completions, man pages and licences.
"""

import argparse
import gzip
import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

REPOSITORY = Path(__file__).resolve().parents[3]
PACKAGE = "camwright_nodes"
BINARIES = ["camwright", "job_planner", "axis_interpolator", "machine_sim", "machine_hal", "run_logger"]
# Folder of completions below `share`, and name of the file.
COMPLETIONS = {
    "bash": "bash-completion/completions/camwright",
    "zsh": "zsh/vendor-completions/_camwright",
    "fish": "fish/vendor_completions.d/camwright.fish",
}
LICENCE_FILE = re.compile(r"(licen[cs]e|copying|notice|unlicense|copyright)", re.IGNORECASE)
# Debian packages of the shared libraries that a binary may need.
LIBRARIES = {
    "libc.so.6": "libc6",
    "libm.so.6": "libc6",
    "ld-linux-x86-64.so.2": "libc6",
    "ld-linux-aarch64.so.1": "libc6",
    "libgcc_s.so.1": "libgcc-s1",
}
ARCHITECTURES = {"x86_64": "amd64", "aarch64": "arm64"}


def run(*command, **options):
    """Runs a command of the repository and returns its standard output."""
    done = subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True, cwd=REPOSITORY, **options)
    return done.stdout


def metadata():
    return json.loads(run("cargo", "metadata", "--format-version", "1", "--locked"))


def linked_packages(data):
    """Packages of other authors that are linked into the binaries on this computer, by `cargo tree`."""
    tree = run("cargo", "tree", "--locked", "-p", PACKAGE, "-e", "normal", "--prefix", "none", "--format", "{p}")
    names = {tuple(line.split()[:2]) for line in tree.splitlines() if line.strip()}
    found = [p for p in data["packages"] if p["source"] and (p["name"], "v" + p["version"]) in names]
    return sorted(found, key=lambda package: (package["name"], package["version"]))


def licence_texts(package):
    """Licence files of a package, also of a library that it brings along in a folder of its own."""
    root = Path(package["manifest_path"]).parent
    files = [path for pattern in ("*", "*/*") for path in root.glob(pattern) if path.is_file()]
    named = [path for path in files if LICENCE_FILE.match(path.name) and path.suffix not in (".rs", ".py", ".c", ".h")]
    return [(path.relative_to(root), path.read_text(errors="replace").strip()) for path in sorted(named)]


def third_party_licences(data):
    """Text with the licence of every linked package; texts that are the same are printed once."""
    packages = linked_packages(data)
    parts = ["Packages that are linked into the binaries of camwright, with their licences.", ""]
    texts = {}
    for package in packages:
        if not package["license"] and not package["license_file"]:
            sys.exit(f"{package['name']} states no licence")
        numbers = []
        for path, text in licence_texts(package):
            number, _ = texts.setdefault(" ".join(text.split()), (len(texts) + 1, text))
            numbers.append(f"{path} [{number}]")
        where = package["repository"] or package["homepage"] or "crates.io"
        authors = ", ".join(package["authors"]) or "the authors named in its repository"
        parts.append(f"{package['name']} {package['version']}: {package['license']}")
        parts.append(f"  {authors}; {where}")
        parts.append(f"  texts: {', '.join(numbers) if numbers else 'none in the package; the licence named above applies'}")
    for number, text in texts.values():
        parts += ["", "-" * 72, f"[{number}]", "", text]
    return "\n".join(parts) + "\n"


def build_binaries():
    run("cargo", "build", "--release", "--locked", "-p", PACKAGE, "--bins")
    return Path(metadata()["target_directory"]) / "release"


def write(path, text):
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text)


def compress(path):
    """Replaces a file by its compressed form, without a time in it."""
    with open(path.with_name(path.name + ".gz"), "wb") as target:
        with gzip.GzipFile(filename="", mode="wb", fileobj=target, mtime=0) as archive:
            archive.write(path.read_bytes())
    path.unlink()


def stage(prefix, binaries, data):
    """Installs everything below a prefix."""
    shutil.rmtree(prefix, ignore_errors=True)
    programs = prefix / "lib/camwright"
    programs.mkdir(parents=True)
    for name in BINARIES:
        shutil.copy2(binaries / name, programs / name)
        run("strip", "--strip-debug", str(programs / name))
    (prefix / "bin").mkdir()
    # The program finds `share` from its real path, so a link is enough. The names of the nodes are too general for the search path.
    (prefix / "bin/camwright").symlink_to("../lib/camwright/camwright")
    share = prefix / "share"
    ignored = shutil.ignore_patterns("__pycache__")
    shutil.copytree(REPOSITORY / "params", share / "camwright/params", ignore=ignored)
    for folder in ("urdf", "rviz", "foxglove"):
        shutil.copytree(REPOSITORY / "nodes" / folder, share / "camwright" / folder, ignore=ignored)
    program = str(programs / "camwright")
    for shell, path in COMPLETIONS.items():
        write(share / path, run(program, "completions", shell))
    run(program, "man", str(share / "man/man1"))
    for page in (share / "man/man1").iterdir():
        compress(page)
    documents = share / "doc/camwright"
    documents.mkdir(parents=True)
    shutil.copytree(REPOSITORY / "docs", documents / "docs", ignore=shutil.ignore_patterns("book.toml", "*.css", "*.js", "*.hbs"))
    # The parameter files refer to the documents beside them.
    (share / "camwright/docs").symlink_to("../doc/camwright/docs")
    licence = (REPOSITORY / "LICENSE").read_text()
    write(documents / "copyright", f"camwright, copyright The camwright maintainers\n\n{licence}")
    write(documents / "THIRD_PARTY_LICENSES", third_party_licences(data))
    shutil.copy(REPOSITORY / "CHANGELOG.md", documents / "changelog")
    for name in ("THIRD_PARTY_LICENSES", "changelog"):
        compress(documents / name)
    for path in [prefix, *prefix.rglob("*")]:
        if not path.is_symlink():
            path.chmod(0o755 if path.is_dir() or path.parent == programs else 0o644)


def dependencies(programs):
    """Debian packages of the shared libraries, libc6 with the version that the symbols need."""
    packages, libc = set(), (2, 0)
    for name in BINARIES:
        for library in re.findall(r"\(NEEDED\).*\[(.*)\]", run("readelf", "-dW", str(programs / name))):
            if library not in LIBRARIES:
                sys.exit(f"{name} needs {library}, whose Debian package is unknown")
            packages.add(LIBRARIES[library])
        versions = re.findall(r"\bGLIBC_(\d+)\.(\d+)", run("readelf", "-VW", str(programs / name)))
        libc = max([libc, *((int(major), int(minor)) for major, minor in versions)])
    minimum = f"libc6 (>= {libc[0]}.{libc[1]})"
    return ", ".join(minimum if package == "libc6" else package for package in sorted(packages))


def control(package, architecture, prefix):
    size = sum(path.stat().st_size for path in prefix.rglob("*") if path.is_file() and not path.is_symlink())
    fields = {
        "Package": "camwright",
        "Version": package["version"],
        "Architecture": architecture,
        "Maintainer": "The camwright maintainers <maintainers@camwright.example.org>",
        "Installed-Size": str(-(-size // 1024)),
        "Depends": dependencies(prefix / "lib/camwright"),
        "Section": "science",
        "Priority": "optional",
        "Description": "grinding and turning of parts that are not round\n"
        " Plans, simulates and records the motion of grinding machines and lathes\n"
        " for camshafts, plate and groove cams, eccentrics and three-dimensional\n"
        " cams, as ROS 2 nodes that need no ROS installation.",
    }
    return "".join(f"{key}: {value}\n" for key, value in fields.items())


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("--binaries", type=Path, metavar="DIR", help="package these binaries instead of building them")
    arguments.add_argument("--out", type=Path, metavar="DIR", help="folder of the packages [default: target/package]")
    arguments.add_argument("--fast", action="store_true", help="compress little, for tests")
    args = arguments.parse_args()

    binaries = (args.binaries or build_binaries()).resolve()
    data = metadata()
    package = next(package for package in data["packages"] if package["name"] == PACKAGE)
    out = (args.out or Path(data["target_directory"]) / "package").resolve()
    machine = os.uname().machine
    if machine not in ARCHITECTURES:
        sys.exit(f"packages are built on {' and '.join(ARCHITECTURES)}, not on {machine}")
    architecture = ARCHITECTURES[machine]
    epoch = os.environ.get("SOURCE_DATE_EPOCH") or run("git", "log", "-1", "--format=%ct").strip()
    environment = {**os.environ, "SOURCE_DATE_EPOCH": epoch}

    name = f"camwright-{package['version']}-{machine}-linux"
    prefix = out / name
    stage(prefix, binaries, data)
    tarball = out / f"{name}.tar.gz"
    run(
        "tar", "--create", "--sort=name", f"--mtime=@{epoch}", "--owner=0", "--group=0", "--numeric-owner",
        f"--use-compress-program=gzip -n -{1 if args.fast else 9}", "--file", str(tarball), "-C", str(out), name,
    )  # fmt: skip
    root = out / "deb"
    shutil.rmtree(root, ignore_errors=True)
    root.mkdir()
    prefix.rename(root / "usr")
    write(root / "DEBIAN/control", control(package, architecture, root / "usr"))
    deb = out / f"camwright_{package['version']}_{architecture}.deb"
    level = ["-Zgzip", "-z1"] if args.fast else ["-Zxz"]
    run("dpkg-deb", "--root-owner-group", *level, "--build", str(root), str(deb), env=environment)
    shutil.rmtree(root)
    for path in (tarball, deb):
        print(path)


if __name__ == "__main__":
    main()
