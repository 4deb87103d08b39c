#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <iterator>
#include <set>
#include <utility>

#include "base/scheduler.h"
#include "client/tuple_query.h"
#include "model/json_members.h"
#include "model/point_keys.h"
#include "verbs/answers.h"
#include "web/api/forms.h"
#include "web/api/route.h"
#include "web/api/tracked_set.h"
#include "web/exchange.h"

namespace rubicon::web::api {

namespace {

using Tree = nlohmann::ordered_json;

constexpr Duration kInboxPatience = std::chrono::seconds(3);
constexpr const char* kExpectedName = "NETWORK.DEVICE, also with * and ?";
/// Names without wildcards that count as one command: the island finds them without a search.
constexpr std::size_t kNamesOfACommand = 50;

const std::string& any_inbox() {
  static const auto kKey = model::IslandKey{"*"}.inbox();
  return kKey;
}

/// A device that waits or is ignored.
struct InboxEntry {
  OwnerId island{};
  Tree tree;
};

/// Two ignored devices may have the same key.
std::string name_of_entry(const InboxEntry& entry) {
  return fmt::format("{}:{} {}", number(entry.island), model::text_of(entry.tree, "key"),
                     model::text_of(entry.tree, "address"));
}

Tree entry_json(const InboxEntry& entry) {
  return entry.tree;
}

/// What the tuples of inboxes say: devices, and how many there are in each state.
class Inboxes {
 public:
  void add(const client::Tuple& tuple) {
    const auto tree = model::object_of(tuple.value);
    const auto parts = model::key_parts(tuple.key);
    if (parts.size() == 4) return add_entry(tuple.owner, tree, "waiting");
    if (parts.size() == 3) return add_ignored(tuple.owner, tree);
    waiting += model::count_of(tree, "count");
    ignored += model::count_of(tree, "ignored");
  }

  std::vector<InboxEntry> entries;
  std::uint64_t waiting = 0, ignored = 0;

 private:
  void add_entry(OwnerId island, Tree tree, std::string_view state) {
    tree["island"] = number(island);
    tree["state"] = state;
    entries.push_back({island, std::move(tree)});
  }
  void add_ignored(OwnerId island, const nlohmann::json& tree) {
    const auto list = tree.find("devices");
    if (list == tree.end() || !list->is_array()) return;
    for (const auto& one : *list) {
      if (one.is_object()) add_entry(island, one, "ignored");
    }
  }
};

/// What a client decided about one device, or about the devices of a pattern.
struct Decision {
  std::string word, which;
};

struct Order {
  static constexpr std::size_t kMaxCount = 1000;  ///< names of a list

  std::vector<Decision> decisions;
  bool is_list = false;
  std::optional<OwnerId> island;

  /// In commands.
  double cost() const {
    double sum = 0;
    for (const auto& [word, which] : decisions)
      sum += which.find_first_of("*?") == which.npos ? 1.0 / kNamesOfACommand : 1.0;
    return sum;
  }
};

Result<Order> read_order(std::string_view body) {
  const auto tree = verbs::parse_object(body);
  if (!tree) return fail(tree.error());
  verbs::Members members(*tree);
  Order order;
  for (const auto* word : {"approve", "ignore"}) {
    for (auto& name : members.texts(word, kExpectedName, Order::kMaxCount))
      order.decisions.push_back({word, std::move(name)});
    order.is_list |= tree->contains(word) && tree->at(word).is_array();
  }
  order.is_list |= order.decisions.size() > 1;
  if (const auto island = members.count("island", 0, model::kMaxIslandId))
    order.island = OwnerId(static_cast<std::uint32_t>(*island));
  if (auto good = members.end(); !good) return fail(good.error());
  if (!order.decisions.empty()) return order;
  return fail(ErrorCode::kInvalid, fmt::format("approve is missing; expected {}", kExpectedName));
}

/// The outcome of a decision.
struct Decided {
  std::string state, reason;
  std::optional<Error> error;

  unsigned status() const {
    const bool is_missing = error && error->code == ErrorCode::kNotFound;
    return is_missing ? 404 : status_of_outcome(state);
  }
};

void add_json(const Decision& decision, const Decided& decided, Tree& tree) {
  tree["decision"] = decision.word;
  tree["device"] = decision.which;
  tree["state"] = decided.state;
  tree["reason"] = decided.reason;
  if (decided.error) tree["error"] = verbs::error_json(*decided.error);
}

/// Finds the inbox that is meant, sets it once for each decision, and answers with what became of them.
class InboxOrder final : public Exchange {
 public:
  InboxOrder(Context& context, Caller caller, Order order, Respond respond)
      : context_(context), caller_(std::move(caller)), order_(std::move(order)), respond_(std::move(respond)) {
    inboxes_ = std::make_unique<client::TupleQuery>(
        context.scheduler, context.space, context.peers, Pattern{order_.island, any_inbox()},
        [this](const std::vector<client::Tuple>& tuples) { found(tuples); }, kInboxPatience);
  }

