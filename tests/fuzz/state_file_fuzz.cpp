#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

#include "fuzz_target.h"
#include "state/state_store.h"

namespace rubicon::fuzz::state_file_fuzz {

namespace {

struct Folder {
  std::filesystem::path path = std::filesystem::temp_directory_path() / ("rubicon-fuzz-" + std::to_string(::getpid()));
  Folder() { std::filesystem::create_directories(path); }
  ~Folder() { std::filesystem::remove_all(path); }
};

}  // namespace

// A state file as found on a damaged disk: opened, read and written, or refused.
FUZZ_TARGET(state_file) {
  static const Folder folder;
  const auto file = folder.path / "state";
  std::filesystem::remove(folder.path / "state-wal");
  std::ofstream(file, std::ios::binary | std::ios::trunc)
      .write(reinterpret_cast<const char*>(data), static_cast<std::streamsize>(size));
  const auto store = state::StateStore::open(file, IslandId(6541));
  if (!store) return 0;
  state::KnownDevice device;
  std::ignore = (*store)->each("", [&](state::StateStore::Row, state::KnownDevice&& known) { device = known; });
  std::ignore = (*store)->save(device);
  std::ignore = (*store)->forget(device.network, device.address);
  return 0;
}

}  // namespace rubicon::fuzz::state_file_fuzz
