// SPDX-License-Identifier: MIT
// The C data interface of Apache Arrow: https://arrow.apache.org/docs/format/CDataInterface.html
#include "gdal/arrow_columns.hpp"

#include <fmt/format.h>
#include <ogr_recordbatch.h>
#include <ogrsf_frmts.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>
#include <memory>
#include <optional>
#include <type_traits>

#include "gdal/session.hpp"
#include "silvafit/base/error.hpp"

namespace silvafit::source {
namespace {

/// A structure of Arrow, which has its own release function.
template <typename Structure>
struct Owned : Structure {
  Owned() : Structure{} {}
  ~Owned() {
    if (this->release != nullptr) this->release(this);
  }
  Owned(const Owned&) = delete;
  Owned& operator=(const Owned&) = delete;
};
using Batch = Owned<ArrowArray>;

/// One column of a batch.
struct Cells {
  const ArrowArray& array;
  std::size_t first;  ///< of the batch's rows within the buffers

  bool is_null(std::size_t row) const {
    const auto* const valid = static_cast<const std::uint8_t*>(array.buffers[0]);
    if (valid == nullptr || array.null_count == 0) return false;
    const std::size_t i = first + row;
    return ((valid[i / 8] >> (i % 8)) & 1U) == 0;
  }
  template <typename Value>
  Value value(std::size_t row) const {
    return static_cast<const Value*>(array.buffers[1])[first + row];
  }
  bool bit(std::size_t row) const {
    const std::size_t i = first + row;
    return ((static_cast<const std::uint8_t*>(array.buffers[1])[i / 8] >> (i % 8)) & 1U) != 0;
  }
  template <typename Offset>
  std::string_view bytes(std::size_t row) const {
    const auto* const offsets = static_cast<const Offset*>(array.buffers[1]) + first + row;
    const auto* const data = static_cast<const char*>(array.buffers[2]);
    return {data + offsets[0], static_cast<std::size_t>(offsets[1] - offsets[0])};
  }
};

/// The shortest decimal number that is this float: 12.3, not 12.300000190734863.
double as_written(float value) {
  double parsed = value;
  const std::string text = fmt::format("{}", value);
  return std::sscanf(text.c_str(), "%lf", &parsed) == 1 ? parsed : value;
}

std::string date_text(std::chrono::sys_days day) {
  const std::chrono::year_month_day date(day);
  return fmt::format("{:04}-{:02}-{:02}",
                     static_cast<int>(date.year()),
                     static_cast<unsigned>(date.month()),
                     static_cast<unsigned>(date.day()));
}

std::string clock_text(std::int64_t milliseconds) {
  const std::int64_t seconds = milliseconds / 1000;
  std::string text =
      fmt::format("{:02}:{:02}:{:02}", seconds / 3600, seconds / 60 % 60, seconds % 60);
  if (milliseconds % 1000 != 0) text += fmt::format(".{:03}", milliseconds % 1000);
  return text;
}

std::string time_text(std::int64_t milliseconds) {
  const std::chrono::sys_time<std::chrono::milliseconds> time{
      std::chrono::milliseconds(milliseconds)};
  const auto day = std::chrono::floor<std::chrono::days>(time);
  return date_text(day) + "T" + clock_text((time - day).count());
}

/// Grows a column by batches.
class Column {
 public:
  virtual ~Column() = default;
  virtual void append(const Cells& cells, std::size_t rows) = 0;
  virtual std::variant<std::vector<double>, data::TextColumn> finish() = 0;
};

/// A column of what a function makes of each cell: numbers or texts.
template <typename Convert>
class ConvertedColumn : public Column {
 public:
  explicit ConvertedColumn(Convert convert) : convert_(convert) {}
  void append(const Cells& cells, std::size_t rows) override {
    for (std::size_t row = 0; row < rows; ++row) {
      if constexpr (kIsNumber) {
        values_.push_back(cells.is_null(row) ? data::kMissing : convert_(cells, row));
      } else {
        cells.is_null(row) ? values_.append_missing() : values_.append(convert_(cells, row));
      }
    }
  }
  std::variant<std::vector<double>, data::TextColumn> finish() override {
    return std::move(values_);
  }

 private:
  static constexpr bool kIsNumber =
      std::is_arithmetic_v<std::invoke_result_t<Convert, const Cells&, std::size_t>>;

