#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "rubicon/address.hpp"
#include "rubicon/time.hpp"
#include "transport/local_stream.h"
#include "transport/user_names.h"

namespace rubicon::tuples::host {

/// Ids from here on are free for everybody; those below are of islands and count at the doors of islands only.
inline constexpr std::uint32_t kFirstFreeId = 65536;

/// The socket of a process in the folder.
struct Door {
  std::string token;     ///< of the process: 16 hexadecimal digits, the name of the socket without `.sock`
  std::string place;     ///< the folder where it stands
  bool islands = false;  ///< ids of islands count here
  friend auto operator<=>(const Door&, const Door&) = default;
};

/// An id that no other process can have while this lives.
class IdLock {
 public:
  virtual ~IdLock() = default;
};

/// Where the processes of one space meet: what the engine needs of the disk and the kernel, which tests replace by
/// memory and virtual time.
class Folder {
 public:
  virtual ~Folder() = default;
  /// The folder as people know it, for texts.
  virtual std::string path() const = 0;
  /// A new token, which no other process has.
  virtual std::string make_token() const = 0;
  /// kDuplicate with who has it: `component 6541 runs already: rubicon-proxy, pid 812 of root since 10:07`; kRefused:
  /// islands run elsewhere; kIo with the reason.
  virtual Result<std::unique_ptr<IdLock>> lock(OwnerId id) = 0;
  /// Makes the socket of this process, which is removed with the listener. kInvalid: its path is too long; kIo: the
  /// file system has no sockets or locks.
  virtual Result<std::unique_ptr<transport::LocalListener>> open(const std::string& token,
                                                                 transport::LocalAccept accept) = 0;
  /// Whether that socket still stands where it was made.
  virtual bool is_open() const = 0;
  /// That of this process, after open().
  virtual Result<Door> own_door() const = 0;
  /// The sockets of all processes, this one's too, by place and token.
  virtual Result<std::vector<Door>> doors() const = 0;
  /// kNotFound, kUnreachable: no process is behind the door; kBusy: try again a little later; kRefused: it is not the
  /// door of the process behind it, or not for this user; else kIo.
  virtual Result<std::unique_ptr<transport::LocalStream>> connect(const Door& door, transport::LocalCalls calls) = 0;
  /// The door of a process that connected to this one and says that it has this token. kNotFound: it has no such door,
  /// or no more; kRefused: that door is of another user.
  virtual Result<Door> door_of(const std::string& token, const transport::LocalPeer& who) const = 0;
  /// `call` receives the name of a user, in a later turn.
  virtual void name_of(const transport::LocalPeer& who, transport::UserNames::Call call) = 0;
  /// Since the start of the kernel, also while it slept: the same for all processes of the host (CLOCK_BOOTTIME).
  virtual Duration since_boot() const = 0;
};

}  // namespace rubicon::tuples::host
