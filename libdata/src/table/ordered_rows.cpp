// SPDX-License-Identifier: MIT
#include "silvafit/data/ordered_rows.hpp"

namespace silvafit::data {

OrderedRows::OrderedRows(std::ostream& stream, bool sorts) : stream_(stream) {
  if (sorts) sort_.emplace();
}

void OrderedRows::add(std::size_t line, std::string_view text) {
  sort_ ? sort_->add({.first = line}, text) : write(text);
}

void OrderedRows::write(std::string_view text) {
  constexpr std::size_t kFlushAt = std::size_t{1} << 18U;
  buffer_ += text;
  if (buffer_.size() >= kFlushAt) flush();
}

void OrderedRows::flush() {
  stream_.write(buffer_.data(), static_cast<std::streamsize>(buffer_.size()));
  buffer_.clear();
}

void OrderedRows::finish() {
  if (sort_) {
    ExternalSort::Key key;
    std::string text;
    while (sort_->next(key, text)) write(text);
  }
  flush();
}

}  // namespace silvafit::data
