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
  Json figures;
  while (const auto line = browser.line()) {
    const auto part = Json::parse(*line, nullptr, false);
    if (!part.is_object()) throw std::runtime_error("browser.mjs: " + *line);
    figures.update(part);
  }
  if (browser.exit_code() != 0) throw std::runtime_error("browser.mjs: " + browser.errors());
  out["browser"] = std::move(figures);
}

}  // namespace rubicon::bench::web
