#include "tuples/dds/signal.h"

#include <map>

namespace rubicon::tuples::dds {

/// Lives until the last posted call ran; `call` is only touched on the loop's thread.
struct Signal::Shared : std::enable_shared_from_this<Signal::Shared> {
  /// The argument of a DDS listener.
  struct Listener {
    Shared* shared = nullptr;
    Source source{};
    DdsListener handle;
  };

  DdsEcology::Post post;
  std::function<void(unsigned)> call;
  std::atomic<unsigned> raised{0};
  std::map<Source, Listener> listeners;

  void raise(Source source) {
    if (raised.fetch_or(source) != 0) return;
    post([self = shared_from_this()] {
      const auto sources = self->raised.exchange(0);
      if (const auto wake = self->call) wake(sources);
    });
  }
  static void on_event(void* context) {
    const auto& listener = *static_cast<Listener*>(context);
    listener.shared->raise(listener.source);
  }
  void listen(Source source) {
    auto& listener = listeners[source];
    listener = {this, source, DdsListener(dds_create_listener(&listener))};
    dds_lset_data_available(listener.handle.get(), [](dds_entity_t, void* context) { on_event(context); });
    dds_lset_publication_matched(listener.handle.get(), [](dds_entity_t, const dds_publication_matched_status_t,
                                                           void* context) { on_event(context); });
    dds_lset_subscription_matched(listener.handle.get(), [](dds_entity_t, const dds_subscription_matched_status_t,
                                                            void* context) { on_event(context); });
  }
};

Signal::Signal(DdsEcology::Post post, std::function<void(unsigned)> call) : shared_(std::make_shared<Shared>()) {
  shared_->post = std::move(post);
  shared_->call = std::move(call);
  for (const auto source : {kPresence, kInterests, kFrames, kWriter}) shared_->listen(source);
}

Signal::~Signal() {
  shared_->call = nullptr;
}

const dds_listener_t* Signal::listener(Source source) const {
  return shared_->listeners.at(source).handle.get();
}

void Signal::raise(Source source) {
  shared_->raise(source);
}

std::shared_ptr<const void> Signal::used() const {
  return shared_;
}

}  // namespace rubicon::tuples::dds
