#include "tuples/joined/joined_ecology.h"

#include <fmt/format.h>

#include "base/assert.h"
#include "tuples/joined/joined_link.h"

namespace rubicon::tuples::joined {

JoinedEcology::JoinedEcology(std::vector<Engine> engines, Scheduler& scheduler, base::LogSink& log,
                             std::string own_host)
    : engines_(std::move(engines)), own_host_(std::move(own_host)), scheduler_(scheduler), log_(log) {
  RUBICON_ASSERT(!engines_.empty() && engines_.size() <= kMaxEngines);
}

Result<std::unique_ptr<Link>> JoinedEcology::join(OwnerId id) {
  std::vector<JoinedLink::Engine> links;
  for (const auto& engine : engines_) {
    auto link = engine.ecology.join(id);
    if (!link) {
      auto error = std::move(link.error());
      error.text = fmt::format("{}: {}", engine.name, error.text);
      return fail(std::move(error));
    }
    links.push_back({engine.name, std::move(*link)});
  }
  return std::make_unique<JoinedLink>(id, std::move(links), scheduler_, log_, own_host_);
}

}  // namespace rubicon::tuples::joined
