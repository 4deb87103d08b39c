#include "networks/wsn/island_id_keeper.h"

#include <tuple>

#include "motes/mote_records.h"

namespace rubicon::networks::wsn {

Bytes IslandIdKeeper::packet() const {
  return motes::packet_of(motes::AmType::kConfig, motes::encode_config({motes::kSetIslandId, island_}));
}

void IslandIdKeeper::repeat(std::optional<Duration> period) {
  next_.cancel();
  if (!period) return;
  next_ = scheduler_.after(*period, [this, period] {
    std::ignore = send_({packet(), sink::Lane::kProbe, scheduler_.now() + *period, true, {}});
    repeat(period);
  });
}

void IslandIdKeeper::correct() {
  const auto now = scheduler_.now();
  if (corrected_ && now < *corrected_ + kMinPause) return;
  corrected_ = now;
  std::ignore = send_({packet(), sink::Lane::kCommand, now + kMinPause, true, {}});
}

}  // namespace rubicon::networks::wsn
