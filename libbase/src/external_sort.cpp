// SPDX-License-Identifier: MIT
// Merge sort on disk: Knuth, The Art of Computer Programming 3, section 5.4.
#include "silvafit/base/external_sort.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <queue>
#include <system_error>
#include <utility>
#include <vector>

#include "silvafit/base/atomic_file.hpp"
#include "silvafit/base/io_error.hpp"
#include "silvafit/base/system.hpp"

namespace silvafit {
namespace {

/// More files than this are merged into one, because the system limits the number of open files.
constexpr std::size_t kMostRuns = 256;

std::filesystem::path temporary_place() {
  std::error_code ignored;
  return std::filesystem::temp_directory_path(ignored) / "silvafit-sort";
}

[[noreturn]] void fail(const char* verb) {
  throw IoError(std::string("cannot ") + verb + " a temporary file (" + system::reason(errno) +
                    "); delete files there, or set TMPDIR to a folder with more space",
                {.file = temporary_place().string()});
}

/// Sorted records in a file.
class Run {
 public:
  Run() : file_(open_nameless_file(temporary_place())) {}

  void write(ExternalSort::Key key, std::string_view record) {
    const std::array<std::uint64_t, 2> numbers{key.first, key.second};
    const auto size = static_cast<std::uint32_t>(record.size());
    put(numbers.data(), sizeof numbers);
    put(&size, sizeof size);
    put(record.data(), record.size());
  }

  void rewind() {
    if (std::fflush(file_.get()) != 0) fail("write");
    std::rewind(file_.get());
  }

  bool read(ExternalSort::Key& key, std::string& record) {
    std::array<std::uint64_t, 2> numbers{};
    std::uint32_t size = 0;
    if (std::fread(numbers.data(), sizeof numbers, 1, file_.get()) != 1) {
      if (std::ferror(file_.get()) != 0) fail("read");
      return false;
    }
    get(&size, sizeof size);
    record.resize(size);
    get(record.data(), size);
    key = {numbers[0], numbers[1]};
    return true;
  }

 private:
  void put(const void* bytes, std::size_t size) {
    if (size > 0 && std::fwrite(bytes, size, 1, file_.get()) != 1) fail("write");
  }
  void get(void* bytes, std::size_t size) {
    if (size > 0 && std::fread(bytes, size, 1, file_.get()) != 1) fail("read");
  }

  NamelessFile file_;
};

/// The next record of a run.
struct Head {
  ExternalSort::Key key{};
  std::size_t run = 0;
  std::string record{};
};

/// Merges the records of several runs in order; records with equal keys in the order of the runs.
class Merge {
 public:
  explicit Merge(std::vector<Run>& runs) : runs_(runs), heads_(runs.size()) {
    for (std::size_t i = 0; i < runs.size(); ++i) {
      heads_[i].run = i;
      runs_[i].rewind();
      advance(i);
    }
  }

  bool next(ExternalSort::Key& key, std::string& record) {
    if (queue_.empty()) return false;
    const std::size_t run = queue_.top().second;
    queue_.pop();
    key = heads_[run].key;
    std::swap(record, heads_[run].record);
    advance(run);
    return true;
  }

 private:
  using Entry = std::pair<ExternalSort::Key, std::size_t>;

  void advance(std::size_t run) {
    Head& head = heads_[run];
    if (runs_[run].read(head.key, head.record)) queue_.emplace(head.key, run);
  }

  std::vector<Run>& runs_;
  std::vector<Head> heads_;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue_{};
};

}  // namespace

struct ExternalSort::State {
  struct Entry {
    Key key{};
    std::size_t begin = 0;
    std::size_t size = 0;
  };

  explicit State(std::size_t most) : memory(most) {}

  void sort() {
    std::ranges::stable_sort(entries, {}, &Entry::key);
    next_entry = 0;
  }

  std::string_view record_of(const Entry& entry) const {
    return std::string_view(bytes).substr(entry.begin, entry.size);
  }

  void spill() {
    if (runs.size() == kMostRuns) collapse();
    sort();
    Run run;
    for (const Entry& entry : entries) run.write(entry.key, record_of(entry));
    runs.push_back(std::move(run));
    entries.clear();
    bytes.clear();
  }

  void collapse() {
    Run all;
    Key key;
    std::string record;
    Merge whole(runs);
    while (whole.next(key, record)) all.write(key, record);
    runs.clear();
    runs.push_back(std::move(all));
  }

  void begin_reading() {
    is_reading = true;
    if (runs.empty()) return sort();
    if (!entries.empty()) spill();
    entries = {};
    bytes = {};
    merge = std::make_unique<Merge>(runs);
  }

  std::size_t memory;
  std::string bytes{};
  std::vector<Entry> entries{};
  std::size_t next_entry = 0;
  std::vector<Run> runs{};
  std::unique_ptr<Merge> merge{};
  bool is_reading = false;
};

ExternalSort::ExternalSort(std::size_t memory) : state_(std::make_unique<State>(memory)) {}
ExternalSort::~ExternalSort() = default;
ExternalSort::ExternalSort(ExternalSort&&) noexcept = default;
ExternalSort& ExternalSort::operator=(ExternalSort&&) noexcept = default;

void ExternalSort::add(Key key, std::string_view record) {
  State& state = *state_;
  // Vectors and strings double their memory as they grow, and a stable sort needs as much again.
  const std::size_t used = 2 * state.bytes.size() + 3 * sizeof(State::Entry) * state.entries.size();
  if (used > state.memory && !state.entries.empty()) state.spill();
  state.entries.push_back({key, state.bytes.size(), record.size()});
  state.bytes += record;
}

bool ExternalSort::next(Key& key, std::string& record) {
  State& state = *state_;
  if (!state.is_reading) state.begin_reading();
  if (state.merge) return state.merge->next(key, record);
  if (state.next_entry == state.entries.size()) return false;
  const State::Entry& entry = state.entries[state.next_entry++];
  key = entry.key;
  record = state.record_of(entry);
  return true;
}

std::size_t ExternalSort::runs() const { return state_->runs.size(); }

}  // namespace silvafit
