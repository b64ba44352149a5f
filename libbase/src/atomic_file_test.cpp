// SPDX-License-Identifier: MIT
#include "silvafit/base/atomic_file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <string>

#include "silvafit/base/error.hpp"

namespace fs = std::filesystem;

namespace {

struct Folder {
  fs::path path = fs::temp_directory_path() / ("silvafit-atomic-" + std::to_string(::getpid()));
  Folder() { fs::create_directories(path); }
  ~Folder() { fs::remove_all(path); }
};

}  // namespace

TEST_CASE("a file appears only when it is committed") {
  const Folder folder;
  const fs::path target = folder.path / "deep" / "file.txt";
  {
    silvafit::AtomicFile file(target);
    file.stream() << "half";
    CHECK_FALSE(fs::exists(target));
  }
  CHECK_FALSE(fs::exists(target));
  CHECK(fs::is_empty(target.parent_path()));

  silvafit::write_file(target, "whole\n");
  CHECK(silvafit::read_file(target) == "whole\n");
}

TEST_CASE("an abandoned file leaves the old content") {
  const Folder folder;
  const fs::path target = folder.path / "file.txt";
  silvafit::write_file(target, "old");
  {
    silvafit::AtomicFile file(target);
    file.stream() << "new";
  }
  CHECK(silvafit::read_file(target) == "old");
}

TEST_CASE("a pipe is written to and stays a pipe") {
  const Folder folder;
  const fs::path pipe = folder.path / "pipe";
  REQUIRE(::mkfifo(pipe.c_str(), 0600) == 0);
  const int reader = ::open(pipe.c_str(), O_RDONLY | O_NONBLOCK);
  REQUIRE(reader >= 0);
  silvafit::write_file(pipe, "through");
  std::string bytes(16, '.');
  const auto count = ::read(reader, bytes.data(), bytes.size());
  ::close(reader);
  REQUIRE(count == 7);
  CHECK(bytes.substr(0, 7) == "through");
  CHECK(fs::is_fifo(pipe));
}

TEST_CASE("a file that cannot be written or read is named") {
  CHECK_THROWS_WITH(silvafit::write_file("/proc/none/file.txt", "x"),
                    Catch::Matchers::Contains("/proc/none"));
  CHECK_THROWS_AS(silvafit::read_file("does-not-exist.csv"), silvafit::InputError);
  CHECK_THROWS_WITH(silvafit::read_file("does-not-exist.csv"),
                    Catch::Matchers::Contains("does-not-exist.csv: cannot read"));
  // A name that no file can have is not a file either.
  CHECK_THROWS_AS(silvafit::read_file(std::string(300, 'n')), silvafit::InputError);
}

TEST_CASE("a temporary folder goes with all that is in it") {
  fs::path path;
  {
    const silvafit::TemporaryFolder folder("silvafit-test");
    const silvafit::TemporaryFolder other("silvafit-test");
    path = folder.path();
    CHECK(path != other.path());
    CHECK(fs::is_empty(path));
    silvafit::write_file(path / "deep" / "file.txt", "x");
  }
  CHECK_FALSE(fs::exists(path));
}
