#pragma once

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <unordered_map>
#include <vector>

#include "base/log.h"
#include "base/scheduler.h"
#include "tuples/host/connection.h"
#include "tuples/host/folder.h"
#include "tuples/judge.h"
#include "tuples/link.h"
#include "tuples/own_links.h"

namespace rubicon::tuples::host {

/// A process of the folder, this one too: the connection to it, and the components that it showed here.
struct Process {
  struct Component {
    std::uint64_t incarnation = 0;
    std::string host, summary;
    std::map<std::uint32_t, SubscriptionSpec> interests{};  ///< by id
  };
  static constexpr std::size_t kMaxComponents = 1000, kMaxInterests = 10'000;  ///< the latter of one component
  static constexpr std::size_t kMaxBytes = std::size_t{4} << 20;               ///< of all summaries and interests

  explicit Process(Scheduler& scheduler) : connection(scheduler) {}

  Connection connection;
  Door door{};              ///< without a token: not known yet
  bool own = false;         ///< this process
  bool ours = false;        ///< this process connected, not the other
  Member user{};            ///< `user:ann`, with `user:1000` and groups as roles; empty if there is no judge
  bool introduced = false;  ///< it received the components of this process
  bool greeted = false;     ///< its hello came
  bool ready = false;       ///< it sent all its components
  bool silent = false;      ///< it answers nothing: its components count as lost
  bool said_goodbye = false;
  bool ended = false;                  ///< to be removed in a later turn
  std::optional<uid_t> counted_for{};  ///< the user, of a connection that ProcessTables counts
  SteadyTime begun{}, heard{};
  SteadyTime asked{};  ///< zero: no question waits for its answer
  std::map<OwnerId, Component> components{};
  std::size_t bytes = 0;  ///< as kMaxBytes counts
};

/// A folder may hold hundreds of processes, and each meets all others: nothing of a meeting walks through them.
struct ProcessTables {
  bool has(const Door& door) const { return by_token.contains(door.token); }
  /// Counts the connection; how many its user has now, in both directions.
  std::size_t count(Process& process);
  /// Of a process that ends.
  void discount(Process& process);
  void unlist(const Process& process, OwnerId id);

  std::unordered_multimap<std::string, Process*> by_token{};          ///< that are not ended and whose door is known
  std::unordered_map<uid_t, std::size_t> by_user{};                   ///< connections
  std::unordered_map<OwnerId, std::vector<Process*>> by_component{};  ///< ended ones too, until they are removed
};

/// A door that is tried again: since when, when next, and after which pause.
struct Again {
  SteadyTime since{}, next{};
  Duration pause{};
};

class HostLink;

struct HostOptions {
  Duration lease = std::chrono::seconds(2);     ///< a process that does not answer for this time is lost
  Duration patience = std::chrono::seconds(2);  ///< how long is tried to reach a process whose queue is full
  /// Decides what users may do here; null: every user who may enter the folder may do everything.
  std::shared_ptr<Judge> judge = nullptr;
};

/// Components of one host that meet in a folder of Unix sockets (docs/host.md): one socket a process, one connection
/// between two processes, whatever components they have. The kernel vouches for who is behind a connection.
///
/// A process that enters connects to all sockets of the folder; who comes later connects to it. Their answers together
/// are complete. The end of a connection is the end of the process.
class HostEcology final : public StandInEcology {
 public:
  /// Enters the folder and begins to meet the others. The scheduler and the log outlive it. With the errors of
  /// Folder::open() and Folder::doors().
  static Result<std::unique_ptr<HostEcology>> open(std::unique_ptr<Folder> folder, HostOptions options,
                                                   Scheduler& scheduler, base::LogSink& log);
  ~HostEcology() override;

