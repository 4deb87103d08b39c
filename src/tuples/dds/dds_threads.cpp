#include "tuples/dds/dds_threads.h"

#include <dds/ddsrt/log.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <map>
#include <vector>

#include "base/log.h"

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

namespace {

/// Messages that may wait for the loop; more are dropped.
constexpr int kMaxPending = 16;
constexpr std::size_t kMaxLength = 500;  // of a message

thread_local CycloneLog::Capture* capture = nullptr;
/// All that live, the latest last; used on the loop's thread only.
std::vector<void*> sinks;

/// What a message of Cyclone 0.10.2 means, by a part of it.
struct Meaning {
  std::string_view part, text;
};
constexpr std::array kMeanings{
    Meaning{"malformed packet", "a packet that is not valid was dropped"},
    Meaning{"truncated to", "a packet that is longer than allowed was dropped"},
    Meaning{"conn_write to", "a packet could not be sent"},
    Meaning{"tcp write failed", "a TCP connection broke while it was written to"},
    Meaning{"tcp accept failed", "a TCP connection could not be accepted"},
    Meaning{"tcp failed to connect", "a TCP connection could not be opened"},
    Meaning{"socket receive buffer", "the system's socket buffers are small: bursts may lose packets"},
    Meaning{"failed to increase socket", "the system's socket buffers are small: bursts may lose packets"}};

/// The meaning first, if we know it; the words of Cyclone are for who looks for them.
std::string explained(const std::string& text) {
  const auto known = std::find_if(kMeanings.begin(), kMeanings.end(),
                                  [&](const auto& one) { return text.find(one.part) != text.npos; });
  return known == kMeanings.end() ? "Cyclone DDS says: " + text
                                  : fmt::format("{} (Cyclone DDS: {})", known->text, text);
}

/// The text without line end and full stop.
std::string message_of(const dds_log_data_t& data) {
  std::string_view text(data.message);
  while (!text.empty() && (text.back() == '\n' || text.back() == ' ' || text.back() == '.')) text.remove_suffix(1);
  return std::string(text.substr(0, kMaxLength));
}

}  // namespace

struct CycloneLog::Shared : std::enable_shared_from_this<CycloneLog::Shared> {
  Shared(Scheduler& loop, DdsEcology::Post to, base::LogSink& sink)
      : scheduler(loop), post(std::move(to)), log(sink, "dds") {}

  void take(std::string text) {
    if (capture) {
      capture->text += (capture->text.empty() ? "" : "; ") + text;
      return;
    }
    if (pending.fetch_add(1) >= kMaxPending) {
      --pending;
      return;
    }
    post([self = shared_from_this(), text = std::move(text)] {
      --self->pending;
      self->log_limited(text);
    });
  }

  /// Messages are of one kind if their texts are equal up to the first number or path.
  void log_limited(const std::string& text) {
    if (alive && limit.allow(text.substr(0, text.find_first_of("0123456789/")), scheduler.now()))
      log.warning(explained(text));
  }

  Scheduler& scheduler;
  DdsEcology::Post post;
  Log log;
  base::RateLimit limit;
  std::atomic<int> pending{0};
  bool alive = true;  // used on the loop's thread only
};

CycloneLog::CycloneLog(Scheduler& scheduler, DdsEcology::Post post, base::LogSink& log)
    : shared_(std::make_shared<Shared>(scheduler, std::move(post), log)) {
  sinks.push_back(shared_.get());
  use_latest();
}

void CycloneLog::use_latest() {
  if (sinks.empty()) return dds_set_log_sink(nullptr, nullptr);
  dds_set_log_sink(
      [](void* shared, const dds_log_data_t* data) {
        constexpr std::uint32_t kWanted = DDS_LC_FATAL | DDS_LC_ERROR | DDS_LC_WARNING;
        if ((data->priority & kWanted) != 0) static_cast<Shared*>(shared)->take(message_of(*data));
      },
      sinks.back());
}

CycloneLog::~CycloneLog() {
  shared_->alive = false;
  std::erase(sinks, shared_.get());
  use_latest();
}

CycloneLog::Capture::Capture() {
  capture = this;
}

CycloneLog::Capture::~Capture() {
  capture = nullptr;
}

}  // namespace rubicon::tuples::dds
