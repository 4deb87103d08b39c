#include "apps/rubicon/trust/needs_host.h"

#include "base/config_reader.h"
#include "config/config_file.h"
#include "config/engine_config.h"
#include "trust/started_realm.h"

namespace rubicon::cli::trust {

bool is_of_another_realm(const std::string& configuration, const std::filesystem::path& folder) {
  using Choice = config::TrustSetup::Choice;
  using rubicon::trust::whole_path;
  const auto root = config::load_config(configuration, {});
  if (!root) return false;
  base::ConfigErrors errors;
  base::ConfigReader reader(*root, "", errors);
  const auto engine = config::read_engine(reader, {});
  const auto& own = engine.trust.folder;
  if (!engine.dds || engine.trust.choice == Choice::kNo) return true;
  return !own.empty() && whole_path(std::filesystem::path(configuration).parent_path() / own) != whole_path(folder);
}

}  // namespace rubicon::cli::trust
