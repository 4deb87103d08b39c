#include "web/api/socket.h"

#include <fmt/format.h>

#include <utility>

#include "base/bytes.h"
#include "base/text.h"
#include "model/json_members.h"
#include "web/api/forms.h"

namespace rubicon::web::api {

namespace {

/// The largest whole number that every JSON parser keeps exactly.
constexpr std::uint64_t kMaxId = 1ULL << 53U;
constexpr Duration kSlowPause = std::chrono::minutes(1);

}  // namespace

Socket::Socket(Context& context, Caller caller, ConversationCallbacks calls)
    : context_(context),
      caller_(std::move(caller)),
      callbacks_(std::move(calls)),
      told_slow_(context.scheduler.now() - kSlowPause),
      silence_(context.scheduler,
               [this] {
                 tell_alive_ = true;
                 wake();
               }),
      hello_time_(context.scheduler, [this] { callbacks_.close("no hello with a token within 10 s"); }) {
  ++context_.counters.conversations;
  if (caller_.role == Role::kNone) hello_time_.set(kHelloTime);
  silence_.set(kSilence);
}

Socket::~Socket() {
  --context_.counters.conversations;
}

void Socket::received(std::string_view text) {
  ++context_.counters.frames_in;
  auto tree = verbs::parse_object(text);
  if (!tree) return refuse(nullptr, tree.error());
  verbs::Members members(std::move(*tree));
  const auto id = members.count("id", 0, kMaxId);
  const auto verb = members.text("do", "a verb, such as subscribe");
  if (!id || *id <= last_id_) {
    members.fault(fmt::format("id: expected a whole number above {}, the last one", last_id_));
    return refuse(id ? Json(*id) : Json(), members.end().error());
  }
  last_id_ = *id;
  if (const auto done = request(*id, verb, members); !done) refuse(*id, done.error());
}

void Socket::answer(Id id, const Line& line) {
  put(verbs::answer_line({{"id", id}}, {}, line));
}

void Socket::refuse(const Json& id, const Error& error, const Line& line) {
  if (error.code == ErrorCode::kBusy) ++context_.counters.busy;
  put(verbs::answer_line({{"id", id}}, fail(error), line));
}

/// One answer alone may be longer than the bound: a tuple of 1 MiB.
void Socket::put(std::string frame) {
  if (answer_bytes_ > kMaxPending) return callbacks_.close("more than 1 MiB of answers wait: the client does not read");
  answer_bytes_ += frame.size();
  answers_.push_back(std::move(frame));
  wake();
}

std::optional<std::string> Socket::next() {
  auto frame = next_frame();
  line_free_ = !frame.has_value();
  if (!frame) return frame;
  handed_at_ = context_.scheduler.now();
  silence_.set(kSilence);
  ++context_.counters.frames_out;
  context_.counters.bytes_out += frame->size();
  return frame;
}

std::optional<std::string> Socket::next_frame() {
  if (auto frame = next_answer()) return frame;
  if (caller_.role == Role::kNone) return std::nullopt;
  if (std::exchange(tell_slow_, false)) return R"({"slow":true})";
  if (auto frame = next_message()) return frame;
  if (auto frame = next_list()) return frame;
  if (auto frame = next_of_feeds()) return frame;
  if (!std::exchange(tell_alive_, false)) return std::nullopt;
  std::string alive = "{\"alive\":";
  model::append_seconds(context_.scheduler.wall_now(), alive);
  return alive + "}";
}

std::optional<std::string> Socket::next_answer() {
  if (answers_.empty()) return std::nullopt;
  auto frame = std::move(answers_.front());
  answers_.pop_front();
  answer_bytes_ -= frame.size();
  return frame;
}

std::optional<std::string> Socket::next_message() {
  if (const auto lost = std::exchange(lost_messages_, 0); lost > 0)
    return fmt::format(R"({{"lost":{{"messages":{}}}}})", lost);
  if (messages_.empty()) return std::nullopt;
  auto frame = std::move(messages_.front());
  messages_.pop_front();
  message_bytes_ -= frame.size();
  return frame;
}

std::optional<std::string> Socket::next_list() {
  if (std::exchange(islands_due_, false)) return model::dump({{"islands", components_json(context_.space, true)}});
  if (std::exchange(components_due_, false))
    return model::dump({{"components", components_json(context_.space, false)}});
  return std::nullopt;
}

/// Each subscription in turn, so that a large snapshot does not hold up the others.
std::optional<std::string> Socket::next_of_feeds() {
  auto place = feeds_.upper_bound(served_);
  for (std::size_t i = 0; i < feeds_.size(); ++i, ++place) {
    if (place == feeds_.end()) place = feeds_.begin();
    if (auto frame = place->second->next()) {
      served_ = place->first;
      return frame;
    }
  }
  return std::nullopt;
}

void Socket::message_arrived(const client::UserMessage& message) {
  Line content;
  content["from"] = number(message.from);
  content["network"] = message.network;
  content["device"] = message.device;
  content["type"] = message.type;
  const bool is_text = base::is_utf8(message.bytes);
  content[is_text ? "value" : "b64"] = is_text ? message.bytes : base::to_base64(message.bytes);
  messages_.push_back(model::dump({{"message", content}}));
  message_bytes_ += messages_.back().size();
  for (; messages_.size() > kMaxMessages || message_bytes_ > kMaxPending; ++lost_messages_) {
    message_bytes_ -= messages_.front().size();
    messages_.pop_front();
  }
  wake();
}

/// Between two frames this is the pace of the subscription. While a frame waits for the reader, the reader is slow.
void Socket::merged() {
  const auto now = context_.scheduler.now();
  if (line_free_ || now - handed_at_ < kSlow || now - told_slow_ < kSlowPause) return;
  told_slow_ = now;
  tell_slow_ = true;
}

void Socket::watch_components() {
  if (peers_) return;
  const auto changed = [this] {
    islands_due_ = islands_asked_;
    components_due_ = components_asked_;
    wake();
  };
  peers_ = context_.space.watch_peers([changed](OwnerId, tuples::PeerEvent) { changed(); });
  summaries_ = context_.space.watch_summaries([changed](OwnerId, std::string_view) { changed(); });
}

}  // namespace rubicon::web::api
