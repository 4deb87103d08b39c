#include "trust/site/known_realm.h"

#include <sys/stat.h>

#include <tuple>
#include <utility>

namespace rubicon::trust::site {

namespace {

constexpr mode_t kRealmMode = 0644;

}  // namespace

Result<KnownRealm> KnownRealm::open(const SitePlace& place, WallTime now) {
  const SiteFolder folder(place.folder);
  auto authority = folder.authority(now);
  if (!authority) return fail(authority.error());
  auto document = folder.realm_document();
  if (!document) return fail(document.error());
  auto realm = read_realm(*document, *authority, folder.files().path(kRealmFile));
  if (!realm) return fail(realm.error());
  KnownRealm known(place, std::move(*authority), std::move(*realm), std::move(*document));
  if (place.state.empty()) return known;
  const FolderFiles state(place.state);
  auto kept = state.read(kRealmFile, kMaxRealm);
  if (!kept) return known;
  auto newer = read_realm(*kept, known.authority_, state.path(kRealmFile));
  if (!newer || !known.is_newer(*newer)) return known;
  known.realm_ = std::move(*newer);
  known.document_ = std::move(*kept);
  return known;
}

Result<bool> KnownRealm::take(std::string_view document, std::string_view from) {
  // Most of what others hand on is what we have.
  if (document == document_) return false;
  auto realm = read_realm(document, authority_, from);
  if (!realm) return fail(realm.error());
  if (!is_newer(*realm)) return false;
  realm_ = std::move(*realm);
  document_ = std::string(document);
  keep();
  return true;
}

KnownRealm::Version KnownRealm::version() const {
  struct stat about {};
  if (::stat((place_.folder / kRealmFile).c_str(), &about) != 0) return {};
  return {about.st_mtim.tv_sec, about.st_mtim.tv_nsec, about.st_size, about.st_ino};
}

bool KnownRealm::look() {
  const auto now = version();
  if (std::exchange(looked_, now) == now) return false;
  const SiteFolder folder(place_.folder);
  auto document = folder.realm_document();
  if (!document || *document == document_) return false;
  auto realm = read_realm(*document, authority_, kRealmFile);
  if (!realm || !is_newer(*realm)) return false;
  realm_ = std::move(*realm);
  document_ = std::move(*document);
  return true;
}

/// The folder of a host is root's: a unit keeps what it hears in its state folder. Where neither works, the next start
/// hears it again.
void KnownRealm::keep() const {
  const FolderFiles folder(place_.folder);
  if (const auto lock = folder.lock(Duration(0)); lock && keep_in(folder)) return;
  if (!place_.state.empty()) std::ignore = keep_in(FolderFiles(place_.state));
}

/// Another process may have heard a newer one.
bool KnownRealm::keep_in(const FolderFiles& folder) const {
  if (const auto there = folder.read(kRealmFile, kMaxRealm)) {
    const auto realm = read_realm(*there, authority_, kRealmFile);
    if (realm && !(realm_.number > realm->number)) return true;
  }
  return folder.write(kRealmFile, document_, kRealmMode).has_value();
}

}  // namespace rubicon::trust::site
