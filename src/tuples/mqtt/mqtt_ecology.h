#pragma once

#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "base/clocks.h"
#include "base/log.h"
#include "base/scheduler.h"
#include "transport/transports.h"
#include "tuples/judge.h"
#include "tuples/link.h"
#include "tuples/mqtt/channel.h"
#include "tuples/mqtt/documents.h"
#include "tuples/mqtt/messages.h"
#include "tuples/mqtt/presence.h"
#include "tuples/mqtt/search.h"
#include "tuples/mqtt/uplink.h"
#include "tuples/own_links.h"

namespace rubicon::tuples::mqtt {

class MqttLink;

struct SpaceOptions {
  std::vector<SpaceBroker> brokers{};  ///< the first one that is there; all must be brokers of the same components
  std::string space = "default";       ///< is_space(): components of other spaces are not seen
  Duration lease = std::chrono::seconds(20);  ///< at least kMinLease; others lose this process after such a silence
  /// Take requests of others from a broker whose users may write in each other's names.
  bool trust_broker = false;
  bool watch_all = false;                  ///< meet all components of the space, whether they matter here or not
  std::shared_ptr<Judge> judge = nullptr;  ///< what members may do here; null: whatever the broker lets them
  /// Who a user is. Null: each user is a member without roles, and `island-7` island 7.
  std::shared_ptr<UserRealm> realm = nullptr;
};
inline constexpr Duration kMinLease = std::chrono::seconds(13);
/// kInvalid: user, space or lease.
Result<void> check_options(const SpaceOptions& options);
/// The member that a user of the broker is here; nullptr: none.
std::shared_ptr<const Member> member_of(const SpaceOptions& options, const std::string& user);

/// Components that meet at an MQTT broker (docs/sites.md): one connection a process, whatever components it has. The
/// broker says which user is behind a connection.
class MqttEcology final : public StandInEcology {
 public:
  using Clock = std::function<Duration()>;
  /// Begins to connect, and tries again as long as it lives. The scheduler, the transports and the log outlive it.
  /// kInvalid for options that no broker can accept.
  static Result<std::unique_ptr<MqttEcology>> open(SpaceOptions options, Scheduler& scheduler,
                                                   transport::Transports& transports, base::LogSink& log,
                                                   Clock since_boot = base::since_boot);
  ~MqttEcology() override;

  /// kDuplicate if this process has the component already. The link ends before the ecology.
  Result<std::unique_ptr<Link>> join(OwnerId id) override;
  Result<std::unique_ptr<Link>> join_as(StandIn who) override;
  bool may_stand_in(OwnerId carrier, OwnerId id) const override;

  /// `call` receives, in a later turn and once per start, the component of this process whose id another one uses that
  /// lives and began before. That component should end.
  void watch_displaced(std::function<void(OwnerId)> call) { displaced_ = std::move(call); }
  /// As Link::seeks(); nullopt: all components of the space.
  bool seeks(std::optional<OwnerId> id);
  /// Why there is no connection; empty: there is one, or the first attempt goes on.
  const std::string& trouble() const { return uplink_.trouble(); }

  struct Counters {
    Channel::Losses losses;
    std::uint64_t reconnects = 0;  ///< connections after the first one
    std::uint64_t foreign = 0;  ///< messages at our topics that no component of ours sent, or that name another sender
    std::uint64_t too_large = 0;  ///< values that exceed what the broker takes
  };
  const Counters& counters() const { return counters_; }
  std::size_t presence_bytes() const { return presence_.bytes(); }
  /// Pairs of an own component and another one that exchanged something.
  std::size_t channels() const;
  /// Of realm files that others show; zeros without a realm.
  Documents::Counters documents() const { return documents_ ? documents_->counters() : Documents::Counters(); }

 private:
  friend class MqttLink;
  struct Early {
    Line from;
    FrameHead head;
    Bytes entries;
    SteadyTime since;
  };
  /// A frame that the broker may find too large.
  struct Large {
    OwnerId source{}, target{};
    std::uint64_t stream = 0, number = 0;
    std::size_t size = 0;
  };
  /// Whether a start of a component lives.
  struct Question {
    std::uint64_t number = 0, incarnation = 0;
    OwnerId asker{};
    SteadyTime since{};
  };
  /// A component that owes acknowledgements, or of which another start is shown.
  struct Suspect {
    SteadyTime asked = SteadyTime::max();  ///< and did not answer yet
    SteadyTime answered{};
  };
  /// What another connection of the own user shows.
  struct OwnLine {
    SteadyTime since{};                    ///< when this entry began, or `here` changed
    bool here = false;                     ///< its own topic
    bool heard = false;                    ///< something came from there
    std::map<OwnerId, std::uint64_t> ids;  ///< with their starts
  };
  static constexpr Duration kLately = std::chrono::seconds(10);
  static constexpr std::size_t kMaxEarly = std::size_t{4} << 20;

