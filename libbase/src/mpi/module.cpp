// SPDX-License-Identifier: MIT
// Ranks by MPI.
#include <mpi.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <thread>

#include "rank_module.hpp"

namespace silvafit {
namespace {

class MpiRanks : public Ranks {
 public:
  MpiRanks() {
    int provided = 0;
    // Threads compute; only the first one exchanges bytes.
    MPI_Init_thread(nullptr, nullptr, MPI_THREAD_FUNNELED, &provided);
    MPI_Comm_rank(MPI_COMM_WORLD, &rank_);
    MPI_Comm_size(MPI_COMM_WORLD, &size_);
    std::atexit([] {
      int is_ended = 0;
      MPI_Finalized(&is_ended);
      if (is_ended == 0) MPI_Finalize();
    });
  }

  std::size_t rank() const override { return static_cast<std::size_t>(rank_); }
  std::size_t size() const override { return static_cast<std::size_t>(size_); }

  std::vector<std::string> gather(std::string_view own) override {
    const std::uint64_t own_size = own.size();
    std::vector<std::uint64_t> sizes(size());
    MPI_Allgather(&own_size, 1, MPI_UINT64_T, sizes.data(), 1, MPI_UINT64_T, MPI_COMM_WORLD);
    std::vector<std::string> all(size());
    for (std::size_t from = 0; from < size(); ++from) {
      all[from] = from == rank() ? std::string(own) : std::string(sizes[from], '\0');
      send_to_all(all[from], static_cast<int>(from));
    }
    return all;
  }

  bool all_come_here() override {
    MPI_Request request = MPI_REQUEST_NULL;
    MPI_Ibarrier(MPI_COMM_WORLD, &request);
    constexpr int kTries = 300;
    constexpr auto kPause = std::chrono::milliseconds(10);
    for (int i = 0; i < kTries; ++i) {
      int is_done = 0;
      MPI_Test(&request, &is_done, MPI_STATUS_IGNORE);
      if (is_done != 0) return true;
      std::this_thread::sleep_for(kPause);
    }
    return false;
  }

  [[noreturn]] void end_job(int status) override {
    MPI_Abort(MPI_COMM_WORLD, status);
    std::_Exit(status);
  }

 private:
  /// Numbers of bytes are ints in MPI, so that long texts go in pieces.
  void send_to_all(std::string& bytes, int from) {
    constexpr std::size_t kPiece = std::size_t{1} << 30U;
    for (std::size_t begin = 0; begin < bytes.size(); begin += kPiece) {
      const std::size_t count = std::min(kPiece, bytes.size() - begin);
      MPI_Bcast(bytes.data() + begin, static_cast<int>(count), MPI_BYTE, from, MPI_COMM_WORLD);
    }
  }

  int rank_ = 0;
  int size_ = 1;
};

}  // namespace
}  // namespace silvafit

extern "C" __attribute__((visibility("default"))) silvafit::Ranks* silvafit_mpi_ranks() {
  static silvafit::MpiRanks ranks;
  return &ranks;
}
