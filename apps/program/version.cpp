#include "apps/program/process.h"

#include <dlfcn.h>
#include <link.h>

#include <array>
#include <string_view>

namespace rubicon::program {

namespace {

/// A function that a loaded library exports; nullptr if no loaded library does. Its header is not needed here: only the
/// room that uses a library includes its headers.
template <typename Function>
Function* exported(const char* name) {
  return reinterpret_cast<Function*>(::dlsym(RTLD_DEFAULT, name));
}

/// Calls a version function without arguments.
std::string text_of(const char* function) {
  const auto call = exported<const char*()>(function);
  return call ? call() : "";
}

std::string openssl() {
  constexpr int kVersionString = 6;  // OPENSSL_VERSION_STRING of <openssl/crypto.h>
  const auto call = exported<const char*(int)>("OpenSSL_version");
  return call ? call(kVersionString) : "";
}

std::string mosquitto() {
  const auto call = exported<int(int*, int*, int*)>("mosquitto_lib_version");
  if (!call) return "";
  int major = 0, minor = 0, revision = 0;
  call(&major, &minor, &revision);
  return std::to_string(major) + "." + std::to_string(minor) + "." + std::to_string(revision);
}

/// `expat_2.5.0` -> `2.5.0`.
std::string expat() {
  const auto text = text_of("XML_ExpatVersion");
  return text.substr(text.find('_') + 1);
}

struct Library {
  std::string_view name;
  std::string_view file;  ///< how the name of its shared object begins; empty = in the program itself
  std::string (*version)();
};

constexpr std::array kLibraries{
    Library{"Boost", "", [] { return std::string(RUBICON_BOOST); }},
    Library{"Cyclone DDS", "libddsc", [] { return std::string(RUBICON_CYCLONEDDS); }},
    Library{"expat", "libexpat.", expat},
    Library{"fmt", "libfmt.", [] { return std::string(RUBICON_FMT); }},
    Library{"libmosquitto", "libmosquitto.", mosquitto},
    Library{"libzip", "libzip.", [] { return text_of("zip_libzip_version"); }},
    Library{"OpenSSL", "libcrypto.", openssl},
    Library{"simdjson", "libsimdjson.", [] { return std::string(RUBICON_SIMDJSON); }},
    Library{"spdlog", "libspdlog.", [] { return std::string(RUBICON_SPDLOG); }},
    Library{"SQLite", "libsqlite3.", [] { return text_of("sqlite3_libversion"); }},
    Library{"yaml-cpp", "libyaml-cpp.", [] { return std::string(RUBICON_YAML_CPP); }},
    Library{"zstd", "libzstd.", [] { return text_of("ZSTD_versionString"); }},
};

bool is_loaded(std::string_view file) {
  const auto look = [](dl_phdr_info* object, std::size_t, void* wanted) {
    const std::string_view path = object->dlpi_name;
    return path.substr(path.rfind('/') + 1).starts_with(*static_cast<std::string_view*>(wanted)) ? 1 : 0;
  };
  return file.empty() || ::dl_iterate_phdr(look, &file) != 0;
}

}  // namespace

std::string version_text(const char* program) {
  const std::string commit = RUBICON_COMMIT;
  auto text = std::string(program) + " " RUBICON_VERSION "\ncommit: " + (commit.empty() ? "not known" : commit) +
              "\nlibraries: ";
  std::string_view separator;
  for (const auto& library : kLibraries) {
    if (!is_loaded(library.file)) continue;
    const auto version = library.version();
    text.append(separator).append(library.name).append(version.empty() ? "" : " ").append(version);
    separator = ", ";
  }
  return text;
}

}  // namespace rubicon::program
