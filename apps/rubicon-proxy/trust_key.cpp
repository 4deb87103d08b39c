#include "apps/rubicon-proxy/trust_key.h"

#include <fmt/format.h>

#include <filesystem>

#include "apps/rubicon-proxy/check.h"
#include "trust/folder_files.h"
#include "trust/place.h"
#include "trust/trust_folder.h"

namespace rubicon::daemon {

int print_trust_key(const std::string& file) {
  base::ConfigErrors errors;
  const auto config = load_island(file, {}, errors);
  if (!config) return report(config.error());
  const auto& folder = config->engine.trust_folder;
  if (folder.empty()) return report({ErrorCode::kNotFound, file + ": the island is without trust, so it has no key"});
  const auto place = trust::place_of_island(folder, config->id);
  if (!place) return report(place.error());
  const auto name = trust::key_file(place->member);
  if (const auto key = trust::FolderFiles(folder).read_key(name, trust::KeyReaders::kOwner); !key)
    return report(key.error());
  fmt::print("{}\n", (std::filesystem::path(folder) / name).string());
  return kExitOk;
}

}  // namespace rubicon::daemon
