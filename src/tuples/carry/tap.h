#pragma once

#include "tuples/link.h"

namespace rubicon::tuples::carry {

/// Receives what the own component of the carrier sees of an engine; engines have numbers from 0.
class TapEvents {
 public:
  virtual ~TapEvents() = default;
  /// False: the component itself does not hear of it.
  virtual bool on_peer(std::size_t engine, const PeerIdentity& who, PeerEvent event) = 0;
  virtual void on_summary(std::size_t engine, OwnerId peer, std::string_view summary) = 0;
  /// The component left: its view of the engine is empty.
  virtual void on_detached(std::size_t engine) = 0;
  /// The summary to show in place of the own one.
  virtual std::string shown(std::string summary) const = 0;
};

/// An engine as the components of a process use it; shows what one of them sees. The engine and the events outlive it
/// and its links.
class TappedEcology final : public Ecology {
 public:
  TappedEcology(Ecology& engine, std::size_t number, OwnerId watched, TapEvents& events)
      : engine_(engine), number_(number), watched_(watched), events_(events) {}

  Result<std::unique_ptr<Link>> join(OwnerId id) override;

 private:
  Ecology& engine_;
  std::size_t number_;
  OwnerId watched_;
  TapEvents& events_;
};

}  // namespace rubicon::tuples::carry
