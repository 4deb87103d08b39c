#include "trust/started_realm.h"

#include <fmt/format.h>

#include "trust/trust_folder.h"

namespace rubicon::trust {

namespace {

namespace fs = std::filesystem;

constexpr std::size_t kLargest = 1024;
constexpr mode_t kForAll = 0644;

}  // namespace

fs::path whole_path(const fs::path& folder) {
  std::error_code error;
  const auto path = fs::absolute(folder, error).lexically_normal();
  return path.has_filename() ? path : path.parent_path();
}

StartedRealm::StartedRealm(const fs::path& folder)
    : folder_(whole_path(folder)), files_(folder_.parent_path()), name_(folder_.filename().string() + ".realm") {}

Result<void> StartedRealm::check_is_there() const {
  if (TrustFolder(folder_).has_realm()) return {};
  const auto text = files_.read(name_, kLargest);
  if (!text && text.error().code == ErrorCode::kNotFound) return {};
  if (!text) return fail(text.error());
  return fail(ErrorCode::kNotFound,
              fmt::format("{}: has no realm, but islands of this host started with {} (says {}): put the folder back "
                          "from your copy, or join that realm again; `sudo rubicon trust dds init` makes a new realm",
                          folder_.string(), text->substr(0, text->find('\n')), files_.path(name_)));
}

Result<void> StartedRealm::keep(const RealmIdentity& realm) const {
  const auto text = fmt::format("{}\n{}\n", realm.name, realm.fingerprint);
  if (const auto before = files_.read(name_, kLargest); before && *before == text) return {};
  return files_.write(name_, text, kForAll);
}

}  // namespace rubicon::trust
