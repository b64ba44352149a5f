// SPDX-License-Identifier: MIT
#include "gdal/session.hpp"

#include <cpl_conv.h>
#include <cpl_error.h>
#include <gdal.h>
#include <ogr_srs_api.h>

#include <algorithm>
#include <mutex>
#include <set>
#include <string_view>
#include <utility>

#include "gdal/functions.hpp"
#include "silvafit/source/open_table.hpp"
#include "source_kind.hpp"

namespace silvafit::source {
namespace {

std::set<std::string, std::less<>> wanted_drivers() {
  // Queries of other formats with SQLite use layers in memory.
  std::set<std::string, std::less<>> names{"Memory"};
  for (const SourceKind& kind : source_kinds()) {
    for (std::string_view rest = kind.drivers; !rest.empty();) {
      const std::size_t comma = rest.find(',');
      names.emplace(rest.substr(0, comma));
      rest = comma == std::string_view::npos ? std::string_view() : rest.substr(comma + 1);
    }
  }
  return names;
}

void register_drivers() {
  GDALAllRegister();
  const auto wanted = wanted_drivers();
  for (int i = GDALGetDriverCount() - 1; i >= 0; --i) {
    GDALDriverH const driver = GDALGetDriver(i);
    if (!wanted.contains(std::string_view(GDALGetDescription(driver)))) {
      GDALDeregisterDriver(driver);
    }
  }
  // Otherwise PROJ would download grids for changes of datum.
  OSRSetPROJEnableNetwork(0);
}

void CPL_STDCALL keep_message(CPLErr severity, CPLErrorNum /*number*/, const char* text) {
  auto* const kept = static_cast<KeptMessages*>(CPLGetErrorHandlerUserData());
  if (severity >= CE_Failure) kept->add(text);
}

}  // namespace

void start_gdal() {
  static std::once_flag once;
  std::call_once(once, register_drivers);
}

KeptMessages::KeptMessages() { CPLPushErrorHandlerEx(keep_message, this); }

KeptMessages::~KeptMessages() { CPLPopErrorHandler(); }

Setting::Setting(const char* name, const char* value) : name_(name) {
  const char* const before = CPLGetThreadLocalConfigOption(name, nullptr);
  had_value_ = before != nullptr;
  if (had_value_) before_ = before;
  CPLSetThreadLocalConfigOption(name, value);
}

Setting::~Setting() {
  CPLSetThreadLocalConfigOption(name_.c_str(), had_value_ ? before_.c_str() : nullptr);
}

std::string version_of_gdal() { return GDALVersionInfo("RELEASE_NAME"); }

}  // namespace silvafit::source
