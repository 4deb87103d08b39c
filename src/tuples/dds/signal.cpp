#include "tuples/dds/signal.h"

#include <map>

namespace rubicon::tuples::dds {

/// Lives until the last posted call ran; `call` is only touched on the loop's thread.
struct Signal::Shared : std::enable_shared_from_this<Signal::Shared> {
  /// What a listener is given.
  struct Ear {
    Shared* shared = nullptr;
    Source source{};
    DdsListener listener;
  };

  DdsEcology::Post post;
  std::function<void(unsigned)> call;
  std::atomic<unsigned> raised{0};
  std::map<Source, Ear> ears;

  void raise(Source source) {
    if (raised.fetch_or(source) != 0) return;
    post([self = shared_from_this()] {
      const auto sources = self->raised.exchange(0);
      if (const auto wake = self->call) wake(sources);
    });
  }
  static void hear(void* ear) {
    const auto& [shared, source, listener] = *static_cast<Ear*>(ear);
    shared->raise(source);
  }
  void listen(Source source) {
    auto& ear = ears[source];
    ear = {this, source, DdsListener(dds_create_listener(&ear))};
    dds_lset_data_available(ear.listener.get(), [](dds_entity_t, void* told) { hear(told); });
    dds_lset_publication_matched(ear.listener.get(),
                                 [](dds_entity_t, const dds_publication_matched_status_t, void* told) { hear(told); });
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
  return shared_->ears.at(source).listener.get();
}

void Signal::raise(Source source) {
  shared_->raise(source);
}

}  // namespace rubicon::tuples::dds
