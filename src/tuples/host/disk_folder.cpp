#include "tuples/host/folder.h"

#include <dirent.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/random.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <utility>

#include "base/clocks.h"
#include "base/own_file.h"
#include "transport/host_names.h"
#include "tuples/host/connection.h"

namespace rubicon::tuples::host {

namespace {

constexpr std::string_view kSocket = ".sock", kLock = ".lock";
constexpr mode_t kOwn = 0700, kOfPeople = 0750;
/// Users whose folders are searched; those of further users are ignored.
constexpr std::size_t kMaxUsers = 4096;

Error trouble(const std::string& path, std::string_view doing, int error) {
  const auto code = error == EACCES || error == EPERM || error == ELOOP || error == ENOTDIR ? ErrorCode::kRefused
                    : error == ENOENT                                                       ? ErrorCode::kNotFound
                                                                                            : ErrorCode::kIo;
  return {code, fmt::format("{}: cannot {}: {}", path, doing, std::strerror(error))};
}

/// Makes the folder unless it exists. The folder belongs to this user, and no other may write to it. A folder of
/// several users gets its group from the one above, because the service may not set that bit itself
/// (systemd.exec(5), RestrictSUIDSGID=).
Result<void> make_own(const std::string& path, mode_t mode) {
  const bool made = ::mkdir(path.c_str(), mode) == 0;
  if (!made && errno != EEXIST) return fail(trouble(path, "make the folder", errno));
  struct stat found {};
  if (::lstat(path.c_str(), &found) != 0) return fail(trouble(path, "look at the folder", errno));
  const auto refuse = [&](std::string_view why) {
    return fail(ErrorCode::kRefused, fmt::format("{}: {}: remove it, or set RUBICON_FOLDER", path, why));
  };
  if (!S_ISDIR(found.st_mode)) return refuse(S_ISLNK(found.st_mode) ? "is a symbolic link" : "is not a folder");
  if (found.st_uid != ::geteuid()) return refuse(fmt::format("belongs to uid {}", found.st_uid));
  const auto has = found.st_mode & 0777;
  if (made && has != mode && ::chmod(path.c_str(), (found.st_mode & S_ISGID) | mode) != 0)  // the umask took some
    return fail(trouble(path, "give the folder its permissions", errno));
  if (!made && (has & ~mode) != 0) return refuse(fmt::format("has permissions {:o}, expected {:o}", has, mode));
  return {};
}

std::vector<std::string> names_in(const std::string& path) {
  std::vector<std::string> names;
  auto* folder = ::opendir(path.c_str());
  if (!folder) return names;
  while (const auto* entry = ::readdir(folder)) {
    if (entry->d_name[0] != '.') names.emplace_back(entry->d_name);
  }
  ::closedir(folder);
  std::sort(names.begin(), names.end());
  return names;
}

/// The owner of the socket if it is one, and its folder has the same.
Result<uid_t> owner_of(const Door& door) {
  const auto path = fmt::format("{}/{}{}", door.place, door.token, kSocket);
  struct stat folder {
  }, socket{};
  if (::lstat(path.c_str(), &socket) != 0) return fail(trouble(path, "look at the socket", errno));
  if (::stat(door.place.c_str(), &folder) != 0) return fail(trouble(door.place, "look at the folder", errno));
  if (!S_ISSOCK(socket.st_mode)) return fail(ErrorCode::kNotFound, path + " is not a socket");
  if (socket.st_uid != folder.st_uid)
    return fail(ErrorCode::kRefused,
                fmt::format("{} is of uid {}, its folder of uid {}", path, socket.st_uid, folder.st_uid));
  return socket.st_uid;
}

/// Whether the path still names the open file: another process may have removed it meanwhile.
bool is_same(int file, const std::string& path) {
  struct stat open {
  }, named{};
  return ::fstat(file, &open) == 0 && ::lstat(path.c_str(), &named) == 0 && open.st_ino == named.st_ino &&
         open.st_dev == named.st_dev;
}

/// A lock on a file, in which stands who holds it. It removes the file while it holds the lock, so that no other
/// process does.
class DiskLock final : public IdLock {
 public:
  DiskLock(OwnFile file, std::string path) : file_(std::move(file)), path_(std::move(path)) {}
  ~DiskLock() override {
    if (is_same(file_.get(), path_)) ::unlink(path_.c_str());
  }

