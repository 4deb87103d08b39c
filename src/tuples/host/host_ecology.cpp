#include "tuples/host/host_ecology.h"

#include <fmt/format.h>

#include <algorithm>

#include "transport/host_names.h"
#include "tuples/host/host_link.h"
#include "tuples/refusals.h"

namespace rubicon::tuples::host {

namespace {

/// A process that connected says who it is within this time.
constexpr Duration kHelloTime = std::chrono::seconds(2);
/// Pause before a process whose queue is full, or which chose another connection, is tried again.
constexpr Duration kPause = std::chrono::milliseconds(10);
/// The shortest time between two checks of the other processes and of the own socket.
constexpr Duration kMaxLook = std::chrono::seconds(1);
constexpr std::size_t kMaxConnections = 256;  ///< of one user to this process

std::string text_of(const transport::LocalPeer& who) {
  return fmt::format("pid {} of uid {}", who.process, who.user);
}

}  // namespace

std::size_t ProcessTables::count(Process& process) {
  process.counted_for = process.connection.peer().user;
  return ++by_user[*process.counted_for];
}

void ProcessTables::discount(Process& process) {
  const auto user = std::exchange(process.counted_for, std::nullopt);
  if (user && --by_user[*user] == 0) by_user.erase(*user);
  const auto [first, last] = by_token.equal_range(process.door.token);
  const auto known = std::find_if(first, last, [&](const auto& one) { return one.second == &process; });
  if (known != last) by_token.erase(known);
}

void ProcessTables::unlist(const Process& process, OwnerId id) {
  const auto found = by_component.find(id);
  std::erase(found->second, &process);
  if (found->second.empty()) by_component.erase(found);
}

HostEcology::HostEcology(std::unique_ptr<Folder> folder, HostOptions options, Scheduler& scheduler, base::LogSink& log)
    : folder_(std::move(folder)),
      options_(options),
      scheduler_(scheduler),
      log_(Log(log, "host"), scheduler),
      token_(folder_->make_token()) {}

Result<std::unique_ptr<HostEcology>> HostEcology::open(std::unique_ptr<Folder> folder, HostOptions options,
                                                       Scheduler& scheduler, base::LogSink& log) {
  std::unique_ptr<HostEcology> ecology(new HostEcology(std::move(folder), options, scheduler, log));
  if (auto entered = ecology->enter(); !entered) return fail(std::move(entered.error()));
  return ecology;
}

HostEcology::~HostEcology() {
  tell_all({Record::Type::kGoodbye});
  for (const auto& process : processes_) {
    if (!process->own) process->connection.flush();
  }
}

/// Listens first, so that a process that comes meanwhile finds this one.
Result<void> HostEcology::enter() {
  if (auto opened = open_door(); !opened) return opened;
  auto& own = add_process();
  own.own = own.ours = true;
  own.connection.loop(calls_of(own));
  introduce(own);
  if (auto met = meet_all(); !met) return met;
  look();
  return {};
}

Result<void> HostEcology::open_door() {
  auto listener = folder_->open(token_, [this](auto stream) { return accept(std::move(stream)); });
  if (!listener) return fail(std::move(listener.error()));
  listener_ = std::move(*listener);
  return {};
}

Process& HostEcology::add_process() {
  auto& process = *processes_.emplace_back(std::make_unique<Process>(scheduler_));
  process.begun = process.heard = scheduler_.now();
  return process;
}

Connection::Callbacks HostEcology::calls_of(Process& process) {
  return {[this, &process](const Record& record) { on_record(process, record); },
          [this, &process](const Error& why) { on_ended(process, why); }};
}

Result<void> HostEcology::meet_all() {
  const auto doors = folder_->doors();
  if (!doors) return fail(doors.error());
  for (const auto& door : *doors) {
    if (door.token != token_ && !known_.has(door)) connect(door);
  }
  return {};
}

/// From now on the process is the one behind that door.
void HostEcology::know(Process& process, Door door) {
  if (process.door.token.empty()) known_.by_token.emplace(door.token, &process);
  process.door = std::move(door);
}

void HostEcology::connect(const Door& door) {
  auto& process = add_process();
  process.ours = true;
  know(process, door);
  auto stream = folder_->connect(door, process.connection.begin(calls_of(process)));
  if (stream) {
    process.connection.take(std::move(*stream));
    if (known_.count(process) > kMaxConnections) return refuse(process, "its user has too many processes already");
    return introduce(process);
  }
  end(process);
  const auto& why = stream.error();
  if (why.code == ErrorCode::kBusy) return connect_later(door);
  later_.erase(door);
  if (why.code != ErrorCode::kNotFound && why.code != ErrorCode::kUnreachable) log_.warning(door.place, why.text);
}

void HostEcology::connect_later(const Door& door) {
  const auto now = scheduler_.now();
  auto& again = later_.try_emplace(door, Again{now, now, kPause / 2}).first->second;
  again.pause *= 2;
  again.next = now + again.pause;
  if (again.since + options_.patience > now) return connect_again_.advance_to(again.next);
  later_.erase(door);
  meet_again_ = true;
}

/// Those whose pause is over.
void HostEcology::connect_again() {
  const auto now = scheduler_.now();
  const auto all = later_;
  for (const auto& [door, again] : all) {
    if (again.next > now) {
      connect_again_.advance_to(again.next);
    } else if (!known_.has(door)) {
      connect(door);  // its hello ends the wait
    }
  }
}

transport::LocalCallbacks HostEcology::accept(std::unique_ptr<transport::LocalStream> stream) {
  auto& process = add_process();
  auto calls = process.connection.begin(calls_of(process));
  process.connection.take(std::move(stream));
  if (known_.count(process) > kMaxConnections)
    lifetime_.post(scheduler_, [this, &process] { refuse(process, "its user has too many connections already"); });
  return calls;
}

/// What is said first: who this process is, its components, and what they subscribe to.
void HostEcology::introduce(Process& process) {
  process.introduced = true;
  process.connection.send({Record::Type::kHello, {}, {}, kProtocolVersion, token_});
  for (const auto& [id, link] : links_.all()) {
    if (!link->attached()) continue;
    link->show(process.connection);
    link->ask(process.connection);
  }
  process.connection.send({Record::Type::kReady});
}

/// A process that this one reached, and that ended before it said who it is, may have chosen its own connection to this
/// process, whose hello is under way.
void HostEcology::on_ended(Process& process, const Error& why) {
  if (process.ended) return;
  const auto door = process.door;
  const bool met = process.greeted, left = process.said_goodbye, ours = process.ours;
  if (met && !left && why.code == ErrorCode::kInvalid)
    log_.warning(door.token, door.place + ": " + why.text + ": closed");
  end(process);
  if (!met && ours) connect_later(door);
  meet_again_ |= met && !left;
}

void HostEcology::end(Process& process) {
  process.ended = true;
  known_.discount(process);
  process.connection.close();
  review_all(process, process.said_goodbye ? PeerEvent::kLeft : PeerEvent::kLost);
  purge_.request();
}

void HostEcology::purge() {
  for (const auto& process : processes_) {
    if (!process->ended) continue;
    for (const auto& [id, component] : process->components) known_.unlist(*process, id);
  }
  std::erase_if(processes_, [](const auto& one) { return one->ended; });
}

void HostEcology::refuse(Process& process, const std::string& why) {
  if (process.ended) return;
  if (process.own) return void(log_.error("own", fmt::format("a record of this process: {}", why)));
  const auto who = text_of(process.connection.peer());
  log_.warning(who, fmt::format("{} is refused: {}", who, why));
  end(process);
}

/// Asks a process whether it lives only while this process depends on it. Makes the own socket again if it is gone.
void HostEcology::look() {
  const auto pace = std::min(options_.lease / 2, kMaxLook);
  const auto now = scheduler_.now();
  const bool was_stopped = next_look_ != SteadyTime{} && now > next_look_ + pace;
  next_look_ = now + pace;
  look_timer_ = scheduler_.at(next_look_, [this] { look(); });
  std::vector<Process*> all;
  for (const auto& one : processes_) all.push_back(one.get());
  const auto alive = lifetime_.watch();
  for (auto* process : all) {
    if (alive.ended()) return;
    // Reads what arrived while this process was stopped, before it calls another process silent.
    if (was_stopped && process->asked != SteadyTime{}) process->asked = now;
    check(*process, now);
  }
  if (alive.ended()) return;
  if (!folder_->is_open()) {
    if (auto opened = open_door(); !opened) log_.warning("door", opened.error().text);
    meet_again_ = true;
  }
  if (!std::exchange(meet_again_, false)) return;
  if (auto met = meet_all(); !met) log_.warning("doors", met.error().text);
}

void HostEcology::check(Process& process, SteadyTime now) {
  if (process.own || process.ended) return;
  if (!process.greeted) {
    if (!process.ours && now - process.begun > kHelloTime) refuse(process, "it does not say who it is");
    return;
  }
  if (process.asked != SteadyTime{}) {
    if (process.connection.has_read()) process.asked = now;  // the question may wait behind much else
    if (process.silent || now - process.asked < options_.lease) return;
    process.silent = true;
    return review_all(process, PeerEvent::kLost);
  }
  if (!reads_from(process) && process.connection.unread() == 0) return;
  if (now - process.heard < options_.lease / 2) return;
  process.connection.send({Record::Type::kAsk});
  process.connection.watch_reading();
  process.asked = now;
}

/// A process that was silent and answers again: its components are met again, and their snapshots are requested.
void HostEcology::heard(Process& process) {
  process.heard = scheduler_.now();
  process.asked = {};
  if (!std::exchange(process.silent, false)) return;
  for (const auto& [id, link] : links_.all()) {
    if (link->attached()) link->ask(process.connection);
  }
  review_all(process, PeerEvent::kLost);
}

bool HostEcology::knows_all() const {
  return later_.empty() && std::none_of(processes_.begin(), processes_.end(),
                                        [](const auto& one) { return !one->ended && one->ours && !one->ready; });
}

std::vector<std::string> HostEcology::awaited() const {
  std::vector<std::string> all;
  for (const auto& one : processes_) {
    if (!one->ended && one->ours && !one->own && !one->ready) all.push_back(text_of(one->connection.peer()));
  }
  for (const auto& [door, again] : later_) {
    if (!known_.has(door)) all.push_back(fmt::format("the process of {}/{}.sock", door.place, door.token));
  }
  return all;
}

Result<void> HostEcology::check_free(OwnerId id) {
  const auto lock = folder_->lock(id);
  return lock ? Result<void>() : fail(lock.error());
}

Result<std::unique_ptr<Link>> HostEcology::join(OwnerId id) {
  if (links_.find(id)) return fail(already_here(id));
  auto lock = folder_->lock(id);
  if (!lock) return fail(std::move(lock.error()));
  const auto displaced = [this, id] {
    if (displaced_) displaced_(id);
  };
  return std::make_unique<HostLink>(*this, StandIn{id, transport::host_id("host"), displaced}, std::move(*lock));
}

Result<std::unique_ptr<Link>> HostEcology::join_as(StandIn who) {
  if (links_.find(who.id)) return fail(already_here(who.id));
  return std::make_unique<HostLink>(*this, std::move(who), nullptr);
}

}  // namespace rubicon::tuples::host
