#include <fmt/format.h>
#include <fmt/ranges.h>

#include <set>
#include <utility>

#include "base/lifetime.h"
#include "client/tuple_query.h"
#include "model/json_members.h"
#include "model/point_keys.h"
#include "web/api/members.h"
#include "web/api/page_of.h"
#include "web/api/route.h"
#include "web/api/setting.h"
#include "web/api/tuple_read.h"
#include "web/error_response.h"

namespace rubicon::web::api {

namespace {

constexpr Duration kInboxPatience = std::chrono::seconds(3);

const std::string& any_inbox() {
  static const auto kKey = model::IslandKey{"*"}.inbox();
  return kKey;
}

std::string name_of_entry(const client::Tuple& tuple) {
  return fmt::format("{}:{}", number(tuple.owner), tuple.key);
}

nlohmann::ordered_json entry_json(const client::Tuple& tuple) {
  nlohmann::ordered_json entry = model::object_of(tuple.value);
  entry["island"] = number(tuple.owner);
  return entry;
}

/// What a client decided.
struct Order {
  std::string word, which;
  std::optional<OwnerId> island;
};

Result<Order> read_order(std::string_view body) {
  const auto tree = parse_object(body);
  if (!tree) return fail(tree.error());
  Members members(*tree, "inbox");
  Order order;
  order.word = members.has("ignore") ? "ignore" : "approve";
  order.which = members.text(order.word.c_str(), "NETWORK.DEVICE, also with * and ?");
  if (const auto island = members.count("island", model::kMaxIslandId))
    order.island = OwnerId(static_cast<std::uint32_t>(*island));
  if (order.which.empty()) members.fault({ErrorCode::kInvalid, order.word + ": expected NETWORK.DEVICE"});
  if (auto good = members.end(); !good) return fail(good.error());
  return order;
}

/// Finds the inbox that is meant, sets it, and answers with the outcome.
class Decision final : public Exchange {
 public:
  Decision(Context& context, Order order, Respond respond)
      : context_(context), order_(std::move(order)), respond_(std::move(respond)) {
    inboxes_ = std::make_unique<client::TupleQuery>(
        context.scheduler, context.space, context.peers, Pattern{order_.island, any_inbox()},
        [this](const std::vector<client::Tuple>& inboxes) { found(inboxes); }, kInboxPatience);
  }

 private:
  void found(const std::vector<client::Tuple>& inboxes) {
    if (inboxes.empty()) return end(error_response({ErrorCode::kNotFound, "no island has an inbox"}));
    if (inboxes.size() == 1) return decide(inboxes.front());
    std::set<std::uint32_t> islands;
    for (const auto& inbox : inboxes) islands.insert(number(inbox.owner));
    end(error_response(
        {ErrorCode::kInvalid, fmt::format("inbox: island is missing; expected one of {}", fmt::join(islands, ", "))}));
  }

  void decide(const client::Tuple& inbox) {
    SetRequest request;
    request.owner = inbox.owner;
    request.key = inbox.key;
    request.value = order_.word + " " + order_.which;
    request.media_type = "text/plain";
    set_ = std::make_unique<TrackedSet>(
        context_, request,
        TrackedSet::Calls{[this, owner = inbox.owner](const tuples::Reply& reply) { replied(owner, reply); }, {}});
  }

  void replied(OwnerId island, const tuples::Reply& reply) {
    const auto verdict = verdict_of(reply, island);
    const std::string state = verdict ? "applied" : std::string(to_string(reply.verdict));
    nlohmann::ordered_json tree;
    tree["island"] = number(island);
    tree["decision"] = order_.word;
    tree["device"] = order_.which;
    tree["state"] = state;
    tree["reason"] = reply.text;
    if (!verdict) tree["error"] = {{"code", to_string(verdict.error().code)}, {"text", verdict.error().text}};
    end(json_response(tree, status_of_outcome(state)));
  }

  /// What reports its end is destroyed in a later turn, with this.
  void end(Response response) {
    lifetime_.post(context_.scheduler, [respond = std::exchange(respond_, nullptr), response = std::move(response)] {
      respond(response);  // may destroy this
    });
  }

  Context& context_;
  Order order_;
  Respond respond_;
  std::unique_ptr<client::TupleQuery> inboxes_;
  std::unique_ptr<TrackedSet> set_;
  base::Lifetime lifetime_;
};

}  // namespace

std::unique_ptr<Exchange> list_inbox(Call& call) {
  const auto range = read_range(call.query);
  if (auto good = call.may_read({std::nullopt, any_inbox()}); !good) return call.refuse(good.error());
  const std::vector<Pattern> patterns{{std::nullopt, model::IslandKey{"*"}.inbox("*.*")}, {std::nullopt, any_inbox()}};
  return call.read(patterns, [range, request = call.request](std::vector<client::Tuple> tuples) {
    double ignored = 0;
    std::erase_if(tuples, [&ignored](const client::Tuple& tuple) {
      const bool is_inbox = tuple.key.ends_with(any_inbox().substr(1));
      if (is_inbox) ignored += std::max(0.0, model::number_of(model::object_of(tuple.value), "ignored"));
      return is_inbox;
    });
    auto page = page_of("waiting", std::move(tuples), request, range, name_of_entry, entry_json);
    page["ignored"] = static_cast<std::uint64_t>(ignored);
    return json_response(page);
  });
}

std::unique_ptr<Exchange> decide_inbox(Call& call) {
  if (auto good = call.query.end(); !good) return call.refuse(good.error());
  auto order = read_order(call.request.body);
  if (!order) return call.refuse(order.error());
  const auto key = model::IslandKey{"proxy"}.inbox();
  if (auto good = call.check(Verb::kSet, order->island.value_or(model::kNoOwner), key); !good)
    return call.refuse(good.error());
  auto& context = call.context;
  if (!context.commands.take(call.caller_name(), context.scheduler.now()))
    return call.refuse(
        {ErrorCode::kBusy, fmt::format("more than {} commands in a second", Context::kCommandsPerSecond)});
  return std::make_unique<Decision>(context, std::move(*order), call.respond);
}

}  // namespace rubicon::web::api
