#include "support/memory/memory_folder.h"

#include <fmt/format.h>

#include <algorithm>
#include <deque>
#include <utility>
#include <vector>

namespace rubicon::tuples::host {

/// One end of a stream; `peer` is the other one.
struct MemoryHost::End {
  pid_t owner = 0;  ///< the process that reads here
  transport::LocalPeer who;
  transport::LocalCallbacks calls;
  std::weak_ptr<End> peer;
  Bytes arriving;
  std::deque<std::size_t> writes;  ///< of what arrives
  bool alive = true, full = false, peer_closed = false, told = false;
  Timer next;  ///< of a slow process: it reads on
};

struct MemoryHost::State : std::enable_shared_from_this<MemoryHost::State> {
  struct Standing {
    pid_t owner = 0;
    uid_t user = 0;
    bool islands = false;
    transport::LocalAccept accept;
    std::uint64_t number = 0;  ///< of all that were ever made
  };
  explicit State(Scheduler& s) : scheduler(s) {}

  std::shared_ptr<End> make_end(pid_t owner, uid_t user_of_peer, pid_t peer) {
    auto end = std::make_shared<End>();
    end->owner = owner;
    end->who = {user_of_peer, peer, {}};
    ends.push_back(end);
    return end;
  }
  bool runs(pid_t process) const { return !stopped.contains(process); }

  Bytes next_bytes(const std::shared_ptr<End>& end) {
    const auto slow = paces.find(end->owner);
    if (slow == paces.end() || end->arriving.size() <= slow->second) {
      end->writes.clear();
      return std::exchange(end->arriving, {});
    }
    for (auto left = slow->second; left >= end->writes.front(); end->writes.pop_front()) left -= end->writes.front();
    const auto rest = end->arriving.begin() + static_cast<std::ptrdiff_t>(slow->second);
    Bytes bytes(end->arriving.begin(), rest);
    end->arriving.erase(end->arriving.begin(), rest);
    end->next = scheduler.after(std::chrono::milliseconds(100), [self = shared_from_this(), to = std::weak_ptr(end)] {
      if (const auto there = to.lock()) self->arrive(there);
    });
    return bytes;
  }

  /// What arrived is read in a later turn, if the process runs then.
  void arrive(const std::shared_ptr<End>& end) {
    scheduler.post([self = shared_from_this(), end] {
      if (!end->alive || !self->runs(end->owner)) return;
      if (!end->arriving.empty()) {
        if (end->next.pending()) return;
        const auto bytes = self->next_bytes(end);
        if (end->calls.received) end->calls.received(bytes);
        if (const auto peer = end->peer.lock(); peer && std::exchange(peer->full, false)) self->writable(peer);
      }
      if (end->alive && end->peer_closed && end->arriving.empty() && !std::exchange(end->told, true) &&
          end->calls.failed)
        end->calls.failed({ErrorCode::kUnreachable, "the other process is gone"});
    });
  }
  void writable(const std::shared_ptr<End>& end) {
    scheduler.post([self = shared_from_this(), end] {
      if (end->alive && self->runs(end->owner) && end->calls.writable) end->calls.writable();
    });
  }
  void close(const std::shared_ptr<End>& end) {
    if (!std::exchange(end->alive, false)) return;
    if (const auto peer = end->peer.lock()) {
      peer->peer_closed = true;
      arrive(peer);
    }
    std::erase(ends, end);
  }

  Scheduler& scheduler;
  std::map<std::string, Standing> doors;
  std::map<std::pair<OwnerId, uid_t>, pid_t> locks;  ///< each user has a folder
  std::map<uid_t, std::string> names;
  std::vector<std::shared_ptr<End>> ends;
  std::set<pid_t> stopped;
  std::map<pid_t, std::size_t> paces;                         ///< of slow ones
  std::map<pid_t, std::vector<std::function<void()>>> later;  ///< connections that a stopped process will accept
  pid_t processes = 0;
  std::uint64_t doors_made = 0;
  std::size_t listings = 0;
  std::function<void()> meanwhile;
};

class MemoryLocal final : public transport::LocalStream {
 public:
  MemoryLocal(std::shared_ptr<MemoryHost::State> state, std::shared_ptr<MemoryHost::End> end)
      : state_(std::move(state)), end_(std::move(end)) {}
  ~MemoryLocal() override { state_->close(end_); }
  MemoryLocal(const MemoryLocal&) = delete;
  MemoryLocal& operator=(const MemoryLocal&) = delete;

