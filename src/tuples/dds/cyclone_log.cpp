#include "tuples/dds/cyclone_log.h"

#include <dds/ddsrt/log.h>

#include <atomic>

#include "base/rate_limit.h"

namespace rubicon::tuples::dds {

namespace {

/// Sentences on their way to the loop; more are dropped.
constexpr int kMostUnderWay = 16;
constexpr std::size_t kLongest = 500;

thread_local CycloneLog::Ear* ear = nullptr;
CycloneLog* latest = nullptr;  // of the loop's thread

/// What is said without who says it and the line's end.
std::string sentence(const dds_log_data_t& data) {
  std::string_view text(data.message);
  while (!text.empty() && (text.back() == '\n' || text.back() == ' ' || text.back() == '.')) text.remove_suffix(1);
  return std::string(text.substr(0, kLongest));
}

}  // namespace

struct CycloneLog::Shared : std::enable_shared_from_this<CycloneLog::Shared> {
  Shared(Scheduler& loop, DdsEcology::Post to, base::LogSink& sink)
      : scheduler(loop), post(std::move(to)), log(sink, "dds") {}

  void take(std::string text) {
    if (ear) {
      ear->heard += (ear->heard.empty() ? "" : "; ") + text;
      return;
    }
    if (under_way.fetch_add(1) >= kMostUnderWay) {
      --under_way;
      return;
    }
    post([self = shared_from_this(), text = std::move(text)] {
      --self->under_way;
      self->say(text);
    });
  }

  /// Of one kind is what begins alike: addresses and numbers stand further behind.
  void say(const std::string& text) {
    if (alive && limit.allow(text.substr(0, text.find_first_of("0123456789/")), scheduler.now())) log.warning(text);
  }

  Scheduler& scheduler;
  DdsEcology::Post post;
  Log log;
  base::RateLimit limit;
  std::atomic<int> under_way{0};
  bool alive = true;  // of the loop's thread
};

CycloneLog::CycloneLog(Scheduler& scheduler, DdsEcology::Post post, base::LogSink& log)
    : shared_(std::make_shared<Shared>(scheduler, std::move(post), log)) {
  latest = this;
  dds_set_log_sink(
      [](void* shared, const dds_log_data_t* data) {
        constexpr std::uint32_t kWanted = DDS_LC_FATAL | DDS_LC_ERROR | DDS_LC_WARNING;
        if ((data->priority & kWanted) != 0) static_cast<Shared*>(shared)->take(sentence(*data));
      },
      shared_.get());
}

CycloneLog::~CycloneLog() {
  shared_->alive = false;
  if (latest != this) return;
  latest = nullptr;
  dds_set_log_sink(nullptr, nullptr);
}

CycloneLog::Ear::Ear() {
  ear = this;
}

CycloneLog::Ear::~Ear() {
  ear = nullptr;
}

}  // namespace rubicon::tuples::dds
