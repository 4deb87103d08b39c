#include "trust/guard_functions.h"

#include <dlfcn.h>
#include <fmt/format.h>
#include <sys/stat.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <filesystem>
#include <string_view>
#include <vector>

#include "trust/id_ranges.h"

namespace rubicon::trust {

namespace {

namespace fs = std::filesystem;

constexpr const char* kGuardVariable = "RUBICON_GUARD";
constexpr const char* kGuardFile = "librubicon-guard.so";

/// The program or library that has this function.
fs::path own_file() {
  Dl_info about{};
  if (::dladdr(reinterpret_cast<const void*>(&own_file), &about) == 0 || about.dli_fname == nullptr) return {};
  std::error_code error;
  const fs::path named = about.dli_fname;
  // The name of a program is what its caller said.
  const auto file = named.extension() == ".so" || named.string().find(".so.") != std::string::npos
                        ? fs::canonical(named, error)
                        : fs::read_symlink("/proc/self/exe", error);
  return error ? fs::path() : file;
}

template <std::size_t size>
std::string_view text_in(const char (&field)[size]) {
  return {field, static_cast<std::size_t>(std::find(field, field + size, '\0') - field)};
}

/// A structure of another version would be read wrongly. The first guards had no version: 0.
Result<void> check_version(void* library, const std::string& path) {
  const auto ask = reinterpret_cast<decltype(&rubicon_guard_version)>(::dlsym(library, "rubicon_guard_version"));
  const int version = ask == nullptr ? 0 : ask();
  if (version == RUBICON_GUARD_VERSION) return {};
  return fail(ErrorCode::kUnsupported,
              fmt::format("{}: is of another version of Rubicon (guard {}, expected {}): install packages of the same "
                          "version",
                          path, version, RUBICON_GUARD_VERSION));
}

}  // namespace

std::string guard_path() {
  if (const char* asked = std::getenv(kGuardVariable); asked != nullptr && *asked != '\0') return asked;
  const auto folder = own_file().parent_path();
  const fs::path installed = RUBICON_GUARD_FOLDER;  // relative to the prefix: lib/x86_64-linux-gnu/rubicon
  // A library beside the guard's folder; a program of a build; an installed program, wherever its prefix went.
  for (const auto& candidate : {folder / "rubicon", folder / "../lib", folder / ".." / installed}) {
    std::error_code error;
    const auto path = fs::canonical(candidate / kGuardFile, error);
    if (!folder.empty() && !error) return path.string();
  }
  return (fs::path(RUBICON_PREFIX) / installed / kGuardFile).string();
}

Result<void> GuardFunctions::load(const std::string& path) {
  if (loaded()) return {};
  // Never closed: threads of DDS may be in it until the process ends.
  void* library = ::dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (library == nullptr) {
    const char* reason = ::dlerror();
    return fail(ErrorCode::kIo, fmt::format("{}: cannot load the guard: {}", path, reason == nullptr ? "" : reason));
  }
  const auto who = reinterpret_cast<decltype(&rubicon_guard_who)>(::dlsym(library, "rubicon_guard_who"));
  const auto revoke = reinterpret_cast<decltype(&rubicon_guard_revoke)>(::dlsym(library, "rubicon_guard_revoke"));
  const auto meets_revoked =
      reinterpret_cast<decltype(&rubicon_guard_meets_revoked)>(::dlsym(library, "rubicon_guard_meets_revoked"));
  const auto watch = reinterpret_cast<decltype(&rubicon_guard_watch)>(::dlsym(library, "rubicon_guard_watch"));
  if (who != nullptr) {
    if (auto same = check_version(library, path); !same) return same;
  }
  if (who == nullptr || revoke == nullptr || meets_revoked == nullptr || watch == nullptr)
    return fail(ErrorCode::kIo, fmt::format("{}: is not the guard of Rubicon: its functions are missing", path));
  watch_ = watch;
  revoke_ = revoke;
  meets_revoked_ = meets_revoked;
  who_ = who;
  begin_watch();
  return {};
}

void GuardFunctions::begin_watch() {
  if (watch_ == nullptr || !refused_) return;
  watch_(
      [](void* context, const std::uint8_t* prefix, const char* name, int is_verified, const char* reason) {
        tuples::dds::GuidPrefix peer{};
        std::copy_n(prefix, peer.size(), peer.begin());
        (*static_cast<tuples::dds::DdsTrust::Refused*>(context))({peer, name, is_verified != 0, reason});
      },
      &refused_);
}

void GuardFunctions::watch(tuples::dds::DdsTrust::Refused call) {
  if (watch_ != nullptr && refused_) watch_(nullptr, &refused_);
  refused_ = std::move(call);
  begin_watch();
}

std::optional<tuples::Member> GuardFunctions::who(const tuples::dds::GuidPrefix& participant) const {
  const auto ask = who_.load();
  rubicon_guard_peer peer{};
  if (ask == nullptr || ask(participant.data(), &peer) != 1) return {};
  auto ids = parse_ranges(text_in(peer.ids));
  auto roles = parse_roles(text_in(peer.roles));
  if (!ids || !roles || text_in(peer.name).empty()) return {};
  return tuples::Member{std::string(text_in(peer.name)), std::move(*roles), std::move(*ids),
                        std::string(text_in(peer.serial)), WallTime(std::chrono::seconds(peer.expires))};
}

bool GuardFunctions::meets_revoked() const {
  const auto ask = meets_revoked_.load();
  return ask != nullptr && ask() == 1;
}

void GuardFunctions::revoke(const RevokedList& list) const {
  const auto tell = revoke_.load();
  if (tell == nullptr) return;
  std::vector<const char*> serials;
  serials.reserve(list.certificates.size());
  for (const auto& one : list.certificates) serials.push_back(one.serial.c_str());
  tell(serials.data(), serials.size());
}

}  // namespace rubicon::trust