  Result<std::size_t> write(ByteView bytes) override {
    const auto peer = end_->peer.lock();
    if (!peer || !peer->alive) return fail(ErrorCode::kUnreachable, "the other process is gone");
    const auto room = MemoryHost::kRoom - std::min(peer->arriving.size(), MemoryHost::kRoom);
    const auto done = std::min(bytes.size(), room);
    peer->arriving.insert(peer->arriving.end(), bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(done));
    end_->full = done < bytes.size();
    if (done > 0) peer->writes.push_back(done);
    if (done > 0) state_->arrive(peer);
    return done;
  }
  std::size_t unread() const override {
    const auto peer = end_->peer.lock();
    return peer ? peer->arriving.size() + 700 * peer->writes.size() : 0;  // as Linux counts
  }
  const transport::LocalPeer& peer() const override { return end_->who; }

 private:
  std::shared_ptr<MemoryHost::State> state_;
  std::shared_ptr<MemoryHost::End> end_;
};

/// What one process sees. Ends without a trace with the process: locks and doors are its own.
class MemoryFolder final : public Folder {
 public:
  MemoryFolder(std::shared_ptr<MemoryHost::State> state, pid_t process, uid_t user, bool islands, std::string token)
      : state_(std::move(state)), process_(process), user_(user), islands_(islands), token_(std::move(token)) {}

  std::string path() const override { return "/memory"; }
  std::string make_token() const override { return token_; }
  Result<std::unique_ptr<IdLock>> lock(OwnerId id) override {
    const auto [held, fresh] = state_->locks.try_emplace({id, user_}, process_);
    if (!fresh)
      return fail(ErrorCode::kDuplicate, fmt::format("component {} runs already: pid {}", number(id), held->second));
    return std::make_unique<Lock>(state_, std::pair(id, user_), process_);
  }
  Result<std::unique_ptr<transport::LocalListener>> open(const std::string& token,
                                                         transport::LocalAccept accept) override {
    state_->doors[token] = {process_, user_, islands_, std::move(accept), ++state_->doors_made};
    return std::make_unique<Listener>(state_, token, state_->doors_made);
  }
  void name_of(const transport::LocalPeer& who, transport::UserNames::Call call) override {
    const auto number = std::to_string(who.user);
    const auto found = state_->names.find(who.user);
    transport::UserName name{found == state_->names.end() ? number : found->second, number, {}};
    for (const auto group : who.groups) name.groups.push_back(std::to_string(group));
    state_->scheduler.post([name, call = std::move(call)] { call(name); });
  }
  bool is_open() const override { return state_->doors.contains(token_); }
  Result<Door> own_door() const override { return Door{token_, path(), islands_}; }
  Result<std::vector<Door>> doors() const override {
    if (const auto call = std::exchange(state_->meanwhile, nullptr)) call();
    ++state_->listings;
    std::vector<Door> all;
    for (const auto& [token, standing] : state_->doors) all.push_back({token, path(), standing.islands});
    return all;
  }
  Result<std::unique_ptr<transport::LocalStream>> connect(const Door& door, transport::LocalCallbacks calls) override {
    const auto found = state_->doors.find(door.token);
    if (found == state_->doors.end()) return fail(ErrorCode::kNotFound, door.token + " is not there");
    const auto& standing = found->second;
    auto here = state_->make_end(process_, standing.user, standing.owner);
    auto there = state_->make_end(standing.owner, user_, process_);
    here->calls = std::move(calls);
    here->peer = there;
    there->peer = here;
    auto arrive = [state = state_, there, token = door.token] {
      const auto now = state->doors.find(token);
      if (now == state->doors.end() || !there->alive) return state->close(there);
      there->calls = now->second.accept(std::make_unique<MemoryLocal>(state, there));
      state->arrive(there);
    };
    if (state_->runs(standing.owner)) {
      state_->scheduler.post(std::move(arrive));
    } else {
      state_->later[standing.owner].push_back(std::move(arrive));
    }
    return std::make_unique<MemoryLocal>(state_, std::move(here));
  }
  Result<Door> door_of(const std::string& token, const transport::LocalPeer& who) const override {
    const auto found = state_->doors.find(token);
    if (found == state_->doors.end() || found->second.owner != who.process)
      return fail(ErrorCode::kRefused, "it has no socket in the folder");
    return Door{token, path(), found->second.islands};
  }
  Duration since_boot() const override { return state_->scheduler.now().time_since_epoch() + std::chrono::hours(1); }