  Convert convert_;
  std::conditional_t<kIsNumber, std::vector<double>, data::TextColumn> values_;
};

/// Numbers of 64 bits, such as the record numbers of databases.
class LongColumn : public Column {
 public:
  void append(const Cells& cells, std::size_t rows) override {
    constexpr std::int64_t kLargest = std::int64_t{1} << 53;
    for (std::size_t row = 0; row < rows; ++row) {
      const bool is_null = cells.is_null(row);
      const std::int64_t value = is_null ? 0 : cells.value<std::int64_t>(row);
      is_exact_ = is_exact_ && value >= -kLargest && value <= kLargest;
      values_.push_back(value);
      is_null_.push_back(is_null ? 1 : 0);
    }
  }
  std::variant<std::vector<double>, data::TextColumn> finish() override {
    if (is_exact_) {
      std::vector<double> numbers;
      numbers.reserve(values_.size());
      for (std::size_t i = 0; i < values_.size(); ++i) {
        numbers.push_back(is_null_[i] != 0 ? data::kMissing : static_cast<double>(values_[i]));
      }
      return numbers;
    }
    data::TextColumn texts;
    for (std::size_t i = 0; i < values_.size(); ++i) {
      is_null_[i] != 0 ? texts.append_missing() : texts.append(fmt::format("{}", values_[i]));
    }
    return texts;
  }

 private:
  std::vector<std::int64_t> values_;
  std::vector<char> is_null_;
  bool is_exact_ = true;
};

/// Milliseconds in the unit of a format of time stamps, such as tsm:UTC.
std::int64_t milliseconds(std::int64_t value, char unit) {
  switch (unit) {
    case 's':
      return value * 1000;
    case 'u':
      return value / 1000;
    case 'n':
      return value / 1000000;
    default:
      return value;
  }
}

template <typename Convert>
std::unique_ptr<Column> converted(Convert convert) {
  return std::make_unique<ConvertedColumn<Convert>>(convert);
}

template <typename Value>
std::unique_ptr<Column> numbers() {
  return converted(
      [](const Cells& cells, std::size_t row) -> double { return cells.value<Value>(row); });
}

/// Days since 1970-01-01.
constexpr std::string_view kDate = "tdD";

/// A column of a format; null if it is not read.
std::unique_ptr<Column> column_of(std::string_view format) {
  using C = const Cells&;
  using R = std::size_t;
  if (format == "b") return converted([](C c, R row) { return c.bit(row) ? 1.0 : 0.0; });
  if (format == "c") return numbers<std::int8_t>();
  if (format == "C") return numbers<std::uint8_t>();
  if (format == "s") return numbers<std::int16_t>();
  if (format == "S") return numbers<std::uint16_t>();
  if (format == "i") return numbers<std::int32_t>();
  if (format == "I") return numbers<std::uint32_t>();
  if (format == "f") return converted([](C c, R row) { return as_written(c.value<float>(row)); });
  if (format == "g") return numbers<double>();
  if (format == "l") return std::make_unique<LongColumn>();
  if (format == "u") return converted([](C c, R row) { return c.bytes<std::int32_t>(row); });
  if (format == "U") return converted([](C c, R row) { return c.bytes<std::int64_t>(row); });
  if (format == kDate) {
    return converted([](C c, R row) {
      return date_text(std::chrono::sys_days(std::chrono::days(c.value<std::int32_t>(row))));
    });
  }
  if (format == "ttm") {
    return converted([](C c, R row) { return clock_text(c.value<std::int32_t>(row)); });
  }
  if (format.starts_with("ts") && format.size() > 2) {
    const char unit = format[2];
    return converted(
        [unit](C c, R row) { return time_text(milliseconds(c.value<std::int64_t>(row), unit)); });
  }
  return nullptr;
}

/// Whether the metadata of a column, in Arrow's format, name the extension of geometries.
bool is_geometry(const ArrowSchema& column) {
  if (column.metadata == nullptr) return false;
  const char* at = column.metadata;
  const auto next_size = [&at] {
    std::int32_t size = 0;
    std::memcpy(&size, at, sizeof size);
    at += sizeof size;
    return size;
  };
  const std::int32_t pairs = next_size();
  for (std::int32_t i = 0; i < 2 * pairs; ++i) {
    const std::int32_t size = next_size();
    const std::string_view text(at, static_cast<std::size_t>(size));
    if (text == "ogc.wkb" || text == "geoarrow.wkb") return true;
    at += size;
  }
  return false;
}

/// Reads one layer; an object, because its functions share much state.
class Reader {
 public:
  Reader(OGRLayer& layer,
         const std::string& row_id,
         const GeometrySink& geometry,
         const BatchCheck& check,
         const std::string& file)
      : geometry_(geometry), check_(check), row_id_(row_id), file_(file) {
    // NOLINTNEXTLINE(cppcoreguidelines-pro-type-reinterpret-cast): GDAL's handle of a layer
    auto* const handle = reinterpret_cast<OGRLayerH>(&layer);
    if (!OGR_L_GetArrowStream(handle, &stream_, nullptr) ||
        stream_.get_schema(&stream_, &schema_) != 0) {
      fail(1);
    }
    name_of_row_ids_ = layer.GetFIDColumn();
    for (std::int64_t i = 0; i < schema_.n_children; ++i) add_column(*schema_.children[i]);
  }

