#include "trust/site/live_realm.h"

#include <fmt/format.h>
#include <sys/stat.h>

#include <filesystem>
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
  // Most documents that others pass on are the one that we have.
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

Result<std::shared_ptr<LiveRealm>> LiveRealm::open(const std::string& ca_file, const std::string& user,
                                                   base::Scheduler& scheduler, Log log) {
  const auto place = site_place_beside(ca_file, user);
  if (!place) return std::shared_ptr<LiveRealm>();
  auto known = KnownRealm::open(*place, scheduler.wall_now());
  if (!known) return fail(std::move(known.error()));
  return std::shared_ptr<LiveRealm>(new LiveRealm(std::move(*known), user, scheduler, std::move(log)));
}

LiveRealm::LiveRealm(KnownRealm known, std::string user, base::Scheduler& scheduler, Log log)
    : known_(std::move(known)), user_(std::move(user)), scheduler_(scheduler), log_(std::move(log)) {
  read_members();
  look_ = scheduler_.after(kLook, [this] { look(); });
}

std::shared_ptr<const tuples::Member> LiveRealm::member(std::string_view user) const {
  const auto found = members_.find(user);
  return found == members_.end() ? nullptr : found->second;
}

LiveRealm::Taken LiveRealm::take(std::string_view document, std::string_view from) {
  const auto newer = known_.take(document, from);
  if (!newer) return Taken::kWrong;
  if (!*newer) return Taken::kOlder;
  changed();
  return Taken::kNewer;
}

void LiveRealm::look() {
  look_ = scheduler_.after(kLook, [this] { look(); });
  if (known_.look()) changed();
}

/// A call may end others.
void LiveRealm::changed() {
  read_members();
  const auto watches = watches_;
  for (auto one = watches->begin(); one != watches->end();) {
    const auto number = one->first;
    const auto call = one->second;
    call();
    one = watches->upper_bound(number);
  }
}

/// A member that did not change keeps its pointer.
void LiveRealm::read_members() {
  const auto& realm = known_.realm();
  std::map<std::string_view, std::vector<tuples::IdRange>> islands;
  for (const auto& [id, user] : realm.islands) islands[user].push_back({id, id});
  auto before = std::exchange(members_, {});
  for (const auto& [user, roles] : realm.members) {
    tuples::Member member{user, roles, {{kFirstFreeId, 0xffffffff}}};
    const auto own = islands.find(user);
    if (own != islands.end()) member.ids.insert(member.ids.end(), own->second.begin(), own->second.end());
    auto& kept = before[user];
    members_[user] = kept && *kept == member ? std::move(kept) : std::make_shared<tuples::Member>(std::move(member));
  }
  log_.info(fmt::format("realm {}: {} members, {} shut out, as of its file {}", realm.name, realm.members.size(),
                        realm.revoked.size(), realm.number));
  if (realm.is_revoked(user_))
    log_.error(
        fmt::format("{} was shut out of the realm {}: other members ignore this process; `rubicon trust add` on "
                    "the host with the authority makes a member of another name",
                    user_, realm.name));
}

tuples::Handle LiveRealm::watch(std::function<void()> call) {
  const auto number = ++last_watch_;
  watches_->emplace(number, std::move(call));
  return tuples::Handle([watches = std::weak_ptr(watches_), number] {
    if (const auto all = watches.lock()) all->erase(number);
  });
}

}  // namespace rubicon::trust::site
