#pragma once

#include "base/deadline.h"
#include "web/api/context.h"
#include "web/api/feed.h"
#include "web/exchange.h"

namespace rubicon::web::api {

/// A subscription as server-sent events. After kSilence without an event it sends a comment.
class EventStream final : public Conversation {
 public:
  static constexpr Duration kSilence = std::chrono::seconds(5);

  EventStream(Context& context, const Caller& caller, FeedOptions options, ConversationCalls calls);
  ~EventStream() override;

  void received(std::string_view) override {}
  std::optional<std::string> next() override;

 private:
  Context& context_;
  ConversationCalls calls_;
  EventStock stock_;
  bool comment_due_ = false;
  base::Deadline silence_;
  Feed feed_;
};

}  // namespace rubicon::web::api
