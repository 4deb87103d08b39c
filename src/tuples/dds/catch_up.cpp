#include "tuples/dds/catch_up.h"

#include <algorithm>

namespace rubicon::tuples::dds {

CatchUp::CatchUp(Scheduler& scheduler, Duration lease)
    : scheduler_(scheduler),
      lease_(lease),
      until_(scheduler.now() + kAfterStart),
      looked_(scheduler.now()),
      looked_by_wall_(scheduler.wall_now()) {
  tick();
}

void CatchUp::begin() {
  until_ = std::max(until_, scheduler_.now() + kAfterStart);
}

Duration CatchUp::left() {
  look();
  return std::max(until_ - scheduler_.now(), Duration(0));
}

void CatchUp::look() {
  const auto now = scheduler_.now();
  const auto wall = scheduler_.wall_now();
  // Others count from the last announcement, which was sent some time before it slept.
  const auto longest = lease_ / 2;
  if (now - looked_ > longest || wall - looked_by_wall_ > longest) until_ = std::max(until_, now + kAfterSleep);
  looked_ = now;
  looked_by_wall_ = wall;
}

void CatchUp::tick() {
  look();
  timer_ = scheduler_.after(lease_ / 4, [this] { tick(); });
}

}  // namespace rubicon::tuples::dds
