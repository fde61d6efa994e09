#!/usr/bin/env python3
# SPDX-FileCopyrightText: The Raybundle authors
# SPDX-License-Identifier: Apache-2.0
"""The architecture check finds what it is there for, and leaves allowed code alone."""

import tempfile
import unittest
from pathlib import Path

from check_architecture import ARROWS, check_tree

SPDX = "// SPDX-FileCopyrightText: The Raybundle authors\n// SPDX-License-Identifier: Apache-2.0\n"
HEADER = SPDX + "#pragma once\n"


def offences(files):
    """Offences of a tree with these {path: text}, as `path:line: sentence`."""
    with tempfile.TemporaryDirectory() as root:
        for path, text in files.items():
            file = Path(root, path)
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text(text, encoding="utf-8")
        return [f"{path}:{line}: {sentence}" for path, line, sentence in check_tree(root)]


class CheckArchitecture(unittest.TestCase):
    def assert_offence(self, path, text, *words):
        found = offences({path: text})
        self.assertEqual(len(found), 1, found)
        for word in (path, *words):
            self.assertIn(word, found[0])

    def include_line(self, path, include):
        head = HEADER if path.endswith(".hpp") else SPDX
        return path, head + f"#include {include}\n"

    def test_allows_the_arrows_that_are_drawn(self):
        for path, include in [
            ("calib_core/scene/include/raybundle/scene/a.hpp", '"raybundle/geometry/a.hpp"'),
            ("calib_core/calibrate/src/a.cpp", '"raybundle/bundle/a.hpp"'),
            ("targets/include/raybundle/targets/a.hpp", "<opencv2/core/mat.hpp>"),
            ("calib_core/geometry/include/raybundle/geometry/a.hpp", "<Eigen/Core>"),
            ("apps/a.cpp", '"raybundle/calibrate/a.hpp"'),
            ("tests/unit/camera/a.cpp", "<ceres/ceres.h>"),
        ]:
            self.assertEqual(offences(dict([self.include_line(path, include)])), [])

    def test_allows_private_headers_of_the_same_module(self):
        own = dict([self.include_line("targets/src/deep/a.cpp", '"b.hpp"')])
        own["targets/src/b.hpp"] = HEADER
        self.assertEqual(offences(own), [])

    def test_finds_arrows_that_are_not_drawn(self):
        for path, include, words in [
            ("calib_core/geometry/src/a.cpp", '"raybundle/camera/a.hpp"', "geometry may not include camera"),
            ("calib_core/initialize/src/a.cpp", '"raybundle/bundle/a.hpp"', "initialize may not include bundle"),
            ("calib_core/bundle/src/a.cpp", "<raybundle/initialize/a.hpp>", "bundle may not include initialize"),
            ("calib_core/io/src/a.cpp", '"raybundle/targets/a.hpp"', "io may not include targets"),
            ("runtime/stereo/src/a.cpp", '"raybundle/bundle/a.hpp"', "stereo may not include bundle"),
        ]:
            self.assert_offence(*self.include_line(path, include), f":3: " if path.endswith(".cpp") else "", words)

    def test_finds_private_headers_of_another_module(self):
        files = dict([self.include_line("calib_core/io/src/a.cpp", '"../../bundle/src/b.hpp"')])
        files["calib_core/bundle/src/b.hpp"] = HEADER
        self.assertEqual(len(offences(files)), 1)

    def test_finds_includes_of_leaves(self):
        files = dict([self.include_line("targets/src/a.cpp", '"../../apps/b.hpp"')])
        files["apps/b.hpp"] = HEADER
        self.assertIn("targets may not include apps", offences(files)[0])

    def test_finds_quoted_names_that_are_no_header_of_the_module(self):
        self.assert_offence(*self.include_line("calib_core/io/src/a.cpp", '"nowhere.hpp"'), "nowhere.hpp")

    def test_finds_libraries_out_of_their_place(self):
        for path, include, words in [
            ("calib_core/scene/src/a.cpp", "<opencv2/core.hpp>", "OpenCV"),
            ("calib_core/initialize/src/a.cpp", "<ceres/jet.h>", "Ceres"),
            ("calib_core/bundle/src/a.cpp", "<ceres/ceres.h>", "Ceres"),
            ("calib_core/io/include/raybundle/io/a.hpp", "<nlohmann/json.hpp>", "public header"),
            ("calib_core/scene/src/a.cpp", "<GeographicLib/Geocentric.hpp>", "GeographicLib"),
            ("calib_core/geometry/src/a.cpp", "<gtest/gtest.h>", "GoogleTest"),
        ]:
            self.assert_offence(*self.include_line(path, include), words)

    def test_finds_a_second_user_of_mrcal(self):
        first = dict([self.include_line("calib_core/uncertainty/src/a.cpp", "<mrcal/mrcal.h>")])
        self.assertEqual(offences(first), [])
        second = dict([self.include_line("calib_core/uncertainty/src/b.cpp", "<mrcal/mrcal.h>")])
        self.assertIn("one adapter", offences(first | second)[0])

    def test_finds_types_of_one_name(self):
        def source(opening, closing):
            return SPDX + f"namespace raybundle {{\n{opening}struct Spot {{}};\n{closing}}}  // namespace raybundle\n"

        shared = {"targets/src/a.cpp": source("", "")}
        self.assertEqual(offences(shared | {"runtime/stereo/src/b.cpp": source("namespace {\n", "}  // namespace\n")}), [])
        found = offences(shared | {"runtime/stereo/src/b.cpp": source("", "")})
        self.assertEqual(len(found), 1, found)
        self.assertIn("raybundle::Spot is also in", found[0])

    def test_finds_what_every_file_must_have(self):
        path = "calib_core/scene/src/a"
        self.assert_offence(path + ".cpp", "int a;\n", "SPDX")
        self.assert_offence(path + ".hpp", SPDX, "#pragma once")
        self.assert_offence(path + ".cpp", SPDX + "\n" * 500, "502 lines")
        self.assert_offence("calib_core/CMakeLists.txt", "add_subdirectory(a)\n", "SPDX")

    def test_finds_units_that_hide_in_names(self):
        path = "calib_core/scene/src/a.cpp"
        for name, right in [("kStepPx", "kStep_px"), ("kFarM", "kFar_m"), ("kLongMm", "kLong_mm"), ("kBendRad", "kBend_rad")]:
            self.assert_offence(path, SPDX + f"constexpr double {name} = 1.0;\n", ":3: ", right)
        for name in ["kStep_px", "kPitch_mrad", "kMostSeconds", "kAlikeSigmas", "kSpx", "kM"]:
            self.assertEqual(offences({path: SPDX + f"constexpr double {name} = 1.0;\n"}), [])

    def test_finds_modules_without_arrows(self):
        self.assert_offence("calib_core/novel/src/a.cpp", SPDX, "novel")
        self.assert_offence("calib_core/scene/src/a.cpp", SPDX + '#include "raybundle/novel/a.hpp"\n', "novel")

    def test_arrows_make_no_circle(self):
        def visit(module, above):
            self.assertNotIn(module, above)
            for below in ARROWS[module]:
                visit(below, [*above, module])

        for module in ARROWS:
            visit(module, [])


if __name__ == "__main__":
    unittest.main()
