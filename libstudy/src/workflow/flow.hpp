// SPDX-License-Identifier: MIT
// The parts of a command's table: the table itself or, to save memory, parts of whole groups one
// after another. A part is read while the caller works on the one before.
#pragma once

#include <chrono>
#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "silvafit/base/read_ahead.hpp"
#include "silvafit/data/csv.hpp"
#include "silvafit/data/table_parts.hpp"
#include "silvafit/stand/inventory.hpp"
#include "silvafit/study/callbacks.hpp"
#include "silvafit/study/unit_settings.hpp"

namespace silvafit::study {

using Clock = std::chrono::steady_clock;

inline double seconds_since(Clock::time_point begin) {
  return std::chrono::duration<double>(Clock::now() - begin).count();
}

/// How a command reads.
struct FlowSettings {
  bool is_in_parts = false;
  std::size_t rows = data::TablePartsOptions{}.rows;  ///< of a part, at least
  unsigned threads = 0;                               ///< 1: no reading ahead
};

/// The trees of an inventory, in parts of whole plots. All notes are given with a whole table, or
/// after the last part.
/// \param options  requirements of the caller; the settings are filled in
/// \throws as stand::InventoryBatches
stand::InventoryBatches inventory_flow(const data::TableSource& source,
                                       const ReadingSettings& settings,
                                       const stand::InventoryOptions& options,
                                       const FlowSettings& flow = {},
                                       const NoteCallback& note = {});

/// The rows of a table, in parts of whole groups.
class TableFlow {
 public:
  /// \param group  gets the header and returns the name of the column whose groups stay whole, if
  ///               the file has such a column; empty: rows are independent
  /// \throws in parts UsageError if the source is no CSV file; else as data::TableParts
  TableFlow(const data::TableSource& source,
            const ReadingSettings& settings,
            const FlowSettings& flow,
            const std::function<std::string(const std::vector<std::string>&)>& group,
            const NoteCallback& note = {});

  /// The next part; nothing after the last.
  std::optional<data::TableSource> next() { return ahead_.next(); }
  bool is_in_parts() const { return parts_.has_value(); }
  bool is_sorted() const { return parts_ && parts_->is_sorted(); }
  /// Of all parts; 0 for a table as a whole.
  std::size_t rows() const { return parts_ ? parts_->rows() : 0; }

 private:
  std::optional<data::TableSource> read();

  std::optional<data::TableSource> whole_{};
  std::optional<data::TableParts> parts_{};
  ReadAhead<std::optional<data::TableSource>> ahead_;
};

}  // namespace silvafit::study
