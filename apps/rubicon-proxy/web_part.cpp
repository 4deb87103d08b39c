#include "apps/rubicon-proxy/web_part.h"

#include <fmt/format.h>

#include "rubicon/summary.hpp"
#include "transport/host_name.h"

namespace rubicon::daemon {

void WebPart::take(const std::optional<config::WebSetup>& setup, const std::string& directory,
                   history::History* history) {
  if (service_ && setup == setup_) {
    if (const auto read = service_->reload(); !read)
      log_.warning(fmt::format("{}; the page goes on with what it had", read.error().text));
    return;
  }
  close();
  if (!setup) return;
  if (const auto opened = open(*setup, directory, history); !opened) {
    close();
    return log_.warning(fmt::format("{}; the island goes on without its page", opened.error().text));
  }
  setup_ = setup;
  log_.info("open " + service_->address());
}

Result<void> WebPart::open(const config::WebSetup& setup, const std::string& directory, history::History* history) {
  auto link = host_.ecology.join(id_);
  if (!link) return fail(link.error());
  link_ = std::move(*link);
  auto& scheduler = host_.loop.scheduler();
  space_ = std::make_unique<TupleSpace>(id_, scheduler, *link_);
  const model::Summary summary{"page of the island", transport::host_name(), transport::own_process(), "",
                               scheduler.wall_now()};
  if (auto named = space_->describe(model::to_json(summary)); !named) return named;
  auto service = web::WebService::open(
      {host_.loop.context(), scheduler, *space_, host_.transports, host_.log, history, host_.island, host_.closed},
      setup, directory, name_);
  if (!service) return fail(service.error());
  service_ = std::move(*service);
  return {};
}

void WebPart::close() {
  service_.reset();
  space_.reset();
  link_.reset();
  setup_.reset();
}

}  // namespace rubicon::daemon
