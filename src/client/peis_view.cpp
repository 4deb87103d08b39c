#include "client/peis_view.h"

#include <utility>

#include "tuples/peis/metrics.h"
#include "tuples/peis/presence.h"

namespace rubicon::client {

namespace {

using tuples::peis::TroubleKind;

PeisTrouble::Kind kind_of(TroubleKind kind) {
  switch (kind) {
    case TroubleKind::kForeignNetwork: return PeisTrouble::Kind::kForeignNetwork;
    case TroubleKind::kForeignVersion: return PeisTrouble::Kind::kForeignVersion;
    case TroubleKind::kUnreachable: return PeisTrouble::Kind::kUnreachable;
    case TroubleKind::kOwnId: return PeisTrouble::Kind::kOwnId;
    case TroubleKind::kSharedId: return PeisTrouble::Kind::kSharedId;
  }
  return PeisTrouble::Kind::kUnreachable;
}

}  // namespace

PeisView view_of(const tuples::peis::PeisEcology& ecology) {
  PeisView view;
  const auto count = [&view](std::string_view name, std::uint64_t value) {
    if (value > 0) view.counters[std::string(name)] += value;
  };
  for (const auto* presence : ecology.presences()) {
    tuples::peis::each_counter(presence->counters(), count);
    const auto* node = presence->node();
    if (!node) continue;
    tuples::peis::each_counter(node->counters(), count);
    view.local = transport::to_string(node->local());
    view.connections += node->links().size();
    for (const auto& one : node->troubles())
      view.troubles.push_back({kind_of(one.kind), one.id, one.name, one.detail, one.times});
  }
  return view;
}

}  // namespace rubicon::client
