#!/usr/bin/env python3
# SPDX-FileCopyrightText: The Raybundle authors
# SPDX-License-Identifier: Apache-2.0
"""Holds the sources against the arrows of ARCHITECTURE.md, and against what linters do not see of the rules for files
and names, and prints each offence as file:line: sentence.

Usage: check_architecture.py [ROOT]; exits with 1 when there is an offence.
"""

import os
import re
import sys
from pathlib import Path

# module -> modules that it may include directly; what those may include is allowed too.
ARROWS = {
    "geometry": [],
    "camera": ["geometry"],
    "scene": ["camera"],
    "toml": ["scene"],
    "io": ["scene"],
    "initialize": ["scene"],
    "targets": ["toml"],
    "synthetic": ["toml"],
    "bundle": ["scene"],
    "uncertainty": ["bundle"],
    "calibrate": ["initialize", "uncertainty"],
    "cockpit": ["synthetic"],
    "device": ["geometry"],
    "structured_light": ["device", "scene"],
    "stereo": ["device", "scene"],
    "occupancy": ["device"],
}

# Folders that may include anything, and that nothing else includes.
LEAVES = ["apps", "python", "tests", "bench"]

# library -> (how its headers begin, modules that may use it, whether their public headers may).
LIBRARIES = {
    "Ceres": (r"ceres/", [], False),
    "OpenCV": (r"opencv2/", ["targets"], True),
    "AprilTag": (r"apriltag/", ["targets"], False),
    "cairo": (r"cairo", ["targets"], False),
    "GeographicLib": (r"GeographicLib/", ["geometry"], False),
    "mrcal": (r"mrcal/", ["uncertainty"], False),
    "Embree": (r"embree", ["synthetic", "cockpit"], False),
    "OpenSSL": (r"openssl/", ["io"], False),
    "nlohmann-json": (r"nlohmann/", ["io"], False),
    "yaml-cpp": (r"yaml-cpp/", ["io"], False),
    "toml++": (r"toml\+\+/|toml\.hpp", ["toml"], True),
    "CLI11": (r"CLI/", [], False),
    "GoogleTest": (r"gtest/|gmock/", [], False),
}

MAX_LINES = 400
NAMESPACE = re.compile(r"^namespace(?: ([\w:]+))? \{")
TYPE = re.compile(r"^(?:struct|class|enum class) ([\w:]+)[^;]*\{")
INCLUDE = re.compile(r'^\s*#\s*include\s*([<"])([^>"]+)[>"]')
SOURCES = (".cpp", ".hpp")
HIDDEN_UNIT = re.compile(r"\b(k[A-Z][A-Za-z0-9]*[a-z0-9])(Px2?|Rad|Mrad|Mm?|Ms|Deg|Grey)\b")
IGNORED = ("build", "corpus", "__pycache__")  # folders; a corpus holds inputs, not sources
WITH_SPDX = (".cpp", ".hpp", ".h", ".py", ".cmake", ".toml", ".sh")
SPDX = ("SPDX-FileCopyrightText: ", "SPDX-License-Identifier: Apache-2.0")


def module_of(path):
    """Module or leaf folder of a path relative to the root; None for files that belong to none."""
    parts = Path(path).parts
    if parts[0] == "calib_core" and len(parts) > 2:
        return parts[1]
    if parts[0] in ("datasets", "runtime") and len(parts) > 2:
        return parts[1]
    return parts[0] if len(parts) > 1 else None


def reachable(module):
    """The module and all that it may include, directly or not."""
    found = {module}
    for below in ARROWS.get(module, []):
        found |= reachable(below)
    return found


def project_files(root):
    for folder, folders, files in os.walk(root):
        folders[:] = sorted(f for f in folders if f not in IGNORED and not f.startswith("."))
        for name in sorted(files):
            yield os.path.relpath(os.path.join(folder, name), root)


