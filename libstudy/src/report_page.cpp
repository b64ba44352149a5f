// SPDX-License-Identifier: MIT
#include "silvafit/study/report_page.hpp"

#include <kainjow/mustache.hpp>
#include <nlohmann/json.hpp>

#include "silvafit/base/atomic_file.hpp"
#include "silvafit/base/error.hpp"

namespace silvafit {

namespace {

/// U+2028 and U+2029 share their first two bytes of UTF-8 and were line ends in scripts.
constexpr std::string_view kSeparatorLead = "\xE2\x80";

/// The escape of what stands at the position, and how many bytes it replaces; empty if none is
/// needed.
struct Escape {
  std::string_view text{};
  std::size_t replaced = 1;
};

Escape escape_at(std::string_view json, std::size_t position) {
  switch (json[position]) {
    case '<':
      return {"\\u003c"};
    case '>':
      return {"\\u003e"};
    case '&':
      return {"\\u0026"};
    case '\xE2':
      break;
    default:
      return {};
  }
  const std::string_view sign = json.substr(position, 3);
  if (sign.size() < 3 || !sign.starts_with(kSeparatorLead)) return {};
  if (sign[2] == '\xA8') return {"\\u2028", 3};
  if (sign[2] == '\xA9') return {"\\u2029", 3};
  return {};
}

kainjow::mustache::mustache read_template(const std::filesystem::path& path) {
  const std::string text = read_file(path);
  kainjow::mustache::mustache page(text);
  const Place place{.file = path.string()};
  if (!page.is_valid())
    throw InputError("cannot be read as a template: " + page.error_message(), place);
  // Another HTML file would be copied without the data, and nobody would be told.
  if (text.find("& data ") == std::string::npos) {
    throw InputError("is not the template of the report page; reinstall silvafit", place);
  }
  return page;
}

}  // namespace

std::string escape_for_script(std::string_view json) {
  std::string escaped;
  escaped.reserve(json.size() + json.size() / 64);
  for (std::size_t position = 0; position < json.size();) {
    const Escape escape = escape_at(json, position);
    if (escape.text.empty()) {
      escaped += json[position];
    } else {
      escaped += escape.text;
    }
    position += escape.replaced;
  }
  return escaped;
}

void write_report_page(const std::filesystem::path& template_path,
                       std::string_view data_json,
                       const std::string& title,
                       const std::filesystem::path& out_path) {
  if (!nlohmann::json::accept(data_json))
    throw UsageError("the data of a report page must be JSON");
  kainjow::mustache::mustache page = read_template(template_path);
  kainjow::mustache::data values;
  values.set("title", title);
  values.set("data", escape_for_script(data_json));
  write_file(out_path, page.render(values));
}

}  // namespace silvafit
