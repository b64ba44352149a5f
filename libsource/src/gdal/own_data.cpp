// SPDX-License-Identifier: MIT
#include "gdal/own_data.hpp"

#include <fmt/format.h>
#include <sqlite3.h>

#include <algorithm>
#include <fstream>
#include <memory>
#include <optional>
#include <string_view>
#include <utility>

#include "gdal/session.hpp"
#include "gdal/stored_types.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/base/words.hpp"

namespace silvafit::source {
namespace {

constexpr std::string_view kMemory = ":memory:";
constexpr char kRemedy[] = "add `allow_network` if that is meant";

struct CloseDatabase {
  void operator()(sqlite3* database) const { sqlite3_close_v2(database); }
};
struct FinishStatement {
  void operator()(sqlite3_stmt* statement) const { sqlite3_finalize(statement); }
};
using Database = std::unique_ptr<sqlite3, CloseDatabase>;
using Statement = std::unique_ptr<sqlite3_stmt, FinishStatement>;

/// Functions of GDAL and SpatiaLite that compute with their arguments only.
bool is_of_geometries(const std::string& function) {
  static constexpr std::string_view kNames =
      "area asbinary asgeojson astext aswkt boundary buffer castautomagic casttomulti "
      "casttopoint casttosingle casttoxy centroid contains convexhull coorddimension "
      "crosses difference disjoint distance envelope equals geometryn geometrytype "
      "geomfromtext geomfromwkb glength intersection intersects isempty isvalid m "
      "makepoint makepointz numgeometries numpoints overlaps perimeter setsrid srid "
      "touches transform within x y z";
  const std::string name = in_lower_case(function);
  return name.starts_with("st_") || name.starts_with("mbr") || name == "hstore_get_value" ||
         has_word(kNames, name);
}

/// Virtual tables of SpatiaLite that read their own database.
bool is_of_database(const std::string& module) {
  static constexpr std::string_view kModules =
      "virtualspatialindex virtualelementary virtualknn virtualknn2 virtualnetwork "
      "virtualrouting";
  return has_word(kModules, in_lower_case(module));
}

/// The rest of a message of SQLite behind a beginning.
std::optional<std::string> behind(std::string_view beginning, std::string_view message) {
  if (!message.starts_with(beginning)) return std::nullopt;
  return std::string(message.substr(beginning.size()));
}

void compute_nothing(sqlite3_context* context, int /*count*/, sqlite3_value** /*arguments*/) {
  sqlite3_result_null(context);
}

/// What a query would use beyond its database.
struct Foreign {
  std::string function{};
  std::string module{};
  std::string problem{};  ///< any other message of SQLite
};

/// The first column of a row, in UTF-8 whatever the encoding of the database.
std::string text_of(sqlite3_stmt* statement) {
  const unsigned char* const text = sqlite3_column_text(statement, 0);
  const auto size = static_cast<std::size_t>(sqlite3_column_bytes(statement, 0));
  return text == nullptr ? std::string() : std::string(text, text + size);
}

/// A connection of SQLite itself, without the functions and tables that GDAL adds to each.
class PlainDatabase {
 public:
  explicit PlainDatabase(std::string_view path)
      : no_tables_("OGR_SQLITE_STATIC_VIRTUAL_OGR", "NO") {
    // A database in memory does not exist yet.
    const int flags =
        path == kMemory ? SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE : SQLITE_OPEN_READONLY;
    sqlite3* opened = nullptr;
    const int status = sqlite3_open_v2(std::string(path).c_str(), &opened, flags, nullptr);
    database_.reset(opened);
    is_open_ = status == SQLITE_OK;
  }

  bool is_open() const { return is_open_; }

  /// Prepares a query; functions of geometries become known when it uses them.
  Foreign foreign(const std::string& sql) {
    for (;;) {
      if (prepared(sql)) return {};
      const std::string message = sqlite3_errmsg(database_.get());
      if (auto module = behind("no such module: ", message)) return {.module = *std::move(module)};
      auto function = behind("no such function: ", message);
      if (!function) return {.problem = message};
      if (!is_of_geometries(*function) || !add_function(*function)) {
        return {.function = *std::move(function)};
      }
    }
  }