 private:
  OwnFile file_;
  std::string path_;
};

/// A process that looks for left locks holds one for a moment: tries for 0.1 s.
bool try_lock(int file) {
  constexpr int kTries = 50;
  constexpr useconds_t kPause = 2000;
  for (int tries = 0; ::flock(file, LOCK_EX | LOCK_NB) != 0; ++tries) {
    if (errno != EWOULDBLOCK || tries >= kTries) return false;
    ::usleep(kPause);
    errno = EWOULDBLOCK;
  }
  return true;
}

/// Removes the files of locks that killed processes left.
void remove_left_locks(const std::string& folder) {
  for (const auto& name : names_in(folder)) {
    if (!name.ends_with(kLock)) continue;
    const auto path = folder + "/" + name;
    auto file = OwnFile::of_descriptor(::open(path.c_str(), O_RDWR | O_NOFOLLOW | O_CLOEXEC));
    if (file.get() >= 0 && ::flock(file.get(), LOCK_EX | LOCK_NB) == 0) const DiskLock left(std::move(file), path);
  }
}

std::string text_in(int file) {
  std::array<char, 256> text{};
  const auto size = ::pread(file, text.data(), text.size(), 0);
  std::string found(text.data(), size > 0 ? static_cast<std::size_t>(size) : 0);
  return found.substr(0, found.find('\n'));
}

std::string own_text() {
  std::array<char, 32> since{};
  const auto now = std::time(nullptr);
  std::tm local{};
  std::strftime(since.data(), since.size(), "%Y-%m-%d %H:%M", ::localtime_r(&now, &local));
  return fmt::format("{}, {} since {}\n", program_invocation_short_name, transport::own_process(), since.data());
}

class DiskFolder final : public Folder {
 public:
  DiskFolder(Place place, std::string space, Scheduler& scheduler, transport::Transports& transports)
      : place_(std::move(place)), space_(std::move(space)), transports_(transports), names_(scheduler, transports) {}

  std::string path() const override { return place_.path; }

  std::string make_token() const override {
    std::uint64_t random = 0;
    while (::getrandom(&random, sizeof random, 0) != sizeof random) {
    }
    return fmt::format("{:016x}", random);
  }

  Result<std::unique_ptr<IdLock>> lock(OwnerId id) override;
  Result<std::unique_ptr<transport::LocalListener>> open(const std::string& token,
                                                         transport::LocalAccept accept) override;
  bool is_open() const override {
    struct stat found {};
    return ::lstat(own_socket_.c_str(), &found) == 0 && found.st_ino == inode_;
  }
  Result<Door> own_door() const override { return Door{own_token_, own_, own_islands_}; }
  Result<std::vector<Door>> doors() const override;
  Result<std::unique_ptr<transport::LocalStream>> connect(const Door& door, transport::LocalCallbacks calls) override;
  Result<Door> door_of(const std::string& token, const transport::LocalPeer& who) const override;
  void name_of(const transport::LocalPeer& who, transport::UserNames::Call call) override {
    names_.look_up(who, std::move(call));
  }
  Duration since_boot() const override { return base::since_boot(); }

  Result<void> make();

 private:
  struct Listener;
  std::vector<std::pair<std::string, bool>> places() const;

