#include "trust/folder_files.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <grp.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <ctime>
#include <system_error>
#include <tuple>

namespace rubicon::trust {

namespace {

namespace fs = std::filesystem;
using base::OwnFile;

constexpr std::size_t kMaxKeySize = 4096;
constexpr mode_t kLockMode = 0600;
constexpr Duration kLockPause = std::chrono::milliseconds(50);

ErrorCode code_of(int error) {
  switch (error) {
    case EACCES:
    case EPERM:
    case EROFS: return ErrorCode::kRefused;
    case ENOENT: return ErrorCode::kNotFound;
    default: return ErrorCode::kIo;
  }
}

std::string last_part(const std::string& name) {
  return fs::path(name).filename().string();
}

/// All of the file, at most `largest` bytes; nullopt: it has more, or cannot be read.
std::optional<std::string> content_of(int descriptor, std::size_t largest) {
  std::string text(largest + 1, '\0');
  std::size_t done = 0;
  while (done < text.size()) {
    const auto count = ::read(descriptor, text.data() + done, text.size() - done);
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return {};
    if (count == 0) break;
    done += static_cast<std::size_t>(count);
  }
  if (done > largest) {
    OPENSSL_cleanse(text.data(), text.size());
    return {};
  }
  text.resize(done);
  return text;
}

/// Empty, or what is wrong with the access to a key.
std::string access_fault(const struct stat& about, KeyReaders readers) {
  const bool is_ours = about.st_uid == ::geteuid() || about.st_uid == 0;
  if (!is_ours) return "belongs to another user: expected this one, or root";
  if ((about.st_mode & (S_IRWXO | S_IWGRP | S_IXGRP)) != 0)
    return "others may use this key: expected the mode 0600; run chmod 600 as its owner";
  if ((about.st_mode & S_IRGRP) == 0) return {};
  if (readers == KeyReaders::kOwner)
    return "a group may read this key: expected the mode 0600; run chmod 600 as its owner";
  if (people_group() == about.st_gid) return {};
  return "a group may read this key: expected the mode 0600, or the group `rubicon`; run chmod 600 as its owner";
}

Result<SecretText> read_checked_key(const OwnFile& file, const std::string& path, KeyReaders readers) {
  struct stat about {};
  if (::fstat(file.get(), &about) != 0) return fail(ErrorCode::kIo, fmt::format("{}: {}", path, std::strerror(errno)));
  if (!S_ISREG(about.st_mode)) return fail(ErrorCode::kInvalid, fmt::format("{}: is not an ordinary file", path));
  if (const auto fault = access_fault(about, readers); !fault.empty())
    return fail(ErrorCode::kRefused, fmt::format("{}: {}", path, fault));
  auto text = content_of(file.get(), kMaxKeySize);
  if (!text)
    return fail(ErrorCode::kInvalid, fmt::format("{}: cannot be read, or has more than {} bytes", path, kMaxKeySize));
  return SecretText(std::move(*text));
}

/// Empty, or why this file cannot be the lock of the folder. A hard link would hand the file behind it to the owner of
/// the folder.
std::string_view fault_of_lock(const struct stat& lock, const struct stat& folder) {
  if (!S_ISREG(lock.st_mode) || lock.st_nlink != 1) return "is not an ordinary file with one name: remove it";
  if (lock.st_uid != folder.st_uid && lock.st_uid != 0) return "belongs to another user than its folder: remove it";
  return {};
}

}  // namespace

std::optional<gid_t> people_group() {
  std::array<char, 16384> texts{};
  group entry{};
  group* found = nullptr;
  if (::getgrnam_r("rubicon", &entry, texts.data(), texts.size(), &found) != 0 || found == nullptr) return {};
  return entry.gr_gid;
}

tl::unexpected<Error> FolderFiles::failed(const std::string& name, std::string_view what, int error) const {
  if (error == ELOOP || error == ENOTDIR)
    return fail(ErrorCode::kRefused,
                fmt::format("{}: a part of this path is a symbolic link, or not a folder: expected neither below {}",
                            path(name), root_.string()));
  return fail(code_of(error), fmt::format("{}: cannot {}: {}", path(name), what, std::strerror(error)));
}

Result<OwnFile> FolderFiles::open_folder_of(const std::string& name) const {
  constexpr int kFlags = O_RDONLY | O_DIRECTORY | O_CLOEXEC;
  auto folder = OwnFile::of_descriptor(::open(root_.c_str(), kFlags));
  if (folder.get() < 0) return failed(name, "open", errno);
  for (const auto& part : fs::path(name).parent_path()) {
    folder = OwnFile::of_descriptor(::openat(folder.get(), part.c_str(), kFlags | O_NOFOLLOW));
    if (folder.get() < 0) return failed(name, "open", errno);
  }
  return folder;
}

Result<OwnFile> FolderFiles::open_file(const std::string& name) const {
  const auto folder = open_folder_of(name);
  if (!folder) return fail(folder.error());
  // A pipe in place of the file must not hold up the program.
  auto file = OwnFile::of_descriptor(
      ::openat(folder->get(), last_part(name).c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK));
  if (file.get() < 0) return failed(name, "open", errno);
  return file;
}

Result<std::string> FolderFiles::read(const std::string& name, std::size_t largest) const {
  const auto file = open_file(name);
  if (!file) return fail(file.error());
  struct stat about {};
  if (::fstat(file->get(), &about) != 0) return failed(name, "read", errno);
  if (!S_ISREG(about.st_mode)) return fail(ErrorCode::kInvalid, fmt::format("{}: is not an ordinary file", path(name)));
  if ((about.st_mode & (S_IWGRP | S_IWOTH)) != 0)
    return fail(
        ErrorCode::kRefused,
        fmt::format("{}: others may change this file: expected the mode 0644; run chmod 644 as its owner", path(name)));
  auto text = content_of(file->get(), largest);
  if (!text)
    return fail(ErrorCode::kInvalid, fmt::format("{}: cannot be read, or has more than {} bytes", path(name), largest));
  return std::move(*text);
}

Result<SecretText> FolderFiles::read_key(const std::string& name, KeyReaders readers) const {
  const auto file = open_file(name);
  if (!file) return fail(file.error());
  return read_checked_key(*file, path(name), readers);
}

bool FolderFiles::exists(const std::string& name) const {
  struct stat about {};
  return ::lstat(path(name).c_str(), &about) == 0;
}

Result<void> FolderFiles::check_exists(const std::string& name, std::string_view absent) const {
  struct stat about {};
  if (::lstat(path(name).c_str(), &about) == 0) return {};
  if (errno == ENOENT) return fail(ErrorCode::kNotFound, fmt::format("{}: {}", path(name), absent));
  return failed(name, "see whether it is there", errno);
}

KeyReaders FolderFiles::key_readers(const std::string& name) const {
  struct stat about {};
  const bool is_for_group =
      ::lstat(path(name).c_str(), &about) == 0 && S_ISREG(about.st_mode) && (about.st_mode & S_IRGRP) != 0;
  return is_for_group && people_group() == about.st_gid ? KeyReaders::kPeople : KeyReaders::kOwner;
}

std::vector<std::string> FolderFiles::names(const std::string& folder) const {
  std::vector<std::string> names;
  std::error_code none;
  for (fs::directory_iterator at(root_ / folder, none), end; !none && at != end; at.increment(none)) {
    auto name = at->path().filename().string();
    if (!name.starts_with('.')) names.push_back(std::move(name));
  }
  std::sort(names.begin(), names.end());
  return names;
}

Result<void> FolderFiles::make_folder(const std::string& name, mode_t mode) const {
  if (name.empty()) {
    std::error_code error;
    if (root_.has_parent_path()) fs::create_directories(root_.parent_path(), error);
    if (::mkdir(root_.c_str(), mode) == 0) return ::chmod(root_.c_str(), mode), Result<void>();
    if (errno == EEXIST && fs::is_directory(root_, error)) return check_folder(name, mode);
    return failed(name, "make the folder", errno);
  }
  const auto parent = open_folder_of(name);
  if (!parent) return fail(parent.error());
  if (::mkdirat(parent->get(), last_part(name).c_str(), mode) != 0)
    return errno == EEXIST ? check_folder(name, mode) : failed(name, "make the folder", errno);
  // Whatever the umask took away.
  if (::fchmodat(parent->get(), last_part(name).c_str(), mode, 0) != 0) return failed(name, "change its mode", errno);
  ::fsync(parent->get());
  return {};
}

/// A user who may write a folder may replace each file in it.
Result<void> FolderFiles::check_folder(const std::string& name, mode_t mode) const {
  const auto folder = open_folder_of(name.empty() ? name : name + "/");
  if (!folder) return fail(folder.error());
  struct stat about {};
  if (::fstat(folder->get(), &about) != 0) return failed(name, "read", errno);
  if (about.st_uid != ::geteuid() && about.st_uid != 0)
    return fail(ErrorCode::kRefused,
                fmt::format("{}: this folder belongs to another user: expected this one, or root", path(name)));
  if ((about.st_mode & (S_IWGRP | S_IWOTH)) != 0)
    return fail(ErrorCode::kRefused,
                fmt::format("{}: others may change this folder: expected the mode 0{:o}; run chmod {:o} as its owner",
                            path(name), mode, mode));
  const bool is_wider = (about.st_mode & (S_IRWXG | S_IRWXO) & ~mode) != 0;
  if (is_wider && ::fchmod(folder->get(), mode) != 0) return failed(name, "change its mode", errno);
  return {};
}

Result<void> FolderFiles::write(const std::string& name, std::string_view text, mode_t mode, std::optional<gid_t> group,
                                std::optional<uid_t> owner) const {
  const auto folder = open_folder_of(name);
  if (!folder) return fail(folder.error());
  const auto last = last_part(name);
  const auto beside = fmt::format(".{}.{}", last, ::getpid());
  ::unlinkat(folder->get(), beside.c_str(), 0);  // of an earlier process with this number
  const auto file = OwnFile::of_descriptor(
      ::openat(folder->get(), beside.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0600));
  if (file.get() < 0) return failed(name, "write", errno);
  auto written = file.write(text, path(name));
  constexpr auto kSame = static_cast<id_t>(-1);
  if (written && (group || owner) && ::fchown(file.get(), owner.value_or(kSame), group.value_or(kSame)) != 0)
    written = failed(name, "give it to its owner and group", errno);
  if (written && (::fchmod(file.get(), mode) != 0 || ::fsync(file.get()) != 0)) written = failed(name, "write", errno);
  if (written && ::renameat(folder->get(), beside.c_str(), folder->get(), last.c_str()) != 0)
    written = failed(name, "replace", errno);
  if (!written) {
    ::unlinkat(folder->get(), beside.c_str(), 0);
    return written;
  }
  ::fsync(folder->get());
  return {};
}

/// Made where it is missing; one of root is given to the owner of the folder, who could not open it otherwise.
Result<OwnFile> FolderFiles::open_lock() const {
  const auto folder = open_folder_of(kLockFile);
  if (!folder) return fail(folder.error());
  struct stat folder_about {
  }, about{};
  if (::fstat(folder->get(), &folder_about) != 0) return failed(kLockFile, "open", errno);
  const auto user = ::geteuid();
  if (user != 0 && folder_about.st_uid != user && folder_about.st_uid != 0)
    return fail(ErrorCode::kRefused,
                fmt::format("{}: its folder belongs to another user: expected this one, or root", path(kLockFile)));
  auto file = OwnFile::of_descriptor(
      ::openat(folder->get(), kLockFile, O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK, kLockMode));
  if (file.get() < 0 || ::fstat(file.get(), &about) != 0) return failed(kLockFile, "open", errno);
  if (const auto fault = fault_of_lock(about, folder_about); !fault.empty())
    return fail(ErrorCode::kRefused, fmt::format("{}: {}", path(kLockFile), fault));
  if (about.st_uid != folder_about.st_uid && user == 0)
    std::ignore = ::fchown(file.get(), folder_about.st_uid, folder_about.st_gid);
  if ((about.st_mode & 07777) != kLockMode && ::fchmod(file.get(), kLockMode) != 0)
    return failed(kLockFile, "change its mode", errno);
  return file;
}

/// flock() has no time limit of its own.
Result<OwnFile> FolderFiles::lock(Duration patience) const {
  auto file = open_lock();
  if (!file) return file;
  for (Duration waited{}; ::flock(file->get(), LOCK_EX | LOCK_NB) != 0; waited += kLockPause) {
    if (errno != EWOULDBLOCK) return failed(kLockFile, "lock", errno);
    if (waited >= patience)
      return fail(ErrorCode::kBusy,
                  fmt::format("{}: another program that changes this folder has this lock{}: `fuser -v {}` shows which",
                              path(kLockFile), waited > Duration(0) ? ", for seconds already" : "", path(kLockFile)));
    const timespec pause{0, std::chrono::nanoseconds(kLockPause).count()};
    ::nanosleep(&pause, nullptr);
  }
  return file;
}

}  // namespace rubicon::trust
