// SPDX-License-Identifier: MIT
#include "descriptor_stream.hpp"

#include <cerrno>
#include <cstring>
#include <utility>

#include "silvafit/base/system.hpp"

namespace silvafit {

bool Descriptor::close() {
  const int number = std::exchange(number_, -1);
  return number < 0 || system::close(number);
}

DescriptorBuffer::DescriptorBuffer(int descriptor) : descriptor_(descriptor) {
  setp(block_.data(), block_.data() + block_.size());
}

bool DescriptorBuffer::write_all(const char* bytes, std::size_t count) {
  while (count > 0 && error_number_ == 0) {
    const std::ptrdiff_t written = system::write(descriptor_, bytes, count);
    if (written >= 0) {
      bytes += written;
      count -= static_cast<std::size_t>(written);
    } else {
      error_number_ = errno;
    }
  }
  return error_number_ == 0;
}

bool DescriptorBuffer::write_buffered() {
  const auto count = static_cast<std::size_t>(pptr() - pbase());
  setp(block_.data(), block_.data() + block_.size());
  return write_all(block_.data(), count);
}

std::streambuf::int_type DescriptorBuffer::overflow(int_type c) {
  if (!write_buffered()) return traits_type::eof();
  if (traits_type::eq_int_type(c, traits_type::eof())) return traits_type::not_eof(c);
  return sputc(traits_type::to_char_type(c));
}

std::streamsize DescriptorBuffer::xsputn(const char* bytes, std::streamsize count) {
  if (count <= epptr() - pptr()) {
    std::memcpy(pptr(), bytes, static_cast<std::size_t>(count));
    pbump(static_cast<int>(count));
    return count;
  }
  const bool is_written = write_buffered() && write_all(bytes, static_cast<std::size_t>(count));
  return is_written ? count : 0;
}

int DescriptorBuffer::sync() { return write_buffered() ? 0 : -1; }

}  // namespace silvafit