  Place place_;
  std::string space_;
  transport::Transports& transports_;
  transport::UserNames names_;
  std::string own_;  ///< the folder of this process
  bool own_islands_ = false;
  std::string own_token_, own_socket_;
  ino_t inode_ = 0;
};

/// The socket goes with it, if it is still there.
struct DiskFolder::Listener final : transport::LocalListener {
  Listener(std::unique_ptr<transport::LocalListener> i, std::string p, ino_t n)
      : inner(std::move(i)), path(std::move(p)), inode(n) {}
  ~Listener() override {
    struct stat found {};
    if (::lstat(path.c_str(), &found) == 0 && found.st_ino == inode) ::unlink(path.c_str());
  }
  std::unique_ptr<transport::LocalListener> inner;
  std::string path;
  ino_t inode;
};

/// In a shared place, the owner of `islands` is the user of the service.
Result<void> DiskFolder::make() {
  struct stat there {};
  const bool is_folder = ::stat(place_.path.c_str(), &there) == 0 && S_ISDIR(there.st_mode);
  if (is_folder && ::access(place_.path.c_str(), X_OK) != 0)
    return fail(trouble(place_.path, "enter the folder", errno));
  if (!place_.shared) {
    own_ = place_.path + "/" + space_;
    own_islands_ = true;
    if (auto made = make_own(place_.path, kOwn); !made) return made;
    return make_own(own_, kOwn);
  }
  struct stat islands {};
  const auto path = place_.path + "/islands";
  if (::stat(path.c_str(), &islands) != 0) return fail(trouble(path, "enter the folder", errno));
  own_islands_ = islands.st_uid == ::geteuid();
  const auto base = own_islands_ ? path : fmt::format("{}/people/{}", place_.path, ::geteuid());
  if (!own_islands_) {
    if (auto made = make_own(base, kOfPeople); !made) return made;
  }
  own_ = base + "/" + space_;
  return make_own(own_, kOfPeople);
}

Result<std::unique_ptr<IdLock>> DiskFolder::lock(OwnerId id) {
  if (number(id) < kFirstFreeId && !own_islands_)
    return fail(
        ErrorCode::kRefused,
        fmt::format("component {}: islands in {} run only as the service; for your own island set RUBICON_FOLDER "
                    "to a folder of yours",
                    number(id), place_.path));
  const auto path = fmt::format("{}/{}{}", own_, number(id), kLock);
  while (true) {
    auto file = OwnFile::of_descriptor(::open(path.c_str(), O_RDWR | O_CREAT | O_NOFOLLOW | O_CLOEXEC, 0600));
    if (file.get() < 0) return fail(trouble(path, "open the lock", errno));
    if (!try_lock(file.get())) {
      if (errno != EWOULDBLOCK) return fail(trouble(path, "lock", errno));
      return fail(ErrorCode::kDuplicate, fmt::format("component {} runs already: {}", number(id), text_in(file.get())));
    }
    if (!is_same(file.get(), path)) continue;
    const auto text = own_text();
    if (::ftruncate(file.get(), 0) != 0 || !file.write(text, path)) return fail(trouble(path, "write the lock", errno));
    return std::make_unique<DiskLock>(std::move(file), path);
  }
}

/// Under another name first, so that who finds the socket can connect to it.
Result<std::unique_ptr<transport::LocalListener>> DiskFolder::open(const std::string& token,
                                                                   transport::LocalAccept accept) {
  if (auto made = make(); !made) return fail(std::move(made.error()));
  own_token_ = token;
  own_socket_ = fmt::format("{}/{}{}", own_, token, kSocket);
  if (own_socket_.size() > transport::kMaxSocketPath)
    return fail(ErrorCode::kInvalid, fmt::format("{}: the path of a socket has at most {} bytes, this one has {}",
                                                 own_socket_, transport::kMaxSocketPath, own_socket_.size()));
  const auto before = fmt::format("{}/.{}", own_, token);
  ::unlink(before.c_str());
  auto listener = transports_.listen_local(before, std::move(accept));
  if (!listener) return fail(std::move(listener.error()));
  struct stat found {};
  if (::lstat(before.c_str(), &found) != 0 || ::rename(before.c_str(), own_socket_.c_str()) != 0)
    return fail(trouble(own_socket_, "name the socket", errno));
  inode_ = found.st_ino;
  return std::make_unique<Listener>(std::move(*listener), own_socket_, inode_);
}

/// The folders of all users, and whether ids of islands count there. Ignores a folder that has the name of another
/// user.
std::vector<std::pair<std::string, bool>> DiskFolder::places() const {
  if (!place_.shared) return {{own_, true}};
  std::vector<std::pair<std::string, bool>> all{{fmt::format("{}/islands/{}", place_.path, space_), true}};
  for (const auto& user : names_in(place_.path + "/people")) {
    const auto folder = fmt::format("{}/people/{}", place_.path, user);
    struct stat found {};
    if (all.size() > kMaxUsers) break;
    if (::lstat(folder.c_str(), &found) == 0 && S_ISDIR(found.st_mode) && user == std::to_string(found.st_uid))
      all.emplace_back(fmt::format("{}/{}", folder, space_), false);
  }
  return all;
}

Result<std::vector<Door>> DiskFolder::doors() const {
  std::vector<Door> all;
  for (const auto& [path, islands] : places()) {
    for (const auto& name : names_in(path)) {
      const auto token = name.substr(0, name.size() - std::min(name.size(), kSocket.size()));
      if (name.ends_with(kSocket) && is_token(token)) all.push_back({token, path, islands});
    }
  }
  return all;
}

/// If no process listens on a socket of this user, a process that was killed left it, and its locks. Nobody looks for
/// locks otherwise: that takes each of them for a moment, in which its component cannot start.
Result<std::unique_ptr<transport::LocalStream>> DiskFolder::connect(const Door& door, transport::LocalCallbacks calls) {
  const auto owner = owner_of(door);
  if (!owner) return fail(owner.error());
  const auto path = fmt::format("{}/{}{}", door.place, door.token, kSocket);
  auto stream = transports_.open_local(path, std::move(calls));
  if (!stream) {
    const bool is_left = stream.error().code == ErrorCode::kUnreachable && *owner == ::geteuid();
    if (is_left && ::unlink(path.c_str()) == 0) remove_left_locks(door.place);
    return stream;
  }
  if ((*stream)->peer().user != *owner)
    return fail(ErrorCode::kRefused,
                fmt::format("{} is of uid {}, but uid {} listens", path, *owner, (*stream)->peer().user));
  return stream;
}

Result<Door> DiskFolder::door_of(const std::string& token, const transport::LocalPeer& who) const {
  Error why{ErrorCode::kNotFound, fmt::format("it has no socket in {}", place_.path)};
  const auto own = fmt::format("{}/people/{}/{}", place_.path, who.user, space_);
  for (const auto& [path, islands] : std::vector<std::pair<std::string, bool>>{
           {place_.shared ? fmt::format("{}/islands/{}", place_.path, space_) : own_, true}, {own, false}}) {
    const Door door{token, path, islands};
    const auto owner = owner_of(door);
    if (owner && *owner == who.user) return door;
    if (owner) why = {ErrorCode::kRefused, fmt::format("its socket in {} is of uid {}", path, *owner)};
  }
  return fail(std::move(why));
}

}  // namespace

Result<std::unique_ptr<Folder>> open_disk_folder(const Place& place, const std::string& space, Scheduler& scheduler,
                                                 transport::Transports& transports) {
  if (auto good = check_space(space); !good) return fail(std::move(good.error()));
  auto folder = std::make_unique<DiskFolder>(place, space, scheduler, transports);
  if (auto made = folder->make(); !made) return fail(std::move(made.error()));
  return folder;
}

}  // namespace rubicon::tuples::host
