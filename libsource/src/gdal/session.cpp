// SPDX-License-Identifier: MIT
#include "gdal/session.hpp"

#include <cpl_conv.h>
#include <cpl_error.h>
#include <cpl_http.h>
#include <cpl_string.h>
#include <cpl_vsi_virtual.h>
#include <gdal.h>
#include <ogr_srs_api.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <map>
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
  // Queries of other formats with SQLite use layers in memory; terrains are rasters.
  std::set<std::string, std::less<>> names{"Memory", "GTiff", "AAIGrid"};
  for (const SourceKind& kind : source_kinds()) {
    for (std::string_view rest = kind.drivers; !rest.empty();) {
      const std::size_t comma = rest.find(',');
      names.emplace(rest.substr(0, comma));
      rest = comma == std::string_view::npos ? std::string_view() : rest.substr(comma + 1);
    }
  }
  return names;
}

/// Errors in threads that have no KeptMessages.
std::atomic<std::size_t> other_errors{0};
std::atomic<bool> refused_network{false};

void CPL_STDCALL count_error(CPLErr severity, CPLErrorNum /*number*/, const char* /*text*/) {
  if (severity >= CE_Failure) ++other_errors;
}

void register_drivers() {
  CPLSetErrorHandler(count_error);
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

/// File systems of GDAL that read memory, standard input, or a part of a file of another one.
bool is_local(std::string_view prefix) {
  static constexpr std::array<std::string_view, 11> kLocal{"/vsimem/",
                                                           "/vsizip/",
                                                           "/vsigzip/",
                                                           "/vsitar/",
                                                           "/vsi7z/",
                                                           "/vsirar/",
                                                           "/vsisubfile/",
                                                           "/vsisparse/",
                                                           "/vsicrypt/",
                                                           "/vsicached?",
                                                           "/vsistdin"};
  return std::ranges::any_of(kLocal,
                             [&](std::string_view local) { return prefix.starts_with(local); });
}

void* refuse_file(void* /*data*/, const char* /*name*/, const char* /*access*/) {
  refused_network = true;
  return nullptr;
}

int refuse_status(void* /*data*/, const char* /*name*/, VSIStatBufL* /*status*/, int /*flags*/) {
  refused_network = true;
  return -1;
}

CPLHTTPResult* refuse_request(const char* /*address*/,
                              CSLConstList /*options*/,
                              GDALProgressFunc /*progress*/,
                              void* /*progress_data*/,
                              CPLHTTPFetchWriteFunc /*write*/,
                              void* /*write_data*/,
                              void* /*data*/) {
  refused_network = true;
  // Without a result GDAL would send the request itself.
  auto* const result = static_cast<CPLHTTPResult*>(CPLCalloc(1, sizeof(CPLHTTPResult)));
  result->nStatus = 1;
  result->pszErrBuf = CPLStrdup("no access to networks");
  return result;
}

/// GDAL's own handlers of the file systems that are not local.
const std::map<std::string, VSIFilesystemHandler*>& remote_file_systems() {
  static const std::map<std::string, VSIFilesystemHandler*> handlers = [] {
    std::map<std::string, VSIFilesystemHandler*> found;
    const CPLStringList prefixes(VSIGetFileSystemsPrefixes());
    for (int i = 0; i < prefixes.size(); ++i) {
      if (is_local(prefixes[i])) continue;
      found.emplace(prefixes[i], VSIFileManager::GetHandler(prefixes[i]));
    }
    return found;
  }();
  return handlers;
}

void refuse_file_system(const std::string& prefix) {
  VSIFilesystemPluginCallbacksStruct* const callbacks = VSIAllocFilesystemPluginCallbacksStruct();
  callbacks->open = refuse_file;
  callbacks->stat = refuse_status;
  VSIInstallPluginHandler(prefix.c_str(), callbacks);
  VSIFreeFilesystemPluginCallbacksStruct(callbacks);
}

}  // namespace

void set_network(bool is_allowed) {
  static std::mutex mutex;
  static bool was_allowed = true;
  const std::lock_guard lock(mutex);
  refused_network = false;
  const auto& remote = remote_file_systems();
  if (is_allowed == std::exchange(was_allowed, is_allowed)) return;
  for (const auto& [prefix, handler] : remote) {
    is_allowed ? VSIFileManager::InstallHandler(prefix, handler) : refuse_file_system(prefix);
  }
  CPLHTTPSetFetchCallback(is_allowed ? nullptr : refuse_request, nullptr);
}

bool has_refused_network() { return refused_network; }

void start_gdal() {
  static std::once_flag once;
  std::call_once(once, register_drivers);
}

KeptMessages::KeptMessages() : others_before_(other_errors) {
  CPLPushErrorHandlerEx(keep_message, this);
}

KeptMessages::~KeptMessages() { CPLPopErrorHandler(); }

bool KeptMessages::has_errors() const { return !errors_.empty() || other_errors != others_before_; }

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
