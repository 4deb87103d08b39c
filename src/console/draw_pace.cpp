#include "console/draw_pace.h"

#include <algorithm>
#include <utility>

namespace rubicon::console {

void DrawPace::ask() {
  if (std::exchange(asked_, true)) return;
  due_ = scheduler_.at(std::max(earliest_, scheduler_.now()), [this] { draw(); });
}

void DrawPace::draw() {
  asked_ = false;
  const auto took = draw_();
  const auto now = scheduler_.now();
  earliest_ = now + kShare * took;
  due_ = scheduler_.at(std::max(earliest_, now + kIdle), [this] { draw(); });
}

}  // namespace rubicon::console
