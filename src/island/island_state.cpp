#include "island/island_state.h"

#include <fcntl.h>
#include <fmt/format.h>

#include <array>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string_view>
#include <system_error>

#include "base/own_file.h"

namespace rubicon::island {

namespace fs = std::filesystem;

std::string state_path(const island::IslandConfig& config) {
  if (config.state.file.empty()) return {};
  return (fs::path(config.directory) / config.state.file).string();
}

std::string good_config_path(const island::IslandConfig& config) {
  const auto path = state_path(config);
  return path.empty() ? path : path + ".good.yaml";
}

namespace {

/// A database, or what a crash of the machine leaves of one: nothing or zeros. Any other file belongs to another
/// program.
bool may_have_been_ours(const std::string& path) {
  constexpr std::string_view kDatabase("SQLite format 3\0", 16);
  std::array<char, kDatabase.size()> head{};
  std::ifstream file(path, std::ios::binary);
  file.read(head.data(), head.size());
  const std::string_view found(head.data(), head.size());
  return fs::is_regular_file(path) && (found == kDatabase || found.find_first_not_of('\0') == std::string_view::npos);
}

}  // namespace

Result<std::unique_ptr<state::StateStore>> open_state(const island::IslandConfig& config, const Log& log,
                                                      WallTime now) {
  const auto path = state_path(config);
  if (path.empty()) {
    const auto& discovery = config.proxy.discovery;
    if (discovery.otherwise != proxy::DiscoveryAction::kAuto || !discovery.rules.empty())
      log.warning("there is no state file: what is approved or ignored is forgotten at the end (state: {file: ...})");
    return std::unique_ptr<state::StateStore>();
  }
  const state::StateOptions options{config.state.max_bytes};
  auto store = state::StateStore::open(path, config.id, options);
  if (!store && store.error().code == ErrorCode::kInvalid && may_have_been_ours(path)) {
    auto aside = state::set_aside(path, now);
    if (!aside) return fail(std::move(aside.error()));
    log.error(fmt::format("{}; it is now {}, and the island begins with an empty memory", store.error().text, *aside));
    store = state::StateStore::open(path, config.id, options);
  }
  if (store && (*store)->stats().read_only)
    log.warning(fmt::format("{} can only be read: nothing new is remembered", path));
  return store;
}

Result<void> keep_good_config(const island::IslandConfig& config, const std::string& file) {
  const auto path = good_config_path(config);
  std::error_code error;
  if (path.empty() || fs::equivalent(file, path, error)) return {};
  const auto fresh = path + ".new";
  std::ifstream source(file, std::ios::binary);
  const std::string text(std::istreambuf_iterator<char>(source), {});
  if (!source.is_open()) return fail(ErrorCode::kIo, fmt::format("{}: cannot be read, so it is not kept", file));
  fs::remove(fresh, error);
  const auto target = OwnFile::open(fresh, O_WRONLY | O_EXCL);
  if (!target) return fail(ErrorCode::kIo, target.error().text);
  if (auto done = target->write(text, fresh); !done) return done;
  fs::rename(fresh, path, error);
  if (error) return fail(ErrorCode::kIo, fmt::format("{}: cannot be written: {}", path, error.message()));
  return {};
}

Result<void> NetworkMemory::remember(const std::string& network, std::string_view name, ByteView value,
                                     network::Keep keep) {
  if (!store_)
    return fail(ErrorCode::kUnsupported, "nothing can be remembered without a state file (state: {file: ...})");
  if (const auto fits = network::check_memory(name, value); !fits)
    return fail(fits.error().code, fmt::format("network {}: {}", network, fits.error().text));
  return store_->remember(network, name, value, network::kMaxMemories, keep == network::Keep::kNow);
}

Result<std::optional<Bytes>> NetworkMemory::remembered(const std::string& network, std::string_view name) {
  if (!store_)
    return fail(ErrorCode::kUnsupported, "nothing can be remembered without a state file (state: {file: ...})");
  return store_->remembered(network, name);
}

}  // namespace rubicon::island
