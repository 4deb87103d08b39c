#include "trust/rights/wish_log.h"

#include <fmt/format.h>

#include <utility>

namespace rubicon::trust::rights {

void WishLog::write(std::string_view text) {
  const auto now = scheduler_.now();
  if (window_ == SteadyTime::min() || now - window_ >= kWindow) {
    window_ = now;
    logged_ = 0;
  }
  if (++logged_ <= kLines) return log_.info(text);
  if (more_++ > 0) return;
  end_ = scheduler_.at(window_ + kWindow, [this] {
    log_.info(fmt::format("{} more {}{}", std::exchange(more_, 0), what_,
                          where_.empty() ? "" : ", which " + where_ + " names"));
  });
}

}  // namespace rubicon::trust::rights
