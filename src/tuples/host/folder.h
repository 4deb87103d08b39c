#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/scheduler.h"
#include "rubicon/address.hpp"
#include "rubicon/result.hpp"
#include "rubicon/time.hpp"
#include "transport/sockets.h"
#include "transport/transports.h"
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
  virtual Result<std::unique_ptr<transport::LocalStream>> connect(const Door& door,
                                                                  transport::LocalCallbacks calls) = 0;
  /// The door of a process that connected to this one and says that it has this token. kNotFound: it has no such door,
  /// or no more; kRefused: that door is of another user.
  virtual Result<Door> door_of(const std::string& token, const transport::LocalPeer& who) const = 0;
  /// `call` receives the name of a user, in a later turn.
  virtual void name_of(const transport::LocalPeer& who, transport::UserNames::Call call) = 0;
  /// Since the start of the kernel, also while it slept: the same for all processes of the host (CLOCK_BOOTTIME).
  virtual Duration since_boot() const = 0;
};

/// The folder that the unit and the packages make.
inline constexpr const char* kInstalledFolder = "/run/rubicon";
inline constexpr const char* kDefaultSpace = "default";

/// Where the processes of a space meet.
struct Place {
  std::string path;
  /// Of several users: islands stand in `islands`, all others in `people/<uid>`. Else the folder of one person.
  bool shared = false;
};

/// What decides about the place besides the configuration.
struct Surroundings {
  std::string installed = kInstalledFolder;
  std::string given{};      ///< RUBICON_FOLDER
  std::string beside{};     ///< a folder that stands in the file `rubicon.folder` beside the program, if it exists
  std::string runtime{};    ///< XDG_RUNTIME_DIR
  std::string temporary{};  ///< the system's folder for temporary files
  std::string people = "/run/user";  ///< where folders as XDG_RUNTIME_DIR stand
  static Surroundings of_process();
};

/// The place: the first of RUBICON_FOLDER, `configured`, that of a demo of the same tree, the installed folder where
/// this user may enter it, and the person's own, which is `rubicon` in XDG_RUNTIME_DIR where that is this user's, else
/// `rubicon-<uid>` in the folder for temporary files. kInvalid for a path that is not absolute.
Result<Place> choose_place(const std::string& configured, const Surroundings& around);

/// Other folders of this host where components are, as far as this user may see: of people, and the installed one.
std::vector<std::string> other_places(const std::string& used, const Surroundings& around);
/// Whether the installed folder is there, and closed to this user.
bool is_shut_out(const Surroundings& around);

/// RUBICON_SPACE, else the configured one, else `default`.
std::string choose_space(const std::string& configured);

/// The space of a host that takes the place of a DDS domain with a tag: `d3-<tag>`.
std::string space_of(std::uint32_t domain, const std::string& tag);

/// A space has 1 to 40 of `A-Za-z0-9._-`, and begins with no dot. kInvalid says so.
Result<void> check_space(const std::string& space);

/// The folder of a space on the disk, `<place>/<space>`; below a shared place `islands/<space>` and
/// `people/<uid>/<space>`. Makes what is missing. Checks owner and permissions, and follows no symbolic link. kInvalid:
/// the space has no valid name; kRefused: the folder belongs to another user, is open to others, or may not be entered;
/// kIo: the file system refuses. Scheduler and transports outlive the folder.
Result<std::unique_ptr<Folder>> open_disk_folder(const Place& place, const std::string& space, Scheduler& scheduler,
                                                 transport::Transports& transports);

}  // namespace rubicon::tuples::host
