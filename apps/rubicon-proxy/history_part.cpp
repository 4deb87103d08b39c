#include "apps/rubicon-proxy/history_part.h"

#include <fmt/format.h>

#include "model/point_keys.h"
#include "rubicon/summary.hpp"
#include "transport/host_name.h"

namespace rubicon::daemon {

bool HistoryPart::has(const std::optional<config::HistorySetup>& setup) const {
  return setup ? history_ && history_->setup() == *setup : !history_;
}

void HistoryPart::take(const std::optional<config::HistorySetup>& setup, const std::string& directory) {
  if (has(setup)) return;
  status_.reset();
  history_.reset();  // writes the last points
  space_.reset();
  link_.reset();
  if (!setup) return;
  if (const auto opened = open(*setup, directory); !opened)
    log_.warning(fmt::format("{}; the island goes on without its history", opened.error().text));
}

Result<void> HistoryPart::open(const config::HistorySetup& setup, const std::string& directory) {
  auto worker = transport::start_worker("history");
  if (!worker) return fail(worker.error());
  auto link = host_.ecology.join(id_);
  if (!link) return fail(link.error());
  link_ = std::move(*link);
  space_ = std::make_unique<TupleSpace>(id_, host_.scheduler, *link_);
  const model::Summary summary{"history of the island", transport::host_name(), transport::own_process(), "",
                               host_.scheduler.wall_now()};
  if (auto named = space_->describe(model::to_json(summary)); !named) return named;
  history_ = std::make_unique<history::History>(
      setup, history::History::Context{host_.scheduler, std::move(*worker), host_.log, directory});
  history_->follow(*space_);
  status_ = std::make_unique<history::StatusTuple>(host_.scheduler, host_.island,
                                                   model::IslandKey{host_.prefix}.history().status(), *history_);
  return {};
}

}  // namespace rubicon::daemon
