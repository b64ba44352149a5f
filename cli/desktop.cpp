// SPDX-License-Identifier: MIT
#include <cstdio>
#include <filesystem>

#include "program.hpp"
#include "silvafit/base/system.hpp"
#include "silvafit/source/open_table.hpp"
#include "standard_output.hpp"

namespace silvafit::cli {
namespace {

namespace fs = std::filesystem;

constexpr const char* kFirstSteps =
    "Drop the table of your trees (CSV or workbook) on silvafit.exe. It fits models and writes\n"
    "tables and a report into a folder beside the file, and opens the report.\n"
    "\n"
    "Or open a terminal in the folder of the table, and type:\n"
    "  silvafit study inventory.csv --out results    models, tables and a report\n"
    "  silvafit view results                         the stand in 3D, in a browser\n"
    "  silvafit --help                               all commands\n";

/// The folder of the study of a file that was dropped on the program; empty if none was.
fs::path folder_of_dropped(const std::vector<std::string>& words) {
  if (!system::takes_dropped_files() || words.size() != 2) return {};
  const fs::path file = words.back();
  const std::string ending = file.extension().string();
  std::error_code ignored;
  const bool is_table = ending == ".csv" || ending == ".CSV" || source::is_layered(words.back());
  return is_table && fs::is_regular_file(file, ignored)
             ? fs::path(file).replace_extension() += "-study"
             : fs::path();
}

}  // namespace

int run_as_started(const std::vector<std::string>& words,
                   const std::function<int(const std::vector<std::string>&)>& run) {
  const fs::path folder = folder_of_dropped(words);
  int status = 0;
  if (words.size() == 1 && system::has_own_console()) {
    print_visible(kFirstSteps);
  } else if (folder.empty()) {
    status = run(words);
  } else {
    status = run({words.front(), "study", words.back(), "--out", folder.string()});
    if (status == 0) system::open_in_browser(fs::absolute(folder) / "report.html");
  }
  if (system::has_own_console()) {
    print_visible("\nPress Enter to close this window.");
    std::fflush(stdout);
    std::getchar();
  }
  return status;
}

}  // namespace silvafit::cli
