#include "apps/rubicon/loop_component.h"

#include <utility>

#include "apps/rubicon/output/output.h"
#include "client/ecology_options.h"
#include "rubicon/summary.hpp"
#include "transport/host_names.h"
#include "transport/machine_sockets.h"

namespace rubicon::cli {

void PrintedWarnings::write(base::LogLevel level, std::string_view, std::string_view text) {
  if (level >= base::LogLevel::kWarning) print_error(text);
}

Result<void> LoopComponent::open(client::Options options, const std::string& name) {
  if (auto good = client::check(options); !good) return good;
  auto& scheduler = loop_.scheduler();
  const auto id = client::component_id(options);
  auto engines = client::engine_options(options);
  if (!engines) return fail(engines.error());
  auto realm = client::open_realm(options, scheduler, log_);
  if (!realm) return fail(realm.error());
  if (engines->mqtt) engines->mqtt->realm = std::move(*realm);
  closed_ = engines->host && engines->host->place.shared;
  const auto post = [this](std::function<void()> call) { loop_.scheduler().post(std::move(call)); };
  auto ecology = tuples::engines::Engines::open(
      *engines, {scheduler, post, transports_, log_, transport::netlink_interfaces(transport::asio_watch(loop_))});
  if (!ecology) return fail(ecology.error());
  ecology_ = std::move(*ecology);
  auto link = ecology_->join(id);
  if (!link) return fail(link.error());
  link_ = std::move(*link);
  space_ = std::make_unique<TupleSpace>(id, scheduler, *link_);
  const model::Summary summary{name, transport::host_name(), transport::own_process(), "", scheduler.wall_now()};
  return space_->describe(model::to_json(summary));
}

}  // namespace rubicon::cli
