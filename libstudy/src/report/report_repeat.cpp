// SPDX-License-Identifier: MIT
#include "report/report_repeat.hpp"

#include <fmt/format.h>

#include <Eigen/Core>
#include <boost/version.hpp>

#include "silvafit/base/atomic_file.hpp"
#include "silvafit/base/fingerprint.hpp"

namespace silvafit::study {
namespace {

using nlohmann::ordered_json;

std::string compiler() {
#if defined(__clang__)
  return fmt::format("clang {}.{}.{}", __clang_major__, __clang_minor__, __clang_patchlevel__);
#else
  return fmt::format("g++ {}.{}.{}", __GNUC__, __GNUC_MINOR__, __GNUC_PATCHLEVEL__);
#endif
}

std::string boost() {
  constexpr int kMajor = 100000;
  constexpr int kMinor = 100;
  return fmt::format("{}.{}.{}",
                     BOOST_VERSION / kMajor,
                     BOOST_VERSION / kMinor % (kMajor / kMinor),
                     BOOST_VERSION % kMinor);
}

std::string eigen() {
  return fmt::format("{}.{}.{}", EIGEN_WORLD_VERSION, EIGEN_MAJOR_VERSION, EIGEN_MINOR_VERSION);
}

}  // namespace

ordered_json report_versions() {
  return ordered_json::array({{{"name", "silvafit"}, {"version", SILVAFIT_VERSION}},
                              {{"name", "compiler"}, {"version", compiler()}},
                              {{"name", "Eigen"}, {"version", eigen()}},
                              {{"name", "Boost"}, {"version", boost()}}});
}

ordered_json report_repeat(const StudyRecord& record) {
  const std::string& file = record.inventory.inventory.file;
  return {{"fingerprint", file.empty() ? "" : fingerprint(read_file(file, kAnySize))},
          {"versions", report_versions()}};
}

}  // namespace silvafit::study
