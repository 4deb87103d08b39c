#include "tuples/dds/signal.h"

namespace rubicon::tuples::dds {

/// Lives until the last posted call ran; `call` is only touched on the loop's thread.
struct Signal::Shared : std::enable_shared_from_this<Signal::Shared> {
  DdsEcology::Post post;
  std::function<void()> call;
  std::atomic<bool> raised{false};

  void raise() {
    if (raised.exchange(true)) return;
    post([self = shared_from_this()] {
      self->raised = false;
      if (const auto wake = self->call) wake();
    });
  }
};

Signal::Signal(DdsEcology::Post post, std::function<void()> call) : shared_(std::make_shared<Shared>()) {
  shared_->post = std::move(post);
  shared_->call = std::move(call);
  listener_.reset(dds_create_listener(shared_.get()));
  dds_lset_data_available(listener_.get(), [](dds_entity_t, void* shared) { static_cast<Shared*>(shared)->raise(); });
  dds_lset_publication_matched(listener_.get(), [](dds_entity_t, const dds_publication_matched_status_t, void* shared) {
    static_cast<Shared*>(shared)->raise();
  });
}

Signal::~Signal() {
  shared_->call = nullptr;
}

void Signal::raise() {
  shared_->raise();
}

}  // namespace rubicon::tuples::dds
