// SPDX-License-Identifier: MIT
// Runs a target over its corpus, and over changed copies of it for a while, without libFuzzer.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>
#include <vector>

#include "fuzz_target.hpp"
#include "silvafit/base/atomic_file.hpp"
#include "silvafit/base/random.hpp"

namespace {

namespace fs = std::filesystem;
using silvafit::Random;

std::vector<std::string> read_corpus(const fs::path& folder) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(folder)) files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  std::vector<std::string> corpus;
  corpus.reserve(files.size());
  for (const fs::path& file : files) corpus.push_back(silvafit::read_file(file));
  return corpus;
}

/// The words of a libFuzzer dictionary: what stands between quotes, \xNN and \\ as bytes.
std::vector<std::string> read_dictionary(const fs::path& file) {
  std::vector<std::string> words;
  std::ifstream lines(file);
  for (std::string line; std::getline(lines, line);) {
    const std::size_t begin = line.find('"');
    const std::size_t end = line.rfind('"');
    if (line.starts_with('#') || begin == end || begin == std::string::npos) continue;
    std::string word;
    for (std::size_t i = begin + 1; i < end; ++i) {
      if (line[i] != '\\') {
        word += line[i];
      } else if (line[i + 1] == 'x') {
        word += static_cast<char>(std::stoi(line.substr(i + 2, 2), nullptr, 16));
        i += 3;
      } else {
        word += line[++i];
      }
    }
    words.push_back(word);
  }
  return words;
}

/// Changes bytes as a careless editor or a bad disk would: flips, repeats, drops, swaps, inserts.
class Mutator {
 public:
  Mutator(std::vector<std::string> corpus, std::vector<std::string> words)
      : corpus_(std::move(corpus)), words_(std::move(words)) {}

  std::string next() {
    std::string bytes = corpus_[below(corpus_.size())];
    for (std::size_t changes = 1 + below(4); changes > 0; --changes) change(bytes);
    return bytes;
  }

 private:
  std::size_t below(std::size_t count) {
    return static_cast<std::size_t>(random_.below(static_cast<std::uint64_t>(count)));
  }

  void change(std::string& bytes) {
    const std::size_t at = below(bytes.size() + 1);
    const std::size_t many = std::min(bytes.size() - at, below(16) + 1);
    switch (below(6)) {
      case 0:
        if (at < bytes.size()) bytes[at] = static_cast<char>(below(256));
        break;
      case 1:
        bytes.erase(at, many);
        break;
      case 2:
        bytes.insert(at, bytes.substr(at, many));
        break;
      case 3:
        bytes.resize(at);
        break;
      case 4: {
        const std::string& other = corpus_[below(corpus_.size())];
        bytes = bytes.substr(0, at) + other.substr(below(other.size() + 1));
        break;
      }
      default:
        if (!words_.empty()) bytes.insert(at, words_[below(words_.size())]);
    }
  }

  std::vector<std::string> corpus_;
  std::vector<std::string> words_;
  Random random_{1};
};

int run(const fs::path& folder, const fs::path& dictionary, double seconds) {
  const std::vector<std::string> corpus = read_corpus(folder);
  if (corpus.empty()) throw std::runtime_error("the corpus is empty: " + folder.string());
  for (const std::string& bytes : corpus) silvafit::fuzz::read_checked(bytes);
  Mutator mutator(corpus, read_dictionary(dictionary));
  const auto start = std::chrono::steady_clock::now();
  std::size_t runs = 0;
  for (; std::chrono::steady_clock::now() - start < std::chrono::duration<double>(seconds);
       ++runs) {
    const std::string bytes = mutator.next();
    try {
      silvafit::fuzz::read_checked(bytes);
    } catch (const std::exception& error) {
      silvafit::write_file("finding", bytes);
      std::fprintf(stderr, "%s; the bytes are in the file `finding`\n", error.what());
      return 1;
    }
  }
  std::printf("%zu files of the corpus, %zu changed ones\n", corpus.size(), runs);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 4) {
    std::fputs("usage: fuzz-replay-NAME CORPUS DICTIONARY SECONDS\n", stderr);
    return 2;
  }
  try {
    return run(argv[1], argv[2], std::stod(argv[3]));
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}
