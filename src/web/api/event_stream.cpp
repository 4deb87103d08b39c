#include "web/api/event_stream.h"

#include <utility>

namespace rubicon::web::api {

EventStream::EventStream(Context& context, const Caller& caller, FeedOptions options, ConversationCalls calls)
    : context_(context),
      calls_(std::move(calls)),
      silence_(context.scheduler,
               [this] {
                 comment_due_ = true;
                 calls_.wake();
               }),
      feed_(context, caller, stock_, std::move(options), std::make_unique<StreamWriter>(),
            Feed::Calls{[this] { calls_.wake(); }, [] {}, [this](const char* why) { calls_.close(why); }}) {
  ++context_.counters.streams;
  silence_.set(kSilence);
}

EventStream::~EventStream() {
  --context_.counters.streams;
}

std::optional<std::string> EventStream::next() {
  auto frame = feed_.next();
  if (!frame && std::exchange(comment_due_, false)) frame = ":\n\n";
  if (!frame) return frame;
  silence_.set(kSilence);
  context_.counters.bytes_out += frame->size();
  return frame;
}

}  // namespace rubicon::web::api