  LayerColumns read();

 private:
  [[noreturn]] void fail(std::size_t row) const {
    throw InputError("reading the rows failed from here; the file may be damaged",
                     {.file = file_, .line = row});
  }
  void add_column(const ArrowSchema& schema);
  void append(const Batch& batch);
  void pass_geometries(const Cells& cells, std::size_t rows) const;

  struct Field {
    std::string name{};
    std::unique_ptr<Column> column{};  ///< null if the column is not read
    bool is_geometry = false;
    bool is_wide = false;  ///< offsets of 64 bits
    bool is_date = false;
    bool has_early_dates = false;
  };

  KeptMessages messages_{};
  const GeometrySink& geometry_;
  const BatchCheck& check_;
  const std::string& row_id_;
  const std::string& file_;
  std::string name_of_row_ids_{};
  Owned<ArrowArrayStream> stream_{};
  Owned<ArrowSchema> schema_{};
  std::vector<Field> fields_{};
  LayerColumns result_{};
};

void Reader::add_column(const ArrowSchema& schema) {
  Field field{.name = schema.name};
  const std::string_view format = schema.format;
  // GDAL puts row ids first, under their column's name or its own.
  const bool is_row_id = fields_.empty() && format == "l" &&
                         (field.name == name_of_row_ids_ || field.name == "OGC_FID");
  if ((format == "z" || format == "Z") && is_geometry(schema)) {
    field.is_geometry = true;
    field.is_wide = format == "Z";
  } else if (schema.dictionary != nullptr) {
    result_.unread.push_back(field.name);
  } else if (!is_row_id || field.name == row_id_) {
    field.column = column_of(format);
    field.is_date = format == kDate;
    if (!field.column) result_.unread.push_back(field.name);
  }
  fields_.push_back(std::move(field));
}

void Reader::pass_geometries(const Cells& cells, std::size_t rows) const {
  const bool is_wide = std::ranges::any_of(fields_, &Field::is_wide);
  for (std::size_t row = 0; row < rows; ++row) {
    std::string_view bytes;
    if (!cells.is_null(row)) {
      bytes = is_wide ? cells.bytes<std::int64_t>(row) : cells.bytes<std::int32_t>(row);
    }
    // NOLINTNEXTLINE(cppcoreguidelines-pro-type-reinterpret-cast): bytes are bytes
    geometry_({reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size()});
  }
}

void Reader::append(const Batch& batch) {
  const auto rows = static_cast<std::size_t>(batch.length);
  for (std::size_t i = 0; i < fields_.size(); ++i) {
    const ArrowArray& array = *batch.children[i];
    const Cells cells{array, static_cast<std::size_t>(batch.offset + array.offset)};
    if (fields_[i].is_geometry) {
      if (geometry_) pass_geometries(cells, rows);
    } else if (fields_[i].column) {
      fields_[i].column->append(cells, rows);
      for (std::size_t row = 0; row < rows && fields_[i].is_date; ++row) {
        const bool is_early = !cells.is_null(row) && cells.value<std::int32_t>(row) <= 0;
        fields_[i].has_early_dates = fields_[i].has_early_dates || is_early;
      }
    }
  }
  result_.rows += rows;
}

LayerColumns Reader::read() {
  for (;;) {
    Batch batch;
    const bool has_failed = stream_.get_next(&stream_, &batch) != 0;
    check_(result_.rows, fields_.size());
    // After an error in a damaged file GDAL may return batches without end.
    if (has_failed || messages_.has_errors()) fail(result_.rows + 1);
    if (batch.release == nullptr) break;
    append(batch);
  }
  for (Field& field : fields_) {
    if (field.column) {
      if (field.has_early_dates) result_.early_dates.push_back(field.name);
      result_.columns.push_back({.name = field.name, .values = field.column->finish()});
    }
  }
  return std::move(result_);
}

}  // namespace

LayerColumns read_columns(OGRLayer& layer,
                          const std::string& row_id,
                          const GeometrySink& geometry,
                          const BatchCheck& check,
                          const std::string& file) {
  return Reader(layer, row_id, geometry, check, file).read();
}

}  // namespace silvafit::source