  /// The names of tables and views; none if the database cannot be read.
  std::optional<std::vector<std::string>> tables() {
    const Statement statement =
        prepared("select name from sqlite_master where type in ('table', 'view')");
    if (!statement) return std::nullopt;
    std::vector<std::string> names;
    int status = SQLITE_ROW;
    while ((status = sqlite3_step(statement.get())) == SQLITE_ROW) {
      names.push_back(text_of(statement.get()));
    }
    if (status != SQLITE_DONE) return std::nullopt;
    return names;
  }

  /// Whether its pages fit together. Rows that break rules of their table are no damage, and
  /// neither are rules with functions of other programs, which cannot be checked.
  bool is_sound() {
    const Statement statement = prepared("pragma quick_check");
    if (!statement) return true;
    int status = SQLITE_ROW;
    while ((status = sqlite3_step(statement.get())) == SQLITE_ROW) {
      const std::string message = text_of(statement.get());
      const bool is_of_rules =
          message.starts_with("NULL value in") || message.starts_with("CHECK constraint failed in");
      if (message != "ok" && !is_of_rules) return false;
    }
    return status == SQLITE_DONE;
  }

  bool run(const std::string& sql) {
    return sqlite3_exec(database_.get(), sql.c_str(), nullptr, nullptr, nullptr) == SQLITE_OK;
  }

 private:
  /// Null if the query is wrong.
  Statement prepared(const std::string& sql) {
    sqlite3_stmt* statement = nullptr;
    sqlite3_prepare_v2(database_.get(), sql.c_str(), -1, &statement, nullptr);
    return Statement(statement);
  }
  bool add_function(const std::string& name) {
    if (std::ranges::find(added_, name) != added_.end()) return false;
    added_.push_back(name);
    return sqlite3_create_function_v2(database_.get(),
                                      name.c_str(),
                                      -1,
                                      SQLITE_UTF8 | SQLITE_DETERMINISTIC | SQLITE_INNOCUOUS,
                                      nullptr,
                                      compute_nothing,
                                      nullptr,
                                      nullptr,
                                      nullptr) == SQLITE_OK;
  }

  Setting no_tables_;
  Database database_{};
  bool is_open_ = false;
  std::vector<std::string> added_{};
};

void require_own_query(PlainDatabase& database, const std::string& sql) {
  const Foreign foreign = database.foreign(sql);
  if (foreign.function.empty()) return;
  throw UsageError(
      fmt::format(
          "the function {} may read other files or a network; {}", foreign.function, kRemedy),
      {.column = "`sql`"});
}

}  // namespace

bool is_sqlite_file(const std::string& path) {
  static constexpr std::string_view kBeginning("SQLite format 3\0", 16);
  std::string bytes(kBeginning.size(), ' ');
  std::ifstream file(path, std::ios::binary);
  file.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  return file.good() && bytes == kBeginning;
}

bool is_sound_database(const std::string& path) {
  PlainDatabase database(path);
  return database.is_open() && database.is_sound();
}

bool require_own_data(const std::string& path,
                      const TableChoice& choice,
                      const std::string& place) {
  PlainDatabase database(path);
  const auto tables = database.is_open() ? database.tables() : std::nullopt;
  if (!tables) return false;
  for (const std::string& table : *tables) {
    const Foreign foreign = database.foreign("select * from " + quoted_name(table));
    const bool is_harmless = foreign.module.empty() || is_of_database(foreign.module);
    if (foreign.function.empty() && is_harmless) continue;
    const std::string what = foreign.module.empty() ? "uses the function " + foreign.function
                                                    : "is a virtual table of " + foreign.module;
    throw InputError(fmt::format("{} {}, which may read other files or a network; {}",
                                 quoted_name(table),
                                 what,
                                 kRemedy),
                     {.file = place});
  }
  if (!choice.sql.empty()) require_own_query(database, choice.sql);
  return true;
}

std::string require_own_layers(const std::string& sql, const std::vector<QueriedLayer>& layers) {
  PlainDatabase database(kMemory);
  for (const QueriedLayer& layer : layers) {
    std::string columns;
    for (const std::string& column : layer.columns) {
      columns += (columns.empty() ? "" : ", ") + quoted_name(column);
    }
    database.run(fmt::format("create table {} ({})", quoted_name(layer.name), columns));
  }
  require_own_query(database, sql);
  return database.foreign(sql).problem;
}

}  // namespace silvafit::source