  MqttEcology(SpaceOptions options, Scheduler& scheduler, transport::Transports& transports, base::LogSink& log,
              Clock since_boot);

  // -- the connection (mqtt_ecology.cpp)
  Uplink::Callbacks uplink_calls();
  void on_connected(const transport::MqttConnack& connack);
  void on_lost();
  void show_all();
  void empty_former();
  Search::Callbacks search_calls();
  void on_complete(bool all);
  bool publish(std::string topic, std::string payload, bool retained);
  bool publish(transport::MqttPublication one);
  void on_taken(const transport::MqttOutcome& outcome);
  void on_not_taken(const transport::MqttOutcome& outcome, const Error& why);
  void look();
  // -- what arrives
  void on_message(const transport::MqttMessage& message);
  void on_presence(const Topics::Presence& at, std::string_view payload, bool retained);
  void on_frame(const Line& from, ByteView payload);
  void take(const Line& from, const FrameHead& head, ByteView entries);
  void hold(const Line& from, const FrameHead& head, ByteView entries);
  void on_check(const Line& from, const FrameHead& head, ByteView entries);
  void on_answer(const Line& from, const FrameHead& head, std::uint64_t number);
  void note_own(const Topics::Presence& at, std::uint64_t incarnation, bool here);
  void foreign(const Line& from, const std::string& what);
  void set_vouched(bool vouched);
  void on_changed(OwnerId id, PeerEvent how);
  // -- who others are
  void open_documents();
  void judge_again();
  // -- for links
  /// A component of this process: what it says does not pass the broker, where others could say it too.
  bool is_own(OwnerId id, std::uint64_t incarnation) const;
  bool may_have(const std::string& user, OwnerId id) const;
  std::shared_ptr<const Member> vouched_member(const std::string& user) const;
  Channel::Sent send(const FrameHead& head, ByteView entries);
  Channel::Sent send_to(const Line& to, const FrameHead& head, ByteView entries);
  bool may_swallow(std::size_t size) const;
  void show(const MqttLink& link);
  void show_soon();
  void hide(const MqttLink& link);
  std::uint32_t credit() const;
  void read_again();
  void ask_rivals();
  void look_at_suspects();
  void ask_doubted();
  void empty_leftovers();
  void ask(const MqttLink& asker, OwnerId id, const Reached& who);

  SpaceOptions options_;
  Scheduler& scheduler_;
  base::LimitedLog log_;
  Clock since_boot_;
  Topics topics_;
  Presence presence_;
  Search search_;
  Uplink uplink_;
  Packing packing_;
  std::unique_ptr<Documents> documents_;  ///< null: there is no realm
  Handle realm_changes_;
  Line own_;
  std::vector<Line> former_;              ///< earlier connections of this process that may have left topics
  bool vouched_ = true, probed_ = false;  ///< whether the broker protects names, and it was tried on this connection
  bool returns_ = false;                  ///< until presence was read on this connection
  std::uint64_t count_ = 0;               ///< of connections
  std::uint64_t streams_ = 0;             ///< the last one that a channel began
  OwnLinks<MqttLink> links_;
  std::map<OwnerId, SteadyTime> heard_;  ///< who sent lately, or was asked for values
  std::deque<Early> early_;
  std::size_t early_bytes_ = 0;
  std::map<std::pair<OwnerId, Line>, Question> questions_;
  std::map<OwnerId, Suspect> suspects_;
  std::map<Line, OwnLine> own_lines_;
  bool answers_ = false;            ///< the broker says what it does not take
  std::size_t largest_ = SIZE_MAX;  ///< bytes of entries that the broker takes in one message, as far as known
  std::size_t proven_ = 0;          ///< so many bytes it took
  std::map<std::uint64_t, Large> large_;
  std::uint64_t large_number_ = 0;
  std::function<void(OwnerId)> displaced_;
  Counters counters_;
  SteadyTime shown_at_{};  ///< own presence, last
  SteadyTime read_at_{};   ///< presence of others, completely
  Duration read_again_in_{};
  unsigned shown_lately_ = 0;  ///< messages of presence since the last look
  Timer look_;
  base::OncePerTurn flush_soon_, show_here_soon_;
  base::Lifetime lifetime_;
};

}  // namespace rubicon::tuples::mqtt
