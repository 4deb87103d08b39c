#include <stdexcept>
#include <utility>

#include "peis/measurements.h"
#include "transport/local_transports.h"
#include "tuples/peis/peis_ecology.h"
#include "tuples/peis/tuple_wire.h"

namespace rubicon::bench {

namespace {

struct Engine {
  explicit Engine(transport::Loop& loop) : transports(loop) {}

  transport::LocalTransports transports;
  std::unique_ptr<tuples::peis::PeisEcology> ecology;
};

}  // namespace

std::shared_ptr<tuples::Ecology> open_peis(const Meeting& meeting, transport::Loop& loop, base::LogSink& log) {
  auto engine = std::make_shared<Engine>(loop);
  tuples::peis::PeisOptions options;
  options.network = meeting.tag;
  auto ecology = tuples::peis::PeisEcology::open(options, loop.scheduler(), engine->transports, log);
  if (!ecology) throw std::runtime_error(ecology.error().text);
  engine->ecology = std::move(*ecology);
  return {engine, engine->ecology.get()};
}

namespace peis {

std::size_t bytes_of_push() {
  constexpr std::string_view kMediaType = "text/plain";
  return tuples::peis::kHeaderSize + tuples::peis::kNetworkTupleSize + kMediaType.size() + value_of(0).size() + 1;
}

}  // namespace peis

}  // namespace rubicon::bench
