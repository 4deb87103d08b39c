#pragma once

#include <map>
#include <optional>
#include <set>

#include "base/log.h"
#include "base/rate_limit.h"
#include "tuples/dds/dds_ecology.h"
#include "tuples/dds/peer.h"
#include "tuples/dds/signal.h"

namespace rubicon::tuples::dds {

/// One component's end of the ecology (docs/ecology.md): says that it is there and what it subscribes to, and has a
/// channel to each component it tells something.
class DdsLink final : public Link, private FrameReader {
 public:
  /// `displaced` is called in a later turn when another process has the id, and had it before.
  DdsLink(OwnerId self, Entity participant, const DdsOptions& options, Scheduler& scheduler, DdsEcology::Post post,
          std::function<void()> displaced, std::shared_ptr<Appearances> appearances, base::LogSink& log);
  ~DdsLink() override;

  void attach(LinkListener* listener) override;
  bool publish(OwnerId subscriber, std::span<const Change> changes) override;
  void subscribe(const SubscriptionSpec& spec) override;
  void unsubscribe(std::uint32_t id) override;
  Result<void> remote_set(const RemoteSet& wish) override;
  void reply(const Reply& reply) override;
  std::vector<OwnerId> peers() const override;
  void describe(std::string summary) override;
  std::uint64_t refused() const override { return refused_; }

 private:
  // FrameReader: the entries of the frame at hand
  void on_changes(std::span<const Change> changes) override;
  void on_set(RemoteSet&& wish) override;
  void on_reply(Reply&& reply) override;

  Result<void> enter();
  Result<void> make_readers();
  void leave();
  void drain(unsigned sources);
  void take_presences();
  void take_interests();
  bool take_frames();
  /// What is heard of a component's presence.
  struct PresenceNews {
    OwnerId id;
    std::uint64_t incarnation;
    bool there, left;
    std::uint16_t version;  ///< only told of those that are there
    std::string summary, host;
  };
  bool speaks_as_we(const PresenceNews& news);
  void present(const PresenceNews& news);
  bool refuses(Peer& peer, const RemoteSet& wish);
  void settle(OwnerId id, Peer& peer, bool left);
  void tell_summary(OwnerId id, Peer& peer);
  void come(OwnerId id, Peer& peer, std::uint64_t incarnation);
  void go(OwnerId id, Peer& peer, PeerEvent event);
  void interest(OwnerId id, std::uint64_t incarnation, std::uint32_t slot, std::optional<SubscriptionSpec> spec);
  void frame(OwnerId source, std::uint64_t incarnation, ByteView content);
  void hold(Peer& peer, std::uint64_t incarnation, ByteView content);
  void tell(OwnerId id, ByteView content);
  std::optional<OwnerId> owner_of(dds_instance_handle_t publication);

  Channel* channel_to(OwnerId id, Peer& peer);
  Peer* find_up(OwnerId id);
  Peer* know(OwnerId id);
  void ask_flush(Duration within);
  void ask_flush();
  void flush();
  void flush(Channel& channel);
  bool flush_slots();
  bool write_slot(std::uint32_t number, const Bytes& content);
  bool write_presence();
  void warn(const std::string& subject, const std::string& text);

  OwnerId self_;
  Scheduler& scheduler_;
  Log log_;
  base::RateLimit log_limit_;
  Duration lease_;
  bool trusts_others_;  ///< remote sets of other hosts are taken
  std::string host_;
  std::uint64_t refused_ = 0;
  std::function<void()> displaced_;
  bool is_displaced_ = false;
  std::shared_ptr<Appearances> appearances_;
  std::string summary_;
  bool presence_unwritten_ = false;
  Signal signal_;
  Entity participant_, presence_topic_, interest_topic_, frame_topic_;
  Entity presence_reader_, interest_reader_, frame_subscriber_, frame_reader_, presence_writer_, interest_writer_;
  LinkListener* listener_ = nullptr;
  std::uint64_t incarnation_ = 0;
  std::map<OwnerId, Peer> peers_;
  std::map<std::uint32_t, Bytes> slots_;            ///< what stands in them; empty = nothing
  std::map<std::uint32_t, std::uint32_t> slot_of_;  ///< by subscription id
  std::set<std::uint32_t> free_slots_, unwritten_slots_;
  std::map<dds_instance_handle_t, std::optional<OwnerId>> publications_;  ///< whose they are, by their partition
  OwnerId reading_from_{};
  Timer flush_timer_;
  SteadyTime flush_at_ = SteadyTime::max();
  bool flush_posted_ = false;
  std::shared_ptr<bool> door_ = std::make_shared<bool>();  ///< posted calls come through it while the link is there
};

}  // namespace rubicon::tuples::dds