 private:
  void found(const std::vector<client::Tuple>& tuples) {
    IslandPrefixes prefixes(context_.space);
    std::vector<client::Tuple> inboxes;
    std::copy_if(tuples.begin(), tuples.end(), std::back_inserter(inboxes),
                 [&prefixes](const auto& one) { return prefixes.fit(one.owner, one.key); });
    if (inboxes.empty()) return end(error_response({ErrorCode::kNotFound, "no island has an inbox"}));
    if (inboxes.size() == 1) return decide(inboxes.front());
    std::set<std::uint32_t> islands;
    for (const auto& inbox : inboxes) islands.insert(number(inbox.owner));
    end(error_response(
        {ErrorCode::kInvalid, fmt::format("island is missing; expected one of {}", fmt::join(islands, ", "))}));
  }

  void decide(const client::Tuple& inbox) {
    island_ = inbox.owner;
    open_ = order_.decisions.size();
    decided_.resize(open_);
    for (std::size_t i = 0; i < decided_.size(); ++i) {
      SetRequest request;
      request.owner = inbox.owner;
      request.key = inbox.key;
      request.value = order_.decisions[i].word + " " + order_.decisions[i].which;
      request.media_type = "text/plain";
      request.caller = caller_;
      if (auto good = context_.permission.check_set(caller_, request); !good) {
        replied(i, {{}, 0, tuples::Verdict::kRefused, good.error().code, good.error().text});
        continue;
      }
      const auto on_reply = [this, i](const tuples::Reply& reply) { replied(i, reply); };
      sets_.push_back(std::make_unique<TrackedSet>(context_, request, TrackedSet::Callbacks{on_reply, {}}));
    }
  }

  void replied(std::size_t index, const tuples::Reply& reply) {
    auto& decided = decided_[index];
    decided.reason = reply.text;
    if (const auto verdict = verbs::verdict_of(reply, island_)) {
      decided.state = "applied";
    } else {
      decided.state = to_string(reply.verdict);
      decided.error = verdict.error();
    }
    if (--open_ == 0) answer();
  }

  void answer() {
    Tree tree{{"island", number(island_)}};
    unsigned status = decided_.front().status();
    if (order_.is_list) {
      status = add_list(tree);
    } else {
      add_json(order_.decisions.front(), decided_.front(), tree);
    }
    end(json_response(tree, status));
  }

  unsigned add_list(Tree& tree) const {
    auto list = Tree::array();
    bool any = false;
    for (std::size_t i = 0; i < decided_.size(); ++i) {
      add_json(order_.decisions[i], decided_[i], list.emplace_back(Tree::object()));
      any |= !decided_[i].error;
    }
    if (!any) tree["error"] = list.front()["error"];
    tree["decisions"] = std::move(list);
    return any ? 200 : decided_.front().status();
  }

  /// What reports its end is destroyed in a later turn, with this.
  void end(Response response) {
    lifetime_.post(context_.scheduler, [respond = std::exchange(respond_, nullptr), response = std::move(response)] {
      respond(response);  // may destroy this
    });
  }

  Context& context_;
  Caller caller_;
  Order order_;
  Respond respond_;
  std::unique_ptr<client::TupleQuery> inboxes_;
  OwnerId island_{};
  std::vector<Decided> decided_;
  std::size_t open_ = 0;  ///< decisions that the island has not replied to
  std::vector<std::unique_ptr<TrackedSet>> sets_;
  base::Lifetime lifetime_;
};

}  // namespace

std::unique_ptr<Exchange> list_inbox(Call& call) {
  const auto range = read_range(call.query);
  if (auto good = call.may_read({std::nullopt, any_inbox()}); !good) return call.refuse(good.error());
  const model::IslandKey any{"*"};
  const std::vector<Pattern> patterns{
      {std::nullopt, any.inbox("*.*")}, {std::nullopt, any.inbox("ignored")}, {std::nullopt, any_inbox()}};
  return call.read(
      patterns, [&space = call.context.space, range, request = call.request](const std::vector<client::Tuple>& tuples) {
        IslandPrefixes prefixes(space);
        Inboxes inboxes;
        for (const auto& tuple : tuples) {
          if (prefixes.fit(tuple.owner, tuple.key)) inboxes.add(tuple);
        }
        auto page = page_of("devices", std::move(inboxes.entries), request, range, name_of_entry, entry_json);
        page["waiting"] = inboxes.waiting;
        page["ignored"] = inboxes.ignored;
        return json_response(page);
      });
}

std::unique_ptr<Exchange> decide_inbox(Call& call) {
  if (auto good = call.query.end(); !good) return call.refuse(good.error());
  auto order = read_order(call.request.body);
  if (!order) return call.refuse(order.error());
  auto& context = call.context;
  const auto key = model::IslandKey{"proxy"}.inbox();
  if (auto good = context.permission.check_decisions(call.request.caller, key, call.take_command()); !good)
    return call.refuse(good.error());
  context.commands.charge(call.caller_name(), context.scheduler.now(), std::max(0.0, order->cost() - 1));
  return std::make_unique<InboxOrder>(context, call.request.caller, std::move(*order), call.respond);
}

}  // namespace rubicon::web::api
