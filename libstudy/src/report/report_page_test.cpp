// SPDX-License-Identifier: MIT
#include "silvafit/study/report_page.hpp"

#include <unistd.h>

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "reference.hpp"
#include "report/script_text.hpp"
#include "silvafit/base/atomic_file.hpp"
#include "silvafit/base/error.hpp"

namespace fs = std::filesystem;
using Catch::Matchers::Contains;
using silvafit::study::escape_for_script;
using silvafit::study::write_report_page;

namespace {

struct Folder {
  fs::path path = fs::temp_directory_path() / ("silvafit-report-" + std::to_string(::getpid()));
  Folder() { fs::create_directories(path); }
  ~Folder() { fs::remove_all(path); }

  fs::path file(const std::string& name, std::string_view content) const {
    silvafit::write_file(path / name, content);
    return path / name;
  }
};

/// A minimal template; its script has characters that a template engine might change.
constexpr std::string_view kTemplate =
    "{{=<% %>=}}<!doctype html>\n<title><% title %></title>\n"
    "<script type=\"application/json\" id=\"report-data\"><%& data %></script>\n"
    "<script>\n  const f = ({a: {{}}, b}) => `${a}` + \"{{title}}\";\n\n</script>\n";

std::string between(const std::string& text, const std::string& start, const std::string& end) {
  const std::size_t from = text.find(start) + start.size();
  return text.substr(from, text.find(end, from) - from);
}

/// The page's data element as a browser reads it: everything up to the first `</script`.
nlohmann::json data_of(const std::string& page) {
  return nlohmann::json::parse(between(page, "id=\"report-data\">", "</script"));
}

}  // namespace

TEST_CASE("filling changes only the tags of a template") {
  const Folder folder;
  write_report_page(folder.file("t.html", kTemplate),
                    R"({"n": 1})",
                    "Fir & beech",
                    folder.path / "out" / "r.html");
  CHECK(silvafit::read_file(folder.path / "out" / "r.html") ==
        "<!doctype html>\n<title>Fir &amp; beech</title>\n"
        "<script type=\"application/json\" id=\"report-data\">{\"n\": 1}</script>\n"
        "<script>\n  const f = ({a: {{}}, b}) => `${a}` + \"{{title}}\";\n\n</script>\n");
}

TEST_CASE("a title that is not UTF-8 makes a page that is") {
  const Folder folder;
  write_report_page(
      folder.file("t.html", kTemplate), "{}", "S\u00e9ne\xff", folder.path / "r.html");
  const std::string page = silvafit::read_file(folder.path / "r.html");
  CHECK(between(page, "<title>", "</title>") == "S\u00e9ne\uFFFD");
}

TEST_CASE("text in the data cannot end its element or be read as a tag") {
  const Folder folder;
  const nlohmann::json data = {
      {"name", "</script><!-- <script> & \u2028\u2029 \u20AC <% title %> {{data}} \\u003c \"q\""}};
  write_report_page(
      folder.file("t.html", kTemplate), data.dump(), "</title><script>", folder.path / "r.html");
  const std::string page = silvafit::read_file(folder.path / "r.html");
  CHECK(data_of(page) == data);
  const std::string island = between(page, "id=\"report-data\">", "</script>\n<script>");
  CHECK(island.find_first_of("<>&") == std::string::npos);
  CHECK(between(page, "<title>", "</title>") == "&lt;/title&gt;&lt;script&gt;");
}

TEST_CASE("escaping changes nothing else and does not read past the end") {
  CHECK(escape_for_script("").empty());
  CHECK(escape_for_script("{\"a\": [1e-9, null, \"\u00e4 \u2014 \u20AC\"]}") ==
        "{\"a\": [1e-9, null, \"\u00e4 \u2014 \u20AC\"]}");
  CHECK(escape_for_script("<\xE2\x80") == "\\u003c\xE2\x80");
}

TEST_CASE("data that are not JSON, and files that are not the template, are errors") {
  const Folder folder;
  const fs::path page = folder.file("t.html", kTemplate);
  const fs::path out = folder.path / "r.html";
  CHECK_THROWS_AS(write_report_page(page, "{\"a\": NaN}", "t", out), silvafit::UsageError);
  CHECK_THROWS_WITH(write_report_page(folder.file("o.html", "<p>other</p>"), "{}", "t", out),
                    Contains("o.html") && Contains("not the template"));
  CHECK_THROWS_WITH(write_report_page(folder.file("b.html", "{{#open}} & data "), "{}", "t", out),
                    Contains("b.html"));
  CHECK_THROWS_AS(write_report_page(folder.path / "none.html", "{}", "t", out),
                  silvafit::InputError);
  CHECK_FALSE(fs::exists(out));
}

TEST_CASE("the bundled page takes the example's data") {
  const fs::path bundled = silvafit::test::data_file("viewer/report.html");
  if (!fs::exists(bundled)) {
    WARN("skipped: the report page was not built (SILVAFIT_BUILD_VIEWER)");
    return;
  }
  const Folder folder;
  const std::string example =
      silvafit::read_file(silvafit::test::source_file("viewer/test/example.json"));
  write_report_page(bundled, example, "Example", folder.path / "r.html");
  const std::string page = silvafit::read_file(folder.path / "r.html");
  CHECK(data_of(page) == nlohmann::json::parse(example));
  CHECK_THAT(page, Catch::Matchers::StartsWith("<!doctype html>"));
  CHECK(page.find("<%") == std::string::npos);
  // The page must be the template plus the data.
  CHECK(page.size() >= fs::file_size(bundled) + example.size() - 200);
}
