#include "trust/trust.h"

#include <fmt/format.h>
#include <sys/stat.h>

#include <tuple>
#include <utility>

#include "base/limited_log.h"
#include "trust/guard_functions.h"
#include "trust/issuer.h"
#include "trust/signed_text.h"
#include "trust/trust_folder.h"

namespace rubicon::trust {

namespace {

constexpr Duration kLookPeriod = std::chrono::seconds(2);
constexpr int kWarningDays = 30;

/// Changes when a file is replaced.
using FileMark = std::tuple<ino_t, std::int64_t, std::int64_t>;

FileMark mark_of(const std::string& path) {
  struct stat about {};
  if (::stat(path.c_str(), &about) != 0) return {};
  return {about.st_ino, about.st_mtim.tv_sec, about.st_mtim.tv_nsec};
}

std::string contents_of(const Papers& papers) {
  return papers.identity_ca.text + papers.certificate.text + papers.permissions_ca.text + papers.governance.text +
         papers.permissions.text;
}

}  // namespace

struct Trust::Impl {
  Impl(Place where, Scheduler& clock, Log to)
      : place(std::move(where)), scheduler(clock), log(std::move(to)), limited(log, clock), folder(place.folder) {}

  Result<Documents> documents();
  Result<void> check_key(const CheckedPapers& checked) const;
  void take_papers(CheckedPapers checked, const std::string& document);
  void read_state();
  Result<void> check_own(const std::string& where) const;
  bool take(std::string_view document, const std::string& where, bool is_on_disk);
  void keep();
  Result<void> write_if_newer() const;
  void look();
  void look_at_folder();
  void warn_of_end();
  int days_left() const;

