// SPDX-License-Identifier: MIT
#include "silvafit/base/atomic_file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <string>

#include "silvafit/base/io_error.hpp"

namespace fs = std::filesystem;

namespace {

struct Folder {
  fs::path path = fs::temp_directory_path() / ("silvafit-atomic-" + std::to_string(::getpid()));
  Folder() { fs::create_directories(path); }
  ~Folder() { fs::remove_all(path); }
};

}  // namespace

TEST_CASE("a file that is larger than its reader allows is refused, endless ones too") {
  const Folder folder;
  const fs::path file = folder.path / "text";
  silvafit::write_file(file, std::string(1000, 'a'));
  CHECK(silvafit::read_file(file, 1000).size() == 1000);
  CHECK_THROWS_WITH(silvafit::read_file(file, 999),
                    Catch::Matchers::Contains("text: is larger than 1 MiB"));
  CHECK_THROWS_AS(silvafit::read_file("/dev/zero", 1 << 20), silvafit::InputError);
}

TEST_CASE("a file appears only when it is committed") {
  const Folder folder;
  const fs::path target = folder.path / "deep" / "file.txt";
  {
    silvafit::AtomicFile file(target);
    file.stream() << "half";
    CHECK_FALSE(fs::exists(target));
  }
  CHECK_FALSE(fs::exists(target));
  // The folder was created for the file, and is removed with it.
  CHECK(fs::is_empty(folder.path));

  silvafit::write_file(target, "whole\n");
  CHECK(silvafit::read_file(target) == "whole\n");
}

TEST_CASE("an abandoned file does not change the old content") {
  const Folder folder;
  const fs::path target = folder.path / "file.txt";
  silvafit::write_file(target, "old");
  {
    silvafit::AtomicFile file(target);
    file.stream() << "new";
  }
  CHECK(silvafit::read_file(target) == "old");
}

TEST_CASE("writing to a pipe keeps the pipe") {
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

TEST_CASE("a replaced file keeps its permissions") {
  const Folder folder;
  const fs::path target = folder.path / "file.txt";
  silvafit::write_file(target, "old");
  fs::permissions(target, fs::perms::owner_read | fs::perms::owner_write);
  silvafit::write_file(target, "new");
  CHECK(silvafit::read_file(target) == "new");
  CHECK(fs::status(target).permissions() == (fs::perms::owner_read | fs::perms::owner_write));
}

TEST_CASE("the target of a link is replaced, and the link is kept") {
  const Folder folder;
  const fs::path target = folder.path / "target.txt";
  const fs::path link = folder.path / "link.txt";
  fs::create_symlink("target.txt", link);
  for (const char* const text : {"new", "newer"}) {
    silvafit::write_file(link, text);
    CHECK(fs::is_symlink(link));
    CHECK(silvafit::read_file(target) == text);
  }
}

TEST_CASE("files that are committed together are there together") {
  const Folder folder;
  const fs::path one = folder.path / "one";
  const fs::path other = folder.path / "other";
  silvafit::write_file(one, "old");
  {
    silvafit::AtomicFile first(one);
    silvafit::AtomicFile second(other);
    first.stream() << "new";
    second.stream() << "new";
    CHECK(silvafit::read_file(one) == "old");
    silvafit::commit_together({&first, &second});
  }
  CHECK(silvafit::read_file(one) == "new");
  CHECK(silvafit::read_file(other) == "new");
}

TEST_CASE("large pieces and small ones keep their order") {
  const Folder folder;
  const fs::path target = folder.path / "file.txt";
  std::string expected;
  silvafit::AtomicFile file(target);
  for (const std::size_t size : {1U, 65535U, 2U, 200000U, 65536U, 0U, 7U}) {
    const std::string piece(size, static_cast<char>('a' + size % 26));
    file.stream() << piece;
    expected += piece;
  }
  file.commit();
  CHECK(silvafit::read_file(target) == expected);
}

TEST_CASE("a full device is an error of input and output with its reason") {
  CHECK_THROWS_AS(silvafit::write_file("/dev/full", "x"), silvafit::IoError);
  CHECK_THROWS_WITH(silvafit::write_file("/dev/full", std::string(100000, 'x')),
                    "/dev/full: cannot write (No space left on device)");
}

TEST_CASE("a folder for results goes if nobody writes into it") {
  const Folder folder;
  {
    const silvafit::ResultFolder made(folder.path / "new" / "deep");
    CHECK(fs::is_empty(folder.path / "new" / "deep"));
  }
  CHECK(fs::is_empty(folder.path));
  {
    const silvafit::ResultFolder made(folder.path / "new" / "deep");
    silvafit::write_file(folder.path / "new" / "file", "x");
  }
  CHECK(fs::exists(folder.path / "new" / "file"));
  CHECK_FALSE(fs::exists(folder.path / "new" / "deep"));
  CHECK_THROWS_AS(silvafit::ResultFolder(folder.path / "new" / "file"), silvafit::IoError);
}

TEST_CASE("a folder for results has one owner at a time") {
  const Folder folder;
  {
    const silvafit::ResultFolder first(folder.path / "out");
    CHECK_THROWS_WITH(silvafit::ResultFolder(folder.path / "out"),
                      Catch::Matchers::Contains("another silvafit is writing into this folder"));
    CHECK(fs::exists(folder.path / "out"));
    const silvafit::ResultFolder beside(folder.path / "beside");
  }
  CHECK_NOTHROW(silvafit::ResultFolder(folder.path / "out"));
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

TEST_CASE("a temporary folder is removed with its content") {
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