  /// With the errors of Folder::lock(); kDuplicate if this process has the component already. The link ends before the
  /// ecology.
  Result<std::unique_ptr<Link>> join(OwnerId id) override;
  /// Whether join() would find the id free now; the errors of Folder::lock().
  Result<void> check_free(OwnerId id);
  /// A stand-in locks nothing: the component itself may start, and displaces it.
  Result<std::unique_ptr<Link>> join_as(StandIn who) override;

  /// `call` receives, in a later turn and once per start, the component of this process whose id another process has
  /// by a better right: as an island of the service, or because it had it before. That component should end.
  void watch_displaced(std::function<void(OwnerId)> call) { displaced_ = std::move(call); }
  /// Whether each process whose socket was in the folder sent its components or is gone. Then a component that is not
  /// present does not exist.
  bool knows_all() const;
  /// The processes that did not send theirs yet: `pid 812 of uid 1000`.
  std::vector<std::string> awaited() const;
  const Folder& folder() const { return *folder_; }

 private:
  friend class HostLink;
  /// The component that counts of those with its id.
  struct Present {
    Process* at = nullptr;
    PeerIdentity who{};
  };

  HostEcology(std::unique_ptr<Folder> folder, HostOptions options, Scheduler& scheduler, base::LogSink& log);

  // -- processes (host_ecology.cpp)
  Result<void> enter();
  Result<void> open_door();
  Process& add_process();
  Connection::Callbacks calls_of(Process& process);
  Result<void> meet_all();
  void know(Process& process, Door door);
  void connect(const Door& door);
  void connect_later(const Door& door);
  void connect_again();
  transport::LocalCallbacks accept(std::unique_ptr<transport::LocalStream> stream);
  void introduce(Process& process);
  void on_ended(Process& process, const Error& why);
  void end(Process& process);
  void purge();
  void refuse(Process& process, const std::string& why);
  void look();
  void check(Process& process, SteadyTime now);
  void heard(Process& process);

  // -- what they say (host_records.cpp)
  void on_record(Process& process, const Record& record);
  Result<void> take(Process& process, const Record& record);
  Result<void> on_hello(Process& process, const Record& hello);
  bool is_twice(const Process& process, const std::string& token);
  void ask_name(Process& process);
  void take_name(Process& process, const Result<transport::UserName>& name);
  Result<void> on_up(Process& process, const Record& up);
  void forget(Process& process, OwnerId id);
  static Process::Component* component(Process& process, OwnerId id);
  bool is_present(const Process& process, OwnerId id) const;
  Result<void> on_summary(Process& process, const Record& news);
  Result<void> on_interest(Process& process, const Record& news);
  void on_no_interest(Process& process, const Record& news);
  Result<void> on_frame(Process& process, const Record& frame);
  void review(OwnerId id, PeerEvent how);
  void review_all(const Process& process, PeerEvent how);
  Process* best(OwnerId id) const;
  PeerIdentity identity(const Process& process, OwnerId id) const;
  const Present* present(OwnerId id) const;

  // -- own components (host_link.cpp)
  void tell_all(const Record& record);
  void each_listener(OwnerId peer, const std::function<void(LinkListener& to)>& call);
  bool reads_from(const Process& process) const;

  std::unique_ptr<Folder> folder_;
  HostOptions options_;
  Scheduler& scheduler_;
  base::LimitedLog log_;
  std::string token_;
  std::unique_ptr<transport::LocalListener> listener_;
  std::vector<std::unique_ptr<Process>> processes_;
  ProcessTables known_;
  std::map<Door, Again> later_;
  std::map<OwnerId, Present> present_;
  OwnLinks<HostLink> links_;
  std::function<void(OwnerId)> displaced_;
  bool meet_again_ = false;  ///< a connection broke although its process may live
  SteadyTime next_look_{};
  Timer look_timer_;
  base::Deadline connect_again_{scheduler_, [this] { connect_again(); }};
  base::OncePerTurn purge_{scheduler_, [this] { purge(); }};
  base::Lifetime lifetime_;
};

}  // namespace rubicon::tuples::host