  const Place place;
  Scheduler& scheduler;
  const Log log;
  base::LimitedLog limited;  ///< for what others send
  const TrustFolder folder;
  GuardFunctions guard;
  std::optional<Realm> realm;
  tuples::Member own;
  RevokedList revoked;
  std::string revoked_document;
  std::function<void()> watcher;
  FileMark revoked_mark;
  std::optional<int> warned_days;
  bool complained_of_guard = false;
  bool must_keep = false;  ///< a list that was heard is not on the disk yet
  Timer look_timer;
  Timer watch_timer;
};

Result<Trust::Documents> Trust::Impl::documents() {
  const auto mark = mark_of(folder.files().path(kRevokedFile));
  const auto papers = folder.papers(place.member);
  if (!papers) return fail(papers.error());
  auto checked = check_papers(*papers, scheduler.wall_now());
  if (!checked) return fail(checked.error());
  if (checked->member.name != place.member)
    return fail(ErrorCode::kInvalid, fmt::format("{}: is the certificate of {}: expected that of {}",
                                                 papers->certificate.where, checked->member.name, place.member));
  if (auto good = check_key(*checked); !good) return fail(good.error());
  if (auto loaded = guard.load(guard_path()); !loaded) {
    // It would let this process in, and know nobody.
    if (loaded.error().code == ErrorCode::kUnsupported) return fail(loaded.error());
    if (!std::exchange(complained_of_guard, true)) log.warning(loaded.error().text);
  }
  const auto before = own;
  take_papers(std::move(*checked), papers->revoked.text);
  revoked_mark = mark;
  read_state();
  guard.revoke(revoked);
  if (auto good = check_own(papers->certificate.where); !good) {
    own = before;
    return fail(good.error());
  }
  const auto key = place.key.empty() ? folder.files().path(key_file(place.member)) : place.key.string();
  return Documents{"file:" + papers->identity_ca.where,
                   "file:" + papers->certificate.where,
                   "file:" + key,
                   "file:" + papers->permissions_ca.where,
                   "file:" + papers->governance.where,
                   "file:" + papers->permissions.where,
                   contents_of(*papers)};
}

Result<void> Trust::Impl::check_key(const CheckedPapers& checked) const {
  const auto name = key_file(place.member);
  const auto where = place.key.empty() ? folder.files().path(name) : place.key.string();
  const auto readers = is_island_member(checked.member) ? KeyReaders::kOwner : KeyReaders::kPeople;
  const auto pem = place.key.empty() ? folder.files().read_key(name, readers) : read_credential(place.key);
  if (!pem) return fail(pem.error());
  const auto key = PrivateKey::of_pem(pem->view(), where);
  if (!key) return fail(key.error());
  if (checked.certificate.has_key(key->get())) return {};
  return fail(ErrorCode::kInvalid, fmt::format("{}: is not the key of {} ({})", where, checked.certificate.subject(),
                                               folder.files().path(certificate_file(place.member))));
}

void Trust::Impl::take_papers(CheckedPapers checked, const std::string& document) {
  const bool same = realm && *realm == checked.realm;
  if (!same || checked.revoked.number >= revoked.number) {
    revoked = std::move(checked.revoked);
    revoked_document = document;
  }
  realm = std::move(checked.realm);
  own = std::move(checked.member);
}

/// A list that this process heard before its last end. The file is its own: what is wrong with it is no reason not to
/// start.
void Trust::Impl::read_state() {
  if (place.state.empty()) return;
  const FolderFiles files(place.state);
  if (!files.exists(kRevokedFile)) return;
  const auto text = files.read(kRevokedFile, kLargestSigned);
  if (!text) return log.warning(text.error().text);
  take(*text, files.path(kRevokedFile), true);
}

Result<void> Trust::Impl::check_own(const std::string& where) const {
  const auto* found = revoked.find(own.serial);
  if (found == nullptr) return {};
  return fail(ErrorCode::kRefused,
              fmt::format("{}: the certificate of {} was revoked on {}", where, own.name, date_text(found->when)));
}

bool Trust::Impl::take(std::string_view document, const std::string& where, bool is_on_disk) {
  if (!realm || document == revoked_document) return false;
  auto list = read_revoked(document, realm->permissions_ca, where);
  if (!list) return limited.warning(where, list.error().text), false;
  if (list->number <= revoked.number) return false;
  for (const auto& one : list->certificates) {
    if (revoked.find(one.serial) == nullptr)
      log.info(fmt::format("{} ({}) was revoked on {}", one.name, one.serial, date_text(one.when)));
  }
  revoked = std::move(*list);
  revoked_document = document;
  guard.revoke(revoked);
  if (!is_on_disk) keep();
  if (auto good = check_own(where); !good) log.error(good.error().text);
  return true;
}

void Trust::Impl::keep() {
  auto kept = write_if_newer();
  // `rubicon trust` has the folder for a moment: the next look tries again.
  must_keep = !kept && kept.error().code == ErrorCode::kBusy;
  if (must_keep) return;
  if (!kept && !place.state.empty()) kept = FolderFiles(place.state).write(kRevokedFile, revoked_document, 0644);
  if (kept) return;
  const auto text = kept.error().text + "; the list of revoked certificates is forgotten at the next start";
  // Tools of people may not write the folder of the host; its islands keep the list.
  if (!is_island_member(own) && kept.error().code == ErrorCode::kRefused)
    log.debug(text);
  else
    log.warning(text);
}

/// Another process may have written a newer one since this one looked.
Result<void> Trust::Impl::write_if_newer() const {
  const auto lock = folder.files().lock(Duration(0));
  if (!lock) return fail(lock.error());
  if (const auto text = folder.files().read(kRevokedFile, kLargestSigned)) {
    const auto there = read_revoked(*text, realm->permissions_ca, folder.files().path(kRevokedFile));
    if (there && there->number >= revoked.number) return {};
  }
  return folder.write_revoked(revoked_document);
}

void Trust::Impl::look() {
  look_at_folder();
  if (must_keep) keep();
  warn_of_end();
  look_timer = scheduler.after(kLookPeriod, [this] { look(); });
}

void Trust::Impl::look_at_folder() {
  const auto mark = mark_of(folder.files().path(kRevokedFile));
  if (mark == FileMark() || mark == revoked_mark) return;
  revoked_mark = mark;
  const auto text = folder.files().read(kRevokedFile, kLargestSigned);
  if (!text) return log.warning(text.error().text);
  if (!take(*text, folder.files().path(kRevokedFile), true)) return;
  watch_timer = scheduler.after(Duration(0), [this] {
    if (watcher) watcher();
  });
}

/// Once a day at most.
void Trust::Impl::warn_of_end() {
  const int days = days_left();
  if (days > kWarningDays || warned_days == days) return;
  warned_days = days;
  const auto text =
      fmt::format("the certificate of {} {} on {}: run `rubicon trust dds renew {}` where the realm was made", own.name,
                  days < 0 ? "ended" : "ends", date_text(own.expires), own.name);
  if (days < 0)
    log.error(text);
  else
    log.warning(text);
}

int Trust::Impl::days_left() const {
  return static_cast<int>(std::chrono::floor<std::chrono::days>(own.expires - scheduler.wall_now()).count());
}

Trust::Trust(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Trust::~Trust() = default;

Result<std::shared_ptr<Trust>> Trust::open(Place place, Scheduler& scheduler, Log log) {
  auto impl = std::make_unique<Impl>(std::move(place), scheduler, std::move(log));
  if (auto read = impl->documents(); !read) return fail(read.error());
  impl->look();
  return std::shared_ptr<Trust>(new Trust(std::move(impl)));
}

Result<Trust::Documents> Trust::documents() {
  return impl_->documents();
}

std::string Trust::guard_library() const {
  return guard_path();
}

const tuples::Member& Trust::own() const {
  return impl_->own;
}

std::optional<tuples::Member> Trust::who(const tuples::dds::GuidPrefix& participant) const {
  auto member = impl_->guard.who(participant);
  if (member && member->expires <= impl_->scheduler.wall_now()) member.reset();
  return member;
}

bool Trust::take_revoked(std::string_view signed_list, std::string_view from) {
  return impl_->take(signed_list, fmt::format("a list of revoked certificates from {}", from), false);
}

bool Trust::meets_revoked() const {
  return impl_->guard.meets_revoked();
}

bool Trust::is_revoked() const {
  return impl_->revoked.find(impl_->own.serial) != nullptr;
}

std::string Trust::revoked() const {
  return impl_->revoked_document;
}

void Trust::watch_revoked(std::function<void()> call) {
  impl_->watcher = std::move(call);
}

void Trust::watch_refused(Refused call) {
  impl_->guard.watch(std::move(call));
}

int Trust::days_left() const {
  return impl_->days_left();
}

}  // namespace rubicon::trust
