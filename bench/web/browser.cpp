#include <stdexcept>

#include "web/rig.h"

namespace rubicon::bench::web {

/// The page itself in Chromium: browser.mjs, which starts the islands that it needs.
void measure_browser(const Plan& plan, Json& out) {
  const Rig rig(out, "browser");
  if (!rig) return;
  const auto script = std::string(RUBICON_SOURCE_DIR "/bench/web/browser.mjs");
  support::Process browser({"node", script, RUBICON_BINARY_DIR "/bin/rubicon-bench-web", std::to_string(plan.devices),
                            std::to_string(plan.watched.count())});
  std::string text;
  constexpr int kMostLines = 1000;
  for (int i = 0; i < kMostLines; ++i) {
    const auto line = browser.line();
    if (!line) break;
    text += *line + "\n";
  }
  auto figures = Json::parse(text, nullptr, false);
  if (figures.is_discarded()) throw std::runtime_error("browser.mjs: " + browser.errors());
  out["browser"] = std::move(figures);
}

}  // namespace rubicon::bench::web
