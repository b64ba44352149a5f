// SPDX-License-Identifier: MIT
// File descriptors, and an output stream over one.
#pragma once

#include <array>
#include <ostream>
#include <streambuf>

namespace silvafit {

/// Closes a descriptor at the end of its scope.
class Descriptor {
 public:
  explicit Descriptor(int number = -1) : number_(number) {}
  ~Descriptor() { close(); }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;

  int number() const { return number_; }
  /// \return whether the system closed it without an error
  bool close();

 private:
  int number_;
};

/// Writes to a descriptor that the caller opens and closes. Unlike std::ofstream it keeps the
/// reason of the first failure.
class DescriptorBuffer final : public std::streambuf {
 public:
  explicit DescriptorBuffer(int descriptor);

  /// errno of the first write that failed; 0 if none failed.
  int error_number() const { return error_number_; }

 protected:
  int_type overflow(int_type c) override;
  std::streamsize xsputn(const char* bytes, std::streamsize count) override;
  int sync() override;

 private:
  bool write_buffered();
  bool write_all(const char* bytes, std::size_t count);

  static constexpr std::size_t kBlock = std::size_t{1} << 16U;
  int descriptor_;
  int error_number_ = 0;
  std::array<char, kBlock> block_{};
};

}  // namespace silvafit
