#include "state/crashing_disk.h"

#include <fcntl.h>
#include <sqlite3.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>
#include <map>
#include <new>
#include <random>
#include <string>
#include <vector>

namespace rubicon::state {
namespace {

constexpr std::size_t kSector = 512;

/// One change of a file that is not on the disk yet.
struct Change {
  bool truncation = false;
  std::size_t offset = 0;  ///< of a truncation: the new size
  std::string bytes;
};

void apply(const Change& change, std::string& content) {
  if (change.truncation) {
    content.resize(std::min(content.size(), change.offset));
    return;
  }
  if (content.size() < change.offset + change.bytes.size()) content.resize(change.offset + change.bytes.size());
  content.replace(change.offset, change.bytes.size(), change.bytes);
}

struct Inode {
  std::string synced;
  std::vector<Change> changes;
  bool deleted = false;
};

struct Disk {
  CrashPlan plan;
  std::int64_t operations = 0;
  sqlite3_vfs* real = nullptr;
  std::map<std::string, Inode> files;
};

Disk& disk() {
  static auto* const one = new Disk;  // outlives every connection
  return *one;
}

std::string content_of(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

void lose_power() {
  std::mt19937 random(disk().plan.seed);
  for (auto& [path, inode] : disk().files) {
    auto content = inode.synced;
    if (disk().plan.loss == CrashPlan::Loss::kSome) {
      for (const auto& change : inode.changes) {
        if (random() % 2 == 0) apply(change, content);
      }
      if (inode.deleted && random() % 2 == 0) continue;
    }
    std::ofstream(path, std::ios::binary | std::ios::trunc) << content;
  }
}

void operation() {
  if (++disk().operations != disk().plan.operation) return;
  if (disk().plan.loss != CrashPlan::Loss::kProcess) lose_power();
  ::_exit(kCrashed);
}

struct File {
  sqlite3_file base;
  Inode* inode;
  sqlite3_file* real() { return reinterpret_cast<sqlite3_file*>(this + 1); }
};

File* of(sqlite3_file* file) {
  return reinterpret_cast<File*>(file);
}
sqlite3_file* real(sqlite3_file* file) {
  return of(file)->real();
}

int close_file(sqlite3_file* file) {
  return real(file)->pMethods ? real(file)->pMethods->xClose(real(file)) : SQLITE_OK;
}
int read_file(sqlite3_file* file, void* to, int size, sqlite3_int64 offset) {
  return real(file)->pMethods->xRead(real(file), to, size, offset);
}
int write_file(sqlite3_file* file, const void* from, int size, sqlite3_int64 offset) {
  operation();
  const std::string bytes(static_cast<const char*>(from), static_cast<std::size_t>(size));
  for (std::size_t at = 0; at < bytes.size(); at += kSector) {
    of(file)->inode->changes.push_back({false, static_cast<std::size_t>(offset) + at, bytes.substr(at, kSector)});
  }
  return real(file)->pMethods->xWrite(real(file), from, size, offset);
}
int truncate_file(sqlite3_file* file, sqlite3_int64 size) {
  operation();
  of(file)->inode->changes.push_back({true, static_cast<std::size_t>(size), {}});
  return real(file)->pMethods->xTruncate(real(file), size);
}
int sync_file(sqlite3_file* file, int) {
  operation();
  auto& inode = *of(file)->inode;
  for (const auto& change : inode.changes) apply(change, inode.synced);
  inode.changes.clear();
  return SQLITE_OK;  // the real disk need not know
}
int size_of_file(sqlite3_file* file, sqlite3_int64* size) {
  return real(file)->pMethods->xFileSize(real(file), size);
}
int lock_file(sqlite3_file* file, int level) {
  return real(file)->pMethods->xLock(real(file), level);
}
int unlock_file(sqlite3_file* file, int level) {
  return real(file)->pMethods->xUnlock(real(file), level);
}
int check_lock(sqlite3_file* file, int* held) {
  return real(file)->pMethods->xCheckReservedLock(real(file), held);
}
int control_file(sqlite3_file* file, int what, void* argument) {
  return real(file)->pMethods->xFileControl(real(file), what, argument);
}
int sector_size(sqlite3_file*) {
  return kSector;
}
int characteristics(sqlite3_file*) {
  return 0;  // promises nothing: SQLite must take care itself
}
int map_shared(sqlite3_file* file, int page, int size, int extend, void volatile** to) {
  return real(file)->pMethods->xShmMap(real(file), page, size, extend, to);
}
int lock_shared(sqlite3_file* file, int offset, int count, int flags) {
  return real(file)->pMethods->xShmLock(real(file), offset, count, flags);
}
void order_shared(sqlite3_file* file) {
  real(file)->pMethods->xShmBarrier(real(file));
}
int unmap_shared(sqlite3_file* file, int deletes) {
  return real(file)->pMethods->xShmUnmap(real(file), deletes);
}

const sqlite3_io_methods kMethods{
    2,           close_file,   read_file,    write_file,   truncate_file, sync_file,       size_of_file,
    lock_file,   unlock_file,  check_lock,   control_file, sector_size,   characteristics, map_shared,
    lock_shared, order_shared, unmap_shared, nullptr,      nullptr};

int open_file(sqlite3_vfs*, const char* path, sqlite3_file* file, int flags, int* out_flags) {
  auto* opened = of(file);
  opened->base.pMethods = nullptr;
  if (!path) return SQLITE_CANTOPEN;  // no temporary files here
  auto [inode, fresh] = disk().files.try_emplace(path);
  if (fresh) inode->second.synced = content_of(path);
  if (inode->second.deleted) inode->second = {};
  opened->inode = &inode->second;
  const int code = disk().real->xOpen(disk().real, path, opened->real(), flags, out_flags);
  if (code == SQLITE_OK) opened->base.pMethods = &kMethods;
  return code;
}

int delete_file(sqlite3_vfs*, const char* path, int sync_folder) {
  operation();
  const auto inode = disk().files.find(path);
  if (inode != disk().files.end()) {
    if (sync_folder) {
      disk().files.erase(inode);
    } else {
      inode->second.deleted = true;
    }
  }
  return disk().real->xDelete(disk().real, path, sync_folder);
}

}  // namespace

void install_crashing_disk(const CrashPlan& plan) {
  static sqlite3_vfs own;
  disk().plan = plan;
  disk().operations = 0;
  disk().files.clear();
  if (disk().real) return;
  disk().real = sqlite3_vfs_find(nullptr);
  own = *disk().real;
  own.zName = "crashing";
  own.pNext = nullptr;
  own.szOsFile = static_cast<int>(sizeof(File)) + disk().real->szOsFile;
  own.xOpen = open_file;
  own.xDelete = delete_file;
  sqlite3_vfs_register(&own, 1);
}

void remove_crashing_disk() {
  sqlite3_vfs_unregister(sqlite3_vfs_find("crashing"));
  sqlite3_vfs_register(disk().real, 1);
  disk().real = nullptr;
  disk().files.clear();
}

std::int64_t disk_operations() {
  return disk().operations;
}

}  // namespace rubicon::state
