// SPDX-License-Identifier: MIT
#include "silvafit/base/paths.hpp"

#include <catch2/catch.hpp>
#include <string>

#include "silvafit/base/atomic_file.hpp"
#include "silvafit/base/built_in_files.hpp"
#include "silvafit/base/error.hpp"

namespace fs = std::filesystem;
using silvafit::kind_of;
using silvafit::PathKind;

TEST_CASE("a name is that of a file, a folder, a device or nothing") {
  const silvafit::TemporaryFolder folder("silvafit-paths");
  const fs::path file = folder.path() / "file";
  silvafit::write_file(file, "x");
  CHECK(kind_of(file) == PathKind::kFile);
  CHECK(kind_of(folder.path()) == PathKind::kFolder);
  CHECK(kind_of("/dev/null") == PathKind::kStream);
  CHECK(kind_of(folder.path() / "nothing") == PathKind::kNothing);
  CHECK(kind_of(file / "below") == PathKind::kNothing);
  CHECK_FALSE(silvafit::is_there(""));
}

TEST_CASE("names that the system cannot follow are errors of the input") {
  const silvafit::TemporaryFolder folder("silvafit-paths");
  const fs::path loop = folder.path() / "loop";
  fs::create_symlink("loop", loop);
  for (const fs::path& path : {loop, loop / "below", folder.path() / std::string(300, 'n')}) {
    CHECK_THROWS_AS(kind_of(path), silvafit::InputError);
    CHECK_THROWS_AS(silvafit::files_in_folder(path, ".json"), silvafit::InputError);
    CHECK_NOTHROW(silvafit::followed(path));
  }
  CHECK_THROWS_WITH(kind_of(loop), Catch::Matchers::Contains("loop: cannot read"));
}

TEST_CASE("the files of a folder are in alphabetical order") {
  const silvafit::TemporaryFolder folder("silvafit-paths");
  for (const char* name : {"b.json", "a.json", "c.txt"}) {
    silvafit::write_file(folder.path() / name, "x");
  }
  const auto files = silvafit::files_in_folder(folder.path(), ".json");
  REQUIRE(files.size() == 2);
  CHECK(files[0].filename() == "a.json");
  CHECK(files[1].filename() == "b.json");
}

TEST_CASE("files of the program are found as those on the disk") {
  auto& files = silvafit::built_in_files();
  files = {{"mem:/a/two.json", "2"},
           {"mem:/a/one.json", "1"},
           {"mem:/a/b/three.json", "3"},
           {"mem:/a/four.txt", ""},
           {"mem:/ab/five.json", "5"}};
  CHECK(kind_of("mem:") == PathKind::kFolder);
  CHECK(kind_of("mem:/a") == PathKind::kFolder);
  CHECK(kind_of("mem:/a/b/three.json") == PathKind::kFile);
  CHECK(kind_of("mem:/a/four.txt") == PathKind::kFile);
  for (const char* nothing : {"", "mem", "mem:/b", "mem:/a/o", "mem:/a/one.json/x"}) {
    CHECK_FALSE(silvafit::is_there(nothing));
  }
  CHECK(silvafit::files_in_folder("mem:/a", ".json") ==
        std::vector<fs::path>{"mem:/a/one.json", "mem:/a/two.json"});
  CHECK_THROWS_AS(silvafit::files_in_folder("mem:/c", ".json"), silvafit::InputError);
  CHECK(silvafit::read_file("mem:/a/one.json") == "1");
  CHECK(silvafit::read_file("mem:/a/four.txt").empty());
  CHECK_THROWS_AS(silvafit::read_file("mem:/a"), silvafit::InputError);
  files.clear();
}
