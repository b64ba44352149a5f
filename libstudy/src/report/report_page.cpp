// SPDX-License-Identifier: MIT
#include "silvafit/study/report_page.hpp"

#include <kainjow/mustache.hpp>
#include <nlohmann/json.hpp>

#include "report/script_text.hpp"
#include "silvafit/base/atomic_file.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/base/json_text.hpp"

namespace silvafit::study {
namespace {

kainjow::mustache::mustache read_template(const std::filesystem::path& path) {
  const std::string text = read_file(path);
  kainjow::mustache::mustache page(text);
  const Place place{.file = path.string()};
  if (!page.is_valid())
    throw InputError("cannot be read as a template: " + page.error_message(), place);
  // Another HTML file would be copied without the data and without an error.
  if (text.find("& data ") == std::string::npos) {
    throw InputError("is not the template of the report page; reinstall silvafit", place);
  }
  return page;
}

/// The text as JSON would have it, where bytes that are not UTF-8 are replaced: a browser may
/// decode a page with other bytes in another encoding.
std::string as_utf8(const std::string& text) {
  return nlohmann::json::parse(json_text(nlohmann::json(text))).get<std::string>();
}

}  // namespace

void write_report_page(const std::filesystem::path& template_path,
                       std::string_view data_json,
                       const std::string& title,
                       const std::filesystem::path& out_path) {
  if (!nlohmann::json::accept(data_json))
    throw UsageError("the data of a report page must be JSON");
  kainjow::mustache::mustache page = read_template(template_path);
  kainjow::mustache::data values;
  values.set("title", as_utf8(title));
  values.set("data", escape_for_script(data_json));
  write_file(out_path, page.render(values));
}

}  // namespace silvafit::study