 private:
  struct Lock final : IdLock {
    Lock(std::shared_ptr<MemoryHost::State> s, std::pair<OwnerId, uid_t> i, pid_t p)
        : state(std::move(s)), id(i), process(p) {}
    ~Lock() override {
      const auto found = state->locks.find(id);
      if (found != state->locks.end() && found->second == process) state->locks.erase(found);
    }
    std::shared_ptr<MemoryHost::State> state;
    std::pair<OwnerId, uid_t> id;
    pid_t process;
  };
  struct Listener final : transport::LocalListener {
    Listener(std::shared_ptr<MemoryHost::State> s, std::string t, std::uint64_t n)
        : state(std::move(s)), token(std::move(t)), number(n) {}
    ~Listener() override {
      const auto found = state->doors.find(token);
      if (found != state->doors.end() && found->second.number == number) state->doors.erase(found);
    }
    std::shared_ptr<MemoryHost::State> state;
    std::string token;
    std::uint64_t number;
  };
  std::shared_ptr<MemoryHost::State> state_;
  pid_t process_;
  uid_t user_;
  bool islands_;
  std::string token_;
};

MemoryHost::MemoryHost(Scheduler& scheduler) : state_(std::make_shared<State>(scheduler)) {}
MemoryHost::~MemoryHost() = default;

std::unique_ptr<Folder> MemoryHost::enter(uid_t user, bool islands) {
  const auto process = ++state_->processes;
  const auto order = tokens_shrink ? 1'000'000 - process : process;
  return std::make_unique<MemoryFolder>(state_, process, user, islands, fmt::format("{:016}", order));
}

void MemoryHost::stop(pid_t process) {
  state_->stopped.insert(process);
}

void MemoryHost::slow_down(pid_t process, std::size_t bytes) {
  state_->paces[process] = bytes;
}

void MemoryHost::go_on(pid_t process) {
  state_->stopped.erase(process);
  for (auto& call : std::exchange(state_->later[process], {})) state_->scheduler.post(std::move(call));
  for (const auto& end : std::vector(state_->ends)) {
    if (end->owner != process) continue;
    state_->arrive(end);
    state_->writable(end);
  }
}

void MemoryHost::kill(pid_t process) {
  stop(process);
  std::erase_if(state_->doors, [&](const auto& one) { return one.second.owner == process; });
  std::erase_if(state_->locks, [&](const auto& one) { return one.second == process; });
  for (const auto& end : std::vector(state_->ends)) {
    if (end->owner == process) state_->close(end);
  }
}

void MemoryHost::meanwhile(std::function<void()> call) {
  state_->meanwhile = std::move(call);
}

void MemoryHost::name(uid_t user, std::string name) {
  state_->names[user] = std::move(name);
}

void MemoryHost::clean() {
  state_->doors.clear();
}

std::size_t MemoryHost::doors() const {
  return state_->doors.size();
}

std::size_t MemoryHost::listings() const {
  return state_->listings;
}

}  // namespace rubicon::tuples::host
