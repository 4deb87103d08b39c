#include "apps/rubicon/trust/started_realm.h"

#include <fmt/format.h>

#include "base/config_reader.h"
#include "config/config_file.h"
#include "config/engine_config.h"

namespace rubicon::cli::trust {

namespace {

namespace fs = std::filesystem;

constexpr std::size_t kLargest = 1024;
constexpr mode_t kForAll = 0644;

/// Without a `/` at its end.
fs::path whole(const fs::path& folder) {
  std::error_code error;
  const auto path = fs::absolute(folder, error).lexically_normal();
  return path.has_filename() ? path : path.parent_path();
}

using Choice = config::TrustSetup::Choice;

/// kNo without engine dds; nullopt: the configuration cannot be read.
std::optional<config::TrustSetup> trust_of(const std::string& configuration) {
  const auto root = config::load_config(configuration, {});
  if (!root) return std::nullopt;
  base::ConfigErrors errors;
  base::ConfigReader reader(*root, "", errors);
  auto engine = config::read_engine(reader);
  if (!engine.dds) engine.trust.choice = Choice::kNo;
  return engine.trust;
}

}  // namespace

bool is_without_host(const std::string& configuration) {
  const auto trust = trust_of(configuration);
  return trust && (trust->choice == Choice::kNo || !trust->folder.empty());
}

bool is_of_another_realm(const std::string& configuration, const fs::path& folder) {
  const auto trust = trust_of(configuration);
  if (!trust || trust->choice == Choice::kNo) return trust.has_value();
  return !trust->folder.empty() && whole(fs::path(configuration).parent_path() / trust->folder) != whole(folder);
}

bool has_realm(const fs::path& folder) {
  std::error_code error;
  return fs::exists(folder / "identity-ca.pem", error);
}

StartedRealm::StartedRealm(const fs::path& folder)
    : folder_(whole(folder)), files_(folder_.parent_path()), name_(folder_.filename().string() + ".realm") {}

Result<void> StartedRealm::check_is_there() const {
  if (has_realm(folder_)) return {};
  const auto text = files_.read(name_, kLargest);
  if (!text && text.error().code == ErrorCode::kNotFound) return {};
  if (!text) return fail(text.error());
  return fail(ErrorCode::kNotFound,
              fmt::format("{}: has no realm, but islands of this host started with {} (says {}): put the folder back "
                          "from your copy, or join that realm again; `sudo rubicon trust init` makes a new realm",
                          folder_.string(), text->substr(0, text->find('\n')), files_.path(name_)));
}

Result<void> StartedRealm::keep(const rubicon::trust::RealmIdentity& realm) const {
  const auto text = fmt::format("{}\n{}\n", realm.name, realm.fingerprint);
  if (const auto before = files_.read(name_, kLargest); before && *before == text) return {};
  return files_.write(name_, text, kForAll);
}

}  // namespace rubicon::cli::trust
