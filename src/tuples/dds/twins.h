#pragma once

#include <functional>
#include <map>
#include <memory>

#include "base/log.h"
#include "base/scheduler.h"
#include "tuples/dds/channel.h"
#include "tuples/dds/writers.h"

namespace rubicon::tuples::dds {

/// Other starts that show this component's id (docs/ecology.md, "Two with one id"). Of two that live the later goes.
/// What a presence says is not believed: whoever started earlier has to answer a question sent to that start, and to
/// stay for a lease, before it displaces this one. A participant has one place; if all are taken, that of who did not
/// answer for longest is given away.
class Twins final : private FrameReader {
 public:
  /// A way to one of them; made when there is something to ask or to answer.
  using MakeChannel = std::function<Result<std::unique_ptr<Channel>>(std::uint64_t incarnation)>;
  struct Calls {
    MakeChannel make_channel;
    std::function<void()> displaced;  ///< once a start: an earlier one is alive
  };

  Twins(OwnerId self, Scheduler& scheduler, Duration lease, Log log, Calls calls)
      : self_(self), scheduler_(scheduler), lease_(lease), log_(std::move(log)), calls_(std::move(calls)) {}

  /// Forgets all; this component's start from now on.
  void begin(std::uint64_t own_incarnation);
  void seen(std::uint64_t incarnation, const Participant& who);
  void gone(std::uint64_t incarnation);
  /// A frame that another start of the id sent to this one.
  void frame(std::uint64_t incarnation, ByteView content);

 private:
  static constexpr std::size_t kMost = 16;
  static constexpr int kPatience = 8;  ///< questions until its silence is logged

  struct Twin {
    Participant participant{};
    SteadyTime since;
    std::uint64_t question = 0;
    bool answered = false;
    int asked = 0;
    std::unique_ptr<Channel> channel;
  };

  void on_changes(std::span<const Change>) override {}
  void on_set(RemoteSet&&) override {}
  void on_reply(Reply&&) override {}
  void on_identity_check(const IdentityCheck& check) override;

  bool make_room(const Participant& who);
  void look();
  bool look_at(std::uint64_t incarnation, Twin& twin);
  void tell(std::uint64_t incarnation, Twin& twin, const IdentityCheck& check);
  Duration pause() const;

  OwnerId self_;
  Scheduler& scheduler_;
  Duration lease_;
  Log log_;
  Calls calls_;
  std::uint64_t own_ = 0;
  std::map<std::uint64_t, Twin> all_;  ///< by their starts
  std::uint64_t reading_from_ = 0;
  bool is_displaced_ = false;
  Timer timer_;
};

}  // namespace rubicon::tuples::dds
