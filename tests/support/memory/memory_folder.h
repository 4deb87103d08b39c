#pragma once

#include <functional>
#include <map>
#include <memory>
#include <set>
#include <string>

#include "base/scheduler.h"
#include "tuples/host/folder.h"

namespace rubicon::tuples::host {

/// The folder of a space in memory, for processes in virtual time: bytes arrive in the next turn, as long as the
/// process that reads them runs. Outlives the folders and all streams.
class MemoryHost {
 public:
  /// Bytes that a stream takes before its reader has them.
  static constexpr std::size_t kRoom = std::size_t{200} * 1024;

  explicit MemoryHost(Scheduler& scheduler);
  ~MemoryHost();
  MemoryHost(const MemoryHost&) = delete;
  MemoryHost& operator=(const MemoryHost&) = delete;

  /// The view of one process. Tokens grow from process to process, or shrink.
  std::unique_ptr<Folder> enter(uid_t user = 1000, bool islands = true);
  bool tokens_shrink = false;
  /// Processes with this number, which count from 1, are stopped: they read nothing and nobody reaches their loop.
  void stop(pid_t process);
  void go_on(pid_t process);
  /// From now on the process reads so many bytes of a stream at once, ten times a second.
  void slow_down(pid_t process, std::size_t bytes);
  /// The process ends without a goodbye: its streams and its door close, its locks end.
  void kill(pid_t process);
  /// What happens while the next process looks for the others, after it opened its own door.
  void meanwhile(std::function<void()> call);
  /// A cleaner removes all sockets; processes keep their connections.
  void clean();
  std::size_t doors() const;
  /// How often processes listed the folder.
  std::size_t listings() const;
  /// The system knows this user by that name; others have their numbers only.
  void name(uid_t user, std::string name);

 private:
  friend class MemoryFolder;
  friend class MemoryLocal;
  struct End;
  struct State;
  std::shared_ptr<State> state_;
};

}  // namespace rubicon::tuples::host
