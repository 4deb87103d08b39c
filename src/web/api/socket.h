#pragma once

#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/scheduler.h"
#include "client/tuple_query.h"
#include "verbs/answers.h"
#include "verbs/members.h"
#include "web/api/context.h"
#include "web/api/feed.h"
#include "web/api/naming.h"
#include "web/api/permission.h"
#include "web/api/tracked_set.h"
#include "web/exchange.h"

namespace rubicon::web::api {

/// One WebSocket (docs/api.md): answers the requests of its frames, and sends what they ask for. Frames are made when
/// the line is free: first answers, then messages and lists, then subscriptions in turns.
class Socket final : public Conversation {
 public:
  static constexpr std::size_t kMaxSubscriptions = 256;
  static constexpr std::size_t kMaxPending = 1024UL * 1024;  ///< bytes of answers that wait
  static constexpr std::size_t kMaxUnderWay = 1000;          ///< commands, reads and messages without an outcome
  static constexpr std::size_t kMaxMessages = 1000;          ///< messages that wait to be sent
  static constexpr std::size_t kMaxListened = 64;
  static constexpr Duration kSilence = std::chrono::seconds(5);     ///< after it, `alive` is sent
  static constexpr Duration kHelloTime = std::chrono::seconds(10);  ///< until the first frame names a token
  static constexpr Duration kSlow = std::chrono::seconds(1);        ///< a frame takes longer: the reader is slow

  Socket(Context& context, Caller caller, ConversationCallbacks calls);
  ~Socket() override;

  void received(std::string_view text) override;
  std::optional<std::string> next() override;
  bool has_caller() const override { return caller_.role != Role::kNone; }

 private:
  using Id = std::uint64_t;
  using Json = nlohmann::json;
  using Line = verbs::Line;
  using Verb = Result<void> (Socket::*)(Id id, verbs::Members& members);
  struct VerbName {
    const char* name;
    Verb verb;
  };
  static std::span<const VerbName> verbs();

  // -- requests
  Result<void> request(Id id, const std::string& verb, verbs::Members& members);
  /// Whether the request waits for the key of its tuple, because it has what people call it.
  Result<bool> look_up(Id id, const std::string& verb, const verbs::Members& members);
  Result<void> hello(Id id, verbs::Members& members);
  Result<void> subscribe(Id id, verbs::Members& members);
  Result<void> unsubscribe(Id id, verbs::Members& members);
  Result<void> get(Id id, verbs::Members& members);
  Result<void> write(Id id, verbs::Members& members);
  Result<void> send(Id id, verbs::Members& members);
  Result<void> listen(Id id, verbs::Members& members);
  Result<void> unlisten(Id id, verbs::Members& members);
  Result<void> list_islands(Id id, verbs::Members& members);
  Result<void> list_components(Id id, verbs::Members& members);

  Result<void> take_command();
  std::size_t under_way() const { return sets_.size() + waiting_.size() + sending_; }
  void replied(Id id, const SetRequest& request, const tuples::Reply& reply);
  void state_changed(Id id, const client::Outcome& outcome, bool is_final);
  template <class Map>
  void forget(Map& map, Id id);

  // -- frames
  void answer(Id id, const Line& line = Line::object());
  void refuse(const Json& id, const Error& error, const Line& line = Line::object());
  void put(std::string frame);
  void message_arrived(const client::UserMessage& message);
  std::optional<std::string> next_frame();
  std::optional<std::string> next_answer();
  std::optional<std::string> next_message();
  std::optional<std::string> next_list();
  std::optional<std::string> next_of_feeds();
  void watch_components();
  void merged();
  void wake() { callbacks_.wake(); }

  Context& context_;
  Caller caller_;
  ConversationCallbacks callbacks_;
  Id last_id_ = 0;
  Allowance commands_{Context::kCommandsPerSecond};

  std::deque<std::string> answers_;
  std::size_t answer_bytes_ = 0;
  std::deque<std::string> messages_;
  std::size_t message_bytes_ = 0;
  std::uint64_t lost_messages_ = 0;
  bool islands_asked_ = false, components_asked_ = false, islands_due_ = false, components_due_ = false;
  EventStock stock_;
  std::map<unsigned, std::unique_ptr<Feed>> feeds_;
  unsigned last_subscription_ = 0;
  unsigned served_ = 0;  ///< the subscription whose frame was sent last
  std::map<Id, std::unique_ptr<TrackedSet>> sets_;
  std::map<Id, std::shared_ptr<void>> waiting_;  ///< what reads tuples for a request
  std::size_t sending_ = 0;
  std::map<std::string, tuples::Handle> listened_;
  tuples::Handle peers_, summaries_;

  bool line_free_ = true;
  SteadyTime handed_at_{};  ///< when the last frame was taken
  SteadyTime told_slow_{};
  bool tell_slow_ = false, tell_alive_ = false;
  base::Deadline silence_, hello_time_;
  base::Lifetime lifetime_;
};

}  // namespace rubicon::web::api
