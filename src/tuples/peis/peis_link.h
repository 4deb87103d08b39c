#pragma once

#include "base/scheduler.h"
#include "tuples/peer_policy.h"
#include "tuples/peis/peis_ecology.h"
#include "tuples/peis/presence.h"

namespace rubicon::tuples::peis {

/// The link of one component over PEIS: a node of its own (README.md of this folder), which exists while a listener is
/// attached.
class PeisLink final : public Link {
 public:
  struct Settings {
    PeisOptions options;
    std::vector<transport::Interface> interfaces;  ///< those of the options
    PeisMachine machine;
    std::string shown_host{};  ///< of a stand-in; empty = that of the machine
  };
  /// `displaced` is called in a later turn if another live component uses the id, and used it before; `token` is
  /// destroyed with the link. The scheduler, the transports and the log outlive it.
  PeisLink(OwnerId self, Settings settings, Scheduler& scheduler, transport::Transports& transports, base::LogSink& log,
           std::function<void()> displaced, std::shared_ptr<void> token = nullptr);
  ~PeisLink() override;

  void attach(LinkListener& listener, std::uint64_t incarnation) override;
  void detach() override;
  bool publish(OwnerId subscriber, std::span<const Change> changes) override;
  void subscribe(const SubscriptionSpec& spec) override;
  void unsubscribe(std::uint32_t id) override;
  Result<void> remote_set(const RemoteSet& set) override;
  void reply(const Reply& reply) override;
  std::vector<OwnerId> peers() const override;
  void describe(std::string summary) override;
  void each_counter(const std::function<void(std::string_view name, std::uint64_t value)>& visit) const override;
  PeerPolicy& policy() override { return *policy_; }

  /// Null while no listener is attached.
  const Presence* presence() const { return presence_.get(); }

 private:
  NodeOptions node_options() const;
  void open();

  OwnerId self_;
  Settings settings_;
  Scheduler& scheduler_;
  transport::Transports& transports_;
  Log log_;
  std::unique_ptr<PeerPolicy> policy_;
  std::function<void()> displaced_;
  std::shared_ptr<void> token_;
  std::uint64_t incarnation_ = 0;
  std::uint32_t magic_ = 0;
  std::string summary_;
  std::unique_ptr<Presence> presence_;
  Timer retry_;
};

}  // namespace rubicon::tuples::peis
