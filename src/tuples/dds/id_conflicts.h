#pragma once

#include <functional>
#include <map>
#include <memory>

#include "base/log.h"
#include "base/scheduler.h"
#include "tuples/dds/channel.h"
#include "tuples/dds/entity.h"

namespace rubicon::tuples::dds {

/// Resolves conflicts with other processes that use this component's id (docs/ecology.md, "Two with one id"). Of two
/// that are alive the later start has to end. A presence alone proves nothing: an earlier start displaces this one only
/// after it answered a question and stayed present for a lease. Bounded: one rival per DDS participant, kMax in all; if
/// there are more, the one that has not answered for longest is forgotten.
class IdConflicts final : private distant::FrameReader {
 public:
  /// Makes a channel to a rival, when there is a question or an answer to send.
  using MakeChannel = std::function<Result<std::unique_ptr<Channel>>(std::uint64_t incarnation)>;
  struct Callbacks {
    MakeChannel make_channel;
    std::function<void()> displaced;  ///< an earlier start is alive; once per start of this component
    bool answers = true;              ///< a stand-in does not: no other presence has to end because of it
  };

  IdConflicts(OwnerId self, Scheduler& scheduler, Duration lease, Log log, Callbacks calls)
      : self_(self), scheduler_(scheduler), lease_(lease), log_(std::move(log)), callbacks_(std::move(calls)) {}

  /// Forgets all rivals; sets the start of this component.
  void begin(std::uint64_t own_incarnation);
  void seen(std::uint64_t incarnation, const Participant& who);
  void gone(std::uint64_t incarnation);
  /// A frame from another start of the id to this one.
  void on_frame(std::uint64_t incarnation, ByteView content);

 private:
  static constexpr std::size_t kMax = 16;
  static constexpr int kUnansweredQuestions = 8;  ///< then the silence is logged

  struct Rival {
    Participant participant{};
    SteadyTime since;
    std::uint64_t question = 0;
    bool answered = false;
    int asked = 0;
    std::unique_ptr<Channel> channel;
  };

  void on_identity_check(const distant::IdentityCheck& check) override;

  bool make_room(const Participant& who);
  void ask_rivals();
  bool ask(std::uint64_t incarnation, Rival& rival);
  void send(std::uint64_t incarnation, Rival& rival, const distant::IdentityCheck& check);
  Duration pause() const;

  OwnerId self_;
  Scheduler& scheduler_;
  Duration lease_;
  Log log_;
  Callbacks callbacks_;
  std::uint64_t own_ = 0;
  std::map<std::uint64_t, Rival> all_;  ///< by incarnation
  std::uint64_t reading_from_ = 0;
  bool is_displaced_ = false;
  Timer timer_;
};

}  // namespace rubicon::tuples::dds