def included_module(root, path, name):
    """Module that an include refers to; None for libraries, "" for a quoted name that is no file of the project."""
    own = re.match(r"raybundle/([^/]+)/", name)
    if own:
        return own.group(1)
    module = module_of(path)
    for folder in [os.path.dirname(path), f"calib_core/{module}/src", f"{module}/src", f"datasets/{module}/src",
                   f"runtime/{module}/src"]:
        target = os.path.normpath(os.path.join(folder, name))
        if (root / target).is_file():
            return module_of(target)
    return ""


def check_include(root, path, quote, name):
    """Sentences about one #include of one file."""
    module = module_of(path)
    if module in LEAVES:
        return
    public = "/include/" in path
    for library, (pattern, modules, public_too) in LIBRARIES.items():
        if not re.match(pattern, name):
            continue
        if module not in modules:
            yield f"{module} may not use {library}; only these may: {', '.join(modules + LEAVES)}"
        elif public and not public_too:
            yield f"{library} belongs into sources, not into a public header"
    if quote == "<" and not name.startswith("raybundle/"):
        return
    target = included_module(root, path, name)
    if target == "":
        yield f'"{name}" is no header of {module}; write raybundle/<module>/<header> or <library header>'
    elif target not in reachable(module):
        yield f"{module} may not include {target}: ARCHITECTURE.md draws no such arrow"


def check_source(root, path, lines):
    """(line, sentence) for each offence of a C++ file."""
    module = module_of(path)
    if module not in ARROWS and module not in LEAVES:
        yield 1, f"{module} is no module that ARCHITECTURE.md knows: draw its arrows there and in {Path(__file__).name}"
        return
    if path.endswith(".hpp") and "#pragma once" not in lines:
        yield 1, "the header has no #pragma once"
    if len(lines) > MAX_LINES:
        yield MAX_LINES + 1, f"{len(lines)} lines; a file holds one concept in at most {MAX_LINES}"
    for number, line in enumerate(lines, 1):
        include = INCLUDE.match(line)
        if include:
            for sentence in check_include(root, path, *include.groups()):
                yield number, sentence
        for name, unit in HIDDEN_UNIT.findall(line):
            yield number, f"{name}{unit} hides its unit; write {name}_{unit.lower()}"


def shared_types(lines):
    """(line, name with its namespaces) of each type that other files could mean by that name."""
    namespaces = []
    for number, line in enumerate(lines, 1):
        opened = NAMESPACE.match(line)
        if opened:
            namespaces.append(opened.group(1) or "")
        elif line.startswith("}  // namespace") and namespaces:
            namespaces.pop()
        defined = TYPE.match(line)
        if defined and "" not in namespaces:
            yield number, "::".join([*namespaces, defined.group(1)])


def check_tree(root):
    """(path, line, sentence) for each offence in the tree."""
    root = Path(root)
    mrcal_users = []
    defined_in = {}
    for path in project_files(root):
        if not (path.endswith(WITH_SPDX) or os.path.basename(path) == "CMakeLists.txt"):
            continue
        lines = (root / path).read_text(encoding="utf-8").splitlines()
        if not all(any(text in line for line in lines[:3]) for text in SPDX):
            yield path, 1, "the two SPDX lines are missing at the top"
        if not path.endswith(SOURCES):
            continue
        yield from ((path, number, sentence) for number, sentence in check_source(root, path, lines))
        for number, name in shared_types(lines) if module_of(path) in [*ARROWS, "apps"] else []:
            first = defined_in.setdefault(name, path)
            if first != path:
                yield path, number, f"{name} is also in {first}: a program with both has two meanings for one name"
        if module_of(path) not in LEAVES and any("include <mrcal/" in line for line in lines):
            mrcal_users.append(path)
    for path in mrcal_users[1:]:
        yield path, 1, f"mrcal stays behind one adapter, which is {mrcal_users[0]}"


def main():
    root = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).resolve().parents[2]
    offences = list(check_tree(root))
    for path, line, sentence in offences:
        print(f"{path}:{line}: {sentence}")
    print(f"{len(offences)} offences against the architecture")
    return 1 if offences else 0


if __name__ == "__main__":
    sys.exit(main())
