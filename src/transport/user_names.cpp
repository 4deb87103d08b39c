#include "transport/user_names.h"

#include <grp.h>
#include <pwd.h>

#include <cerrno>
#include <optional>
#include <utility>

namespace rubicon::transport {

namespace {

/// Names that are kept; beyond them all are asked for again.
constexpr std::size_t kMaxKept = 1000;
/// A group has a list of its members in there.
constexpr std::size_t kMaxText = std::size_t{4} << 20;

/// Calls `ask` with more and more room. nullopt: the system cannot tell; an empty text: it knows none.
template <class Entry, class Ask>
std::optional<std::string> ask_system(const Ask& ask, char* Entry::*name) {
  for (std::size_t room = 4096; room <= kMaxText; room *= 4) {
    std::vector<char> text(room);
    Entry entry{};
    Entry* found = nullptr;
    const int error = ask(entry, text, found);
    if (error == ERANGE || error == EINTR) continue;
    if (found) return entry.*name;
    // getpwnam_r(3): what says "there is none" differs.
    const bool is_none = error == 0 || error == ENOENT || error == ESRCH || error == EBADF || error == EPERM;
    return is_none ? std::optional(std::string()) : std::nullopt;
  }
  return std::nullopt;
}

std::optional<std::string> system_name(uid_t user) {
  return ask_system<passwd>(
      [user](auto& entry, auto& text, auto*& found) {
        return ::getpwuid_r(user, &entry, text.data(), text.size(), &found);
      },
      &passwd::pw_name);
}

std::optional<std::string> system_group(gid_t number) {
  return ask_system<group>(
      [number](auto& entry, auto& text, auto*& found) {
        return ::getgrgid_r(number, &entry, text.data(), text.size(), &found);
      },
      &group::gr_name);
}

}  // namespace

void UserNames::look_up(const LocalPeer& who, Call call) {
  auto question = unknown(who);
  const bool is_known = question.users.empty() && question.groups.empty();
  if (!worker_ && !is_known) worker_ = transports_.start_worker("user names").value_or(nullptr);
  if (!worker_ || is_known)
    return lifetime_.post(scheduler_, [this, who, call = std::move(call)] { call(name_of(who)); });
  if (waiting_ >= kMaxWaiting)
    return lifetime_.post(
        scheduler_, [call = std::move(call)] { call(fail(ErrorCode::kBusy, "too many users wait for their names")); });
  ++waiting_;
  auto answered = lifetime_.guard([this, who, call = std::move(call)](const Question& answers) {
    --waiting_;
    keep(answers);
    call(answers.failed ? Result<UserName>(fail(ErrorCode::kIo, "the system cannot name its user and groups"))
                        : Result<UserName>(name_of(who)));
  });
  worker_->run([question = std::move(question), answered = std::move(answered), &scheduler = scheduler_]() mutable {
    for (auto& [number, found] : question.users) {
      const auto name = system_name(number);
      found.name = name.value_or("");
      question.failed |= !name;
    }
    for (auto& [number, found] : question.groups) {
      const auto name = system_group(number);
      found.name = name.value_or("");
      question.failed |= !name;
    }
    scheduler.post([question = std::move(question), answered = std::move(answered)]() mutable { answered(question); });
  });
}

/// The numbers whose names are not known, or were asked for long ago.
UserNames::Question UserNames::unknown(const LocalPeer& who) const {
  const auto now = scheduler_.now();
  const auto is_known = [now](const auto& all, auto number) {
    const auto found = all.find(number);
    return found != all.end() && now - found->second.since < kKept;
  };
  Question question;
  if (!is_known(users_, who.user)) question.users[who.user].since = now;
  for (const auto group : who.groups) {
    if (!is_known(groups_, group)) question.groups[group].since = now;
  }
  return question;
}

void UserNames::keep(const Question& answers) {
  if (answers.failed) return;
  if (users_.size() + groups_.size() > kMaxKept) {
    users_.clear();
    groups_.clear();
  }
  for (const auto& [number, found] : answers.users) users_.insert_or_assign(number, found);
  for (const auto& [number, found] : answers.groups) groups_.insert_or_assign(number, found);
}

UserName UserNames::name_of(const LocalPeer& who) const {
  UserName name{std::to_string(who.user), std::to_string(who.user), {}};
  if (const auto found = users_.find(who.user); found != users_.end() && !found->second.name.empty())
    name.user = found->second.name;
  for (const auto group : who.groups) {
    name.groups.push_back(std::to_string(group));
    const auto found = groups_.find(group);
    if (found != groups_.end() && !found->second.name.empty()) name.groups.push_back(found->second.name);
  }
  return name;
}

}  // namespace rubicon::transport
