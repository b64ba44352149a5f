# SPDX-License-Identifier: MIT
"""layering.py finds each kind of breach, and only those: small trees of sources with one breach each."""

import pathlib
import tempfile
import unittest

from layering import breaches

SPDX = "// SPDX-License-Identifier: MIT\n"


class Layering(unittest.TestCase):
    def found(self, files):
        with tempfile.TemporaryDirectory() as folder:
            for name, text in files.items():
                path = pathlib.Path(folder, name)
                path.parent.mkdir(parents=True, exist_ok=True)
                path.write_text(text, encoding="utf-8")
            return breaches(folder)

    def test_a_tree_in_order_passes(self):
        self.assertEqual(self.found({
            "libfit/include/silvafit/fit/model.hpp": SPDX + '#pragma once\n#include <Eigen/Core>\n'
            '#include <nlohmann/json_fwd.hpp>\n#include <vector>\n#include "silvafit/data/table.hpp"\n',
            "libfit/src/model.cpp": SPDX + '#include <ceres/ceres.h>\n#include "silvafit/base/error.hpp"\n'
            '#include "own.hpp"\nusing namespace std::literals;\n',
            "libstudy/src/study.cpp": SPDX + '#include "silvafit/tree/crown.hpp"\n#include "silvafit/fit/fit.hpp"\n',
            "cli/main.cpp": SPDX + '#include <CLI/CLI.hpp>\n#include "silvafit/stand/window.hpp"\n',
            "scripts/tool.py": "#!/usr/bin/env python3\n# SPDX-License-Identifier: MIT\n",
            "build/generated.cpp": "int generated;\n",
            "build-dev/generated.cpp": "int generated;\n",
            "viewer/node_modules/package/index.js": "export {};\n",
        }), [])

    def test_folders_of_a_library_have_an_order(self):
        head = SPDX + "#pragma once\n"
        tree = {
            "libfit/include/silvafit/fit/bootstrap.hpp": head,
            "libfit/src/resampling/bootstrap.cpp": SPDX + '#include "silvafit/fit/bootstrap.hpp"\n',
            "libfit/src/model/rows.hpp": head,
            "libfit/src/inference/profile.hpp": head + '#include "model/rows.hpp"\n',
            "libfit/src/model/rows_test.cpp": SPDX + '#include "inference/profile.hpp"\n',
        }
        self.assertEqual(self.found(tree), [])
        self.assertEqual(self.found(tree | {"libfit/src/model/rows.cpp": SPDX + '#include "inference/profile.hpp"\n'}),
                         ["libfit/src/model/rows.cpp:2: model must not know inference (inference/profile.hpp)"])
        self.assertEqual(len(self.found(
            tree | {"libfit/src/model/rows.cpp": SPDX + '#include "silvafit/fit/bootstrap.hpp"\n'})), 1)
        self.assertEqual(len(self.found(tree | {"libfit/src/elsewhere/a.cpp": SPDX + '#include "model/rows.hpp"\n'})), 1)

    def test_a_library_may_not_look_up_or_sideways(self):
        for library, header in [("base", "data"), ("data", "fit"), ("fit", "stand"), ("fit", "tree"),
                                ("stand", "fit"), ("stand", "tree"), ("tree", "fit"), ("tree", "stand"),
                                ("tree", "study")]:
            with self.subTest(library=library, header=header):
                self.assertEqual(
                    self.found({f"lib{library}/src/a.cpp": SPDX + f'#include "silvafit/{header}/b.hpp"\n'}),
                    [f"lib{library}/src/a.cpp:2: lib{library} must not know lib{header} (silvafit/{header}/b.hpp)"])

    def test_tests_of_a_library_are_held_to_its_place(self):
        self.assertEqual(len(self.found({
            "libfit/src/a_test.cpp": SPDX + '#include <silvafit/tree/mesh.hpp>\n'})), 1)

    def test_a_public_header_shows_no_one_elses(self):
        for header in ["ceres/ceres.h", "tiny_gltf.h", "nanoflann.hpp", "boost/geometry.hpp",
                       "nlohmann/json.hpp", "kainjow/mustache.hpp", "tbb/parallel_for.h", "CLI/CLI.hpp",
                       "fmt/format.h", "private.hpp"]:
            with self.subTest(header=header):
                self.assertEqual(
                    self.found({"libstudy/include/silvafit/study/a.hpp": SPDX + f"# include <{header}>\n"}),
                    [f"libstudy/include/silvafit/study/a.hpp:2: a public header must not show {header}"])

    def test_only_the_program_reads_command_lines(self):
        self.assertEqual(len(self.found({"libstudy/src/a.cpp": SPDX + "#include <CLI/CLI.hpp>\n"})), 1)

    def test_code_for_one_system_stands_in_its_folder(self):
        for text, name in [("#include <unistd.h>\n", "unistd.h"), ("# include <sys/stat.h>\n", "sys/stat.h"),
                           ("#ifdef _WIN32\n", "_WIN32"), ("#if defined(__linux__)\n", "__linux__"),
                           ('auto file = open("/proc/self/exe");\n', '"/proc/')]:
            with self.subTest(text=text):
                for path in ["libtree/src/files/spool.cpp", "libbase/src/paths.cpp", "cli/main.cpp"]:
                    self.assertEqual(self.found({path: SPDX + text}),
                                     [f"{path}:2: only base/system.hpp knows the system ({name})"])
                self.assertEqual(self.found({
                    path: SPDX + text for path in ["libbase/src/posix/files.cpp", "libbase/src/windows/files.cpp",
                                                   "libbase/src/paths_test.cpp", "bench/support/measurement.cpp"]}), [])

    def test_messages_name_known_settings_and_no_options(self):
        lists = {"libstudy/include/silvafit/study/setting_list.hpp": SPDX + 'visit(\n    Setting(\n "edge",\n',
                 "libstudy/src/study/setting_names.cpp": SPDX + 'kFurther{"where"};\nkFunctions{"grow"};\n'}
        for text in ["use `edge=torus` or `where`", "a formula is `response ~ terms`", "`Height (m)`", "---"]:
            self.assertEqual(self.found(lists | {"libfit/src/a.cpp": SPDX + f'const char* text = "{text}";\n'}), [])
        for text in ["--edge", "use --edge torus", "(--edge)", "`edges`", "`edges=torus`", "`grow`"]:
            with self.subTest(text=text):
                self.assertEqual(len(self.found(lists | {"libfit/src/a.cpp": SPDX + f'const char* text = "{text}";\n'})), 1)
                self.assertEqual(self.found({path: SPDX + f'const char* text = "{text}";\n'
                                             for path in ["libfit/src/a_test.cpp", "cli/a.cpp"]}), [])
        self.assertEqual(self.found({"libfit/src/a.cpp": SPDX + "// \"--edge\"\nif (c == '\"') --depth;\nauto text = \"a\";\n"}), [])

    def test_a_header_opens_no_namespace_for_others(self):
        for name in ["libfit/include/silvafit/fit/a.hpp", "libfit/src/a.hpp", "tests/support/a.hpp"]:
            with self.subTest(name=name):
                self.assertEqual(self.found({name: SPDX + "  using namespace std;\n"}),
                                 [f"{name}:2: a header must not say `using namespace`"])

    def test_a_source_says_its_licence_on_top(self):
        for name in ["libfit/src/a.cpp", "libfit/CMakeLists.txt", "cmake/a.cmake", "tests/a.py", "viewer/src/a.js"]:
            with self.subTest(name=name):
                self.assertEqual(self.found({name: "\n" + SPDX}),
                                 [f"{name}:1: the first line is not the SPDX line"])
                self.assertEqual(len(self.found({name: ""})), 1)

    def test_a_library_without_a_place_is_not_overlooked(self):
        self.assertEqual(self.found({"libnew/src/a.cpp": SPDX}),
                         ["libnew/src/a.cpp:1: libnew has no place in the order of the libraries"])


if __name__ == "__main__":
    unittest.main()
